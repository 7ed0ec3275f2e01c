//! Commands and sequences of the tests of MoveIt's Pilz planner (PTP, LIN, CIRC, blends) on the Panda and the PRBT:
//! each is planned and verified, begins where the one before ended, ends in its pose, and blends stay inside their
//! radius.
//!
//! Origin: moveit/moveit2, `pilz_industrial_motion_planner/test/test_data` (BSD-3-Clause). Only numbers are taken.

mod cases;

use std::collections::BTreeMap;

use arcfeed_geometry::{ArcLengthCurve, Blending};
use arcfeed_interp::{JointLines, LockedArm, PathArm, PlanError, Planner, ToolLimits, ToolPath, Trajectory};
use arcfeed_kinematics::{JointRange, Joints};
use nalgebra::Vector3;

use cases::{Cartesian, Command, File, RISE, Robot, cases, panda, prbt};

const PERIOD: f64 = 2e-3;

/// The largest ratio of differences to the limits of the joints, velocity and acceleration.
fn by_differences<const N: usize>(q: &[Joints<N>], v: &Joints<N>, a: &Joints<N>) -> [f64; 2] {
    // The last step may be shorter than a period.
    let rates: Vec<Joints<N>> = q[..q.len() - 1].windows(2).map(|w| (w[1] - w[0]) / PERIOD).collect();
    let rate = rates.iter().map(|r| r.component_div(v).amax()).fold(0.0, f64::max);
    let change = rates.windows(2).map(|w| ((w[1] - w[0]) / PERIOD).component_div(a).amax()).fold(0.0, f64::max);
    [rate, change]
}

/// How often the joints rest, both ends among them, by differences: no joint is faster than a thousandth of its limit.
fn rests<const N: usize>(q: &[Joints<N>], v: &Joints<N>) -> usize {
    let rests: Vec<bool> = q.windows(2).map(|w| ((w[1] - w[0]) / PERIOD).component_div(v).amax() < 1e-3).collect();
    usize::from(rests[0]) + rests.windows(2).filter(|w| !w[0] && w[1]).count()
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

/// Where two commands of the tool are blended.
struct Corner {
    before: Vector3<f64>,
    at: Vector3<f64>,
    after: Vector3<f64>,
    radius: f64,
    /// Both commands are lines.
    lines: bool,
}

impl Corner {
    /// Inside the radius; between two lines inside the triangle that they span over the length which the blend may
    /// take of each.
    fn may_blend_at(&self, point: &Vector3<f64>) -> bool {
        let p = point - self.at;
        if !self.lines {
            return p.norm() <= self.radius;
        }
        let [u, w] = [self.before, self.after].map(|end| end - self.at);
        let [d, e] = [u, w].map(|line| line.norm().min(self.radius));
        let (u, w) = (u.normalize(), w.normalize());
        let c = u.dot(&w);
        let [along, across] =
            [(p.dot(&u), p.dot(&w)), (p.dot(&w), p.dot(&u))].map(|(a, b)| (a - c * b) / (1.0 - c * c));
        let beside = (p - u * along - w * across).norm();
        beside < 1e-6 && along > -1e-6 && across > -1e-6 && along / d + across / e < 1.0 + 1e-6
    }
}

/// A robot and its limits. `arms` are those that may follow a path of the tool from these joint values on: the first
/// that gets to its end does.
struct Bench<'a, A, const N: usize> {
    robot: &'a Robot,
    cartesian: Cartesian,
    range: &'a JointRange<N>,
    arms: &'a dyn Fn(&Joints<N>) -> Vec<A>,
}

