//! Braking and changing the speed from a moving, accelerating state, without a jump in acceleration.
use arcfeed_feedrate::{AxisLimits, MotionLaw, SpeedChange};

mod common;
use common::{Curve, Panel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let limits = AxisLimits::symmetric(0.20, 0.8, 12.0)?;
    let (v, a) = (0.08, 0.6);
    let cases = [
        ("to rest", "#c0392b", SpeedChange::brake(v, a, &limits)?),
        ("to 0.05 m/s", "#1f6fb2", SpeedChange::new(v, a, 0.05, &limits)?),
        ("to 0.20 m/s", "#2a8a4a", SpeedChange::new(v, a, 0.20, &limits)?),
        ("braking hard already, to rest", "#8a4aa0", SpeedChange::brake(v, -1.2, &limits)?),
    ];
    for (name, _, change) in &cases {
        println!(
            "{name}: {:.4} s, {:.5} m, speed {:.4} .. {:.4} m/s",
            change.duration(),
            change.length(),
            change.lowest_speed(),
            change.highest_speed()
        );
    }
    let curves = |f: fn(&arcfeed_feedrate::MotionState) -> f64| -> Vec<Curve> {
        cases
            .iter()
            .map(|(name, colour, change)| Curve {
                name,
                colour,
                points: (0..=1000).map(|i| 0.4 * f64::from(i) / 1000.0).map(|t| (t, f(&change.at(t)))).collect(),
            })
            .collect()
    };
    common::write(
        "feedrate_02_speed_change.svg",
        "From 0.08 m/s, accelerating at 0.6 m/s2 (one case: braking at 1.2 m/s2, beyond the limit)",
        "time in s",
        &[
            Panel { label: "v m/s", curves: curves(|s| s.v), limits: vec![limits.v_max()] },
            Panel { label: "a m/s2", curves: curves(|s| s.a), limits: vec![limits.a_max(), -limits.a_max()] },
        ],
    )?;
    Ok(())
}
