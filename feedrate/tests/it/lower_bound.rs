//! Lower bounds on the duration: against closed forms, against plans on finer grids, and against the optima of programs.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, TangentialAcceleration, TangentialJerk,
};
use arcfeed_feedrate::{AxisLimits, FeedError, FeedPlanner, FeedProblem, JerkLimited, LowerBound, MotionLaw, SProfile};

use crate::spline_paths;
use spline_paths::{A_MAX, Path, V_A, V_B, paths};

/// Along a straight line the optimum is the seven-phase profile.
#[test]
fn the_seven_phase_profile_is_bounded_closely() {
    for (length, feed, acceleration, jerk) in [
        (0.2, 0.2, 2.0, 40.0),
        (0.05, 0.4, 3.0, 20.0),
        (1.0, 0.1, 5.0, 400.0),
        (1e-3, 1.0, 1.0, 1000.0),
        (2.0, 3.0, 1.5, 4.0),
    ] {
        let limits = AxisLimits::symmetric(feed, acceleration, jerk).unwrap();
        let exact = SProfile::new(length, 0.0, 0.0, &limits).unwrap().duration();
        for n in [50_u32, 400] {
            let grid: Vec<f64> = (0..=n).map(|i| length * f64::from(i) / f64::from(n)).collect();
            let feeds = vec![feed; n as usize];
            let cap = Feed::new(&feeds).unwrap();
            let (a, j) = (TangentialAcceleration::new(acceleration).unwrap(), TangentialJerk::new(jerk).unwrap());
            let problem = FeedProblem::between_points(&grid, &[&cap, &a, &j]).unwrap();
            let plan = JerkLimited::default().plan(&problem).unwrap();
            let bound = LowerBound::new(&problem, &plan).unwrap();
            let part = bound.duration / exact;
            println!(
                "{length} {feed} {acceleration} {jerk} N {n}: bound / exact {part:.6}, plan / exact {:.6}",
                plan.duration() / exact
            );
            assert!(bound.duration <= plan.duration() && part > 0.99, "{part}");
            // The profile itself is no spline on the grid.
            assert!(part <= 1.0 + 0.5 / f64::from(n), "{part}");
            assert_eq!(bound.conditional, 0);
        }
    }
}

fn problem(path: &Path, case: char, n: usize, ends: [f64; 2]) -> FeedProblem {
    let grid = path.spline.on_knots(n);
    let samples = path.spline.samples(&grid);
    let velocity = JointVelocity::new(samples.path(), if case == 'B' { &V_B } else { &V_A }).unwrap();
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
    let most = A_MAX.map(|a| 10.0 * a);
    let jerk = JointJerk::new(samples.path(), &most).unwrap();
    let problem = FeedProblem::between_points(&grid, &[&velocity, &acceleration, &jerk]).unwrap();
    problem.with_end_speeds(ends[0], ends[1]).unwrap()
}

/// Plans stay above the bound, on finer grids too, and close to it.
#[test]
fn plans_of_joint_splines_are_close_to_their_bound() {
    let mut gaps = Vec::new();
    for path in paths().iter().step_by(if cfg!(debug_assertions) { 5 } else { 1 }) {
        for case in ['A', 'B'] {
            let problem_at = |n: usize| problem(path, case, n, [0.0; 2]);
            let (coarse, fine) = (problem_at(1000), problem_at(4000));
            let plan = JerkLimited::default().plan(&coarse).unwrap();
            let bound = LowerBound::new(&coarse, &plan).unwrap();
            let finer = JerkLimited::new(1e-5).unwrap().plan(&fine).unwrap();
            let at = format!("seed {} {case}", path.seed);
            println!(
                "{at}: gap {:.5}, {} of {} intervals, finer grid {:.5}",
                plan.duration() / bound.duration - 1.0,
                bound.conditional,
                bound.intervals,
                finer.duration() / bound.duration - 1.0
            );
            assert!(bound.duration < plan.duration(), "{at}");
            // The bound is for motions on its grid; those on a finer one are less bound.
            assert!(bound.duration < finer.duration() * 1.003, "{at}: {} on a finer grid", finer.duration());
            gaps.push(plan.duration() / bound.duration - 1.0);
        }
    }
    gaps.sort_by(f64::total_cmp);
    println!("median {:.5}, worst {:.5}", gaps[gaps.len() / 2], gaps[gaps.len() - 1]);
    assert!(gaps[gaps.len() - 1] < 0.001, "{gaps:?}");
}

#[test]
fn motions_between_speeds_have_bounds() {
    let problem = problem(&paths()[2], 'A', 200, [0.004, 0.006]);
    let plan = JerkLimited::default().plan(&problem).unwrap();
    let bound = LowerBound::new(&problem, &plan).unwrap();
    let part = plan.duration() / bound.duration;
    assert!((1.0..1.02).contains(&part), "{part} {bound:?}");
}

#[test]
fn what_has_no_jerk_is_refused() {
    let grid = [0.0, 0.1, 0.2, 0.3];
    let limit = TangentialAcceleration::new(1.0).unwrap();
    let problem = FeedProblem::between_points(&grid, &[&limit]).unwrap();
    let law = arcfeed_feedrate::SpeedLaw::from_knots(&grid, &[0.0, 0.1, 0.1, 0.0]).unwrap();
    assert!(matches!(LowerBound::new(&problem, &law), Err(FeedError::Empty { .. })));
}
