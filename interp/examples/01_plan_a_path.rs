//! Plan a tool path for an arm of your own choice, and look at what limits it.
//!
//! `cargo run -p arcfeed-interp --example 01_plan_a_path`

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, MotionPath, Planner, ToolLimits, ToolPath};
use arcfeed_kinematics::{Joints, models};
use nalgebra::{UnitQuaternion, Vector3, vector};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A wavy line 0.5 m in front of a UR5e, tool down.
    let points = (0..12).map(|i| {
        let x = f64::from(i) / 11.0;
        vector![0.45 + 0.04 * (9.0 * x).sin(), -0.2 + 0.4 * x, 0.25]
    });
    let knots = arcfeed_geometry::KnotVector::clamped_uniform(4, 12)?;
    let curve = NurbsCurve::bspline(4, points.collect(), knots.as_slice().to_vec())?;
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let path = PosePath::new(ArcLengthCurve::new(curve, 1e-15)?, OrientationPath::Constant(down));

    let arm = models::ur5e();
    let limits = arm.range().with_rates(Joints::repeat(3.1), Joints::repeat(8.0), Joints::repeat(80.0))?;
    let tool = ToolLimits::new()
        .with_feed(0.25)?
        .with_tangential_acceleration(1.5)?
        .with_tangential_jerk(30.0)?
        .with_normal_acceleration(1.5)?;
    let path = ToolPath::new(&arm, path, arm.range())?;
    let plan = Planner::new(&arm, Limits::new(limits).with_tool(tool)).plan(&path)?;

    println!("{:.1} mm in {:.3} s, verified:", path.length() * 1e3, plan.duration());
    for check in plan.verification().checks().iter().filter(|c| c.ratio > 0.5) {
        println!("  {}: {:.1} % at s = {:.1} mm", check.id, 100.0 * check.ratio, check.s * 1e3);
    }
    for setpoint in plan.setpoints(0.2)? {
        let p = setpoint?;
        println!(
            "  t {:.1} s  feed {:6.1} mm/s  q {:?}",
            p.t,
            p.feed * 1e3,
            p.q.map(|a| (a * 1e4).round() / 1e4).as_slice()
        );
    }
    Ok(())
}
