//! Every limit of a motion with its worst place so far.

use arcfeed_feedrate::{LimitId, Quantity};
use arcfeed_kinematics::Joints;

use super::check::Verification;
use super::requirement::Requirement;
use super::sample::Sample;
use super::worst::Worst;
use crate::path::MotionPath;
use crate::place::PathParameter;
use crate::setpoint::Setpoint;

/// How far the tool may be turned away from the path's orientation, rad. Exact inverses stay below 1e-9; the step of any
/// encoder is larger.
const ORIENTATION_TOLERANCE: f64 = 1e-6;
/// How far a joint may be away from a path of the joints, rad.
const JOINT_TOLERANCE: f64 = 1e-9;
/// What counts as zero, relative to a limit or to the length of the path: speed at the ends, and the difference between
/// what a setpoint says of the tool and what its joints do.
const ZERO: f64 = 1e-6;
/// No rounding moves a joint by more than this between two samples, rad (m): at the least singular
/// value that a plan comes to, an arm of 20 m is off by less.
const MOST_ROUNDING: f64 = 1e-9;
/// Relative rounding of a speed: where a motion ends at one, its law and that speed need not agree in every digit.
const SPEED: f64 = 1e-10;
/// Intervals of the path's length over which a limit may be let go without that being a gap.
const GAP: f64 = 3e-3;

/// The limits of each joint.
type EachJoint = Vec<Worst>;

/// Named by what they are on; `None` is not limited.
pub(super) struct Tally<'a, const N: usize> {
    r: Requirement<'a, N>,
    middle: Joints<N>,
    /// Places where the acceleration of the joints jumps because the path's curvature does.
    jumps: Vec<f64>,
    gap: f64,
    position: EachJoint,
    velocity: EachJoint,
    acceleration: EachJoint,
    jerk: Option<EachJoint>,
    torque: Option<EachJoint>,
    feed: Option<Worst>,
    tangential: Option<Worst>,
    tangential_jerk: Option<Worst>,
    normal: Option<Worst>,
    normal_jerk: Option<Worst>,
    angular: Option<Worst>,
    chord: Option<Worst>,
    off_path: Option<Worst>,
    turned: Option<Worst>,
    off_joints: Option<EachJoint>,
    continuity: EachJoint,
    ends: Worst,
    agreement: Worst,
}

impl<'a, const N: usize> Tally<'a, N> {
    pub fn new(r: &Requirement<'a, N>) -> Self {
        let (joints, tool, path) = (r.limits.joints(), r.limits.tool(), r.path);
        let each = |quantity, limits: &Joints<N>| -> EachJoint {
            (0..N).map(|joint| Worst::new(LimitId::joint(quantity, joint), limits[joint])).collect()
        };
        let one = |quantity, limit| Worst::new(LimitId::path(quantity), limit);
        let by_length = path.parameter() == PathParameter::ArcLength;
        let along = |quantity, limit: Option<f64>| limit.filter(|_| by_length).map(|limit| one(quantity, limit));
        let prescribed = path.tool(0.0).is_some();
        let feed = tool.feed().or(r.sections.first().map(|section| section.feed));
        Self {
            r: *r,
            middle: (joints.lower() + joints.upper()) / 2.0,
            jumps: jumps(path),
            gap: GAP * path.length(),
            position: each(Quantity::JointPosition, &((joints.upper() - joints.lower()) / 2.0)),
            velocity: each(Quantity::JointVelocity, joints.velocity()),
            acceleration: each(Quantity::JointAcceleration, joints.acceleration()),
            jerk: r.jerk_limited.then(|| each(Quantity::JointJerk, joints.jerk())),
            torque: r.limits.torque().map(|torque| each(Quantity::JointTorque, torque.limits())),
            feed: feed.map(|limit| one(Quantity::Feed, limit)),
            tangential: along(Quantity::TangentialAcceleration, tool.tangential_acceleration()),
            tangential_jerk: along(Quantity::TangentialJerk, tool.tangential_jerk().filter(|_| r.jerk_limited)),
            normal: along(Quantity::NormalAcceleration, tool.normal_acceleration()),
            normal_jerk: along(Quantity::NormalJerk, tool.normal_jerk()),
            angular: tool.angular_speed().map(|limit| one(Quantity::AngularSpeed, limit)),
            chord: path.tool_curve().map(|_| one(Quantity::ChordError, r.chord_tolerance)),
            off_path: prescribed.then(|| one(Quantity::PathDeviation, r.chord_tolerance)),
            turned: prescribed.then(|| one(Quantity::OrientationDeviation, ORIENTATION_TOLERANCE)),
            off_joints: (!prescribed).then(|| each(Quantity::PathDeviation, &Joints::repeat(JOINT_TOLERANCE))),
            continuity: each(Quantity::Continuity, &Joints::repeat(1.0)),
            ends: one(Quantity::Ends, 1.0),
            agreement: one(Quantity::SetpointAgreement, 1.0),
        }
    }

