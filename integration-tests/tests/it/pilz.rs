//! Commands and sequences of the tests of MoveIt's Pilz planner (PTP, LIN, CIRC, blends) on the Panda and the PRBT: each is planned and
//! verified, ends in its pose, and blends stay inside their radius.
//!
//! Origin: moveit/moveit2, `pilz_industrial_motion_planner/test/test_data` (BSD-3-Clause). Only numbers are taken.

use std::collections::BTreeMap;

use arcfeed_geometry::{ArcLengthCurve, ArcTo, Blending, JoinedPath, JoinedPathBuilder, OrientationPath, PosePath};
use arcfeed_interp::{JointLines, Limits, LockedArm, MotionPath, PathArm, Planner, ToolLimits, ToolPath, Trajectory};
use arcfeed_kinematics::{Arm, ArmDescription, JointRange, Joints, models};
use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use serde::Deserialize;

const CASES: &str = include_str!("../data/pilz_cases.json");
/// The planner there knows no jerk: here the full acceleration is reached in a twentieth of a second.
const RISE: f64 = 0.05;
const PERIOD: f64 = 2e-3;

#[derive(Deserialize)]
struct File {
    cartesian: Cartesian,
    panda: Robot,
    prbt: Robot,
}

/// Limits of the tool point.
#[derive(Deserialize, Clone, Copy)]
struct Cartesian {
    v: f64,
    a: f64,
}

#[derive(Deserialize)]
struct Robot {
    arm: Option<serde_json::Value>,
    v: Vec<f64>,
    a: Vec<f64>,
    /// How far joints and poses, printed with six digits, may lie apart.
    precision: f64,
    poses: BTreeMap<String, Pose>,
    commands: BTreeMap<String, Command>,
    sequences: BTreeMap<String, Vec<(String, f64)>>,
}

#[derive(Deserialize)]
struct Pose {
    joints: Vec<f64>,
    xyz: Option<[f64; 3]>,
    xyzw: Option<[f64; 4]>,
}

#[derive(Deserialize)]
struct Command {
    kind: String,
    from: String,
    to: String,
    interim: Option<String>,
    centre: Option<String>,
    vel: f64,
    acc: f64,
}

fn cases() -> File {
    serde_json::from_str(CASES).expect("valid cases")
}

fn panda() -> Arm<7> {
    models::description("panda").expect("built in").build().expect("seven joints")
}

fn prbt(robot: &Robot) -> Arm<6> {
    let text = robot.arm.as_ref().expect("an arm").to_string();
    ArmDescription::from_json(&text).and_then(|arm| arm.build()).expect("six joints")
}

impl Robot {
    fn joints<const N: usize>(&self, pose: &str) -> Joints<N> {
        Joints::from_column_slice(&self.poses[pose].joints)
    }

    fn pose(&self, name: &str) -> Isometry3<f64> {
        let pose = &self.poses[name];
        let ([x, y, z, w], xyz) = (pose.xyzw.expect("a pose"), pose.xyz.expect("a pose"));
        Isometry3::from_parts(Translation3::from(xyz), UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
    }

    /// Limits of the joints, of which commands of joints take a share.
    fn limits<const N: usize>(&self, range: &JointRange<N>, (v, a): (f64, f64)) -> Limits<'static, N> {
        let v = Joints::from_column_slice(&self.v) * v;
        let a = Joints::from_column_slice(&self.a) * a;
        Limits::new(range.with_rates(v, a, a / RISE).expect("valid limits"))
    }

    /// The path of the tool point for commands that follow one another.
    fn programmed(&self, commands: &[&Command]) -> JoinedPath {
        let at = |name: &str| self.pose(name).translation.vector;
        let mut path = JoinedPathBuilder::new(at(&commands[0].from), 1e-6).expect("a start");
        for (i, command) in commands.iter().enumerate() {
            let (from, to) = (at(&command.from), at(&command.to));
            let piece = match (&command.interim, &command.centre) {
                (Some(interim), _) => path.arc(&through(from, at(interim), to), i),
                (_, Some(centre)) => {
                    let centre = at(centre);
                    let normal = Unit::new_normalize((from - centre).cross(&(to - centre)));
                    path.arc(&ArcTo::new(centre, normal, to), i)
                }
                _ => path.line_to(to, i),
            };
            piece.unwrap_or_else(|error| panic!("{} to {}: {error}", command.from, command.to));
        }
        path.build().expect("a path")
    }

