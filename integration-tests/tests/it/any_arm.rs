//! The pipeline with arms that come from files, without the crate of any robot.

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, LockedArm, Method, PathArm, Planner, ToolLimits, ToolPath, Trajectory};
use arcfeed_kinematics::{Arm, ArmDescription, InverseMethod, JointLimits, Joints, models};
use nalgebra::{UnitQuaternion, vector};

fn tool() -> ToolLimits {
    ToolLimits::new()
        .with_feed(0.15)
        .and_then(|t| t.with_tangential_acceleration(1.0))
        .and_then(|t| t.with_tangential_jerk(30.0))
        .and_then(|t| t.with_normal_acceleration(1.0))
        .expect("valid limits")
}

/// A smooth curve in front of the arm, tool down.
fn path() -> PosePath {
    let points = vec![
        vector![0.40, -0.12, 0.20],
        vector![0.46, -0.06, 0.22],
        vector![0.38, 0.00, 0.25],
        vector![0.44, 0.06, 0.22],
        vector![0.40, 0.12, 0.20],
    ];
    let curve = NurbsCurve::bspline(3, points, vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0]).expect("a curve");
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    PosePath::new(ArcLengthCurve::new(curve, 1e-15).expect("of some length"), OrientationPath::Constant(down))
}

fn limits<const N: usize>(arm: &Arm<N>) -> JointLimits<N> {
    arm.range().with_rates(Joints::repeat(2.0), Joints::repeat(10.0), Joints::repeat(200.0)).expect("valid limits")
}

/// Written as URDF, read back: the arm that a user's file would give.
fn from_urdf(name: &str) -> ArmDescription {
    let text = models::description(name).expect("built in").to_urdf();
    ArmDescription::from_urdf(&text, None, None).expect("a URDF")
}

fn checked<A: PathArm<N>, const N: usize>(arm: &A, plan: &Trajectory<'_, N>) {
    let curve = plan.path().tool_curve().expect("a curve").curve();
    assert!(plan.verification().holds(1e-6));
    for setpoint in plan.setpoints(2e-3).expect("a period") {
        let at = setpoint.expect("on the path");
        let tool = arm.forward(&at.q);
        assert!((tool.translation.vector - curve.point(at.s)).norm() < 1e-9, "s = {}", at.s);
    }
}

#[test]
fn six_joints_from_a_urdf_file() {
    for (name, method) in [
        ("ur5e", InverseMethod::ParallelAxis),
        ("kr6_r700", InverseMethod::SphericalWrist),
        ("cr7", InverseMethod::ParallelAxis),
    ] {
        let arm = from_urdf(name).build::<6>().expect("six joints");
        assert_eq!(arm.method(), method, "{name}");
        let path = ToolPath::new(&arm, path(), arm.range()).expect("in reach");
        let plan = Planner::new(&arm, Limits::new(limits(&arm)).with_tool(tool())).plan(&path);
        let plan = plan.expect("it can be followed");
        checked(&arm, &plan);
    }
}

#[test]
fn seven_joints_from_a_urdf_file() {
    let arm = from_urdf("panda").build::<7>().expect("seven joints");
    let path = path();
    let (locked, start) = LockedArm::for_path(&arm, &path).expect("in reach");
    let path = ToolPath::starting_near(&locked, path, &start).expect("in reach");
    let plan = Planner::new(&locked, Limits::new(limits(&arm)).with_tool(tool())).plan(&path);
    let plan = plan.expect("it can be followed");
    checked(&locked, &plan);
}

/// Where the joints' jerk is what limits the speed, sharing it out by fixed parts costs time.
#[test]
fn the_jerk_limited_plan_is_faster_than_the_scan() {
    let arm = models::ur5e();
    let limits =
        arm.range().with_rates(Joints::repeat(2.0), Joints::repeat(5.0), Joints::repeat(20.0)).expect("valid limits");
    let path = ToolPath::new(&arm, path(), limits.range()).expect("in reach");
    let planner = Planner::new(&arm, Limits::new(limits).with_tool(tool()));
    let fast = planner.plan(&path).expect("it can be followed");
    assert_eq!(fast.info().method, Some(Method::JerkLimited));
    let planner = planner.with_method(Method::ContinuousAcceleration);
    let scanned = planner.plan(&path).expect("it can be followed").duration();
    assert!(fast.duration() < 0.95 * scanned, "{} {scanned}", fast.duration());
}