    /// Limits on what happens at one moment.
    pub fn look(&mut self, sample: &Sample<N>) {
        let (at, gap, r) = (&sample.at, self.gap, &self.r);
        let joints = r.limits.joints();
        for k in 0..N {
            self.position[k].see(at.q[k] - self.middle[k], at);
            self.velocity[k].see_binding(at.qd[k], joints.velocity()[k], at, gap);
            self.acceleration[k].see_binding(at.qdd[k], joints.acceleration()[k], at, gap);
        }
        let speed = sample.velocity.norm();
        if let Some(feed) = &mut self.feed {
            feed.see_binding(speed, r.feed_at(at.s), at, gap);
        }
        let tool = r.limits.tool();
        for (worst, value, limit) in [
            (&mut self.tangential, sample.tangential, tool.tangential_acceleration()),
            (&mut self.normal, sample.normal, tool.normal_acceleration()),
            (&mut self.angular, sample.turning, tool.angular_speed()),
        ] {
            if let Some((worst, limit)) = worst.as_mut().zip(limit) {
                worst.see_binding(value, limit, at, gap);
            }
        }
        // normal = kappa v^2, so that kappa^2 v^3 = normal^2 / v.
        if let Some(worst) = self.normal_jerk.as_mut().filter(|_| speed > ZERO * r.scales()[0]) {
            worst.see(sample.normal * sample.normal / speed, at);
        }
        if let Some(worst) = &mut self.off_path {
            worst.see(sample.off_path, at);
        }
        if let Some(worst) = &mut self.turned {
            worst.see(sample.turned, at);
        }
        if let Some(each) = &mut self.off_joints {
            let on_path = r.path.jet(at.s, &at.q).map_or(Joints::repeat(f64::NAN), |jet| jet.q);
            for (k, worst) in each.iter_mut().enumerate() {
                worst.see(at.q[k] - on_path[k], at);
            }
        }
        if let Some((each, limits)) = self.torque.as_mut().zip(r.limits.torque()) {
            // At rest friction has the direction of the motion that follows; at the end, of that which was.
            let qd = if at.qd.amax() == 0.0 { creeping(r, at) } else { at.qd };
            let torque = limits.torque(&at.q, &qd, &at.qdd);
            for k in 0..N {
                each[k].see_binding(torque[k], limits.limits()[k], at, gap);
            }
        }
        self.agreement.see(misfit(r, sample) / ZERO, at);
    }

    /// The jerk that a setpoint states at a knot of the law, between the regular samples. Along a curve of the tool the third derivatives
    /// of the joints have peaks that last for less than the time between two samples: there its mean over that time counts.
    pub fn look_at_jerk(&mut self, at: &Setpoint<N>) {
        if self.r.path.tool_curve().is_some() {
            return;
        }
        if let Some(each) = &mut self.jerk {
            for (worst, jerk) in each.iter_mut().zip(at.jerk.iter()) {
                worst.see(*jerk, at);
            }
        }
    }

