//! The last word on a trajectory: its setpoints against every limit, on dense samples, without the planner's help.
//!
//! Nothing here knows how the trajectory was planned. Setpoints are sampled several times per
//! control period; positions, velocities and accelerations of the tool are recomputed from the
//! joints by forward kinematics; jerk comes from differences of the accelerations, which are
//! averages of the true jerk and so never exceed its maximum; and each position and velocity is
//! held against the one before, so that a jump cannot hide between samples. What rounding may add
//! to a joint position follows from the residual that the arm's inverse states, see
//! [`InverseKinematics::residual`].
//!
//! [`InverseKinematics::residual`]: arcfeed_kinematics::InverseKinematics::residual

use std::collections::VecDeque;

use arcfeed_geometry::PosePath;
use arcfeed_kinematics::{ForwardKinematics, JointLimits, Joints, PoseResidual, ToolDerivatives, Twist};
use nalgebra::Vector3;

use crate::arm::PathArm;
use crate::error::PlanError;
use crate::limits::ToolLimits;
use crate::sections::{Feeds, Section};
use crate::torque::TorqueLimits;
use crate::trajectory::Setpoint;

/// Samples per control period, at least.
const DENSITY: usize = 8;
/// And so many more, that they are no further apart than this, s: a bend takes the arm no less time when its controller is
/// slow.
const FINEST: f64 = 1.25e-4;
/// But not more than this many per period.
const DENSEST: usize = 4096;
/// Motions with more samples than this are refused: more than three hours at 1 ms.
const MOST_SAMPLES: f64 = 1e8;
/// How far the tool may be turned away from the path's orientation, rad. Exact inverses stay below 1e-9; the step of any
/// encoder is larger.
const ORIENTATION_TOLERANCE: f64 = 1e-6;
/// What counts as zero, relative to a limit or to the length of the path: speed at the ends, and the difference between
/// what a setpoint says of the tool and what its joints do.
const ZERO: f64 = 1e-6;

/// No rounding moves a joint by more than this between two samples, rad (m): at the least singular
/// value that a plan comes to, an arm of 20 m is off by less.
const MOST_ROUNDING: f64 = 1e-9;
/// Relative rounding of a speed: where a motion ends at one, its law and that speed need not agree in every digit.
const SPEED: f64 = 1e-10;

/// What is held against a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// Joint position, as distance from the middle of its range (rad) against half the range.
    JointPosition,
    /// Joint velocity, rad/s.
    JointVelocity,
    /// Joint acceleration, rad/s^2.
    JointAcceleration,
    /// Joint jerk, rad/s^3.
    JointJerk,
    /// Speed of the tool point, m/s.
    Feed,
    /// Acceleration of the tool point along its motion, m/s^2.
    TangentialAcceleration,
    /// Derivative of the tangential acceleration, m/s^3.
    TangentialJerk,
    /// Acceleration of the tool point across its motion, m/s^2.
    NormalAcceleration,
    /// Distance of the path from the straight line between two setpoints, m.
    ChordError,
    /// Distance of the tool from the path, m, against the chord tolerance.
    PathDeviation,
    /// Angle between the tool and the path's orientation, rad.
    OrientationDeviation,
    /// Misfit of position, velocity and acceleration from one sample to the next, against what the jerk limit allows.
    Continuity,
    /// Start and end: at the ends of the path and at rest, or at the speeds asked for without tangential acceleration, in units of
    /// what counts as zero.
    Ends,
    /// What the setpoint itself says of pose, feed and tangential acceleration against what its joints do, in units of
    /// what counts as zero.
    SetpointAgreement,
    /// Jerk that the curvature causes at constant speed, kappa^2 v^3, m/s^3; only where it is limited.
    NormalJerk,
    /// Angular speed of the tool, rad/s; only where it is limited.
    AngularSpeed,
    /// Joint torque, N m; only where it is limited.
    JointTorque,
}

