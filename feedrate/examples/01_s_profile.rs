//! One S-profile: speed, acceleration and jerk over time, and what an adaptive one says when the way is too short.
use arcfeed_feedrate::{Adjust, AxisLimits, MotionLaw, SProfile};

mod common;
use common::{Curve, Panel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let limits = AxisLimits::symmetric(0.10, 0.8, 12.0)?;
    let profile = SProfile::new(0.04, 0.02, 0.0, &limits)?;
    println!("{:.4} m in {:.4} s, cruising at {:.4} m/s", profile.length(), profile.duration(), profile.v_peak());

    let short = SProfile::adaptive(0.002, 0.08, 0.0, &limits, Adjust::End)?;
    println!("over 2 mm from 0.08 m/s to rest: {:?}", short.adjusted());

    let sample = |f: fn(&arcfeed_feedrate::MotionState) -> f64| -> Vec<(f64, f64)> {
        (0..=2000).map(|i| profile.duration() * f64::from(i) / 2000.0).map(|t| (t, f(&profile.at(t)))).collect()
    };
    let panel = |label, colour, limit: f64, both: bool, points| Panel {
        label,
        curves: vec![Curve { name: "", colour, points }],
        limits: if both { vec![limit, -limit] } else { vec![limit] },
    };
    common::write(
        "feedrate_01_s_profile.svg",
        "Seven phases from 0.02 m/s to rest",
        "time in s",
        &[
            panel("v m/s", "#1f6fb2", limits.v_max(), false, sample(|s| s.v)),
            panel("a m/s2", "#2a8a4a", limits.a_max(), true, sample(|s| s.a)),
            panel("j m/s3", "#8a4aa0", limits.j_max(), true, sample(|s| s.j)),
        ],
    )?;
    Ok(())
}