    /// The way of the tool along `path`, through the orientations of the poses that the commands name.
    fn pose_path(&self, path: &JoinedPath, commands: &[&Command]) -> PosePath {
        let curve = ArcLengthCurve::new(path.to_curve().expect("a curve"), 1e-12).expect("of some length");
        let ends = commands.iter().map(|command| &command.to);
        let poses: Vec<_> = std::iter::once(&commands[0].from).chain(ends).map(|name| self.pose(name)).collect();
        let turns = poses.windows(2).any(|w| w[0].rotation.angle_to(&w[1].rotation) > 1e-9);
        if !turns {
            return PosePath::new(curve, OrientationPath::Constant(poses[0].rotation));
        }
        let length = curve.length();
        let nearest = |pose: &Isometry3<f64>| {
            let places = (0..=1000).map(|k| length * f64::from(k) / 1000.0);
            let away = |s: &f64| (curve.point(*s) - pose.translation.vector).norm();
            places.min_by(|a, b| away(a).total_cmp(&away(b))).expect("not empty")
        };
        let last = poses.len() - 1;
        let place = |i: usize| match i {
            0 => 0.0,
            i if i == last => length,
            i => nearest(&poses[i]),
        };
        let keys: Vec<_> = poses.iter().enumerate().map(|(i, pose)| (place(i), pose.rotation)).collect();
        PosePath::new(curve, OrientationPath::through(&keys).expect("increasing"))
    }
}

/// The arc from `a` over `b` to `c`.
fn through(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> ArcTo {
    let (u, w) = (b - a, c - a);
    let normal = u.cross(&w);
    let centre =
        a + (w.norm_squared() * normal.cross(&u) - u.norm_squared() * normal.cross(&w)) / (2.0 * normal.norm_squared());
    ArcTo::new(centre, Unit::new_normalize(normal), c)
}

/// The largest ratio of differences to the limits: velocities and accelerations of the joints, and the speed of the tool point.
fn by_differences<const N: usize>(
    motion: &Trajectory<'_, N>,
    arm: &dyn PathArm<N>,
    v: &Joints<N>,
    a: &Joints<N>,
) -> [f64; 3] {
    let q: Vec<Joints<N>> = motion.setpoints(PERIOD).expect("a period").map(|p| p.expect("a setpoint").q).collect();
    // The last step may be shorter than a period.
    let q = &q[..q.len() - 1];
    let rates: Vec<Joints<N>> = q.windows(2).map(|w| (w[1] - w[0]) / PERIOD).collect();
    let rate = rates.iter().map(|r| r.component_div(v).amax()).fold(0.0, f64::max);
    let change = rates.windows(2).map(|w| ((w[1] - w[0]) / PERIOD).component_div(a).amax()).fold(0.0, f64::max);
    let points: Vec<_> = q.iter().map(|q| arm.forward(q).translation.vector).collect();
    let speed = points.windows(2).map(|w| (w[1] - w[0]).norm() / PERIOD).fold(0.0, f64::max);
    [rate, change, speed]
}

fn share<const N: usize>(limits: &[f64], of: f64) -> Joints<N> {
    Joints::from_column_slice(limits) * of
}

/// A command of joints, from pose to pose.
fn ptp<A: PathArm<N> + Sync, const N: usize>(
    robot: &Robot,
    arm: &A,
    range: &JointRange<N>,
    command: &Command,
    name: &str,
) {
    let (from, to) = (robot.joints::<N>(&command.from), robot.joints::<N>(&command.to));
    let path = JointLines::through(&[from, to], &[]).expect("two points");
    let motion = Planner::new(arm, robot.limits(range, (command.vel, command.acc))).plan(&path);
    let motion = motion.unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(motion.verification().holds(1e-6), "{name}");
    let (v, a) = (share(&robot.v, command.vel), share(&robot.a, command.acc));
    let worst = by_differences(&motion, arm, &v, &a);
    assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + 1e-6, "{name}: {worst:?}");
    let end = motion.path().jet(path.length(), &to).expect("the end").q;
    assert!((end - to).amax() < 1e-12, "{name}");
    // All joints in step: the shortest time without a jerk limit, and what the limit can cost.
    let way = (to - from).abs();
    let (v, a) = (1.0 / way.component_div(&v).amax(), 1.0 / way.component_div(&a).amax());
    let shortest = if v * v < a { 1.0 / v + v / a } else { 2.0 / a.sqrt() };
    let rest = motion.duration() - shortest;
    assert!((-1e-9..=2.0 * RISE).contains(&rest), "{name}: {} s, {shortest} s", motion.duration());
}

