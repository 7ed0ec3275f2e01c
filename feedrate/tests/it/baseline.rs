//! The conic optimum against its recorded values, and as a bound for the other planners.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
#![cfg(feature = "clarabel")]
use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity};
use arcfeed_feedrate::{ClarabelBaseline, FeedPlanner, FeedProblem, ForwardBackwardScan, JerkLimited, Reachability};

use crate::spline_paths;
use spline_paths::{A_MAX, JOINTS, Path, Spline, V_A, V_B, paths, worst};

#[test]
fn optimum_and_dual_bound() {
    for path in paths().iter().step_by(4) {
        for r in path.references.iter().filter(|r| r.case != 'C' && r.n == 100) {
            let grid = Spline::uniform(r.n);
            let samples = path.spline.samples(&grid);
            let velocity = JointVelocity::new(samples.path(), velocity(r.case)).unwrap();
            let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
            let problem = FeedProblem::at_points(&grid, &[&velocity, &acceleration]).unwrap();
            let bounded = ClarabelBaseline.solve(&problem).unwrap();
            let at = format!("seed {} case {}", path.seed, r.case);
            let duration = bounded.plan.duration();
            assert!((duration / r.conic - 1.0).abs() < 2e-5, "{at}: {duration} instead of {}", r.conic);
            assert!((bounded.lower_bound / r.dual_bound - 1.0).abs() < 2e-5, "{at}: {}", bounded.lower_bound);
            assert!(bounded.lower_bound <= duration * (1.0 + 1e-6), "{at}");
            for plan in [ForwardBackwardScan.plan(&problem).unwrap(), Reachability.plan(&problem).unwrap()] {
                assert!(plan.duration() >= bounded.lower_bound * (1.0 - 1e-6), "{at}");
            }
        }
    }
}

const JERK: [f64; JOINTS] = [30.6, 23.1, 34.7, 37.4, 37.4, 55.0];

fn velocity(case: char) -> &'static [f64; JOINTS] {
    if case == 'B' { &V_B } else { &V_A }
}

fn jerk_problem(path: &Path, case: char, grid: &[f64], ends: [f64; 2]) -> FeedProblem {
    let samples = path.spline.samples(grid);
    let velocity = JointVelocity::new(samples.path(), velocity(case)).unwrap();
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
    let jerk = JointJerk::new(samples.path(), &JERK).unwrap();
    let problem = FeedProblem::between_points(grid, &[&velocity, &acceleration, &jerk]).unwrap();
    problem.with_end_speeds(ends[0], ends[1]).unwrap()
}

/// Two methods that share nothing but their rows: the banded interior-point iterations and conic programs in sequence. Ours
/// keeps a margin for the jerk between the knots, the programs do not, yet durations agree.
#[test]
fn jerk_limited_beside_a_sequence_of_programs() {
    for (seed, case, ends) in
        [(0, 'A', [0.0; 2]), (3, 'A', [0.0; 2]), (7, 'B', [0.0; 2]), (13, 'B', [0.0; 2]), (2, 'A', [0.004, 0.006])]
    {
        let path = &paths()[seed];
        for n in [60, 100] {
            let at = format!("path {seed} {case} N = {n}");
            let grid = path.spline.on_knots(n);
            let problem = jerk_problem(path, case, &grid, ends);
            let conic = ClarabelBaseline.solve(&problem).unwrap();
            let [speed, acceleration, _] = worst(&path.spline, &grid, &conic.plan, 20, velocity(case), &JERK);
            assert!(speed.max(acceleration) <= 1.0 + 1e-6, "{at}: {speed} {acceleration}");
            assert!(conic.lower_bound <= conic.plan.duration(), "{at}");
            let ours = JerkLimited::default().plan(&problem).unwrap();
            let ratio = ours.duration() / conic.plan.duration();
            assert!((1.0 - 1e-4..1.0 + 5e-4).contains(&ratio), "{at}: {ratio}");
        }
    }
}
