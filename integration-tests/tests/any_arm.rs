//! The pipeline with arms that come from files, without the crate of any robot.

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{LockedArm, Method, PathArm, Plan, Planner, ToolLimits, best_start};
use arcfeed_kinematics::{Arm, ArmDescription, InverseMethod, JointLimits, Joints, models};
use nalgebra::{UnitQuaternion, vector};

const TOOL: ToolLimits = ToolLimits {
    feed: 0.15,
    tangential_acceleration: 1.0,
    tangential_jerk: 30.0,
    normal_acceleration: 1.0,
    normal_jerk: None,
    angular_speed: None,
};

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

fn checked<A: PathArm<N>, const N: usize>(arm: &A, plan: &Plan<N>) {
    assert!(plan.verification().expect("verified").holds(1e-6));
    for setpoint in plan.sampler(arm, 2e-3).expect("a period") {
        let at = setpoint.expect("on the path");
        let tool = arm.forward(&at.q);
        assert!((tool.translation.vector - plan.path().curve().point(at.s)).norm() < 1e-9, "s = {}", at.s);
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
        let (path, limits) = (path(), limits(&arm));
        let start = best_start(&arm, &path, limits.lower(), limits.upper()).expect("in reach");
        let plan = Planner::new(&arm, limits, TOOL).expect("valid").plan(path, &start).expect("it can be followed");
        checked(&arm, &plan);
    }
}

#[test]
fn seven_joints_from_a_urdf_file() {
    let arm = from_urdf("panda").build::<7>().expect("seven joints");
    let path = path();
    let (locked, start) = LockedArm::for_path(&arm, &path).expect("in reach");
    let plan =
        Planner::new(&locked, limits(&arm), TOOL).expect("valid").plan(path, &start).expect("it can be followed");
    checked(&locked, &plan);
}

/// Where the joints' jerk is what limits the speed, sharing it out by fixed parts costs time.
#[test]
fn the_jerk_limited_plan_is_faster_than_the_scan() {
    let arm = models::ur5e();
    let limits =
        arm.range().with_rates(Joints::repeat(2.0), Joints::repeat(5.0), Joints::repeat(20.0)).expect("valid limits");
    let path = path();
    let start = best_start(&arm, &path, limits.lower(), limits.upper()).expect("in reach");
    let planner = Planner::new(&arm, limits, TOOL).expect("valid");
    let fast = planner.plan(path.clone(), &start).expect("it can be followed");
    assert_eq!(fast.made_by().method, Method::JerkLimited);
    let planner = planner.with_scan(arcfeed_interp::Scan::Joined);
    let scanned = planner.plan(path, &start).expect("it can be followed").duration();
    assert!(fast.duration() < 0.95 * scanned, "{} {scanned}", fast.duration());
}