impl Quantity {
    /// Name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::JointPosition => "joint position",
            Self::JointVelocity => "joint velocity",
            Self::JointAcceleration => "joint acceleration",
            Self::JointJerk => "joint jerk",
            Self::Feed => "feed rate",
            Self::TangentialAcceleration => "tangential acceleration",
            Self::TangentialJerk => "tangential jerk",
            Self::NormalAcceleration => "normal acceleration",
            Self::ChordError => "chord error",
            Self::PathDeviation => "deviation from the path",
            Self::OrientationDeviation => "turn away from the path",
            Self::Continuity => "continuity",
            Self::Ends => "state at both ends",
            Self::SetpointAgreement => "setpoint agreement",
            Self::NormalJerk => "normal jerk",
            Self::AngularSpeed => "angular speed",
            Self::JointTorque => "joint torque",
        }
    }

    /// SI unit of the value.
    pub fn unit(self) -> &'static str {
        match self {
            Self::JointPosition | Self::OrientationDeviation => "rad",
            Self::JointVelocity | Self::AngularSpeed => "rad/s",
            Self::JointTorque => "N m",
            Self::JointAcceleration => "rad/s^2",
            Self::JointJerk => "rad/s^3",
            Self::Feed => "m/s",
            Self::TangentialAcceleration | Self::NormalAcceleration => "m/s^2",
            Self::TangentialJerk | Self::NormalJerk => "m/s^3",
            Self::ChordError | Self::PathDeviation => "m",
            Self::Continuity | Self::Ends | Self::SetpointAgreement => "1",
        }
    }
}

/// The worst place of a trajectory for one limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Check {
    /// What was checked.
    pub quantity: Quantity,
    /// Which joint, from 0, where it is a joint's limit.
    pub joint: Option<usize>,
    /// The value there, SI.
    pub value: f64,
    /// Its limit, SI.
    pub limit: f64,
    /// Value over limit: above 1 the limit is broken.
    pub ratio: f64,
    /// Arc length of the place, m.
    pub s: f64,
    /// Time, s.
    pub t: f64,
}

/// What a trajectory must keep.
#[derive(Debug, Clone, Copy)]
pub struct Requirement<'a, const N: usize = 6> {
    /// The path the tool follows.
    pub path: &'a PosePath,
    /// Limits of the tool.
    pub tool: &'a ToolLimits,
    /// Limits of the joints.
    pub joints: &'a JointLimits<N>,
    /// Largest chord error between two control cycles, m.
    pub chord_tolerance: f64,
    /// Control period, s.
    pub period: f64,
    /// Parts of the path with a feed of their own, in their order on it, without overlap.
    pub sections: &'a [Section],
    /// Speeds at the start and at the end of the path, m/s.
    pub end_speeds: [f64; 2],
    /// What the drives can do, where that is to be looked at.
    pub torque: Option<TorqueLimits<'a, N>>,
}

impl<'a, const N: usize> Requirement<'a, N> {
    /// From rest to rest with one feed for the whole path, whatever the torque; the fields can be set afterwards.
    pub fn new(
        path: &'a PosePath,
        tool: &'a ToolLimits,
        joints: &'a JointLimits<N>,
        chord_tolerance: f64,
        period: f64,
    ) -> Self {
        Self { path, tool, joints, chord_tolerance, period, sections: &[], end_speeds: [0.0; 2], torque: None }
    }

    fn feeds(&self) -> Feeds<'a> {
        Feeds { elsewhere: self.tool.feed, sections: self.sections }
    }
}

/// The result of [`verify`]: for every limit the place where the trajectory comes closest to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    checks: Vec<Check>,
    samples: usize,
}

impl Verification {
    /// The worst place for each limit, joint by joint.
    pub fn checks(&self) -> &[Check] {
        &self.checks
    }

    /// The check with the largest ratio.
    pub fn worst(&self) -> Check {
        self.checks
            .iter()
            .copied()
            .fold(self.checks[0], |m, c| if c.ratio > m.ratio || c.ratio.is_nan() { c } else { m })
    }

    /// The largest ratio of one quantity over all joints.
    pub fn worst_of(&self, quantity: Quantity) -> Check {
        self.checks
            .iter()
            .copied()
            .filter(|c| c.quantity == quantity)
            .fold(self.checks[0], |m, c| if m.quantity != quantity || c.ratio > m.ratio { c } else { m })
    }

