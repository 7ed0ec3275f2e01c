//! Curves of the tool on the CR7, under limits that many measurements share.

use std::f64::consts::PI;
use std::sync::Arc;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, Planner, ToolLimits, ToolPath, Trajectory};
use arcfeed_kinematics::{Joints, ParallelAxisArm};
use nalgebra::UnitQuaternion;

/// Whatever prevents a plan.
pub type Failure = Box<dyn std::error::Error>;

/// Feed, tangential acceleration, tangential jerk and normal acceleration of the tool that most measurements take, SI.
pub const TOOL: [f64; 4] = [0.1, 1.0, 20.0, 1.0];

/// The motion along a curve (m, in the base) with the tool pointing down, under limits of the tool as [`TOOL`].
///
/// # Errors
/// Whatever prevents a plan.
pub fn planned<'a>(arm: &'a ParallelAxisArm, curve: NurbsCurve<3>, tool: [f64; 4]) -> Result<Trajectory<'a>, Failure> {
    let rates = [PI, 10.0, 100.0].map(Joints::repeat);
    let limits = arm.range().with_rates(rates[0], rates[1], rates[2])?;
    let down = UnitQuaternion::from_euler_angles(PI, 0.0, 0.0);
    let path = PosePath::new(ArcLengthCurve::new(curve, 1e-15)?, OrientationPath::Constant(down));
    let path = ToolPath::new(arm, path, limits.range())?;
    let [feed, tangential, jerk, normal] = tool;
    let tool = ToolLimits::new()
        .with_feed(feed)?
        .with_tangential_acceleration(tangential)?
        .with_tangential_jerk(jerk)?
        .with_normal_acceleration(normal)?;
    Ok(Planner::new(arm, Limits::new(limits).with_tool(tool)).plan_shared(Arc::new(path))?)
}
