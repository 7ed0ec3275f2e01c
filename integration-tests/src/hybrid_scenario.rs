//! Random scenarios for motion in both spaces, by seed: a random smooth path in the workspace of an arm, random limits, and an operator
//! who does random things at random cycles. Every cycle is held against every limit with nothing but the setpoints.

use arcfeed_feedrate::LiveSection;
use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Command, Excursion, HybridMotion, HybridState, HybridStep, JointMoveBy, LeaveBy, Limits, LivePath, MotionPath,
    Planner, Setpoint, ToolLimits, ToolPath,
};
use arcfeed_kinematics::{Joints, ParallelAxisArm, models};
use arcfeed_testing::Random;
use nalgebra::{UnitQuaternion, Vector3};

/// A motion that takes more cycles than this hangs.
const MOST_CYCLES: usize = 300_000;
/// By how much a limit may seem to be exceeded through rounding.
const TOLERANCE: f64 = 1e-6;

pub(crate) fn vector(random: &mut Random, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.between(-size, size))
}

/// The arms that stages are drawn from: CR7 and UR5e.
pub fn arms() -> [ParallelAxisArm; 2] {
    [models::cr7(), models::ur5e()]
}

/// An arm, a path and limits: what several scenarios share.
#[derive(Debug, Clone)]
pub struct Stage<'a> {
    /// The arm.
    pub arm: &'a ParallelAxisArm,
    /// The path, made ready.
    pub live: LivePath<'a>,
}

impl<'a> Stage<'a> {
    /// The stage that belongs to `seed`, with one of `arms`, or `None` where the random path is one that the arm cannot follow.
    pub fn random(arms: &'a [ParallelAxisArm; 2], seed: u64) -> Option<Self> {
        let r = &mut Random::new(seed ^ 0x5EED_57A6);
        let arm = &arms[usize::from(r.below(2) != 0)];
        let centre = Vector3::new(r.between(0.3, 0.5), r.between(-0.25, 0.25), r.between(0.1, 0.4));
        let size = r.log(0.01, 0.12);
        let count = 4 + r.below(6);
        let degree = 3 + r.below(3).min(count - 4);
        let points: Vec<Vector3<f64>> = (0..count).map(|_| centre + vector(r, size)).collect();
        let mut knots = vec![0.0; degree + 1];
        for _ in 0..count - degree - 1 {
            knots.push(knots[knots.len() - 1] + r.between(0.3, 1.0));
        }
        let end = knots[knots.len() - 1] + r.between(0.3, 1.0);
        knots.extend(vec![end; degree + 1]);
        let curve = ArcLengthCurve::new(NurbsCurve::bspline(degree, points, knots).ok()?, 1e-15).ok()?;
        let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
        let first = UnitQuaternion::from_scaled_axis(vector(r, 0.3)) * down;
        let orientation = if r.below(2) == 0 {
            OrientationPath::Constant(first)
        } else {
            OrientationPath::slerp(curve.length(), first, UnitQuaternion::from_scaled_axis(vector(r, 0.6)) * first)
                .ok()?
        };
        let path = PosePath::new(curve, orientation);
        let mut tool = ToolLimits::new()
            .with_feed(r.log(0.1, 0.6))
            .and_then(|t| t.with_tangential_acceleration(r.log(0.5, 5.0)))
            .and_then(|t| t.with_tangential_jerk(r.log(10.0, 200.0)))
            .and_then(|t| t.with_normal_acceleration(r.log(0.5, 5.0)))
            .ok()?;
        if r.below(3) == 0 {
            tool = tool.with_normal_jerk(r.log(10.0, 200.0)).ok()?;
        }
        if r.below(3) == 0 {
            tool = tool.with_angular_speed(r.log(0.3, 3.0)).ok()?;
        }
        let rates = [r.log(1.0, 4.0), r.log(3.0, 30.0), r.log(30.0, 1000.0)].map(Joints::repeat);
        let limits = arm.range().with_rates(rates[0], rates[1], rates[2]).ok()?;
        let path = ToolPath::new(arm, path, limits.range()).ok()?;
        let period = [1e-3, 2e-3, 4e-3][r.below(3)];
        let planner = Planner::new(arm, Limits::new(limits).with_tool(tool))
            .with_chord_tolerance(r.log(1e-6, 1e-4))
            .and_then(|p| p.with_period(period))
            .ok()?;
        let live = planner.live(path).ok()?;
        Some(Self { arm, live })
    }