    /// True where no ratio exceeds `1 + tolerance`.
    pub fn holds(&self, tolerance: f64) -> bool {
        // NaN does not hold.
        self.checks.iter().all(|c| c.ratio <= 1.0 + tolerance)
    }

    /// Number of setpoints looked at.
    pub fn samples(&self) -> usize {
        self.samples
    }
}

/// Largest ratio found so far for one limit.
struct Worst {
    check: Check,
}

impl Worst {
    fn new(quantity: Quantity, joint: Option<usize>, limit: f64) -> Self {
        Self { check: Check { quantity, joint, value: 0.0, limit, ratio: 0.0, s: 0.0, t: 0.0 } }
    }

    fn see<const N: usize>(&mut self, value: f64, at: &Setpoint<N>) {
        self.see_against(value, self.check.limit, at);
    }

    /// Where the limit is not the same everywhere.
    fn see_against<const N: usize>(&mut self, value: f64, limit: f64, at: &Setpoint<N>) {
        let ratio = value / limit;
        // A NaN, once seen, stays.
        if self.check.ratio.is_nan() {
            return;
        }
        if ratio > self.check.ratio || ratio.is_nan() {
            self.check = Check { value, limit, ratio, s: at.s, t: at.t, ..self.check };
        }
    }
}

/// Holds a trajectory of length `duration` (s) against `requirement`.
///
/// `setpoint` gives the setpoint at a time; it is called with increasing times, eight per control period or
/// more: at least one every 0.125 ms.
///
/// # Errors
/// [`PlanError::Limit`] for a duration that is not a finite number of 0 or more, [`PlanError::TooLong`] for one that
/// would take too many samples; otherwise whatever `setpoint` returns.
pub fn verify<A, const N: usize>(
    arm: &A,
    requirement: &Requirement<'_, N>,
    duration: f64,
    mut setpoint: impl FnMut(f64) -> Result<Setpoint<N>, PlanError>,
) -> Result<Verification, PlanError>
where
    A: PathArm<N> + ?Sized,
{
    if !(duration.is_finite() && duration >= 0.0) {
        return Err(PlanError::Limit { what: "duration", value: duration });
    }
    let mut tally = Tally::new(requirement);
    let density = ((requirement.period / FINEST).ceil() as usize).max(DENSITY).min(DENSEST);
    let dt = requirement.period / density as f64;
    let longest = MOST_SAMPLES * dt;
    if duration > longest {
        return Err(PlanError::TooLong { duration, longest });
    }
    let steps = (duration / dt * (1.0 - 1e-12)).floor() as usize;
    // Ring of the samples of the last control period.
    let mut ring: VecDeque<Sample<N>> = VecDeque::with_capacity(density + 1);
    for i in 0..=steps + 1 {
        let t = if i > steps { duration } else { i as f64 * dt };
        let sample = Sample::new(arm, requirement.path, setpoint(t)?);
        tally.look(&sample, requirement);
        if i == 0 {
            tally.end(&sample, 0.0, requirement.end_speeds[0], requirement);
        }
        if i > steps {
            tally.end(&sample, requirement.path.length(), requirement.end_speeds[1], requirement);
        }
        if let (Some(first), Some(before)) = (ring.front(), ring.back()) {
            let rounding = |at: &Setpoint<N>| joint_rounding(arm, requirement.path, &at.q);
            tally.compare([first, before, &sample], requirement, rounding);
        }
        if ring.len() > density {
            ring.pop_front();
        }
        ring.push_back(sample);
        // One control cycle is complete: the path within it against its chord.
        if ring.len() == density + 1 && i % density == 0 {
            tally.chord(ring.make_contiguous());
        }
    }
    // The last, shorter cycle.
    let last = ring.len().saturating_sub(steps % density + 2);
    tally.chord(&ring.make_contiguous()[last..]);
    Ok(Verification { checks: tally.worst.into_iter().map(|w| w.check).collect(), samples: steps + 2 })
}

