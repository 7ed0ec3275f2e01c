//! Segments that arrive at random moments of the motion: judged by differences of the positions alone.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_feedrate::constraint::{Feed, TangentialAcceleration, TangentialJerk};
use arcfeed_feedrate::{
    FeedError, FeedPlanner, FeedProblem, MotionLaw, PerSegmentScan, Segment, SegmentStream, StreamStatus, StreamedScan,
    boundaries, plan_per_segment, plan_windowed,
};

use crate::common::curve_like;
use arcfeed_testing::Random;
use arcfeed_testing::allocations_in;

/// A stream to be run; printed as a literal when something is wrong with it.
#[derive(Debug, Clone)]
struct Case {
    /// Length, speed, acceleration, jerk of each segment.
    segments: Vec<[f64; 4]>,
    /// Cycle before which each segment is there; one that finds the window full comes later.
    cycles: Vec<usize>,
    v_start: f64,
    look_ahead: usize,
    period: f64,
}

/// What a run shows.
struct Run {
    /// Positions, one a cycle, the start included.
    p: Vec<f64>,
    /// Cycle before which each segment was pushed.
    pushed: Vec<usize>,
    /// Cycle after which each segment was done.
    done: Vec<usize>,
    /// Cycles after which the motion rested before the end, with the segment it waited for.
    rests: Vec<(usize, usize)>,
    held_back: usize,
    duration: f64,
}

impl Case {
    fn segments(&self) -> Vec<Segment> {
        self.segments.iter().map(|s| Segment::new(s[0], s[1], s[2], s[3]).unwrap()).collect()
    }

    fn random(seed: u64) -> Self {
        let mut rng = Random::new(seed);
        let n = 1 + (rng.unit() * 40.0) as usize;
        let (a, j) = (rng.log(0.3, 3.0), rng.log(5.0, 100.0));
        let (shortest, longest) = (rng.log(1e-4, 5e-3), rng.log(5e-3, 0.1));
        let segments: Vec<[f64; 4]> = (0..n)
            .map(|_| [rng.log(shortest, longest), rng.log(0.01, 0.3), a * rng.log(0.5, 2.0), j * rng.log(0.5, 2.0)])
            .collect();
        let period = rng.log(5e-4, 4e-3);
        let look_ahead = 1 + (rng.unit() * 12.0) as usize;
        // All at once, evenly, or in bursts with stalls between.
        let (kind, gap) = (rng.unit(), rng.log(1.0, 400.0));
        let mut at = 0.0;
        let cycles: Vec<usize> = (0..n)
            .map(|_| {
                at += if kind < 0.2 {
                    0.0
                } else if kind < 0.5 {
                    gap
                } else if rng.unit() < 0.7 {
                    rng.unit() * 3.0
                } else {
                    gap * 4.0 * rng.unit()
                };
                at as usize
            })
            .collect();
        let mut case = Self { segments, cycles, v_start: 0.0, look_ahead, period };
        if rng.unit() < 0.5 {
            let first = case.first();
            let highest = match SegmentStream::new(&first, 1e3, look_ahead) {
                Err(FeedError::StartTooFast { highest_start, .. }) => highest_start,
                other => panic!("{other:?}"),
            };
            case.v_start = highest * if rng.unit() < 0.3 { 1.0 } else { rng.unit() };
        }
        case
    }

    /// The segments that are there at the start: those of cycle 0 that find a place, and at least one.
    fn first(&self) -> Vec<Segment> {
        let there = self.cycles.iter().take_while(|c| **c == 0).count();
        self.segments()[..there.clamp(1, self.look_ahead + 1)].to_vec()
    }

    fn run(&self) -> Result<Run, FeedError> {
        let segments = self.segments();
        let first = self.first();
        let mut stream = SegmentStream::new(&first, self.v_start, self.look_ahead)?;
        let mut next = first.len();
        let mut run = Run {
            p: vec![0.0],
            pushed: vec![0; next],
            done: Vec::new(),
            rests: Vec::new(),
            held_back: 0,
            duration: f64::NAN,
        };
        for cycle in 0..2_000_000 {
            while next < segments.len() && self.cycles[next] <= cycle && stream.free() > 0 {
                stream.push(segments[next])?;
                run.pushed.push(cycle);
                next += 1;
            }
            if next == segments.len() {
                stream.finish();
            }
            let step = stream.step(self.period)?;
            run.p.push(step.state.p);
            run.done.resize(step.segment, cycle + 1);
            match step.status {
                StreamStatus::Moving { held_back } => run.held_back += usize::from(held_back),
                StreamStatus::Waiting => run.rests.push((cycle + 1, step.segment)),
                StreamStatus::Reached { unused } => {
                    run.duration = (cycle + 1) as f64 * self.period - unused;
                    return Ok(run);
                }
            }
        }
        panic!("does not end: {self:?}");
    }

