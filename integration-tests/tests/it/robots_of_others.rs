//! Arms of several makers as their own URDF files describe them: base and tip are found, limits are those of the file, pose and Jacobian
//! are those of Pinocchio, the inverse comes back, and a circle is planned and verified.
//!
//! Origin: each arm names its file and licence in the data. Only names and numbers are taken; `integration-tests/robots/records.py` makes
//! the records anew.

use std::f64::consts::PI;
use std::fmt::Write as _;

use arcfeed_geometry::{ArcLengthCurve, ArcTo, JoinedPathBuilder, OrientationPath, PosePath};
use arcfeed_interp::{Limits, LockedArm, PathArm, Planner, ToolLimits, ToolPath};
use arcfeed_kinematics::{Arm, ArmDescription, ForwardKinematics, InverseKinematics, Joints};
use arcfeed_testing::Random;
use nalgebra::{Isometry3, Matrix3x4, OMatrix, Rotation3, Unit, UnitQuaternion};
use serde::Deserialize;

const CASES: &str = include_str!("../data/robots_of_others.json");
/// No file states an acceleration or a jerk: rad/s^2, rad/s^3.
const ACCELERATION: f64 = 10.0;
const JERK: f64 = 200.0;
/// For the files whose velocity limits are 0, which says nothing: rad/s.
const VELOCITY: f64 = 2.0;
/// Radius of the circle, m.
const RADIUS: f64 = 0.01;
/// Where each joint starts the circle: the share of its range, of at most one turn.
const START: [f64; 7] = [0.48, 0.64, 0.34, 0.65, 0.69, 0.63, 0.45];

#[derive(Deserialize)]
struct File {
    arms: Vec<Case>,
}

/// Name, type, parent, child, xyz, rpy, axis, limits (lower, upper, effort, velocity), mimic (joint, multiplier).
#[derive(Deserialize)]
struct FileJoint([String; 9]);

#[derive(Deserialize)]
struct Case {
    name: String,
    base: String,
    tip: String,
    links: Vec<String>,
    joints: Vec<FileJoint>,
    records: Vec<Record>,
}

#[derive(Deserialize)]
struct Record {
    q: Vec<f64>,
    pose: [f64; 12],
    jacobian: Vec<f64>,
}

impl FileJoint {
    fn urdf(&self) -> String {
        let [name, kind, parent, child, xyz, rpy, axis, limit, mimic] = &self.0;
        let mut text = format!(
            "<joint name='{name}' type='{kind}'><origin xyz='{xyz}' rpy='{rpy}'/><parent link='{parent}'/><child link='{child}'/>"
        );
        if !axis.is_empty() {
            write!(text, "<axis xyz='{axis}'/>").expect("memory");
        }
        if let [lower, upper, effort, velocity] = limit.split(' ').collect::<Vec<_>>()[..] {
            write!(text, "<limit lower='{lower}' upper='{upper}' effort='{effort}' velocity='{velocity}'/>")
                .expect("memory");
        }
        if let Some((joint, multiplier)) = mimic.split_once(' ') {
            write!(text, "<mimic joint='{joint}' multiplier='{multiplier}'/>").expect("memory");
        }
        text + "</joint>"
    }

    /// Lower, upper, effort, velocity; none where the joint has no limits.
    fn limits(&self) -> Option<[f64; 4]> {
        let values: Vec<f64> = self.0[7].split_whitespace().map(|value| value.parse().expect("a number")).collect();
        values.try_into().ok()
    }
}

impl Case {
    fn description(&self) -> ArmDescription {
        let links = self.links.iter().map(|link| format!("<link name='{link}'/>"));
        let parts: String = links.chain(self.joints.iter().map(FileJoint::urdf)).collect();
        let text = format!("<robot name='{}'>{parts}</robot>", self.name);
        ArmDescription::from_urdf(&text, None, None).unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    /// The joints of the arm, in the order of the file.
    fn moving(&self) -> Vec<(&FileJoint, [f64; 4])> {
        self.joints.iter().filter_map(|joint| Some((joint, joint.limits()?))).collect()
    }
}

fn cases() -> Vec<Case> {
    let File { arms } = serde_json::from_str(CASES).expect("valid cases");
    assert_eq!(arms.len(), 12);
    arms
}

fn off(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation))
}