/// How far rounding may have moved each joint of a setpoint at `q` on `path`: the residual of the
/// inverse and the rounding of the path itself, carried to the joints, and the rounding of the
/// joint values.
fn joint_rounding<A: PathArm<N> + ?Sized, const N: usize>(arm: &A, path: &PosePath, q: &Joints<N>) -> Joints<N> {
    /// Units in the last place of an arc length and of a coordinate that a path may be off by.
    const PATH: f64 = 16.0 * f64::EPSILON;
    let PoseResidual { position, orientation } = arm.residual(q);
    let reach = arm.configuration(q).position().norm();
    let position = position + PATH * (path.length() + reach);
    let orientation = orientation + PATH;
    let mut moved = q.map(|value| PATH * value.abs());
    for row in 0..6 {
        let mut first = Twist::zeros();
        first[row] = if row < 3 { position } else { orientation };
        let tool = ToolDerivatives { first, second: Twist::zeros(), third: Twist::zeros() };
        // At a singular pose nothing is allowed: no plan leads there.
        let Ok(step) = arm.derivatives(q, &tool) else { return moved };
        moved += step.first.abs();
    }
    moved
}

/// A setpoint with what the tool really does there.
struct Sample<const N: usize> {
    at: Setpoint<N>,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    /// Angular speed.
    turning: f64,
    /// Along the motion and across it.
    tangential: f64,
    normal: f64,
    off_path: f64,
    /// Angle to the path's orientation.
    turned: f64,
    /// Position and angle by which the setpoint's own pose is off, in m and rad added up.
    misstated: f64,
}

impl<const N: usize> Sample<N> {
    fn new<A: ForwardKinematics<N> + ?Sized>(arm: &A, path: &PosePath, at: Setpoint<N>) -> Self {
        let configuration = arm.configuration(&at.q);
        let jacobian = configuration.jacobian();
        let linear = |v: arcfeed_kinematics::Twist| Vector3::new(v[0], v[1], v[2]);
        let pose = configuration.pose();
        let position = pose.translation.vector;
        let twist = jacobian * at.qd;
        let velocity = linear(twist);
        let acceleration = linear(jacobian * at.qdd + configuration.acceleration_bias(&at.qd));
        // At a standstill the motion has no direction of its own; the path has one.
        let direction = velocity.try_normalize(1e-9).unwrap_or_else(|| path.curve().jet(at.s).d1);
        let tangential = acceleration.dot(&direction);
        let wanted = path.orientation().jet(at.s).rotation;
        let stated = (at.pose.translation.vector - position).norm() + at.pose.rotation.angle_to(&pose.rotation);
        Self {
            turned: pose.rotation.angle_to(&wanted),
            misstated: stated,
            position,
            velocity,
            turning: Vector3::new(twist[3], twist[4], twist[5]).norm(),
            tangential,
            normal: (acceleration - direction * tangential).norm(),
            off_path: (position - path.curve().point(at.s)).norm(),
            at,
        }
    }
}

struct Tally<const N: usize> {
    worst: Vec<Worst>,
    lower: Joints<N>,
    upper: Joints<N>,
    /// Arc lengths where the curvature of the path jumps.
    jumps: Vec<f64>,
    /// Positions in `worst` of what is not always limited; of the torques the first joint's.
    normal_jerk: Option<usize>,
    angular: Option<usize>,
    torque: Option<usize>,
}

impl<const N: usize> Tally<N> {
    /// Positions in `Tally::worst`: four joint quantities of `N` entries, then the others in the order of `Tally::new`.
    const POSITION: usize = 0;
    const VELOCITY: usize = N;
    const ACCELERATION: usize = 2 * N;
    const JERK: usize = 3 * N;
    const TOOL: usize = 4 * N;
    const TANGENTIAL: usize = Self::TOOL + 1;
    const TANGENTIAL_JERK: usize = Self::TOOL + 2;
    const NORMAL: usize = Self::TOOL + 3;
    const CHORD: usize = Self::TOOL + 4;
    const OFF_PATH: usize = Self::TOOL + 5;
    const TURNED: usize = Self::TOOL + 6;
    const CONTINUITY: usize = Self::TOOL + 7;
    const ENDS: usize = Self::TOOL + 8;
    const AGREEMENT: usize = Self::TOOL + 9;