/// Commands of the tool that follow one another, with the radius of the blend at the end of each but the last.
fn along<A: PathArm<N> + Sync, const N: usize>(
    robot: &Robot,
    (arm, range): (&A, &JointRange<N>),
    cartesian: Cartesian,
    commands: &[(&Command, f64)],
    name: &str,
) {
    let only: Vec<&Command> = commands.iter().map(|(command, _)| *command).collect();
    let programmed = robot.programmed(&only);
    // A joint lies at the end of the command that its first source names.
    let blend = |source: usize| Blending { radius: commands[source].1, ..Blending::within(1.0) };
    let blended = programmed.blended_by(|joint| blend(joint.sources[0])).expect("blends").path;
    let pose_path = robot.pose_path(&blended, &only);
    let start = robot.joints::<N>(&only[0].from);
    let path = ToolPath::starting_near(arm, pose_path, &start).unwrap_or_else(|error| panic!("{name}: {error}"));
    let least = |value: fn(&Command) -> f64| only.iter().map(|command| value(command)).fold(f64::INFINITY, f64::min);
    let (v, a) = (cartesian.v * least(|c| c.vel), cartesian.a * least(|c| c.acc));
    let tool = ToolLimits::new()
        .with_feed(v)
        .and_then(|tool| tool.with_tangential_acceleration(a))
        .and_then(|tool| tool.with_tangential_jerk(a / RISE))
        .and_then(|tool| tool.with_normal_acceleration(a))
        .expect("valid limits");
    let motion = Planner::new(arm, robot.limits(range, (1.0, 1.0)).with_tool(tool)).plan(&path);
    let motion = motion.unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(motion.verification().holds(1e-6) && motion.stops().len() == 0, "{name}");
    let worst = by_differences(&motion, arm, &share(&robot.v, 1.0), &share(&robot.a, 1.0));
    assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + 1e-6 && worst[2] <= v * (1.0 + 1e-6), "{name}: {worst:?}");

    let curve = |command: &&Command| ArcLengthCurve::new(robot.programmed(&[command]).to_curve()?, 1e-12);
    let commanded: Vec<_> = only.iter().map(curve).collect::<Result<_, _>>().expect("curves");
    let corners: Vec<(Vector3<f64>, f64)> = commands[..commands.len() - 1]
        .iter()
        .map(|(c, radius)| (robot.pose(&c.to).translation.vector, *radius))
        .collect();
    let mut end = arm.forward(&start);
    for setpoint in motion.setpoints(0.05).expect("a period") {
        end = arm.forward(&setpoint.expect("a setpoint").q);
        let at = end.translation.vector;
        let inside = corners.iter().any(|(corner, radius)| (at - corner).norm() <= *radius);
        let beside = commanded.iter().map(|curve| distance(curve, &at)).fold(f64::INFINITY, f64::min);
        assert!(inside || beside < 1e-6, "{name}: {at:?} is on no command and in no blend");
    }
    let goal = robot.pose(&only[only.len() - 1].to);
    let off = (end.translation.vector - goal.translation.vector).norm().max(end.rotation.angle_to(&goal.rotation));
    assert!(off < 1e-6, "{name}: ends {off} beside its pose");
}

/// The distance of a point from a curve: that of samples, and then of ever finer ones beside the nearest.
fn distance(curve: &ArcLengthCurve<3>, point: &Vector3<f64>) -> f64 {
    let away = |s: f64| (curve.point(s.clamp(0.0, curve.length())) - point).norm();
    let (mut middle, mut half) = (0.5 * curve.length(), 0.5 * curve.length());
    while half > 1e-9 {
        let places = (-100..=100).map(|k| middle + half * f64::from(k) / 100.0);
        middle = places.min_by(|a, b| away(*a).total_cmp(&away(*b))).expect("not empty");
        half *= 0.02;
    }
    away(middle)
}

