//! Paths along which the joints pass a singular pose smoothly are planned; those along which they do not are refused.

use std::f64::consts::FRAC_PI_2;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath, Spacing};
use arcfeed_interp::{Limits, PathArm, PathError, PlanError, Planner, Quantity, ToolLimits, ToolPath};
use arcfeed_kinematics::{ForwardKinematics, JointRange, Joints, KinematicsError, models, smallest_singular_value};
use arcfeed_testing::{Random, cases};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Points through which the pose of a smooth joint motion is laid.
const POINTS: usize = 480;
/// Below this smallest singular value the derivatives of the joints do not follow from those of the tool.
const SINGULAR: f64 = 1e-3;

fn limits(range: &JointRange<6>) -> Limits<'static, 6> {
    let joints =
        range.with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(200.0)).expect("valid limits");
    let tool = ToolLimits::new().with_feed(0.2).expect("valid").with_tangential_acceleration(2.0).expect("valid");
    Limits::new(joints).with_tool(tool)
}

/// The path of the tool while the joints are `joints` of 0 to 1.
fn path_of(arm: &dyn ForwardKinematics<6>, joints: impl Fn(f64) -> Joints<6>) -> PosePath {
    let poses: Vec<Isometry3<f64>> =
        (0..POINTS).map(|i| arm.forward(&joints(i as f64 / (POINTS - 1) as f64))).collect();
    let points: Vec<Vector3<f64>> = poses.iter().map(|pose| pose.translation.vector).collect();
    let fit = NurbsCurve::interpolate(&points, 5, Spacing::Chord).expect("points apart");
    let curve = ArcLengthCurve::new(fit.curve, 1e-15).expect("a length");
    let keys: Vec<(f64, UnitQuaternion<f64>)> =
        fit.parameters.iter().zip(&poses).map(|(&u, pose)| (curve.arc_length_at(u), pose.rotation)).collect();
    PosePath::new(curve, OrientationPath::through(&keys).expect("keys in order"))
}

/// The lowest speed of the tool along `joints` of 0 to 1, in parts of the highest.
fn steadiness(arm: &dyn ForwardKinematics<6>, joints: impl Fn(f64) -> Joints<6>) -> f64 {
    let at = |i: usize| arm.forward(&joints(i as f64 / 100.0)).translation.vector;
    let steps = (0..100).map(|i| (at(i + 1) - at(i)).norm());
    let (low, high) = steps.fold((f64::INFINITY, 0.0_f64), |(low, high), step| (low.min(step), high.max(step)));
    low / high
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
fn random_motions_with_smooth_joints_pass_the_straight_wrist() {
    let (kr6, ur5e, cr7) = (models::kr6_r700(), models::ur5e(), models::cr7());
    let (mut planned, mut passed) = (0, 0);
    let seeds = cases(1);
    // The seed says which arm: the first is the CR7. `ARCFEED_CASES=12` plays each arm four times.
    for seed in seeds.clone().map(|i| i + 2) {
        let mut random = Random::new(seed);
        let mut vector = |size: f64| Joints::<6>::from_fn(|_, _| random.between(-size, size));
        let (first, second, third) = (vector(0.5), vector(0.3), vector(0.2));
        let mut random = Random::new(seed + 1_000_000);
        let (turn, at) = (random.sign() * random.between(0.3, 1.5), random.between(0.3, 0.7));
        let base = match seed % 3 {
            0 => Joints::from([0.2, -1.0, 1.4, 0.4, 0.0, 0.3]),
            1 => Joints::from([0.2, -1.2, 1.5, -0.6, 0.0, 0.3]),
            _ => Joints::from([0.3, -0.2, 1.4, 0.3, 0.0, 0.0]),
        };
        let joints = |t: f64| {
            let x = t - at;
            let mut q = base + (first + (second + third * x) * x) * x;
            q[4] = (turn + (second[4] + third[4] * x) * x) * x;
            q
        };
        let what = format!("seed {seed}");
        let steady = match seed % 3 {
            0 => steadiness(&kr6, joints),
            1 => steadiness(&ur5e, joints),
            _ => steadiness(&cr7, joints),
        };
        // By arc length the joints are not smooth where the tool nearly stops.
        if steady < 0.3 {
            continue;
        }
        planned += 1;
        let singular = match seed % 3 {
            0 => singular_setpoints(&kr6, kr6.range(), &path_of(&kr6, joints), &joints(0.0), &what),
            1 => singular_setpoints(&ur5e, ur5e.range(), &path_of(&ur5e, joints), &joints(0.0), &what),
            _ => singular_setpoints(&cr7, cr7.range(), &path_of(&cr7, joints), &joints(0.0), &what),
        };
        passed += usize::from(!singular.is_empty());
    }
    assert!(
        3 * planned >= 2 * seeds.count() && 6 * passed >= 5 * planned,
        "{planned} planned, {passed} with setpoints inside"
    );
}

#[test]
fn random_turns_of_the_fifth_joint_alone_pass_the_straight_wrist() {
    let (kr6, ur5e, cr7) = (models::kr6_r700(), models::ur5e(), models::cr7());
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let mut start = Joints::from([0.2, -1.1, 1.4, 0.4, 0.0, 0.3]).map(|q| q + random.between(-0.3, 0.3));
        start[4] = random.sign() * random.between(0.05, 0.8);
        let turn = -start[4] * random.between(1.2, 2.5);
        let what = format!("seed {seed}");
        let singular = match seed % 3 {
            0 => singular_setpoints(&kr6, kr6.range(), &turn_of_the_fifth(&kr6, &start, turn), &start, &what),
            1 => singular_setpoints(&ur5e, ur5e.range(), &turn_of_the_fifth(&ur5e, &start, turn), &start, &what),
            _ => singular_setpoints(&cr7, cr7.range(), &turn_of_the_fifth(&cr7, &start, turn), &start, &what),
        };
        assert!(singular.iter().any(|q| q[4] < 0.0) && singular.iter().any(|q| q[4] > 0.0), "{what}");
        let others =
            |q: &Joints<6>| [0, 1, 2, 3, 5].into_iter().fold(0.0_f64, |most, k| most.max((q[k] - start[k]).abs()));
        assert!(singular.iter().all(|q| others(q) < 1e-7), "{what}: the others stand still");
    }
}

/// The arc of the tool while the fifth joint alone turns by `turn` from `start`.
fn turn_of_the_fifth(arm: &dyn ForwardKinematics<6>, start: &Joints<6>, turn: f64) -> PosePath {
    let at = arm.configuration(start);
    let (axis, point, pose) = (at.axes()[4], at.points()[4], at.pose());
    let centre = point + axis * axis.dot(&(pose.translation.vector - point));
    let out = pose.translation.vector - centre;
    let towards = axis.cross(&out) * turn.signum();
    let rotation =
        nalgebra::Rotation3::from_basis_unchecked(&[out.normalize(), towards.normalize(), axis * turn.signum()]);
    let frame = Isometry3::from_parts(centre.into(), UnitQuaternion::from_rotation_matrix(&rotation));
    let arc = NurbsCurve::<3>::arc(&frame, out.norm(), 0.0, turn.abs()).expect("a radius");
    let curve = ArcLengthCurve::new(arc, 1e-15).expect("a length");
    let turned = UnitQuaternion::from_axis_angle(&nalgebra::Unit::new_normalize(axis), turn) * pose.rotation;
    let turning = OrientationPath::slerp(curve.length(), pose.rotation, turned).expect("a length above 0");
    PosePath::new(curve, turning)
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
