//! An arm, limits and paths that the tests share.
#![allow(dead_code, reason = "every test uses some of it")]

pub mod bent;

use std::f64::consts::PI;
use std::sync::Arc;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    HybridMotion, Limits, LivePath, MotionPath, PlanError, Planner, ToolLimits, ToolPath, Trajectory,
};
use arcfeed_kinematics::{JointLimits, Joints, ParallelAxisArm, models};
use nalgebra::{UnitQuaternion, Vector3, vector};

pub const FEED: f64 = 0.2;
pub const TANGENTIAL_ACCELERATION: f64 = 1.0;
pub const TANGENTIAL_JERK: f64 = 30.0;
pub const NORMAL_ACCELERATION: f64 = 1.0;

pub fn tool() -> ToolLimits {
    tool_with_feed(FEED)
}

pub fn tool_with_feed(feed: f64) -> ToolLimits {
    ToolLimits::new()
        .with_feed(feed)
        .and_then(|t| t.with_tangential_acceleration(TANGENTIAL_ACCELERATION))
        .and_then(|t| t.with_tangential_jerk(TANGENTIAL_JERK))
        .and_then(|t| t.with_normal_acceleration(NORMAL_ACCELERATION))
        .expect("valid limits")
}

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

/// A live motion along [`knotted`] at 80 % of the feed.
pub fn live_on_the_knotted_path<R>(run: impl FnOnce(&LivePath<'_>, HybridMotion<'_>) -> R) -> R {
    let arm = arm();
    let planner = Planner::new(&arm, Limits::new(limits(&arm)).with_tool(tool()));
    let path = ToolPath::new(&arm, tool_down(knotted()), arm.range()).expect("in reach");
    let live = planner.live(path).expect("in reach");
    let motion = HybridMotion::new(&live, 0.8 * FEED).expect("a feed");
    run(&live, motion)
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
pub fn plan(arm: &ParallelAxisArm, curve: NurbsCurve<3>) -> Result<Trajectory<'_>, PlanError> {
    plan_path(arm, tool_down(curve), tool())
}

pub fn plan_path(arm: &ParallelAxisArm, path: PosePath, tool: ToolLimits) -> Result<Trajectory<'_>, PlanError> {
    let limits = limits(arm);
    let path = ToolPath::new(arm, path, limits.range())?;
    Planner::new(arm, Limits::new(limits).with_tool(tool))
        .with_period(2e-3)?
        .with_chord_tolerance(1e-5)?
        .plan_shared(Arc::new(path))
}

/// The joints at the start of `path` in the best of all configurations.
pub fn start(arm: &ParallelAxisArm, path: &PosePath) -> Joints<6> {
    ToolPath::new(arm, path.clone(), arm.range()).expect("in reach").start()
}