    fn new(r: &Requirement<'_, N>) -> Self {
        let mut worst = Vec::new();
        let mut add = |quantity, joint, limit| {
            worst.push(Worst::new(quantity, joint, limit));
        };
        let (lower, upper) = (*r.joints.lower(), *r.joints.upper());
        for (quantity, limits) in [
            (Quantity::JointPosition, (upper - lower) / 2.0),
            (Quantity::JointVelocity, *r.joints.velocity()),
            (Quantity::JointAcceleration, *r.joints.acceleration()),
            (Quantity::JointJerk, *r.joints.jerk()),
        ] {
            for joint in 0..N {
                add(quantity, Some(joint), limits[joint]);
            }
        }
        for (quantity, limit) in [
            (Quantity::Feed, r.tool.feed),
            (Quantity::TangentialAcceleration, r.tool.tangential_acceleration),
            (Quantity::TangentialJerk, r.tool.tangential_jerk),
            (Quantity::NormalAcceleration, r.tool.normal_acceleration),
            (Quantity::ChordError, r.chord_tolerance),
            (Quantity::PathDeviation, r.chord_tolerance),
            (Quantity::OrientationDeviation, ORIENTATION_TOLERANCE),
            (Quantity::Continuity, 1.0),
            (Quantity::Ends, 1.0),
            (Quantity::SetpointAgreement, 1.0),
        ] {
            add(quantity, None, limit);
        }
        let mut optional = |quantity, limit: Option<f64>| {
            let limit = limit?;
            worst.push(Worst::new(quantity, None, limit));
            Some(worst.len() - 1)
        };
        let normal_jerk = optional(Quantity::NormalJerk, r.tool.normal_jerk);
        let angular = optional(Quantity::AngularSpeed, r.tool.angular_speed);
        let torque = r.torque.map(|torque| {
            let limits = torque.limits();
            worst.extend((0..N).map(|joint| Worst::new(Quantity::JointTorque, Some(joint), limits[joint])));
            worst.len() - N
        });
        let jumps = r
            .path
            .knots()
            .into_iter()
            .filter(|&s| {
                let (a, b) = (r.path.jet_left(s), r.path.jet(s));
                (a.d2 - b.d2).norm() > 1e-7 * (1.0 + a.d2.norm())
            })
            .collect();
        Self { worst, lower, upper, jumps, normal_jerk, angular, torque }
    }

    fn see(&mut self, index: usize, value: f64, at: &Setpoint<N>) {
        self.worst[index].see(value, at);
    }

    /// Limits on what happens at one moment.
    fn look(&mut self, sample: &Sample<N>, r: &Requirement<'_, N>) {
        let at = &sample.at;
        for k in 0..N {
            let middle = 0.5 * (self.lower[k] + self.upper[k]);
            self.see(Self::POSITION + k, (at.q[k] - middle).abs(), at);
            self.see(Self::VELOCITY + k, at.qd[k].abs(), at);
            self.see(Self::ACCELERATION + k, at.qdd[k].abs(), at);
        }
        let speed = sample.velocity.norm();
        let feed = r.feeds().at(at.s);
        self.worst[Self::TOOL].see_against(speed, feed, at);
        self.see(Self::TANGENTIAL, sample.tangential.abs(), at);
        self.see(Self::NORMAL, sample.normal, at);
        self.see(Self::OFF_PATH, sample.off_path, at);
        self.see(Self::TURNED, sample.turned, at);
        let misfit = ((at.feed - speed).abs() / feed)
            + ((at.acceleration - sample.tangential).abs() / r.tool.tangential_acceleration)
            + sample.misstated / ORIENTATION_TOLERANCE * ZERO;
        self.see(Self::AGREEMENT, misfit / ZERO, at);
        // normal = kappa v^2, so that kappa^2 v^3 = normal^2 / v.
        if let Some(index) = self.normal_jerk.filter(|_| speed > ZERO * feed) {
            self.see(index, sample.normal * sample.normal / speed, at);
        }
        if let Some(index) = self.angular {
            self.see(index, sample.turning, at);
        }
        if let (Some(index), Some(limits)) = (self.torque, &r.torque) {
            let torque = limits.torque(&at.q, &at.qd, &at.qdd);
            for k in 0..N {
                self.see(index + k, torque[k].abs(), at);
            }
        }
    }

