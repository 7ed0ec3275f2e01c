//! Every method on ten curves of machine tools, in five sizes, at five feeds, on four arms: `cnc_curves [EVERY, else 100] [FIRST, else 0] [gaps]`.
//!
//! `EVERY` skips all but each so-manieth row of feeds; 1 plans all thousand jobs. One line per job; at the end how often the default
//! planner fell back, was slower than the scan or got slower by a higher feed. `gaps` bounds each duration from below, too.

use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use arcfeed_interp::Method;
use integration_tests::cnc_curves::{ARMS, CncJob, NAMES, Planned};

const SIZES: [f64; 5] = [0.002, 0.01, 0.05, 0.2, 0.5];
const FEEDS: [f64; 5] = [0.005, 0.02, 0.1, 0.5, 2.0];

/// By so much of itself a duration may differ from one that it should not exceed.
const SLOWER: f64 = 1e-4;
const LONGER: f64 = 1e-3;

/// The plan of the default planner, and of the scan.
type Both = [Result<Planned, String>; 2];

#[derive(Default)]
struct Counts {
    refused: usize,
    fell_back: usize,
    slower: usize,
    longer: usize,
    /// s.
    planning: f64,
    /// Sum of the durations by the default planner over those of the scan.
    ratio: f64,
    /// The durations over their lower bounds, less 1.
    gaps: Vec<f64>,
    without_bound: usize,
}

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<usize>());
    let every = arguments.next().and_then(Result::ok).unwrap_or(100).max(1);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let mut jobs = jobs(every, first);
    if std::env::args().any(|argument| argument == "gaps") {
        jobs.iter_mut().for_each(|job| job.bounded = true);
    }
    let begin = Instant::now();
    let results = plan(&jobs);
    let mut counts = Counts::default();
    let mut before: Option<(CncJob, f64)> = None;
    for (i, job) in jobs.iter().enumerate() {
        let row = before.filter(|(last, _)| last.curve == job.curve && last.size == job.size && last.arm == job.arm);
        let (text, duration) = counts.judge(&results[&i], row);
        before = duration.map(|duration| (*job, duration));
        println!("{:10} {:5} mm {:6} mm/s {:9} {text}", job.curve, 1e3 * job.size, 1e3 * job.feed, job.arm);
    }
    let Counts { refused, fell_back, slower, longer, planning, ratio, mut gaps, without_bound } = counts;
    gaps.sort_by(f64::total_cmp);
    if let Some(worst) = gaps.last() {
        let at = |part: usize| 100.0 * gaps[(gaps.len() - 1) * part / 10];
        println!(
            "gap to the lower bound: median {:.3} %, 90 % under {:.3} %, worst {:.3} %; {without_bound} without",
            at(5),
            at(9),
            100.0 * worst
        );
    }
    println!(
        "{} jobs: {refused} refused, {fell_back} fell back, {slower} slower than the scan, {longer} longer at a higher feed; mean \
         duration {:.4} of the scan's; {planning:.1} s to plan, {:.0} s in all",
        jobs.len(),
        ratio / (jobs.len() - refused).max(1) as f64,
        begin.elapsed().as_secs_f64()
    );
    if refused + slower + longer > 0 {
        std::process::exit(1);
    }
}

/// Each so-manieth row of feeds.
fn jobs(every: usize, first: usize) -> Vec<CncJob> {
    let mut rows = Vec::new();
    for curve in NAMES {
        for size in SIZES {
            rows.extend(ARMS.map(|(arm, _)| FEEDS.map(|feed| CncJob::new(curve, size, feed, arm))));
        }
    }
    rows.into_iter().skip(first).step_by(every).flatten().collect()
}

fn plan(jobs: &[CncJob]) -> HashMap<usize, Both> {
    let (next, results) = (AtomicUsize::new(0), Mutex::new(HashMap::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(i) else { break };
                    let both = [Method::JerkLimited, Method::ContinuousAcceleration].map(|method| job.plan(method));
                    results.lock().expect("no panic").insert(i, both);
                }
            });
        }
    });
    results.into_inner().expect("no panic")
}

impl Counts {
    /// Counts a job, after the one before it in its row of feeds. Returns its line of text, and its duration.
    fn judge(&mut self, [best, scan]: &Both, before: Option<(CncJob, f64)>) -> (String, Option<f64>) {
        let Planned { duration, fallback, rounds, intervals, planning, bound } = match best {
            Ok(planned) => planned,
            Err(why) => {
                self.refused += 1;
                return (format!("refused: {why}"), None);
            }
        };
        self.planning += planning;
        let mut text = format!("{duration:10.4} s {rounds:2} rounds {intervals:5} intervals {:6.1} ms", 1e3 * planning);
        if let Some(why) = fallback {
            self.fell_back += 1;
            text += &format!("; fell back: {why}");
        }
        match bound {
            Some(Ok(bound)) => {
                let gap = duration / bound.duration - 1.0;
                self.gaps.push(gap);
                text += &format!("; gap {:.3} %, {} intervals conditional", 100.0 * gap, bound.conditional);
            }
            Some(Err(why)) => {
                self.without_bound += 1;
                text += &format!("; no bound: {why}");
            }
            None => {}
        }
        if let Ok(scan) = scan {
            self.ratio += duration / scan.duration;
            text += &format!("; {:6.2} % of the scan's", 100.0 * duration / scan.duration);
            if scan.duration < duration * (1.0 - SLOWER) {
                self.slower += 1;
                text += ": SLOWER";
            }
        }
        if let Some((last, shorter)) = before
            && *duration > shorter * (1.0 + LONGER)
        {
            self.longer += 1;
            text += &format!("; LONGER than {shorter:.4} s at {} mm/s", 1e3 * last.feed);
        }
        (text, Some(*duration))
    }
}