/// Ends, names and limits are those of the file.
fn as_in_the_file<const N: usize>(case: &Case, description: &ArmDescription, arm: &Arm<N>) {
    let name = &case.name;
    assert_eq!(description.source, format!("URDF, link '{}' to link '{}'", case.base, case.tip), "{name}");
    let moving = case.moving();
    assert_eq!(moving.len(), N, "{name}");
    for (i, ((joint, [lower, upper, effort, velocity]), read)) in moving.iter().zip(&description.joints).enumerate() {
        let known = |value: f64| (value != 0.0).then_some(value);
        assert_eq!(read.name, joint.0[0], "{name}");
        assert_eq!([arm.range().lower()[i], arm.range().upper()[i]], [*lower, *upper], "{name} {}", read.name);
        assert_eq!((read.velocity, read.torque), (known(*velocity), known(*effort)), "{name} {}", read.name);
    }
}

/// The largest difference from the records.
fn from_records<const N: usize>(case: &Case, arm: &Arm<N>) -> f64 {
    let mut worst = 0.0_f64;
    for record in &case.records {
        let configuration = arm.forward_jacobian(&Joints::from_column_slice(&record.q));
        let pose = Matrix3x4::from_row_slice(&record.pose);
        let jacobian = OMatrix::<f64, nalgebra::Const<6>, nalgebra::Const<N>>::from_row_slice(&record.jacobian);
        let matrix = configuration.0.to_homogeneous();
        worst = worst.max((matrix.fixed_rows::<3>(0) - pose).amax()).max((configuration.1 - jacobian).amax());
    }
    worst
}

/// From starts 0.2 rad away in every joint, the pose of the record is found, inside the range.
fn comes_back<const N: usize>(case: &Case, arm: &Arm<N>, random: &mut Random) {
    for (i, record) in case.records.iter().enumerate() {
        let q = Joints::<N>::from_column_slice(&record.q);
        let place = format!("{} {i}", case.name);
        let start = q.map(|value| value + 0.2 * random.sign());
        let pose = Matrix3x4::from_row_slice(&record.pose);
        let turn = Rotation3::from_matrix_unchecked(pose.fixed_columns::<3>(0).into_owned());
        let target =
            Isometry3::from_parts(pose.column(3).into_owned().into(), UnitQuaternion::from_rotation_matrix(&turn));
        let found = arm.inverse(&target, &start).unwrap_or_else(|error| panic!("{place}: {error}"));
        let error = off(&arm.forward(&found), &target);
        assert!(error < 1e-9, "{place}: {error:e}");
        assert!(arm.range().contains(&found), "{place}: {found}");
    }
}

/// Where the arm starts its circle.
fn start<const N: usize>(arm: &Arm<N>) -> Joints<N> {
    Joints::from_fn(|i, _| {
        let (lower, upper) = (arm.range().lower()[i].max(-PI), arm.range().upper()[i].min(PI));
        lower + START[i] * (upper - lower)
    })
}

/// A full circle in the plane of the tool, which keeps its orientation.
fn circle(pose: &Isometry3<f64>) -> PosePath {
    let [centre, normal] =
        [pose * nalgebra::Point3::new(-RADIUS, 0.0, 0.0), (pose.rotation * nalgebra::Vector3::z()).into()];
    let at = pose.translation.vector;
    let mut path = JoinedPathBuilder::new(at, 1e-9).expect("a start");
    path.arc(&ArcTo::new(centre.coords, Unit::new_normalize(normal.coords), at), 0).expect("a circle");
    let curve = path.build().and_then(|path| path.to_curve()).expect("a curve");
    PosePath::new(ArcLengthCurve::new(curve, 1e-12).expect("of some length"), OrientationPath::Constant(pose.rotation))
}

