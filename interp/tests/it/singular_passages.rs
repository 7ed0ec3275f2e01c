//! Paths along which the joints pass a singular pose smoothly are planned; those along which they do not are refused.

use std::f64::consts::FRAC_PI_2;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, PathArm, PathError, PlanError, Planner, Quantity, ToolLimits, ToolPath};
use arcfeed_kinematics::{ForwardKinematics, JointRange, Joints, KinematicsError, models, smallest_singular_value};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Below this smallest singular value the derivatives of the joints do not follow from those of the tool.
const SINGULAR: f64 = 1e-3;

fn limits(range: &JointRange<6>) -> Limits<'static, 6> {
    let joints =
        range.with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(200.0)).expect("valid limits");
    let tool = ToolLimits::new().with_feed(0.2).expect("valid").with_tangential_acceleration(2.0).expect("valid");
    Limits::new(joints).with_tool(tool)
}

/// Plans the motion from `start` and returns the places of its setpoints where the arm is singular, after checks that do not rely on
/// the planner: the tool is on the path, and the joints move no faster than their limits between setpoints.
fn singular_setpoints<A: PathArm<6>>(
    arm: &A,
    range: &JointRange<6>,
    path: &PosePath,
    start: &Joints<6>,
    what: &str,
) -> Vec<Joints<6>> {
    let path = ToolPath::starting_near(arm, path.clone(), start).expect("in reach");
    let trajectory = Planner::new(arm, limits(range)).plan(&path).unwrap_or_else(|e| panic!("{what}: {e}"));
    let period = 2.5e-4;
    let (mut singular, mut before): (Vec<Joints<6>>, Option<Joints<6>>) = (Vec::new(), None);
    for setpoint in trajectory.setpoints(period).expect("a period") {
        let setpoint = setpoint.expect("on the path");
        let (pose, tool) = (arm.forward(&setpoint.q), path.pose_path().pose(setpoint.s));
        let off = (pose.translation.vector - tool.translation.vector).norm();
        let turned = pose.rotation.angle_to(&tool.rotation);
        assert!(off <= 1e-7 && turned <= 2e-7, "{what}: {off} m, {turned} rad off the path at s = {}", setpoint.s);
        if let Some(before) = before {
            assert!(
                (setpoint.q - before).amax() <= 3.0 * period * (1.0 + 1e-6),
                "{what}: a jump at s = {}",
                setpoint.s
            );
        }
        if smallest_singular_value(&arm.jacobian(&setpoint.q)) < SINGULAR {
            singular.push(setpoint.q);
        }
        before = Some(setpoint.q);
    }
    let worst = |quantity| {
        let of = trajectory.verification().checks().iter().filter(move |check| check.id.quantity == quantity);
        of.map(|check| check.ratio).fold(0.0_f64, f64::max)
    };
    assert!(worst(Quantity::PathDeviation) <= 1.0 && worst(Quantity::OrientationDeviation) <= 1.0, "{what}");
    singular
}

/// A circle in the vertical plane of the arm, the tool turned out of that plane by `tilt`; and the joints at its start. The fifth joint
/// passes 0 twice, and without a tilt the fourth and the sixth stand still.
fn circle_in_the_plane(arm: &dyn ForwardKinematics<6>, tilt: f64) -> (PosePath, Joints<6>) {
    let start = Joints::from([0.3, -1.2, 1.7, 0.0, 0.1, 0.0]);
    let pose = arm.forward(&start);
    // The circle begins where the tool stands and lies in the plane of the first axis and the arm.
    let (radius, plane) = (0.08, UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -0.3));
    let frame = Isometry3::from_parts(
        Translation3::from(pose.translation.vector + plane * Vector3::new(-radius, 0.0, 0.0)),
        plane * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2),
    );
    let curve =
        ArcLengthCurve::new(NurbsCurve::<3>::circle(&frame, radius).expect("a radius"), 1e-15).expect("a length");
    let out = UnitQuaternion::from_axis_angle(&nalgebra::Unit::new_normalize(plane * Vector3::z()), tilt);
    (PosePath::new(curve, OrientationPath::Constant(out * pose.rotation)), start)
}

#[test]
fn a_circle_with_the_fourth_joint_constant_passes_the_straight_wrist() {
    let arm = models::kr6_r700();
    let (path, start) = circle_in_the_plane(&arm, 0.0);
    let singular = singular_setpoints(&arm, arm.range(), &path, &start, "circle");
    assert!(singular.iter().any(|q| q[4] < 0.0) && singular.iter().any(|q| q[4] > 0.0));
    assert!(singular.iter().all(|q| q[3].abs() < 1e-7), "the fourth joint stays");
}

#[test]
fn a_wrist_that_has_to_turn_fast_is_refused() {
    let arm = models::kr6_r700();
    for tilt in [1e-6, 1e-5, 1e-4, -3e-5] {
        let (path, start) = circle_in_the_plane(&arm, tilt);
        let path = ToolPath::starting_near(&arm, path, &start).expect("in reach");
        let planned = Planner::new(&arm, limits(arm.range())).plan(&path);
        let Err(error) = planned else { panic!("tilt {tilt}: planned in {} s", planned.expect("planned").duration()) };
        let PlanError::Path(PathError::Arm { source: KinematicsError::Singular { .. }, .. }) = &error else {
            panic!("tilt {tilt}: {error}")
        };
    }
}
