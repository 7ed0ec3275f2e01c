//! A polyline, where the tool has to stop at the corners, with the tool turning on the way.
//!
//! `cargo run -p arcfeed-interp --example 03_corners_and_orientation`

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, MotionPath, Planner, ToolLimits, ToolPath};
use arcfeed_kinematics::{Joints, models};
use nalgebra::{UnitQuaternion, Vector3, vector};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let corners = vec![
        vector![0.40, -0.10, 0.25],
        vector![0.50, -0.10, 0.25],
        vector![0.50, 0.05, 0.25],
        vector![0.40, 0.10, 0.28],
    ];
    let curve = ArcLengthCurve::new(NurbsCurve::polyline(corners)?, 1e-15)?;
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.8) * down;
    let orientation = OrientationPath::slerp(curve.length(), down, turned)?;
    let path = PosePath::new(curve, orientation);

    let arm = models::cr7();
    let limits = arm.range().with_rates(Joints::repeat(3.1), Joints::repeat(10.0), Joints::repeat(100.0))?;
    let tool = ToolLimits::new()
        .with_feed(0.2)?
        .with_tangential_acceleration(2.0)?
        .with_tangential_jerk(40.0)?
        .with_normal_acceleration(2.0)?;
    let path = ToolPath::new(&arm, path, arm.range())?;
    let plan = Planner::new(&arm, Limits::new(limits).with_tool(tool)).plan(&path)?;
    println!("{:.1} mm in {:.3} s", path.length() * 1e3, plan.duration());
    for s in plan.stops() {
        println!("  stops at the corner s = {:.1} mm (speed there {} mm/s)", s * 1e3, plan.law().v_at_s(s) * 1e3);
    }
    Ok(())
}