/// Two commands of joints, the way-point between them passed within `radius` of the tool point.
fn blended_ptps<A: PathArm<N> + Sync, const N: usize>(
    robot: &Robot,
    (arm, range): (&A, &JointRange<N>),
    commands: [&Command; 2],
    radius: f64,
    name: &str,
) {
    let [from, middle, to] = [&commands[0].from, &commands[0].to, &commands[1].to].map(|pose| robot.joints::<N>(pose));
    let corner = arm.forward(&middle).translation.vector;
    let far = |q: &Joints<N>| (arm.forward(q).translation.vector - corner).norm();
    let lines = [(from - middle).normalize(), (to - middle).normalize()];
    // The blend ends where the tool leaves the sphere, on either line.
    let leaves = |d: &f64| lines.iter().any(|line| far(&(middle + line * *d)) > radius);
    let d = (1..).map(|k| f64::from(k) * 1e-3).find(leaves).expect("the tool moves") - 1e-3;
    let least = |value: fn(&Command) -> f64| value(commands[0]).min(value(commands[1]));
    let limits = robot.limits(range, (least(|c| c.vel), least(|c| c.acc)));
    let plan = |blend: f64| {
        let path = JointLines::through(&[from, middle, to], &[blend]).expect("a blend that fits");
        let motion = Planner::new(arm, limits).plan(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        let q: Vec<_> = motion.setpoints(PERIOD).expect("a period").map(|p| p.expect("a setpoint").q).collect();
        (motion.duration(), motion.stops().len(), q)
    };
    let ((duration, stops, q), (stopping, ..)) = (plan(d), plan(0.0));
    assert!(stops == 0 && duration < stopping, "{name}: {duration} s, {stopping} s with a stop");
    for q in q {
        let beside = |line: &Joints<N>| (q - middle) - line * (q - middle).dot(line);
        let on_a_line = lines.iter().any(|line| beside(line).norm() < 1e-9);
        assert!(on_a_line || far(&q) <= radius + 1e-9, "{name}: {} m from the way-point", far(&q));
    }
}

/// Runs a sequence; the parts between which the arm stops although the suite blends there.
fn sequence<A: PathArm<N> + Sync, const N: usize>(
    robot: &Robot,
    (arm, range): (&A, &JointRange<N>),
    cartesian: Cartesian,
    steps: &[(String, f64)],
    name: &str,
) -> usize {
    let steps: Vec<(&Command, f64)> = steps.iter().map(|(step, radius)| (&robot.commands[step], *radius)).collect();
    let parts: Vec<_> = steps.chunk_by(|a, b| (a.0.kind == "ptp") == (b.0.kind == "ptp")).collect();
    for part in &parts {
        match part {
            [(first, radius), (second, _)] if first.kind == "ptp" => {
                blended_ptps(robot, (arm, range), [*first, *second], *radius, name);
            }
            [(one, _)] if one.kind == "ptp" => ptp(robot, arm, range, one, name),
            tool => along(robot, (arm, range), cartesian, tool, name),
        }
    }
    parts.len() - 1
}

fn run<A: PathArm<N> + Sync, const N: usize>(
    robot: &Robot,
    arms: (&A, &JointRange<N>),
    cartesian: Cartesian,
) -> BTreeMap<String, usize> {
    for (name, command) in &robot.commands {
        match command.kind.as_str() {
            "ptp" => ptp(robot, arms.0, arms.1, command, name),
            _ => along(robot, arms, cartesian, &[(command, 0.0)], name),
        }
    }
    let stops =
        |(name, steps): (&String, &Vec<(String, f64)>)| (name.clone(), sequence(robot, arms, cartesian, steps, name));
    robot.sequences.iter().map(stops).collect()
}

#[test]
fn joints_and_poses_of_pilz_agree() {
    let file = cases();
    let (panda, prbt) = (panda(), prbt(&file.prbt));
    for (robot, seven) in [(&file.panda, true), (&file.prbt, false)] {
        for (name, pose) in robot.poses.iter().filter(|(_, pose)| pose.xyz.is_some()) {
            let joints = &pose.joints;
            let ours = if seven {
                arcfeed_kinematics::ForwardKinematics::forward(&panda, &Joints::from_column_slice(joints))
            } else {
                arcfeed_kinematics::ForwardKinematics::forward(&prbt, &Joints::from_column_slice(joints))
            };
            let theirs = robot.pose(name);
            let off = (ours.translation.vector - theirs.translation.vector).norm();
            let off = off.max(ours.rotation.angle_to(&theirs.rotation));
            assert!(off < robot.precision, "{name}: {off}");
        }
    }
}

/// Joint 3 is held where the sequence starts; the suite lets its own inverse choose.
#[test]
fn commands_and_sequences_of_pilz_on_the_panda() {
    let File { cartesian, panda: robot, .. } = cases();
    let arm = panda();
    let held = LockedArm::new(&arm, 2, 0.2).expect("a joint");
    let stops = run(&robot, (&held, arm.range()), cartesian);
    let expected = [("ComplexSequence", 4), ("NoIntersectionTraj2", 0), ("SimpleSequence", 0)];
    assert_eq!(stops, expected.map(|(name, stops)| (name.to_owned(), stops)).into());
}

#[test]
fn commands_and_sequences_of_pilz_on_the_prbt() {
    let File { cartesian, prbt: robot, .. } = cases();
    let arm = prbt(&robot);
    let stops = run(&robot, (&arm, arm.range()), cartesian);
    let expected = [
        ("ComplexSequence", 4),
        ("LinPtpSequence", 1),
        ("NoIntersectionTraj2", 0),
        ("PtpLinSequence", 1),
        ("PtpPtpSequence", 0),
        ("SimpleSequence", 0),
    ];
    assert_eq!(stops, expected.map(|(name, stops)| (name.to_owned(), stops)).into());
}