    fn command(&self, r: &mut Random, motion: &HybridMotion<'_>) -> Command {
        let length = self.live.path().length();
        match r.below(14) {
            0 | 1 => Command::Override(r.between(0.0, 1.5)),
            2 => Command::Feed(r.log(0.005, 0.6)),
            3 => {
                let from = r.between(0.0, length);
                Command::Section(LiveSection {
                    from,
                    to: from + r.between(0.01, 0.5) * length,
                    feed: r.log(0.005, 0.3),
                })
            }
            4 => Command::ClearSections,
            5 => Command::Hold,
            6 | 7 => Command::Resume,
            8 => Command::StepBack(r.between(0.0, motion.feed().position())),
            9..=11 => {
                let here = motion.setpoint().q;
                let count = 1 + r.below(4);
                let (lower, upper) = (self.live.joints().lower(), self.live.joints().upper());
                let points: Vec<Joints<6>> = (0..count)
                    .map(|_| Joints::from_fn(|k, _| (here[k] + r.between(-0.8, 0.8)).max(lower[k]).min(upper[k])))
                    .collect();
                let leave = if r.below(2) == 0 { LeaveBy::Braking } else { LeaveBy::AtOnce };
                let within = if r.below(2) == 0 { 0.0 } else { r.log(1e-3, 1.0) };
                let by = if r.below(2) == 0 { JointMoveBy::LeastTime } else { JointMoveBy::Projection };
                let excursion = Excursion::new(&points, leave).and_then(|e| e.with_passing(within));
                excursion.map_or(Command::None, |e| Command::Leave(e.with_joint_moves(by)))
            }
            12 => Command::Return,
            _ => Command::None,
        }
    }

    /// Plays the scenario that belongs to `seed`; `allocations` counts those of this thread, which no step may add to.
    ///
    /// # Errors
    /// What went wrong, and in which cycle.
    pub fn play(&self, seed: u64, allocations: impl Fn() -> usize) -> Result<Played, String> {
        let r = &mut Random::new(seed);
        let feed = r.log(0.01, 0.5);
        let mut motion = HybridMotion::new(&self.live, feed).map_err(|e| e.to_string())?;
        let mut watch = Watch::new(self, *motion.setpoint());
        let acts = r.below(14);
        let span = self.live.curve().duration() / self.live.period() * 1.5;
        let mut cycles: Vec<usize> = (0..acts).map(|_| r.between(0.0, span) as usize).collect();
        cycles.sort_unstable();
        let stops = r.below(8) == 0;
        let last = cycles.last().copied().unwrap_or(0) + r.below(400);
        let mut next = 0;
        let mut played = Played::default();
        for cycle in 0..MOST_CYCLES {
            // Whatever was done, it can be brought to an end: by stopping, or by going on to the end of the path.
            let after = cycle.checked_sub(last);
            let command = match after {
                Some(1) if stops => Command::Stop,
                Some(1) => Command::Override(1.0),
                Some(2) => Command::ClearSections,
                Some(3) => Command::Feed(self.live.tool().feed().unwrap_or(feed)),
                Some(4) => Command::Return,
                Some(5) => Command::Resume,
                _ if next < cycles.len() && cycles[next] <= cycle => {
                    next += 1;
                    self.command(r, &motion)
                }
                _ => Command::None,
            };
            let before = allocations();
            let step = motion.step(&command);
            if allocations() != before {
                return Err(format!("cycle {cycle}, state {:?}: the step allocates", step.state));
            }
            watch.look(&step).map_err(|what| format!("cycle {cycle}, state {:?}: {what}", step.state))?;
            played.left_path |= !step.on_path;
            match step.state {
                HybridState::Done | HybridState::Stopped => {
                    played.cycles = cycle + 1;
                    let s = &step.setpoint;
                    if s.qd.amax() + s.qdd.amax() > 0.0 {
                        return Err(format!("ends in motion: {s:?}"));
                    }
                    if step.state == HybridState::Done && s.s != self.live.path().length() {
                        return Err(format!("done at s = {} of {}", s.s, self.live.path().length()));
                    }
                    if step.state == HybridState::Stopped && !stops {
                        return Err(format!("stopped without being told: {:?}", step.state));
                    }
                    played.worst = watch.worst;
                    return Ok(played);
                }
                _ => {}
            }
        }
        Err(format!("no end after {MOST_CYCLES} cycles: {:?} at {:?}", motion.state(), motion.setpoint()))
    }
}

/// What a scenario came to.
#[derive(Debug, Clone, Copy, Default)]
pub struct Played {
    /// Cycles until the end.
    pub cycles: usize,
    /// True if the tool left the path.
    pub left_path: bool,
    /// Largest ratio of anything to its limit.
    pub worst: f64,
}

