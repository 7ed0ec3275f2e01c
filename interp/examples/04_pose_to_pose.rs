//! From one pose to another as fast as velocity, acceleration, torque and jerk allow, and which of them binds where.
//!
//! `cargo run -p arcfeed-interp --example 04_pose_to_pose`

use arcfeed_geometry::PoseMotion;
use arcfeed_interp::{Limits, Method, Planner, PoseMove, ToolLimits};
use arcfeed_kinematics::{ForwardKinematics, Inertial, Joints, models};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let description = models::description("kr6_r700").ok_or("a built-in arm")?;
    let arm = description.build::<6>()?;
    let start = arm.forward(&Joints::from([0.6, -1.4, 1.9, 0.0, 1.0, 0.3]));
    // Half a metre along y, and a quarter of a turn about the vertical.
    let turn = UnitQuaternion::new(Vector3::z() * std::f64::consts::FRAC_PI_2);
    let goal =
        Isometry3::from_parts((start.translation.vector + Vector3::new(0.0, 0.5, 0.0)).into(), turn * start.rotation);
    let motion = PoseMotion::new(&start, &goal)?;
    println!("{}: {:.3} m and {:.3} rad by {}", motion.kind(), motion.length(), motion.angle(), motion.parameter());

    // The links are known, so torques can be limited; the flange carries 4 kg.
    let load = Inertial::new(4.0, Vector3::new(0.0, 0.0, 0.08), Matrix3::identity() * 0.01)?;
    let dynamics = arm.dynamics().ok_or("its links are known")?.with_payload(load)?;
    let rates = [2.5, 15.0, 300.0].map(Joints::repeat);
    let limits = Limits::new(arm.range().with_rates(rates[0], rates[1], rates[2])?)
        .with_torque(&dynamics, Joints::from([60.0, 90.0, 50.0, 12.0, 12.0, 8.0]))?
        .with_tool(ToolLimits::new().with_feed(1.0)?);
    let path = PoseMove::new(&arm, motion, arm.range())?;
    let planner = Planner::new(&arm, limits);
    for method in [Method::ForwardBackward, Method::Reachability, Method::InterpolatedReachability, Method::JerkLimited]
    {
        let plan = planner.clone().with_method(method).plan(&path)?;
        let check = plan.verification();
        println!("\n{method}: {:.4} s, at most {:.4} % of a limit", plan.duration(), 100.0 * check.worst().ratio);
        for binding in check.bindings() {
            let places: Vec<String> = binding.intervals.iter().map(|(a, b)| format!("{a:.3}..{b:.3}")).collect();
            println!("  {:<26}{}", binding.id.to_string(), places.join(" "));
        }
    }
    Ok(())
}