    /// The first and the last sample: at `s` on the path, at the speed asked for.
    pub fn end(&mut self, sample: &Sample<N>, s: f64, speed: f64) {
        let (at, r) = (&sample.at, &self.r);
        let joints = r.limits.joints();
        let [fast, strong] = r.scales();
        // Where jerk is not limited the acceleration may step at an end.
        let (speed, acceleration) = if speed == 0.0 {
            (at.qd.component_div(joints.velocity()).amax(), at.qdd.component_div(joints.acceleration()).amax())
        } else {
            ((at.feed - speed).abs() / speed.max(fast), at.acceleration.abs() / strong)
        };
        let acceleration = if r.jerk_limited { acceleration } else { 0.0 * acceleration };
        let place = (at.s - s).abs() / r.path.length();
        // Not `max`: a NaN has to show.
        self.ends.see((speed + acceleration + place) / ZERO, at);
    }

    /// Limits on what happens from one sample to the next; the first sample is the one a control period ago.
    pub fn compare(&mut self, [first, before, now]: [&Sample<N>; 3]) {
        let (a, b) = (&before.at, &now.at);
        let dt = b.t - a.t;
        if dt <= 0.0 {
            return;
        }
        let crosses = |from: f64, to: f64| self.jumps.iter().any(|&s| from <= s && s <= to);
        // Where the curvature itself jumps, acceleration has to step; a controller sees it spread over its period.
        let (base, span) = if crosses(a.s, b.s) { (first, self.r.period) } else { (before, dt) };
        let jumped = crosses(first.at.s, b.s);
        if let Some(each) = &mut self.jerk {
            let jerk = (b.qdd - base.at.qdd) / span;
            for k in 0..N {
                each[k].see_binding(jerk[k], self.r.limits.joints().jerk()[k], b, self.gap);
                if !jumped {
                    each[k].see(b.jerk[k], b);
                }
            }
        }
        if let Some(worst) = &mut self.tangential_jerk {
            worst.see((now.tangential - before.tangential) / dt, b);
        }
        match self.r.jerk_limited {
            true => self.continuous_acceleration(a, b, dt, if jumped { self.r.period } else { 0.0 }),
            false => self.continuous_velocity(a, b, dt),
        }
    }

    /// A motion with jerk below J satisfies `|q1 - q0 - dt (v0 + v1) / 2| <= J dt^3 / 12` and
    /// `|v1 - v0 - dt (a0 + a1) / 2| <= J dt^2 / 4`; an acceleration step within a period adds J period to that.
    fn continuous_acceleration(&mut self, a: &Setpoint<N>, b: &Setpoint<N>, dt: f64, step: f64) {
        let mut rounded: Option<Joints<N>> = None;
        let path = self.r.path;
        for k in 0..N {
            let limit = self.r.limits.joints().jerk()[k];
            let q = (b.q[k] - a.q[k] - 0.5 * dt * (a.qd[k] + b.qd[k])).abs();
            let v = b.qd[k] - a.qd[k] - 0.5 * dt * (a.qdd[k] + b.qdd[k]);
            let allowed_q = limit * (dt / 12.0 + step / 8.0) * dt * dt;
            // What rounding adds is dear to know: it is asked for where it decides.
            let worse = q > allowed_q * self.continuity[k].ratio().max(1.0);
            let decides = worse && q < allowed_q + MOST_ROUNDING;
            let rounding = || path.rounding(&a.q) + path.rounding(&b.q);
            let ratio_q = match decides {
                true => q / (allowed_q + rounded.get_or_insert_with(rounding)[k]),
                false => q / allowed_q,
            };
            // Rounding of v, which is a sum of terms larger than itself.
            let noise_v = 1e-12 + SPEED * b.qd[k].abs();
            let ratio_v = v.abs() / (limit * (dt / 4.0 + step / 2.0) * dt + noise_v);
            self.continuity[k].see(ratio_q.max(ratio_v), b);
        }
    }

