//! One axis from any state to any state in the shortest time, also from outside its limits.
use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, MotionState, StateToState};

mod common;
use common::{Curve, Panel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Slow backwards, and brakes harder than it accelerates.
    let limits = AxisLimits::new((-0.5, 1.0), (-6.0, 4.0), (-80.0, 40.0))?;
    let moving = StateToState::new(&AxisState::new(0.0, -0.4, -1.0), &AxisState::new(0.6, 0.5, 2.0), &limits)?;
    println!("to a moving target: {:.4} s, {} phases", moving.duration(), moving.phases().len());
    let range = moving.position_range();
    println!("it goes back as far as {:.4} m at {:.4} s", range.min, range.t_min);

    // The limit was lowered while the axis ran at 1.6 m/s.
    let lowered = StateToState::new(&AxisState::new(0.0, 1.6, 0.0), &AxisState::rest(1.5), &limits)?;
    println!("from above the limit: {:.4} s", lowered.duration());

    let end = moving.duration().max(lowered.duration());
    let curve = |name, colour, motion: &StateToState, f: fn(&MotionState) -> f64| Curve {
        name,
        colour,
        points: (0..=2000).map(|i| end * f64::from(i) / 2000.0).map(|t| (t, f(&motion.at(t)))).collect(),
    };
    let panel = |label, levels: Vec<f64>, f: fn(&MotionState) -> f64| Panel {
        label,
        curves: vec![
            curve("to a moving target", "#1f6fb2", &moving, f),
            curve("from above the velocity limit", "#d2691e", &lowered, f),
        ],
        limits: levels,
    };
    common::write(
        "feedrate_04_state_to_state.svg",
        "State to state under limits that differ by sign (dashed)",
        "time in s",
        &[
            panel("p m", vec![], |s| s.p),
            panel("v m/s", vec![limits.v_min(), limits.v_max()], |s| s.v),
            panel("a m/s2", vec![limits.a_min(), limits.a_max()], |s| s.a),
            panel("j m/s3", vec![limits.j_min(), limits.j_max()], |s| s.j),
        ],
    )?;
    Ok(())
}
