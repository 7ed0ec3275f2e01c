//! Tests of where the planner begins.

use super::super::parts::prepare;
use super::*;
use crate::constraint::{
    Feed, JointJerk, JointVelocity, PathConstraint, PathDerivatives, TangentialAcceleration, TangentialJerk,
};
use crate::{FeedPlanner, JerkLimited};

/// Windows that grow and shrink along the values, as they do on a grid with intervals of any length.
#[test]
fn least_and_mean_are_those_of_the_window() {
    let values: Vec<f64> = (0..60).map(|k| f64::from(k * 37 % 61)).collect();
    let reach = |k: usize| [k, 59 - k, 1 + k / 9].into_iter().min().unwrap_or(0);
    let (mut least, mut mean) = (Vec::new(), Vec::new());
    least_within(&values, reach, &mut least);
    mean_within(&values, reach, &mut mean);
    for k in 0..values.len() {
        let window = &values[k - reach(k)..=k + reach(k)];
        assert_eq!(least[k], window.iter().copied().fold(f64::INFINITY, f64::min), "at {k}");
        assert!((mean[k] - window.iter().sum::<f64>() / window.len() as f64).abs() < 1e-12, "at {k}");
    }
}

/// Whatever a step takes of the jerk, which grows with another power than the rest of it.
#[test]
fn a_motion_slowed_by_its_scales_is_inside() {
    let grid: Vec<f64> = (0..=20).map(|i| 0.05 * f64::from(i)).collect();
    let (ones, none) = ([1.0; 21], [0.0; 21]);
    for step in [0.0, 0.1, 3.0, 50.0] {
        let steps: [f64; 20] = std::array::from_fn(|k| if k == 9 { step } else { 0.0 });
        let path = PathDerivatives::new(1, &ones, &none).and_then(|path| path.with_third(&none)).expect("finite");
        let path = path.with_steps(&steps).expect("one for each interval");
        let (velocity, jerk) = (JointVelocity::new(path, &[9.0]), JointJerk::new(path, &[10.0]));
        let limits: [&dyn PathConstraint; 2] = [&velocity.expect("above 0"), &jerk.expect("above 0")];
        let problem = FeedProblem::between_points(&grid, &limits).expect("a grid");
        let prepared = prepare(&problem).expect("moves");
        let part = &prepared.parts[0];
        let ends = [part.grid.start, part.grid.end];
        let barrier_problem = BarrierProblem::new(&prepared.problem, ends, part.speeds, &prepared.fastest);
        let (count, mut values) = (barrier_problem.knots.coefficients(), Values::default());
        let x = |i: usize| 4.0 * (std::f64::consts::PI * (i as f64 + 0.5) / count as f64).sin().powi(2);
        let mut c: Vec<f64> = (0..count).map(x).collect();
        barrier_problem.knots.evaluate(&c, &mut values);
        assert!(!barrier_problem.is_inside(&values), "{step}");
        let [scale, jerk_scale] = barrier_problem.largest_scales(&values);
        c.iter_mut().for_each(|c| *c *= 0.999_999 * scale.min(jerk_scale));
        barrier_problem.knots.evaluate(&c, &mut values);
        assert!(barrier_problem.is_inside(&values), "{step}");
    }
}

/// The plan of a problem is a start for the same one. For one with a fifth of its speeds it is none.
#[test]
fn a_plan_is_a_start_for_limits_that_are_about_the_same() {
    let grid: Vec<f64> = (0..=20).map(|i| 0.05 * f64::from(i)).collect();
    let problem = |part: f64| {
        let feeds = [0.6 * part; 20];
        let (feed, acceleration) = (Feed::new(&feeds), TangentialAcceleration::new(2.0 * part * part));
        let jerk = TangentialJerk::new(20.0 * part.powi(3)).expect("above 0");
        let limits: [&dyn PathConstraint; 3] = [&feed.expect("above 0"), &acceleration.expect("above 0"), &jerk];
        FeedProblem::between_points(&grid, &limits).expect("a grid")
    };
    let law = JerkLimited::default().plan(&problem(1.0)).expect("moves");
    for (part, is_near) in [(1.0, true), (1.01, true), (0.95, true), (0.2, false)] {
        let problem = problem(part);
        let prepared = prepare(&problem).expect("moves");
        let whole = &prepared.parts[0];
        let ends = [whole.grid.start, whole.grid.end];
        let mut barrier_problem = BarrierProblem::new(&prepared.problem, ends, whole.speeds, &prepared.fastest);
        let found = near(&prepared.problem, &mut barrier_problem, &law);
        assert_eq!(found.is_some(), is_near, "{part}");
        let mut values = Values::default();
        if let Some(near) = found {
            barrier_problem.knots.evaluate(&near.start, &mut values);
            assert!(barrier_problem.is_inside(&values), "{part}");
        }
    }
}