impl<A: PathArm<N> + Sync, const N: usize> Bench<'_, A, N> {
    fn arm(&self, q: &Joints<N>) -> A {
        (self.arms)(q).swap_remove(0)
    }

    /// The joint values of a pose. They are printed with six digits; here the tool stands in the pose exactly.
    fn stand(&self, name: &str) -> Joints<N> {
        let printed = self.robot.joints(name);
        if self.robot.poses[name].xyz.is_none() {
            return printed;
        }
        let exact = self.arm(&printed).inverse(&self.robot.pose(name), &printed).expect("in reach");
        assert!((exact - printed).amax() < 10.0 * self.robot.precision, "{name}: {exact}, printed {printed}");
        exact
    }

    /// The velocity and acceleration limits of the joints, of which a command takes a share.
    fn rates(&self, (v, a): (f64, f64)) -> (Joints<N>, Joints<N>) {
        (Joints::from_column_slice(&self.robot.v) * v, Joints::from_column_slice(&self.robot.a) * a)
    }

    /// The joint values of a motion in every period and at its end. It is verified, does not stop on the way, and is
    /// inside these shares of the limits.
    fn judged(&self, motion: &Trajectory<'_, N>, shares: (f64, f64), name: &str) -> Vec<Joints<N>> {
        assert!(motion.verification().holds(1e-6) && motion.stops().len() == 0, "{name}");
        let q: Vec<_> = motion.setpoints(PERIOD).expect("a period").map(|p| p.expect("a setpoint").q).collect();
        let (v, a) = self.rates(shares);
        let worst = by_differences(&q, &v, &a);
        assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + 1e-6, "{name}: {worst:?}");
        q
    }

    /// The tool stands in the pose `to` at the end.
    fn ends_in(&self, to: &str, q: &[Joints<N>], name: &str) {
        if self.robot.poses[to].xyz.is_some() {
            let (end, goal) = (self.arm(&q[0]).forward(&q[q.len() - 1]), self.robot.pose(to));
            let off = (end.translation.vector - goal.translation.vector).norm();
            let off = off.max(end.rotation.angle_to(&goal.rotation));
            assert!(off < 1e-6, "{name}: ends {off} beside its pose");
        }
    }

    /// A command of the joints, from where they are.
    fn ptp(&self, from: &Joints<N>, command: &Command, name: &str) -> Vec<Joints<N>> {
        let (arm, to) = (self.arm(from), self.stand(&command.to));
        let path = JointLines::through(&[*from, to], &[]).expect("two points");
        let shares = (command.vel, command.acc);
        let motion = Planner::new(&arm, self.robot.limits(self.range, shares)).plan(&path);
        let motion = motion.unwrap_or_else(|error| panic!("{name}: {error}"));
        let q = self.judged(&motion, shares, name);
        assert!((q[q.len() - 1] - to).amax() < 1e-12, "{name}");
        self.ends_in(&command.to, &q, name);
        // All joints in step: the shortest time without a jerk limit, and what the limit can cost.
        let (way, (v, a)) = ((to - from).abs(), self.rates(shares));
        let (v, a) = (1.0 / way.component_div(&v).amax(), 1.0 / way.component_div(&a).amax());
        let shortest = if v * v < a { 1.0 / v + v / a } else { 2.0 / a.sqrt() };
        let rest = motion.duration() - shortest;
        assert!((-1e-9..=2.0 * RISE).contains(&rest), "{name}: {} s, {shortest} s", motion.duration());
        q
    }

    /// Commands of the tool that follow one another, with the radius of the blend at the end of each but the last.
    fn along(&self, from: &Joints<N>, commands: &[(&Command, f64)], name: &str) -> Vec<Joints<N>> {
        let mut refused = Vec::new();
        for arm in (self.arms)(from) {
            match self.follow(&arm, from, commands, name) {
                Ok(q) => return q,
                Err(error) => refused.push(error.to_string()),
            }
        }
        panic!("{name}: {refused:?}");
    }

    fn follow(
        &self,
        arm: &A,
        from: &Joints<N>,
        commands: &[(&Command, f64)],
        name: &str,
    ) -> Result<Vec<Joints<N>>, PlanError> {
        let robot = self.robot;
        let only: Vec<&Command> = commands.iter().map(|(command, _)| *command).collect();
        // A joint lies at the end of the command that its first source names.
        let blend = |source: usize| Blending { radius: commands[source].1, ..Blending::within(1.0) };
        let blended = robot.programmed(&only).blended_by(|joint| blend(joint.sources[0])).expect("blends").path;
        let path = ToolPath::starting_near(arm, robot.pose_path(&blended, &only), from)?;
        let least = |value: fn(&Command) -> f64| only.iter().map(|c| value(c)).fold(f64::INFINITY, f64::min);
        let (v, a) = (self.cartesian.v * least(|c| c.vel), self.cartesian.a * least(|c| c.acc));
        let tool = ToolLimits::new()
            .with_feed(v)
            .and_then(|tool| tool.with_tangential_acceleration(a))
            .and_then(|tool| tool.with_tangential_jerk(a / RISE))
            .and_then(|tool| tool.with_normal_acceleration(a))
            .expect("valid limits");
        let motion = Planner::new(arm, robot.limits(self.range, (1.0, 1.0)).with_tool(tool)).plan(&path)?;
        let q = self.judged(&motion, (1.0, 1.0), name);
        let points: Vec<Vector3<f64>> = q.iter().map(|q| arm.forward(q).translation.vector).collect();
        let fastest = points.windows(2).map(|w| (w[1] - w[0]).norm() / PERIOD).fold(0.0, f64::max);
        assert!(fastest <= v * (1.0 + 1e-6), "{name}: {fastest} m/s");
        self.on_commands(commands, &points, name);
        self.ends_in(&only[only.len() - 1].to, &q, name);
        Ok(q)
    }

    /// The tool is on a command, or in a blend.
    fn on_commands(&self, commands: &[(&Command, f64)], points: &[Vector3<f64>], name: &str) {
        let curve = |(c, _): &(&Command, f64)| ArcLengthCurve::new(self.robot.programmed(&[c]).to_curve()?, 1e-12);
        let curves: Vec<_> = commands.iter().map(curve).collect::<Result<_, _>>().expect("curves");
        let corner = |w: &[(&Command, f64)]| {
            let [before, at, after] =
                [&w[0].0.from, &w[0].0.to, &w[1].0.to].map(|p| self.robot.pose(p).translation.vector);
            Corner { before, at, after, radius: w[0].1, lines: w.iter().all(|(command, _)| command.kind == "lin") }
        };
        let corners: Vec<Corner> = commands.windows(2).map(corner).collect();
        for at in points.iter().step_by(25) {
            let beside = || curves.iter().map(|curve| distance(curve, at)).fold(f64::INFINITY, f64::min);
            let blends = corners.iter().any(|corner| corner.may_blend_at(at));
            assert!(blends || beside() < 1e-6, "{name}: {at:?} is on no command and in no blend");
        }
    }

    /// Two commands of the joints, the way-point between them passed within `radius` of the tool point.
    fn blended_ptps(&self, from: &Joints<N>, commands: [&Command; 2], radius: f64, name: &str) -> Vec<Joints<N>> {
        let arm = self.arm(from);
        let [middle, to] = commands.map(|command| self.stand(&command.to));
        let corner = arm.forward(&middle).translation.vector;
        let far = |q: &Joints<N>| (arm.forward(q).translation.vector - corner).norm();
        let lines = [(from - middle).normalize(), (to - middle).normalize()];
        // The blend ends where the tool leaves the sphere, on either line.
        let leaves = |d: &f64| lines.iter().any(|line| far(&(middle + line * *d)) > radius);
        let d = (1..).map(|k| f64::from(k) * 1e-3).find(leaves).expect("the tool moves") - 1e-3;
        let least = |value: fn(&Command) -> f64| value(commands[0]).min(value(commands[1]));
        let shares = (least(|c| c.vel), least(|c| c.acc));
        let planner = Planner::new(&arm, self.robot.limits(self.range, shares));
        let path = |blend: f64| JointLines::through(&[*from, middle, to], &[blend]).expect("a blend that fits");
        let [passing, stopping] = [path(d), path(0.0)];
        let [motion, slow] =
            [&passing, &stopping].map(|path| planner.plan(path).unwrap_or_else(|e| panic!("{name}: {e}")));
        let (duration, stopping) = (motion.duration(), slow.duration());
        assert!(duration < stopping, "{name}: {duration} s, {stopping} s with a stop");
        let q = self.judged(&motion, shares, name);
        assert!((q[q.len() - 1] - to).amax() < 1e-12, "{name}");
        self.ends_in(&commands[1].to, &q, name);
        for q in &q {
            let beside = |line: &Joints<N>| (q - middle) - line * (q - middle).dot(line);
            let on_a_line = lines.iter().any(|line| beside(line).norm() < 1e-9);
            assert!(on_a_line || far(q) <= radius + 1e-9, "{name}: {} m from the way-point", far(q));
        }
        q
    }

    /// Runs a sequence, each part from where the one before ended. How often the arm rests on the way; the suite
    /// blends there.
    fn sequence(&self, steps: &[(String, f64)], name: &str) -> usize {
        let steps: Vec<(&Command, f64)> = steps.iter().map(|(s, radius)| (&self.robot.commands[s], *radius)).collect();
        let mut all = vec![self.stand(&steps[0].0.from)];
        for part in steps.chunk_by(|a, b| (a.0.kind == "ptp") == (b.0.kind == "ptp")) {
            let from = all[all.len() - 1];
            let q = match part {
                [(first, radius), (second, _)] if first.kind == "ptp" => {
                    self.blended_ptps(&from, [*first, *second], *radius, name)
                }
                [(one, _)] if one.kind == "ptp" => self.ptp(&from, one, name),
                tool => self.along(&from, tool, name),
            };
            let jump = (q[0] - from).amax();
            assert!(jump < 1e-9, "{name}: {} begins {jump} rad beside the end before it", part[0].0.to);
            all.extend(&q[1..]);
        }
        rests(&all, &self.rates((1.0, 1.0)).0) - 2
    }

    /// Runs all commands and sequences; how often the arm rests on the way of each sequence.
    fn run(&self) -> BTreeMap<String, usize> {
        for (name, command) in &self.robot.commands {
            let from = self.stand(&command.from);
            match command.kind.as_str() {
                "ptp" => self.ptp(&from, command, name),
                _ => self.along(&from, &[(command, 0.0)], name),
            };
        }
        let rests = |(name, steps): (&String, &Vec<(String, f64)>)| (name.clone(), self.sequence(steps, name));
        self.robot.sequences.iter().map(rests).collect()
    }
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

