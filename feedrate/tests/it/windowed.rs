//! Long paths in windows: as fast as the whole within 0.5 %, within all limits, in memory that a window bounds.
#![allow(clippy::unwrap_used)]
use std::hint::black_box;
use std::ops::Range;

use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, Stop, TangentialAcceleration, TangentialJerk,
};
use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, JerkLimited, SpeedLaw, WindowedJerkLimited, WindowedPlan};
use arcfeed_testing::{Random, most_bytes_in};

use crate::row_families_cases::{Case, FAMILIES, Path, judge};
use crate::spline_paths::{A_MAX, JOINTS, Spline, V_A, worst};

const J_MAX: [f64; JOINTS] = [30.6, 23.1, 34.7, 37.4, 37.4, 55.0];

/// A spline of six joints through random way-points.
fn path(seed: u64, way_points: usize) -> Spline {
    let mut rng = Random::new(seed);
    let points: Vec<_> = (0..way_points).map(|_| std::array::from_fn(|_| rng.between(-1.5, 1.5))).collect();
    Spline::natural(&points)
}

/// The limits of the joints on a range of the intervals of `grid`.
fn stretch(spline: &Spline, grid: &[f64], range: Range<usize>) -> Result<FeedProblem, FeedError> {
    let grid = &grid[range.start..=range.end];
    let samples = spline.samples(grid);
    let velocity = JointVelocity::new(samples.path(), &V_A)?;
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX)?;
    let jerk = JointJerk::new(samples.path(), &J_MAX)?;
    FeedProblem::between_points(grid, &[&velocity, &acceleration, &jerk])
}

fn windowed(spline: &Spline, grid: &[f64], window: usize) -> WindowedPlan {
    let planner = WindowedJerkLimited::new(JerkLimited::default(), window).unwrap();
    planner.plan(grid.len() - 1, |range| stretch(spline, grid, range)).unwrap()
}

/// Largest steps of speed and acceleration at the grid points, as parts of their largest values.
fn steps(law: &SpeedLaw, grid: &[f64]) -> [f64; 2] {
    let (mut steps, mut most) = ([0.0_f64; 2], [0.0_f64; 2]);
    for (i, &s) in grid.iter().enumerate().skip(1).take(grid.len() - 2) {
        let [before, after] = [s - 1e-9 * (s - grid[i - 1]), s].map(|s| law.at_position(s));
        for (k, (before, after)) in [(before.v, after.v), (before.a, after.a)].into_iter().enumerate() {
            steps[k] = steps[k].max((after - before).abs());
            most[k] = most[k].max(after.abs());
        }
    }
    [steps[0] / most[0], steps[1] / most[1]]
}

#[test]
fn windows_are_as_fast_as_the_whole_and_keep_all_limits() {
    let (mut windows, mut stops) = (0, 0);
    for seed in 1..=12 {
        // Windows of 2 to 10 s of motion, on grids of some 4 to 20 ms.
        let mut rng = Random::new(seed);
        let (way_points, per, window) = (10 + rng.below(10), 40 + rng.below(160), 350 + rng.below(400));
        let spline = path(seed, way_points);
        let grid = spline.on_knots(per * (way_points - 1));
        let plan = windowed(&spline, &grid, window);
        let whole = JerkLimited::default().plan(&stretch(&spline, &grid, 0..grid.len() - 1).unwrap()).unwrap();
        let ratio = plan.law.duration() / whole.duration();
        let what = format!("seed {seed}: {} intervals, windows of {window}: {ratio}", grid.len() - 1);
        assert!(ratio < 1.005 && ratio > 0.9999, "{what}");
        assert!(worst(&spline, &grid, &plan.law, 6, &V_A, &J_MAX).iter().all(|worst| *worst <= 1.0 + 1e-7), "{what}");
        let [speed, acceleration] = steps(&plan.law, &grid);
        assert!(speed < 1e-8 && acceleration < 1e-6, "{what}: {speed} {acceleration}");
        assert_eq!((plan.law.start(), plan.law.end().p), (grid[0], grid[grid.len() - 1]), "{what}");
        (windows, stops) = (windows + plan.windows, stops + plan.stops.len());
    }
    assert!(windows > 60 && stops == 0, "{windows} windows, {stops} stops");
}