    /// A motion with acceleration below A satisfies `|q1 - q0 - dt (v0 + v1) / 2| <= A dt^2 / 4` and `|v1 - v0| <= A dt`.
    fn continuous_velocity(&mut self, a: &Setpoint<N>, b: &Setpoint<N>, dt: f64) {
        let path = self.r.path;
        let mut rounded: Option<Joints<N>> = None;
        for k in 0..N {
            let limit = self.r.limits.joints().acceleration()[k];
            let q = (b.q[k] - a.q[k] - 0.5 * dt * (a.qd[k] + b.qd[k])).abs();
            let allowed_q = 0.25 * limit * dt * dt;
            let rounding = || path.rounding(&a.q) + path.rounding(&b.q);
            let ratio_q = match q > allowed_q && q < allowed_q + MOST_ROUNDING {
                true => q / (allowed_q + rounded.get_or_insert_with(rounding)[k]),
                false => q / allowed_q,
            };
            let noise_v = 1e-12 + SPEED * b.qd[k].abs();
            let ratio_v = (b.qd[k] - a.qd[k]).abs() / (limit * dt + noise_v);
            let stated = (b.qd[k] - a.qd[k] - 0.5 * dt * (a.qdd[k] + b.qdd[k])).abs() / (2.0 * limit * dt + noise_v);
            self.continuity[k].see(ratio_q.max(ratio_v).max(stated), b);
        }
    }

    /// The samples of one control cycle against the straight line between its first and last.
    pub fn chord(&mut self, cycle: &[Sample<N>]) {
        let Some(worst) = &mut self.chord else { return };
        let (Some(first), Some(last)) = (cycle.first(), cycle.last()) else { return };
        let along = last.position - first.position;
        let length2 = along.norm_squared();
        for sample in cycle {
            let d = sample.position - first.position;
            let f = if length2 > 0.0 { (d.dot(&along) / length2).max(0.0).min(1.0) } else { 0.0 };
            worst.see((d - along * f).norm(), &sample.at);
        }
    }

    pub fn finish(self, samples: usize) -> Verification {
        let joints = [Some(self.position), Some(self.velocity), Some(self.acceleration), self.jerk, self.torque];
        let tool = [
            self.feed,
            self.tangential,
            self.tangential_jerk,
            self.normal,
            self.normal_jerk,
            self.angular,
            self.chord,
            self.off_path,
            self.turned,
        ];
        let rest = [self.off_joints, Some(self.continuity)];
        let all: Vec<Worst> = joints
            .into_iter()
            .flatten()
            .flatten()
            .chain(tool.into_iter().flatten())
            .chain(rest.into_iter().flatten().flatten())
            .chain([self.ends, self.agreement])
            .collect();
        Verification {
            // An infinite limit is none.
            checks: all.iter().map(Worst::check).filter(|check| check.limit != f64::INFINITY).collect(),
            bindings: all.into_iter().filter_map(Worst::binding).collect(),
            samples,
        }
    }
}

/// Joint velocities that have the direction of the path and no size.
fn creeping<const N: usize>(r: &Requirement<'_, N>, at: &Setpoint<N>) -> Joints<N> {
    r.path.jet(at.s, &at.q).map_or(at.qd, |jet| jet.d1 * f64::MIN_POSITIVE.sqrt())
}

/// What a setpoint says of the tool against what its joints do, relative.
fn misfit<const N: usize>(r: &Requirement<'_, N>, sample: &Sample<N>) -> f64 {
    let at = &sample.at;
    let pose = sample.misstated / ORIENTATION_TOLERANCE * ZERO;
    let [fast, strong] = r.scales();
    match r.path.parameter() {
        PathParameter::ArcLength => {
            let speed = sample.velocity.norm();
            pose + (at.feed - speed).abs() / r.feed_at(at.s).min(fast)
                + (at.acceleration - sample.tangential).abs() / strong
        }
        PathParameter::RotationAngle => pose + (at.feed - sample.turning).abs() / r.limits.joints().velocity().min(),
        // The parameter is no measure of the tool.
        PathParameter::JointDistance => pose + 0.0 * (at.feed + at.acceleration),
    }
}

/// Where the curvature or the turning of a path of the tool jumps.
fn jumps<const N: usize>(path: &dyn MotionPath<N>) -> Vec<f64> {
    let Some(curve) = path.tool_curve() else { return Vec::new() };
    let jumps = |s: f64| {
        let (a, b) = (curve.jet_left(s), curve.jet(s));
        (a.d2 - b.d2).norm() > 1e-7 * (1.0 + a.d2.norm())
    };
    curve.knots().into_iter().filter(|s| jumps(*s)).collect()
}
