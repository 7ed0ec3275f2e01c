//! The conic optimum against its recorded values, and as a bound for the other planners.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
#![cfg(feature = "clarabel")]
use arcfeed_feedrate::constraint::{JointAcceleration, JointVelocity};
use arcfeed_feedrate::{BothEndsScan, ClarabelBaseline, FeedPlanner, FeedProblem, Reachability};

#[path = "common/spline_paths.rs"]
mod spline_paths;
use spline_paths::{A_MAX, Spline, V_A, V_B, paths};

#[test]
fn optimum_and_dual_bound() {
    for path in paths().iter().step_by(4) {
        for r in path.references.iter().filter(|r| r.case != 'C' && r.n == 100) {
            let grid = Spline::uniform(r.n);
            let samples = path.spline.samples(&grid);
            let velocity = JointVelocity::new(samples.path(), if r.case == 'B' { &V_B } else { &V_A }).unwrap();
            let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
            let problem = FeedProblem::at_points(&grid, &[&velocity, &acceleration]).unwrap();
            let bounded = ClarabelBaseline.solve(&problem).unwrap();
            let at = format!("seed {} case {}", path.seed, r.case);
            let duration = bounded.plan.duration();
            assert!((duration / r.conic - 1.0).abs() < 2e-5, "{at}: {duration} instead of {}", r.conic);
            assert!((bounded.lower_bound / r.dual_bound - 1.0).abs() < 2e-5, "{at}: {}", bounded.lower_bound);
            assert!(bounded.lower_bound <= duration * (1.0 + 1e-6), "{at}");
            for plan in [BothEndsScan.plan(&problem).unwrap(), Reachability.plan(&problem).unwrap()] {
                assert!(plan.duration() >= bounded.lower_bound * (1.0 - 1e-6), "{at}");
            }
        }
    }
}