/// Problems of all families, between their points too: windows keep what the whole keeps.
#[test]
fn random_problems_in_windows_keep_their_limits() {
    let (mut planned, mut stops) = (0, 0);
    for index in 0..400 {
        let family = index as usize % FAMILIES.len();
        let case = Case::numbered(23, family, index);
        let path = Path::new(&case);
        let n = path.grid.len() - 1;
        let whole = path.problem(true, true).and_then(|problem| JerkLimited::default().plan(&problem));
        let (Ok(whole), true) = (whole, n > 128) else { continue };
        let planner = WindowedJerkLimited::new(JerkLimited::default(), 80).unwrap();
        let plan = match planner.plan(n, |range| path.problem_on(range, true, true)) {
            // Standing still is not possible everywhere.
            Err(FeedError::StaticallyInfeasible { .. }) => continue,
            plan => plan.unwrap_or_else(|error| panic!("{error}: {}", case.literal())),
        };
        let excess = judge(&path, &plan.law, true);
        assert!(excess.at_grid <= 1e-7 && excess.between <= 1e-6, "{excess:?}: {}", case.literal());
        let ratio = plan.law.duration() / whole.duration();
        // Windows of 80 intervals may be shorter than the way to brake.
        assert!(ratio > 0.99 && (ratio < 2.0 || !plan.stops.is_empty()), "{ratio}: {}", case.literal());
        (planned, stops) = (planned + 1, stops + plan.stops.len());
    }
    // There are 8 if a window has to begin at a speed that a scan with constant accelerations can go on from.
    assert!(planned > 100 && stops <= 3, "{planned} problems, {stops} stops");
}

/// Limits on the path alone, with a feed that changes, and stops at some points; `ends` are the speeds at both ends.
fn on_path(range: Range<usize>, intervals: usize, stops: &[usize], ends: [f64; 2]) -> Result<FeedProblem, FeedError> {
    let grid: Vec<f64> = (range.start..=range.end).map(|i| 0.001 * i as f64).collect();
    let feeds: Vec<f64> = range.clone().map(|k| [0.2, 0.12, 0.3][k / 170 % 3]).collect();
    let (feed, acceleration) = (Feed::new(&feeds)?, TangentialAcceleration::new(2.0)?);
    let jerk = TangentialJerk::new(40.0)?;
    let inside = stops.iter().filter(|stop| range.start <= **stop && **stop <= range.end);
    let stops: Vec<Stop> = inside.map(|stop| Stop { at: stop - range.start }).collect();
    let mut limits: Vec<&dyn PathConstraint> = vec![&feed, &acceleration, &jerk];
    limits.extend(stops.iter().map(|stop| stop as &dyn PathConstraint));
    let start = if range.start == 0 { ends[0] } else { 0.0 };
    let end = if range.end == intervals { ends[1] } else { 0.0 };
    FeedProblem::between_points(&grid, &limits)?.with_end_speeds(start, end)
}

#[test]
fn stops_and_speeds_at_the_ends_are_those_of_the_path() {
    const N: usize = 2000;
    for (window, stops, ends) in [
        (300, vec![], [0.1, 0.15]),
        (300, vec![700], [0.0, 0.0]),
        // A stop at the end of a window, just inside one, just behind one; two in one window.
        (300, vec![300, 604, 899, 1500, 1510], [0.05, 0.0]),
        (64, vec![1000], [0.0, 0.1]),
    ] {
        let whole = JerkLimited::default().plan(&on_path(0..N, N, &stops, ends).unwrap()).unwrap();
        let planner = WindowedJerkLimited::new(JerkLimited::default(), window).unwrap();
        let plan = planner.plan(N, |range| on_path(range, N, &stops, ends)).unwrap();
        let [start, end] = [plan.law.at_position(0.0), plan.law.end()];
        assert!((start.v - ends[0]).abs() < 1e-12 && (end.v - ends[1]).abs() < 1e-12, "{window}: {start:?} {end:?}");
        for stop in &stops {
            assert_eq!(plan.law.at_position(0.001 * *stop as f64).v, 0.0, "{window}: stop {stop}");
        }
        let ratio = plan.law.duration() / whole.duration();
        // 32 mm of looking ahead are less than the way to brake.
        let most = if window == 64 { 1.3 } else { 1.005 };
        assert!(ratio > 0.9999 && ratio < most && plan.stops.is_empty(), "{window}: {ratio} {:?}", plan.stops);
        for (i, pair) in (0..N).map(|i| (i, [0.001 * i as f64, 0.001 * (i + 1) as f64])) {
            for part in 0..8 {
                let state = plan.law.at_position(pair[0] + 0.001 * (f64::from(part) + 0.5) / 8.0);
                let feed = [0.2, 0.12, 0.3][i / 170 % 3];
                let worst = (state.v / feed).max(state.a.abs() / 2.0).max(state.j.abs() / 40.0);
                assert!(worst < 1.0 + 1e-7, "{window}: {worst} in interval {i}");
            }
        }
    }
}