/// On lines and arcs joint 3 is held where it is when they begin, or another joint where the arm does not get to their
/// end with that one; the suite lets its own inverse choose.
#[test]
fn commands_and_sequences_of_pilz_on_the_panda() {
    let File { cartesian, panda: robot, .. } = cases();
    let arm = panda();
    let held = |q: &Joints<7>| {
        let arms = [2, 4, 6, 0, 1, 3, 5].map(|k| LockedArm::new(&arm, k, q[k]));
        arms.into_iter().filter_map(Result::ok).collect()
    };
    let rests = Bench { robot: &robot, cartesian, range: arm.range(), arms: &held }.run();
    let expected = [("ComplexSequence", 4), ("NoIntersectionTraj2", 0), ("SimpleSequence", 0)];
    assert_eq!(rests, expected.map(|(name, rests)| (name.to_owned(), rests)).into());
}

#[test]
fn commands_and_sequences_of_pilz_on_the_prbt() {
    let File { cartesian, prbt: robot, .. } = cases();
    let arm = prbt(&robot);
    let rests = Bench { robot: &robot, cartesian, range: arm.range(), arms: &|_: &Joints<6>| vec![arm] }.run();
    let expected = [
        ("ComplexSequence", 4),
        ("LinPtpSequence", 1),
        ("NoIntersectionTraj2", 0),
        ("PtpLinSequence", 1),
        ("PtpPtpSequence", 0),
        ("SimpleSequence", 0),
    ];
    assert_eq!(rests, expected.map(|(name, rests)| (name.to_owned(), rests)).into());
}
