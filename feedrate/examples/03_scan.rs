//! Speed over a path of many short segments: one S-profile per segment against joined segments, under the cap.
use arcfeed_feedrate::{MotionLaw, Segment, SpeedLaw, boundaries, plan_continuous, plan_per_segment, plan_windowed};

mod common;
use common::{Curve, Panel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A feed of 0.1 m/s, slow slopes and three corners.
    let segments = (0..800)
        .map(|i| {
            let s = f64::from(i) / 800.0;
            let slope = 0.06 + 0.05 * (9.0 * s).sin();
            let corner = |at: f64, depth: f64, width: f64| depth * (1.0 + ((s - at) / width).powi(2));
            let cap =
                slope.min(corner(0.22, 0.004, 0.01)).min(corner(0.61, 0.012, 0.02)).min(corner(0.8, 0.006, 0.006));
            Segment::new(2e-4, cap.min(0.1), 1.0, 50.0)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let joined = plan_continuous(&segments, 0.0, 0.0)?;
    let single = plan_per_segment(&segments, 0.0, 0.0)?;
    let windowed = plan_windowed(&segments, 0.0, 10)?;
    println!("joined:                 {:.4} s", joined.duration());
    for (name, plan) in [("one profile a segment: ", &single), ("window of 10 segments:  ", &windowed)] {
        let cost = 100.0 * (plan.duration() / joined.duration() - 1.0);
        println!("{name} {:.4} s, {cost:.1} % longer", plan.duration());
    }

    let s = boundaries(&segments);
    let cap = segments.iter().enumerate().flat_map(|(i, x)| [(s[i], x.v_max()), (s[i + 1], x.v_max())]).collect();
    let curve = |name, colour, plan: &SpeedLaw, f: fn(&arcfeed_feedrate::MotionState) -> f64| Curve {
        name,
        colour,
        points: (0..=8000)
            .map(|i| plan.at(plan.duration() * f64::from(i) / 8000.0))
            .map(|state| (state.p, f(&state)))
            .collect(),
    };
    common::write(
        "feedrate_03_scan.svg",
        "Speed under the cap of 800 segments",
        "position in m",
        &[
            Panel {
                label: "v m/s",
                curves: vec![
                    Curve { name: "cap", colour: "#c0392b", points: cap },
                    curve("one profile a segment", "#d49a2a", &single, |x| x.v),
                    curve("joined", "#1f6fb2", &joined, |x| x.v),
                ],
                limits: vec![],
            },
            Panel {
                label: "a m/s2",
                curves: vec![
                    curve("one profile a segment", "#d49a2a", &single, |x| x.a),
                    curve("joined", "#1f6fb2", &joined, |x| x.a),
                ],
                limits: vec![1.0, -1.0],
            },
        ],
    )?;
    Ok(())
}