/// Where the limits behind a window are lower than those that it was planned with, no motion goes on: it rests at the end of the window.
#[test]
fn a_window_that_cannot_be_left_is_taken_to_its_end() {
    let slow = |range: Range<usize>| {
        let grid: Vec<f64> = (range.start..=range.end).map(|i| 0.001 * i as f64).collect();
        let feeds = vec![if range.start == 0 || range.start >= 300 { 0.2 } else { 1e-3 }; range.len()];
        let (feed, acceleration) = (Feed::new(&feeds)?, TangentialAcceleration::new(2.0)?);
        FeedProblem::between_points(&grid, &[&feed, &acceleration, &TangentialJerk::new(40.0)?])
    };
    let planner = WindowedJerkLimited::new(JerkLimited::default(), 300).unwrap();
    let plan = planner.plan(1000, slow).unwrap();
    assert_eq!(plan.stops, [0.3]);
    assert_eq!((plan.law.at_position(0.3).v, plan.law.end().p), (0.0, 1.0));
    assert!(plan.law.at_position(0.15).v > 0.19 && plan.law.at_position(0.6).v > 0.19);
    // Speeds at the ends of the path hold at these alone, not at the stop.
    let plan = planner.plan(1000, |range| slow(range).and_then(|problem| problem.with_end_speeds(0.1, 0.15))).unwrap();
    assert_eq!((plan.stops.as_slice(), plan.law.at_position(0.3).v), ([0.3].as_slice(), 0.0));
    let speeds = [plan.law.at_position(0.0).v, plan.law.at_position(0.3 - 1e-12).v, plan.law.end().v];
    assert!((speeds[0] - 0.1).abs() < 1e-9 && speeds[1] < 1e-3 && (speeds[2] - 0.15).abs() < 1e-9, "{speeds:?}");
    // What cannot be planned at all says why.
    let error = planner.plan(1000, |range| slow(range).and_then(|problem| problem.with_end_speeds(0.5, 0.0)));
    assert!(matches!(error, Err(FeedError::SpeedOutOfReach { .. })), "{error:?}");
    for window in [63, 100_001] {
        assert!(WindowedJerkLimited::new(JerkLimited::default(), window).is_err(), "{window}");
    }
}

/// Beside the law itself, eight times as many intervals need no more memory.
#[test]
fn memory_is_that_of_a_window() {
    let spline = path(3, 50);
    let law_bytes = 2 * 160;
    let [short, long] = [1, 8].map(|times| {
        let grid = spline.on_knots(49 * 40 * times);
        let bytes = most_bytes_in(|| {
            black_box(windowed(&spline, &grid, 400));
        });
        (grid.len() - 1, bytes)
    });
    let more = long.1 as f64 - short.1 as f64;
    assert!(more < (law_bytes * (long.0 - short.0)) as f64, "{short:?} {long:?}");
    let grid = spline.on_knots(49 * 40);
    let whole = most_bytes_in(|| {
        black_box(JerkLimited::default().plan(&stretch(&spline, &grid, 0..grid.len() - 1).unwrap()).unwrap());
    });
    assert!(short.1 * 2 < whole, "{} bytes in windows, {whole} at once", short.1);
}
