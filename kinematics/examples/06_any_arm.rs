//! Any arm by name: what is known of it, how its inverse is solved, its Denavit-Hartenberg table, and its URDF.
//!
//! `cargo run -p arcfeed-kinematics --example 06_any_arm -- panda`

use arcfeed_kinematics::{KinematicsError, models};

fn main() -> Result<(), KinematicsError> {
    let wanted = std::env::args().nth(1);
    for name in models::NAMES.into_iter().filter(|name| wanted.as_deref().is_none_or(|wanted| wanted == *name)) {
        let Some(described) = models::description(name) else { continue };
        let arm = described.build_any()?;
        println!("{name}: {} joints, {}", arm.joints(), arm.method());
        println!("  source   {}\n  licence  {}", described.source, described.licence);
        for note in &described.notes {
            println!("  note     {note}");
        }
        for line in described.missing() {
            println!("  unknown  {line}");
        }
        // The middle of the ranges is a place every arm can stand at.
        let (lower, upper) = arm.range();
        let q: Vec<f64> = lower.iter().zip(upper).map(|(l, u)| 0.6 * l + 0.4 * u).collect();
        let pose = arm.forward(&q)?;
        let (all, complete) = arm.inverse_all(&pose)?;
        let dexterity = arm.dexterity(&q)?;
        println!(
            "  {} {} solutions for one pose; smallest singular value {:.3}, condition {:.1}",
            if complete { "all" } else { "some" },
            all.len(),
            dexterity.sigma_min,
            dexterity.condition
        );
        if let Some(six) = arm.get::<6>() {
            println!("  reach    {:.3} m at most", six.reach());
            for row in six.chain().to_dh()?.rows {
                println!("  dh       a {:8.4} alpha {:7.4} d {:8.4} theta {:7.4}", row.a, row.alpha, row.d, row.theta);
            }
            if let Some(at) = dexterity.singularities {
                println!(
                    "  nearest singular pose: {}, wrist {:.2} rad, elbow {:.2} rad, shoulder {:.2} m",
                    at.nearest, at.wrist, at.elbow, at.shoulder
                );
            }
        }
    }
    Ok(())
}
