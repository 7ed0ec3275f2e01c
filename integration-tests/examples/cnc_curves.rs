//! Every method on ten curves of machine tools, in five sizes, at five feeds, on four arms: `cnc_curves [EVERY, else 1] [FIRST, else 0]`.
//!
//! `EVERY` skips all but each so-manieth job. One line per job; at the end how often the default planner fell back, was slower than
//! another method or got slower by a higher feed.

use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use arcfeed_interp::Method;
use integration_tests::cnc_curves::{ARMS, CncJob, NAMES, Planned};

const SIZES: [f64; 5] = [0.002, 0.01, 0.05, 0.2, 0.5];
const FEEDS: [f64; 5] = [0.005, 0.02, 0.1, 0.5, 2.0];

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<usize>());
    let every = arguments.next().and_then(Result::ok).unwrap_or(1).max(1);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let others = std::env::args().all(|text| text != "default-only");
    let mut jobs = Vec::new();
    for curve in NAMES {
        for size in SIZES {
            for (arm, _) in ARMS {
                jobs.extend(FEEDS.map(|feed| CncJob::new(curve, size, feed, arm)));
            }
        }
    }
    // Whole rows of feeds stay together.
    let jobs: Vec<CncJob> = jobs
        .chunks(FEEDS.len())
        .enumerate()
        .filter(|(i, _)| i % every == first)
        .flat_map(|(_, row)| row.to_vec())
        .collect();
    let (next, results, begin) = (AtomicUsize::new(0), Mutex::new(HashMap::new()), Instant::now());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(i) else { break };
                    let of = |method| job.plan(method);
                    let scan = others.then(|| of(Method::ContinuousAcceleration));
                    let result = (of(Method::default()), scan);
                    results.lock().expect("no panic").insert(i, result);
                }
            });
        }
    });
    let results = results.into_inner().expect("no panic");
    let (mut refused, mut fell, mut slower, mut longer, mut planning) = (0, 0, 0, 0, 0.0);
    let mut before: Option<(CncJob, f64)> = None;
    for (i, job) in jobs.iter().enumerate() {
        let (default, scan) = &results[&i];
        let mut remarks = Vec::new();
        let text = match default {
            Ok(Planned { duration, fallback, rounds, intervals, planning: time }) => {
                planning += time;
                if let Some(why) = fallback {
                    fell += 1;
                    remarks.push(format!("fell back: {why}"));
                }
                if let Some(Ok(scan)) = scan {
                    if scan.duration < duration * (1.0 - 1e-4) {
                        slower += 1;
                        remarks.push(format!(
                            "slower than the scan's {:.4} s ({:.2} %)",
                            scan.duration,
                            100.0 * (duration / scan.duration - 1.0)
                        ));
                    }
                }
                if let Some((last, shorter)) = before {
                    let same = last.curve == job.curve && last.size == job.size && last.arm == job.arm;
                    if same && *duration > shorter * 1.001 {
                        longer += 1;
                        remarks.push(format!(
                            "longer than at {} mm/s ({:.2} %)",
                            1e3 * last.feed,
                            100.0 * (duration / shorter - 1.0)
                        ));
                    }
                }
                before = Some((*job, *duration));
                format!("{duration:10.4} s {rounds:2} rounds {intervals:6} intervals {:7.1} ms", 1e3 * time)
            }
            Err(why) => {
                refused += 1;
                before = None;
                format!("refused: {why}")
            }
        };
        println!(
            "{:9} {:5} mm {:6} mm/s {:9} {text} {}",
            job.curve,
            1e3 * job.size,
            1e3 * job.feed,
            job.arm,
            remarks.join("; ")
        );
    }
    println!(
        "{} jobs: {refused} refused, {fell} fell back, {slower} slower than the scan, {longer} longer at a higher feed; {planning:.1} s to plan, {:.0} s in all",
        jobs.len(),
        begin.elapsed().as_secs_f64()
    );
}