    /// What is wrong with a run; nothing is taken from the stream but positions and the times of pushes.
    fn fault(&self, run: &Run) -> Option<String> {
        let segments = self.segments();
        let (breaks, h, p) = (boundaries(&segments), self.period, &run.p);
        let end = breaks[segments.len()];
        if p[p.len() - 1] != end {
            return Some(format!("ends at {} and not at {end}", p[p.len() - 1]));
        }
        // A mean of a derivative over the positions of a window is within the loosest limit of the segments it touches.
        let loosest = |from: f64, to: f64, k: usize| {
            let eps = 1e-12 * end;
            let lo = breaks.partition_point(|&b| b <= from - eps).clamp(1, segments.len()) - 1;
            let hi = breaks.partition_point(|&b| b <= to + eps).clamp(1, segments.len()) - 1;
            self.segments[lo..=hi].iter().fold(0.0_f64, |most, s| most.max(s[k]))
        };
        let rounding = 8.0 * f64::EPSILON * end;
        // Before the start the motion had its speed; a cycle in which it ends is cut short.
        let before: Vec<f64> = (1..=3).rev().map(|k| -self.v_start * h * f64::from(k)).collect();
        let all: Vec<f64> = before.iter().chain(p).copied().collect();
        for i in 3..all.len() {
            let w = &all[i - 3..=i];
            let differences = [w[3] - w[2], w[3] - 2.0 * w[2] + w[1], w[3] - 3.0 * (w[2] - w[1]) - w[0]];
            if differences[0] < -1e-9 * h - rounding {
                return Some(format!("runs back at cycle {}", i - 3));
            }
            for (k, d) in differences.iter().enumerate() {
                let (most, order) = (loosest(w[2 - k.min(2)], w[3], k + 1), k as i32 + 1);
                let value = (d.abs() - f64::from(1 << order) * rounding).max(0.0) / h.powi(order);
                if !(value <= most * (1.0 + 1e-6)) {
                    return Some(format!("derivative {order} is {value} of {most} at cycle {}", i - 3));
                }
            }
        }
        for &(cycle, waits_for) in &run.rests {
            let Some(&pushed) = run.pushed.get(waits_for) else {
                return Some(format!("waits at cycle {cycle} for a segment that never came"));
            };
            if pushed < cycle {
                return Some(format!("waits at cycle {cycle} though segment {waits_for} came before cycle {pushed}"));
            }
        }
        self.false_stop(run, &breaks)
    }

    /// A stop between two segments of which the second one had arrived in time.
    fn false_stop(&self, run: &Run, breaks: &[f64]) -> Option<String> {
        for (k, &at) in breaks.iter().enumerate().take(self.segments.len()).skip(1) {
            // Braking to rest at a boundary covers j t^3 / 6 in the last t, and so does leaving it from rest.
            let j = self.segments[k - 1][3];
            let rests = |w: &[f64]| {
                let cube = self.period.powi(3) / 6.0 * (1.0 + 1e-6);
                let (before, after) = (at - w[0], w[1] - at);
                before >= 0.0 && after >= 0.0 && before <= j * cube && after <= self.segments[k][3] * cube
            };
            let Some(rest) = run.p.windows(2).position(rests) else { continue };
            // Where the segment before had begun already, the brake may be too late to be taken off.
            if run.pushed[k] < k.checked_sub(2).map_or(0, |k| run.done[k]) {
                let pushed = run.pushed[k];
                return Some(format!("rests at boundary {k}, cycle {rest}, though the next came at cycle {pushed}"));
            }
        }
        None
    }
}

#[test]
fn random_arrivals_break_no_limit_and_force_no_stop() {
    let (mut rests, mut held, mut stalls) = (0, 0, 0);
    for seed in 0..600 {
        let case = Case::random(seed);
        let run = case.run().unwrap_or_else(|e| panic!("{e}: {case:?}"));
        if let Some(fault) = case.fault(&run) {
            panic!("{fault}:\nlet case = {case:?};");
        }
        rests += run.rests.len();
        held += run.held_back;
        stalls += usize::from(!run.rests.is_empty());
    }
    // The cases are of all kinds.
    assert!(rests > 1000 && held > 1000 && stalls > 50 && stalls < 300, "{rests} {held} {stalls}");
}

