//! One axis between two moving states in several durations, and the durations in which it cannot be done.
use arcfeed_feedrate::{AxisLimits, AxisProblem, AxisState, FeedError, MotionLaw, MotionState, StateToState};

mod common;
use common::{Curve, Panel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let limits = AxisLimits::symmetric(1.0, 3.0, 20.0)?;
    // Passes by at 0.9 m/s and is to be 0.25 m on at 0.8 m/s.
    let problem = AxisProblem::new(&AxisState::new(0.0, 0.9, 0.0), &AxisState::new(0.25, 0.8, 0.0), &limits)?;
    let durations = problem.durations();
    println!("shortest {:.4} s", durations.shortest());
    for (from, to) in durations.blocked() {
        println!("impossible between {from:.4} s and {to:.4} s");
    }
    let Some(&(last_before, first_after)) = durations.blocked().first() else {
        return Err("this problem has a blocked interval".into());
    };
    // In between it says what would be possible instead.
    match problem.with_duration(0.5 * (last_before + first_after)) {
        Err(e @ FeedError::DurationImpossible { .. }) => println!("{e}"),
        other => return Err(format!("{other:?}").into()),
    }
    let shortest = problem.shortest();
    let slow = problem.with_duration(last_before)?;
    let turning = problem.with_duration(first_after)?;
    let end = turning.duration();
    let curve = |name, colour, motion: &StateToState, f: fn(&MotionState) -> f64| Curve {
        name,
        colour,
        points: (0..=2000)
            .map(|i| end * f64::from(i) / 2000.0)
            .take_while(|&t| t <= motion.duration())
            .map(|t| (t, f(&motion.at(t))))
            .collect(),
    };
    let panel = |label, levels: Vec<f64>, f: fn(&MotionState) -> f64| Panel {
        label,
        curves: vec![
            curve("shortest", "#1f6fb2", &shortest, f),
            curve("longest before the blocked interval", "#2a9d5c", &slow, f),
            curve("shortest after it", "#d2691e", &turning, f),
        ],
        limits: levels,
    };
    common::write(
        "feedrate_05_given_duration.svg",
        "The same two states in three durations",
        "time in s",
        &[
            panel("p m", vec![], |s| s.p),
            panel("v m/s", vec![limits.v_min(), limits.v_max()], |s| s.v),
            panel("a m/s2", vec![limits.a_min(), limits.a_max()], |s| s.a),
        ],
    )?;
    Ok(())
}