/// The circle is planned, verified, and kept with all limits as its setpoints show.
fn goes_round<A: PathArm<N>, const N: usize>(
    case: &Case,
    arm: &Arm<N>,
    path: &ToolPath<'_, N>,
    follower: &A,
    pose: &Isometry3<f64>,
) {
    let name = &case.name;
    let velocity = Joints::from_fn(|i, _| match case.moving()[i].1[3] {
        0.0 => VELOCITY,
        known => known,
    });
    let limits =
        arm.range().with_rates(velocity, Joints::repeat(ACCELERATION), Joints::repeat(JERK)).expect("valid limits");
    let tool =
        ToolLimits::new().with_feed(0.05).and_then(|tool| tool.with_normal_acceleration(1.0)).expect("valid limits");
    let planner = Planner::new(follower, Limits::new(limits).with_tool(tool));
    let plan = planner.plan(path).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(plan.verification().holds(1e-6), "{name}");
    assert!(plan.duration() > 2.0 * PI * RADIUS / 0.05, "{name}: {}", plan.duration());
    for setpoint in plan.setpoints(4e-3).expect("a period") {
        let at = setpoint.expect("on the path");
        let tip = pose.inverse() * arm.forward(&at.q);
        let [x, y, z] = (tip.translation.vector + nalgebra::Vector3::new(RADIUS, 0.0, 0.0)).into();
        let error = (x.hypot(y) - RADIUS).abs().max(z.abs()).max(tip.rotation.angle());
        assert!(error < 1e-9, "{name}, {} s: {error:e}", at.t);
        let rates = [at.qd.component_div(&velocity).amax(), at.qdd.amax() / ACCELERATION, at.jerk.amax() / JERK];
        assert!(
            arm.range().contains(&at.q) && rates.iter().all(|rate| *rate < 1.0 + 1e-6),
            "{name}, {} s: {rates:?}",
            at.t
        );
    }
}

#[test]
fn arms_of_others_are_read_and_agree_with_pinocchio() {
    fn check<const N: usize>(case: &Case, description: &ArmDescription) {
        let arm = description.build::<N>().unwrap_or_else(|error| panic!("{}: {error}", case.name));
        as_in_the_file(case, description, &arm);
        assert_eq!(case.records.len(), 4, "{}", case.name);
        let error = from_records(case, &arm);
        assert!(error < 1e-12, "{}: {error:e}", case.name);
    }
    for case in cases() {
        let description = case.description();
        match description.joints.len() {
            7 => check::<7>(&case, &description),
            _ => check::<6>(&case, &description),
        }
    }
}

#[test]
fn inverses_of_arms_of_others_come_back() {
    let mut random = Random::new(20_261_201);
    for case in cases() {
        let description = case.description();
        match description.joints.len() {
            7 => comes_back(&case, &description.build::<7>().expect("seven joints"), &mut random),
            _ => comes_back(&case, &description.build::<6>().expect("six joints"), &mut random),
        }
    }
}

/// Axes that are parallel but for the rounding of their file: poses beside singular ones are missed by the ideal geometry.
#[test]
fn inverses_of_arms_with_rounded_axes_come_back_everywhere() {
    let mut random = Random::new(7);
    let mut arms = 0;
    for case in cases().iter().filter(|case| ["cr30h", "me6"].iter().any(|name| case.name.contains(name))) {
        arms += 1;
        let arm = case.description().build::<6>().expect("six joints");
        for k in 0..4000 {
            let place = |i: usize, share: f64| {
                let (lower, upper) = (arm.range().lower()[i].max(-PI), arm.range().upper()[i].min(PI));
                lower + share * (upper - lower)
            };
            let q = Joints::<6>::from_fn(|i, _| place(i, random.unit()));
            let start = q.map(|value| value + 0.2 * random.signed());
            let target = arm.forward(&q);
            let found =
                arm.inverse(&target, &start).unwrap_or_else(|error| panic!("{} {k}: {error} at {q}", case.name));
            let error = off(&arm.forward(&found), &target);
            assert!(error < 1e-9, "{} {k}: {error:e} at {q}", case.name);
        }
    }
    assert_eq!(arms, 2);
}

#[test]
fn arms_of_others_go_round_a_circle() {
    for case in cases() {
        let description = case.description();
        let name = &case.name;
        if let Ok(arm) = description.build::<7>() {
            let pose = arm.forward(&start(&arm));
            let path = circle(&pose);
            let (locked, near) = LockedArm::for_path(&arm, &path).unwrap_or_else(|error| panic!("{name}: {error}"));
            let path = ToolPath::starting_near(&locked, path, &near).unwrap_or_else(|error| panic!("{name}: {error}"));
            goes_round(&case, &arm, &path, &locked, &pose);
        } else {
            let arm = description.build::<6>().expect("six joints");
            let near = start(&arm);
            let pose = arm.forward(&near);
            let path =
                ToolPath::starting_near(&arm, circle(&pose), &near).unwrap_or_else(|error| panic!("{name}: {error}"));
            goes_round(&case, &arm, &path, &arm, &pose);
        }
    }
}