/// Segments that arrive while the one before is run, early enough: the speed never falls far.
#[test]
fn a_segment_that_arrives_in_time_is_entered_at_speed() {
    let segment = Segment::new(0.02, 0.1, 1.0, 20.0).unwrap();
    // Braking from 0.1 m/s takes 7.5 mm of the 20.
    let mut stream = SegmentStream::new(&[segment; 2], 0.0, 4).unwrap();
    let (mut pushed, mut slowest) = (2, f64::INFINITY);
    loop {
        let step = stream.step(1e-3).unwrap();
        let inside = step.state.p - 0.02 * step.segment as f64;
        if inside > 0.01 && pushed == step.segment + 1 && pushed < 30 {
            stream.push(segment).unwrap();
            pushed += 1;
        }
        match step.status {
            StreamStatus::Reached { .. } => break,
            status => assert!(status != StreamStatus::Waiting),
        }
        if pushed == 30 {
            stream.finish();
        } else if step.segment > 0 {
            slowest = slowest.min(step.state.v);
        }
    }
    assert!(slowest > 0.0999, "{slowest}");
}

/// With everything there before the first step the stream runs the law of the whole path. That law stops on the way where
/// a stop takes less length than braking, and the stream does not: there it is another, in most cases faster.
#[test]
fn a_stream_that_is_there_at_once_is_the_law_of_the_whole_path() {
    let (mut equal, mut slower) = (0, 0);
    for seed in 0..300 {
        let case = at_once(Case::random(seed));
        let whole = plan_per_segment(&case.segments(), case.v_start, 0.0).unwrap();
        let run = case.run().unwrap();
        let ratio = run.duration / whole.duration();
        assert!(ratio < 1.02 && run.held_back == 0, "{ratio}:\nlet case = {case:?};");
        equal += usize::from((ratio - 1.0).abs() < 1e-10);
        slower += usize::from(ratio > 1.0 + 1e-10);
    }
    assert!(equal > 150 && slower < 15, "{equal} {slower}");
}

fn at_once(mut case: Case) -> Case {
    case.cycles.iter_mut().for_each(|c| *c = 0);
    case.look_ahead = case.segments.len();
    case
}

/// A window that is always full is about as fast as the scan with that window, and no faster than the whole path allows.
#[test]
fn a_window_that_is_always_full_is_as_fast_as_the_windowed_scan() {
    let (mut slower, mut worst) = (0, 0.0_f64);
    for seed in 0..60 {
        let segments = curve_like(200, seed);
        let literal = |s: &Segment| [s.length(), s.v_max(), s.a_max(), s.j_max()];
        let case = Case {
            segments: segments.iter().map(literal).collect(),
            cycles: vec![0; segments.len()],
            v_start: 0.0,
            look_ahead: [2, 4, 8, 16, 64][seed as usize % 5],
            period: 1e-3,
        };
        let run = case.run().unwrap();
        assert!(case.fault(&run).is_none(), "{:?}:\nlet case = {case:?};", case.fault(&run));
        let windowed = plan_windowed(&segments, 0.0, case.look_ahead).unwrap().duration();
        let whole = at_once(case.clone()).run().unwrap().duration;
        worst = worst.max(run.duration / windowed);
        assert!(run.duration >= whole * (1.0 - 1e-9), "{} {whole} {}", run.duration, case.look_ahead);
        slower += usize::from(run.held_back > 0);
    }
    assert!(slower > 20 && worst < 1.01, "{slower} {worst}");
}