/// Holds one cycle after the other against all limits.
struct Watch<'a> {
    stage: &'a Stage<'a>,
    before: Setpoint,
    on_path: bool,
    worst: f64,
}

impl<'a> Watch<'a> {
    fn new(stage: &'a Stage<'a>, start: Setpoint) -> Self {
        Self { stage, before: start, on_path: true, worst: 0.0 }
    }

    fn see(&mut self, what: &str, value: f64, limit: f64) -> Result<(), String> {
        let ratio = value / limit;
        // NaN is no pass.
        if ratio <= 1.0 + TOLERANCE {
            self.worst = self.worst.max(ratio);
            return Ok(());
        }
        Err(format!("{what} is {value}, limit {limit}, at s = {}", self.before.s))
    }

    fn look(&mut self, step: &HybridStep) -> Result<(), String> {
        let live = &self.stage.live;
        let (limits, tool, period) = (live.joints(), live.tool(), live.period());
        let (now, before) = (step.setpoint, self.before);
        for k in 0..6 {
            if !(limits.lower()[k] - 1e-12..=limits.upper()[k] + 1e-12).contains(&now.q[k]) {
                return Err(format!("joint {k} at {} is outside its range", now.q[k]));
            }
            let jerk = limits.jerk()[k];
            self.see("joint velocity", now.qd[k].abs(), limits.velocity()[k])?;
            self.see("joint acceleration", now.qdd[k].abs(), limits.acceleration()[k])?;
            self.see("joint jerk", (now.qdd[k] - before.qdd[k]).abs() / period, jerk)?;
            // What every motion satisfies whose jerk is below the limit, from one sample to the next; and rounding.
            let v = now.qd[k] - before.qd[k] - 0.5 * period * (before.qdd[k] + now.qdd[k]);
            let q = now.q[k] - before.q[k] - 0.5 * period * (before.qd[k] + now.qd[k]);
            self.see("jump of joint velocity", v.abs(), jerk * period.powi(2) / 4.0 + 1e-11)?;
            self.see("jump of joint position", q.abs(), jerk * period.powi(3) / 12.0 * 1.001 + 1e-12)?;
        }
        let configuration = arcfeed_kinematics::ForwardKinematics::configuration(self.stage.arm, &now.q);
        let pose = configuration.pose();
        let stated =
            (pose.translation.vector - now.pose.translation.vector).norm() + pose.rotation.angle_to(&now.pose.rotation);
        self.see("misstated pose", stated, 1e-8)?;
        let velocity = (configuration.jacobian() * now.qd).fixed_rows::<3>(0).into_owned();
        let speed = velocity.norm();
        if step.on_path {
            let path = live.path().pose_path();
            let most = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
            let wanted = path.jet(now.s).pose;
            let off = (pose.translation.vector - wanted.translation.vector).norm();
            self.see("distance from the path", off, 1e-9)?;
            self.see("turn away from the path", pose.rotation.angle_to(&wanted.rotation), 1e-7)?;
            self.see("feed", speed, most(tool.feed()))?;
            let angular = (configuration.jacobian() * now.qd).fixed_rows::<3>(3).norm();
            self.see("angular speed", angular, most(tool.angular_speed()))?;
            let acceleration = configuration.jacobian() * now.qdd + configuration.acceleration_bias(&now.qd);
            let acceleration = acceleration.fixed_rows::<3>(0).into_owned();
            let direction = path.curve().jet(now.s).d1;
            let tangential = acceleration.dot(&direction);
            self.see("tangential acceleration", tangential.abs(), most(tool.tangential_acceleration()))?;
            let normal = (acceleration - direction * tangential).norm();
            self.see("normal acceleration", normal, most(tool.normal_acceleration()))?;
            if let (Some(limit), true) = (tool.normal_jerk(), speed > 1e-3 * tool.feed().unwrap_or(0.0)) {
                self.see("normal jerk", normal * normal / speed, limit)?;
            }
            if self.on_path {
                let (a, b) = (path.curve().point(before.s), path.curve().point(now.s));
                let middle = path.curve().point(0.5 * (before.s + now.s));
                let chord = b - a;
                let d = middle - a;
                let f = if chord.norm() > 0.0 { d.dot(&chord) / chord.norm_squared() } else { 0.0 };
                self.see("chord error", (d - chord * f).norm(), live.chord_tolerance())?;
            }
        } else if !self.on_path && before.s != now.s {
            return Err("the place on the path was lost".to_owned());
        }
        (self.before, self.on_path) = (now, step.on_path);
        Ok(())
    }
}