    /// The first and the last sample: at `s` on the path and at rest, or at `speed`.
    fn end(&mut self, sample: &Sample<N>, s: f64, speed: f64, r: &Requirement<'_, N>) {
        let at = &sample.at;
        let (speed, acceleration) = if speed == 0.0 {
            (at.qd.component_div(r.joints.velocity()).amax(), at.qdd.component_div(r.joints.acceleration()).amax())
        } else {
            (
                (sample.velocity.norm() - speed).abs() / r.feeds().highest(),
                sample.tangential.abs() / r.tool.tangential_acceleration,
            )
        };
        let place = (at.s - s).abs() / r.path.length();
        // Not `max`: a NaN has to show.
        self.see(Self::ENDS, (speed + acceleration + place) / ZERO, at);
    }

    /// Limits on what happens from one sample to the next; the first sample is the one a control
    /// period ago. `rounding` tells by how much rounding may have moved the joints of a setpoint.
    fn compare(
        &mut self,
        [first, before, now]: [&Sample<N>; 3],
        r: &Requirement<'_, N>,
        rounding: impl Fn(&Setpoint<N>) -> Joints<N>,
    ) {
        let (a, b) = (&before.at, &now.at);
        let dt = b.t - a.t;
        if dt <= 0.0 {
            return;
        }
        let crosses = |from: f64, to: f64| self.jumps.iter().any(|&s| from <= s && s <= to);
        // Where the curvature itself jumps, acceleration has to step; a controller sees it spread over its period.
        let (base, span) = if crosses(a.s, b.s) { (first, r.period) } else { (before, dt) };
        let jumped = crosses(first.at.s, b.s);
        let jerk = (b.qdd - base.at.qdd) / span;
        for k in 0..N {
            self.see(Self::JERK + k, jerk[k].abs(), b);
            if !jumped {
                self.see(Self::JERK + k, b.jerk[k].abs(), b);
            }
        }
        self.see(Self::TANGENTIAL_JERK, ((now.tangential - before.tangential) / dt).abs(), b);

        // A motion with jerk below J satisfies |q1 - q0 - dt (v0 + v1) / 2| <= J dt^3 / 12 and
        // |v1 - v0 - dt (a0 + a1) / 2| <= J dt^2 / 4; an acceleration step within a period adds J period to that.
        let step = if jumped { r.period } else { 0.0 };
        let mut rounded: Option<Joints<N>> = None;
        for k in 0..N {
            let limit = r.joints.jerk()[k];
            let q = (b.q[k] - a.q[k] - 0.5 * dt * (a.qd[k] + b.qd[k])).abs();
            let v = b.qd[k] - a.qd[k] - 0.5 * dt * (a.qdd[k] + b.qdd[k]);
            let allowed_q = limit * (dt / 12.0 + step / 8.0) * dt * dt;
            // What rounding adds is dear to know: it is asked for where it decides.
            let worse = q > allowed_q * self.worst[Self::CONTINUITY].check.ratio.max(1.0);
            let decides = worse && q < allowed_q + MOST_ROUNDING;
            let ratio_q = match decides {
                true => q / (allowed_q + rounded.get_or_insert_with(|| rounding(a) + rounding(b))[k]),
                false => q / allowed_q,
            };
            // Rounding of v, which is a sum of terms larger than itself.
            let noise_v = 1e-12 + SPEED * b.qd[k].abs();
            let ratio_v = v.abs() / (limit * (dt / 4.0 + step / 2.0) * dt + noise_v);
            self.see(Self::CONTINUITY, ratio_q.max(ratio_v), b);
        }
    }

    /// The samples of one control cycle against the straight line between its first and last.
    fn chord(&mut self, cycle: &[Sample<N>]) {
        let (Some(first), Some(last)) = (cycle.first(), cycle.last()) else { return };
        let along = last.position - first.position;
        let length2 = along.norm_squared();
        for sample in cycle {
            let d = sample.position - first.position;
            let f = if length2 > 0.0 { (d.dot(&along) / length2).max(0.0).min(1.0) } else { 0.0 };
            self.see(Self::CHORD, (d - along * f).norm(), &sample.at);
        }
    }
}
