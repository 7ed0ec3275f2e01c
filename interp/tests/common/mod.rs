//! An arm, limits and paths that the tests share.
#![allow(dead_code, reason = "every test uses some of it")]

use std::f64::consts::PI;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Plan, PlanError, Planner, ToolLimits, best_start};
use arcfeed_kinematics::{JointLimits, Joints, ParallelAxisArm, models};
use nalgebra::{UnitQuaternion, Vector3, vector};

pub const TOOL: ToolLimits = ToolLimits {
    feed: 0.2,
    tangential_acceleration: 1.0,
    tangential_jerk: 30.0,
    normal_acceleration: 1.0,
    normal_jerk: None,
    angular_speed: None,
};

pub fn arm() -> ParallelAxisArm {
    models::ur5e()
}

pub fn limits(arm: &ParallelAxisArm) -> JointLimits<6> {
    arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(200.0)).expect("valid limits")
}

pub fn down() -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(PI, 0.0, 0.0)
}

/// The curve with the tool pointing down.
pub fn tool_down(curve: NurbsCurve<3>) -> PosePath {
    PosePath::new(by_length(curve), OrientationPath::Constant(down()))
}

pub fn by_length(curve: NurbsCurve<3>) -> ArcLengthCurve<3> {
    ArcLengthCurve::new(curve, 1e-15).expect("a curve of some length")
}

/// A rational quintic without inner knots: analytic from end to end.
pub fn analytic() -> NurbsCurve<3> {
    NurbsCurve::new(
        5,
        vec![
            vector![0.40, -0.10, 0.20],
            vector![0.45, -0.02, 0.26],
            vector![0.36, 0.04, 0.22],
            vector![0.34, 0.10, 0.30],
            vector![0.44, 0.12, 0.32],
            vector![0.48, 0.20, 0.25],
        ],
        vec![1.0, 1.3, 0.8, 1.1, 0.9, 1.0],
        [vec![0.0; 6], vec![1.0; 6]].concat(),
    )
    .expect("a valid curve")
}

/// A cubic spline with three inner knots, where the third derivative jumps.
pub fn knotted() -> NurbsCurve<3> {
    NurbsCurve::bspline(
        3,
        vec![
            vector![0.40, -0.15, 0.20],
            vector![0.46, -0.08, 0.22],
            vector![0.38, -0.02, 0.26],
            vector![0.36, 0.06, 0.24],
            vector![0.44, 0.08, 0.20],
            vector![0.46, 0.16, 0.22],
            vector![0.40, 0.20, 0.26],
        ],
        vec![0.0, 0.0, 0.0, 0.0, 0.3, 0.5, 0.8, 1.0, 1.0, 1.0, 1.0],
    )
    .expect("a valid curve")
}

/// A line that runs into a quarter circle of `radius`: the tangent is continuous, the curvature jumps to 1 / radius.
pub fn line_and_arc(length: f64, radius: f64) -> NurbsCurve<3> {
    let start = vector![0.40, -0.10, 0.20];
    let (x, y) = (Vector3::x(), Vector3::y());
    let bend = start + y * length;
    NurbsCurve::new(
        2,
        vec![start, start + y * (0.5 * length), bend, bend + y * radius, bend + (x + y) * radius],
        vec![1.0, 1.0, 1.0, std::f64::consts::FRAC_1_SQRT_2, 1.0],
        vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0],
    )
    .expect("a valid curve")
}

/// A plan of the tool-down motion along `curve` at a control period of 2 ms and a chord tolerance of 10 um.
pub fn plan(arm: &ParallelAxisArm, curve: NurbsCurve<3>) -> Result<Plan, PlanError> {
    plan_path(arm, tool_down(curve), TOOL)
}

pub fn plan_path(arm: &ParallelAxisArm, path: PosePath, tool: ToolLimits) -> Result<Plan, PlanError> {
    let limits = limits(arm);
    let start = best_start(arm, &path, limits.lower(), limits.upper())?;
    Planner::new(arm, limits, tool)?.with_period(2e-3)?.with_chord_tolerance(1e-5)?.plan(path, &start)
}