/// A problem as a stream: with all of it known at once the motion is that of the scan; with little of it known it is slower, and says
/// where it was held back.
#[test]
fn a_problem_is_run_as_a_stream() {
    let grid: Vec<f64> = (0..=200).map(|i| f64::from(i) * 5e-3).collect();
    let feeds: Vec<f64> = (0..200).map(|i| if i % 80 < 50 { 0.5 } else { 0.1 }).collect();
    let (feed, acceleration) = (Feed::new(&feeds).unwrap(), TangentialAcceleration::new(1.0).unwrap());
    let jerk = TangentialJerk::new(30.0).unwrap();
    let problem = FeedProblem::between_points(&grid, &[&feed, &acceleration, &jerk]).unwrap();
    let best = PerSegmentScan::default().plan(&problem).unwrap().duration();
    let run = |look_ahead: usize, gap: f64| StreamedScan { look_ahead, gap, period: 1e-3 }.run(&problem).unwrap();
    let all = run(200, 0.0);
    assert!((all.law.duration() / best - 1.0).abs() < 1e-9 && all.waits.is_empty(), "{} {best}", all.law.duration());
    assert!((all.law.end().p - 1.0).abs() < 1e-12);
    let few = run(3, 0.0);
    assert!(few.law.duration() > 1.1 * best && !few.held_back.is_empty() && few.waits.is_empty());
    // A segment of 5 mm each half second: the motion waits for them.
    let late = run(3, 0.5);
    let waits: f64 = late.waits.iter().map(|(_, dt)| dt).sum();
    assert!(waits > 30.0 && late.law.duration() > 95.0, "{waits} {}", late.law.duration());
    for streamed in [all, few, late] {
        let law = streamed.law;
        let mut before = law.at(0.0);
        for i in 1..=2000 {
            let now = law.at(law.duration() * f64::from(i) / 2000.0);
            let limit = feeds[((before.p / 5e-3) as usize).min(199)].max(feeds[((now.p / 5e-3) as usize).min(199)]);
            assert!(now.p >= before.p && now.v <= limit + 1e-9 && now.a.abs() <= 1.0 + 1e-9, "{now:?}");
            before = now;
        }
    }
}

#[test]
fn steps_and_pushes_allocate_nothing_and_their_work_is_bounded() {
    let segments = curve_like(3000, 5);
    let mut stream = SegmentStream::new(&segments[..1], 0.0, 50).unwrap();
    let mut next = 1;
    let mut phases = 0;
    let count = allocations_in(|| {
        for cycle in 0..40_000 {
            // A stall of half a second now and then.
            while cycle % 4000 > 500 && next < segments.len() && stream.free() > 0 {
                stream.push(segments[next]).unwrap();
                next += 1;
            }
            let mut parts = 0;
            stream.step_with(1e-3, |_, _| parts += 1).unwrap();
            phases = phases.max(parts);
        }
        stream.finish();
    });
    assert_eq!(count, 0);
    assert_eq!(next, segments.len());
    // Seven phases for each segment that a cycle completes, and nine for the one it ends in.
    assert!(phases > 1 && phases <= 9 + 7 * 51, "{phases}");
    assert!(matches!(stream.step(1e-3).unwrap().status, StreamStatus::Reached { .. }));
    let end = boundaries(&segments)[segments.len()];
    assert_eq!(stream.state().p, end);
}

#[test]
fn what_a_stream_refuses() {
    let segment = Segment::new(0.01, 0.1, 1.0, 50.0).unwrap();
    let long = Segment::new(1e300, 1e-300, 1.0, 1.0).unwrap();
    assert!(matches!(SegmentStream::new(&[], 0.0, 0), Err(FeedError::NotPositive { .. })));
    assert!(matches!(SegmentStream::new(&[], 0.0, usize::MAX), Err(FeedError::TooMany { .. })));
    assert!(matches!(SegmentStream::new(&[], 0.1, 4), Err(FeedError::Empty { .. })));
    assert!(matches!(SegmentStream::new(&[segment], f64::NAN, 4), Err(FeedError::NotFinite { .. })));
    assert!(matches!(SegmentStream::new(&[segment], 0.2, 4), Err(FeedError::StartTooFast { .. })));
    assert!(matches!(SegmentStream::new(&[segment; 4], 0.0, 2), Err(FeedError::StreamFull { most: 2 })));
    let mut stream = SegmentStream::new(&[], 0.0, 2).unwrap();
    assert!(stream.push(long).is_err());
    assert!(stream.step(f64::NAN).is_err() && stream.step(-1.0).is_err());
    assert_eq!(stream.step(1e-3).unwrap().status, StreamStatus::Waiting);
    stream.push(segment).unwrap();
    stream.push(segment).unwrap();
    assert!(matches!(stream.push(segment), Err(FeedError::StreamFull { .. })));
    stream.finish();
    assert!(matches!(stream.push(segment), Err(FeedError::StreamEnded)));
    // A cycle longer than the motion.
    let step = stream.step(1e300).unwrap();
    assert!(matches!(step.status, StreamStatus::Reached { .. }) && step.state.p == 0.02);
}
