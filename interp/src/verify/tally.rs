//! Every limit of a motion with its worst place so far.

use arcfeed_feedrate::{LimitId, Quantity};
use arcfeed_kinematics::Joints;
use nalgebra::Vector3;

use super::check::Verification;
use super::joints::{EachJoint, JointRates, JointSample, JointTally, each};
use super::requirement::Requirement;
use super::sample::Sample;
use super::tables::{ACCELERATION, JERK, TORQUE, limit, limit_of_mean};
use super::worst::{Worst, sum_up};
use crate::path::MotionPath;
use crate::place::PathParameter;
use crate::setpoint::Setpoint;

/// Largest angle between the tool and the orientation of the path, rad. Exact inverses stay below 1e-9; the step of any
/// encoder is larger.
const ORIENTATION_TOLERANCE: f64 = 1e-6;
/// Largest distance of a joint from a path of the joints, rad.
const JOINT_TOLERANCE: f64 = 1e-9;
/// The value that counts as zero, relative to a limit or to the length of the path: speed at the ends, and the difference between
/// what a setpoint says of the tool and what its joints do.
const ZERO: f64 = 1e-6;
/// Rounding of a joint velocity, absolute and relative: it is a sum of terms larger than itself, and where a motion ends at
/// a speed, its law and that speed need not agree in every digit.
const SPEED: [f64; 2] = [1e-12, 1e-10];
/// Rounding of an acceleration of the tool, m/s^2.
const ROUNDING: f64 = 1e-11;
/// Intervals of the path's length over which a limit may be let go without that being a gap.
const GAP: f64 = 3e-3;

/// Named by what they are on; `None` is not limited.
pub(crate) struct Tally<'a, const N: usize> {
    r: Requirement<'a, N>,
    rates: JointRates<N>,
    /// Places where the acceleration of the joints jumps because the path's curvature does.
    jumps: Vec<f64>,
    gap: f64,
    joints: JointTally<N>,
    torque: Option<EachJoint>,
    feed: Option<Worst>,
    tangential: Option<Worst>,
    tangential_jerk: Option<Worst>,
    normal: Option<Worst>,
    normal_jerk: Option<Worst>,
    angular: Option<Worst>,
    acceleration: Option<Worst>,
    jerk: Option<Worst>,
    chord: Option<Worst>,
    off_path: Option<Worst>,
    turned: Option<Worst>,
    off_joints: Option<EachJoint>,
    ends: Worst,
    agreement: Worst,
}

impl<'a, const N: usize> Tally<'a, N> {
    pub fn new(r: &Requirement<'a, N>) -> Self {
        let (joints, tool, path) = (r.limits.joints(), r.limits.tool(), r.path);
        let jerk = if r.jerk_limited { *joints.jerk() } else { Joints::repeat(f64::INFINITY) };
        let rates = JointRates { jerk, ..JointRates::from(joints) };
        let one = |quantity, limit| Worst::new(LimitId::path(quantity), limit);
        let by_length = path.parameter() == PathParameter::ArcLength;
        let along = |quantity, limit: Option<f64>| limit.filter(|_| by_length).map(|limit| one(quantity, limit));
        let prescribed = path.tool(0.0).is_some();
        let feed = tool.feed().or(r.sections.first().map(|section| section.feed));
        Self {
            r: *r,
            rates,
            jumps: jumps(path),
            gap: GAP * path.length(),
            joints: JointTally::new(joints.range(), &rates, r.jerk_limited),
            torque: r.limits.torque().map(|torque| each::<N>(Quantity::JointTorque, torque.limits())),
            feed: feed.map(|limit| one(Quantity::Feed, limit)),
            tangential: along(Quantity::TangentialAcceleration, tool.tangential_acceleration()),
            tangential_jerk: along(Quantity::TangentialJerk, tool.tangential_jerk().filter(|_| r.jerk_limited)),
            normal: along(Quantity::NormalAcceleration, tool.normal_acceleration()),
            normal_jerk: along(Quantity::NormalJerk, tool.normal_jerk()),
            angular: tool.angular_speed().map(|limit| one(Quantity::AngularSpeed, limit)),
            acceleration: tool.acceleration().map(|limit| one(Quantity::ToolAcceleration, limit)),
            jerk: tool.jerk().filter(|_| r.jerk_limited).map(|limit| one(Quantity::ToolJerk, limit)),
            chord: path.tool_curve().map(|_| one(Quantity::ChordError, r.chord_tolerance)),
            off_path: prescribed.then(|| one(Quantity::PathDeviation, r.path_tolerance)),
            turned: prescribed.then(|| one(Quantity::OrientationDeviation, ORIENTATION_TOLERANCE)),
            off_joints: (!prescribed).then(|| each::<N>(Quantity::PathDeviation, &Joints::repeat(JOINT_TOLERANCE))),
            ends: one(Quantity::Ends, 1.0),
            agreement: one(Quantity::SetpointAgreement, 1.0),
        }
    }

    /// Limits of the joints at one moment.
    pub fn look_at_joints(&mut self, sample: &Sample<N>) {
        let (at, gap, r, tables) = (&sample.at, self.gap, &self.r, self.r.limits.tables());
        self.joints.see_position(&at.q, at.into());
        for k in 0..N {
            self.joints.velocity[k].see_binding(at.qd[k], self.rates.velocity[k], at, gap);
            let most = limit(self.rates.acceleration[k], tables, &ACCELERATION, k, (&at.q, &at.qd));
            self.joints.acceleration[k].see_binding(at.qdd[k], most, at, gap);
        }
        if let Some((each, limits)) = self.torque.as_mut().zip(r.limits.torque()) {
            // At rest friction has the direction of the motion that follows; at the end, of that which was.
            let qd = if at.qd.amax() == 0.0 { creeping(r, at) } else { at.qd };
            let torque = limits.torque(&at.q, &qd, &at.qdd);
            for k in 0..N {
                let most = limit(limits.limits()[k], tables, &TORQUE, k, (&at.q, &at.qd));
                each[k].see_binding(torque[k], most, at, gap);
            }
        }
    }

    /// Limits of joints and tool at one moment.
    pub fn look(&mut self, sample: &Sample<N>) {
        self.look_at_joints(sample);
        let (at, gap, r) = (&sample.at, self.gap, &self.r);
        let speed = sample.velocity.norm();
        if let Some(feed) = &mut self.feed {
            feed.see_binding(speed, r.feed_at(at.s), at, gap);
        }
        let tool = r.limits.tool();
        for (worst, value, limit) in [
            (&mut self.tangential, sample.tangential, tool.tangential_acceleration()),
            (&mut self.normal, sample.normal, tool.normal_acceleration()),
            (&mut self.angular, sample.turning, tool.angular_speed()),
            (&mut self.acceleration, sample.acceleration.norm(), tool.acceleration()),
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
        self.agreement.see(misfit(r, sample) / ZERO, at);
    }

    /// By how much of a control period the time of a sample is off.
    pub fn look_at_clock(&mut self, off: f64, sample: &Sample<N>) {
        self.agreement.see(off / ZERO, &sample.at);
    }

    /// The jerk that a setpoint states at a knot of the law, between the regular samples. Along a curve of the tool the third derivatives
    /// of the joints have peaks that last for less than the time between two samples: there its mean over that time counts.
    pub fn look_at_jerk(&mut self, at: &Setpoint<N>) {
        if self.r.path.tool_curve().is_some() {
            return;
        }
        if let Some(each) = &mut self.joints.jerk {
            for (k, (worst, jerk)) in each.iter_mut().zip(at.jerk.iter()).enumerate() {
                let tables = self.r.limits.tables();
                let most = limit(self.rates.jerk[k], tables, &JERK, k, (&at.q, &at.qd));
                worst.see_against(*jerk, most, at);
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
    ///
    /// The last two are `dt` apart, s.
    pub fn compare(&mut self, samples: [&Sample<N>; 3], dt: f64) {
        self.compare_joints(samples, dt, true);
        let [first, before, now] = samples;
        if let Some(worst) = self.jerk.as_mut().filter(|_| dt > 0.0) {
            // As for the joints: where the curvature jumps, the step counts as spread over a control period.
            let crosses = |from: &Sample<N>| self.jumps.iter().any(|s| (from.at.s..=now.at.s).contains(s));
            let over = |from: &Sample<N>, time: f64| {
                ((now.acceleration - from.acceleration).norm() - ROUNDING).max(0.0) / time
            };
            let jerk = if crosses(before) { over(first, self.r.period) } else { over(before, dt) };
            worst.see_binding(jerk, worst.check().limit, &now.at, self.gap);
        }
        if let Some(worst) = self.tangential_jerk.as_mut().filter(|_| dt > 0.0) {
            // Accelerations that differ by rounding alone are no jerk.
            let change = now.tangential - before.tangential;
            worst.see(change.signum() * (change.abs() - ROUNDING).max(0.0) / dt, &now.at);
        }
    }

    /// The same, for the joints alone; `on_path` tells whether they follow the path all the time.
    pub fn compare_joints(&mut self, [first, before, now]: [&Sample<N>; 3], dt: f64, on_path: bool) {
        let (a, b) = (&before.at, &now.at);
        if dt <= 0.0 {
            return;
        }
        let crosses = |a: f64, b: f64| on_path && self.jumps.iter().any(|&s| a.min(b) <= s && s <= a.max(b));
        // Where the curvature itself jumps, acceleration has to step; a controller sees it spread over its period, whenever that begins.
        let jumped = crosses(first.at.s, b.s);
        let tables = self.r.limits.tables();
        if let Some(each) = &mut self.joints.jerk {
            let spread = (b.qdd - first.at.qdd) / self.r.period;
            let jerk = if crosses(a.s, b.s) { spread } else { (b.qdd - a.qdd) / dt };
            for k in 0..N {
                let from = if jumped { first } else { before };
                let states = [&from.at, b].map(|at| (&at.q, &at.qd));
                let most = limit_of_mean(self.rates.jerk[k], tables, &JERK, k, states);
                each[k].see_binding(jerk[k], most, b, self.gap);
                let here = limit(self.rates.jerk[k], tables, &JERK, k, (&b.q, &b.qd));
                let (value, most) = if jumped { (spread[k], most) } else { (b.jerk[k], here) };
                each[k].see_against(value, most, b);
            }
        }
        let step = if jumped { self.r.period } else { 0.0 };
        let path = self.r.path;
        let rounding = || path.rounding(a.s, &a.q) + path.rounding(b.s, &b.q);
        let of_speed = |k: usize| SPEED[0] + SPEED[1] * b.qd[k].abs();
        let samples = [a, b].map(|at| JointSample { t: at.t, q: at.q, qd: at.qd, qdd: at.qdd });
        self.joints.see_step([&samples[0], &samples[1]], (dt, step), &self.rates, (rounding, of_speed), b.into());
    }

    /// One place of the path, reached within a control cycle, against the straight line between the cycle's samples.
    pub fn chord_at(&mut self, place: Vector3<f64>, [first, last]: [&Sample<N>; 2]) {
        if let Some(worst) = &mut self.chord {
            worst.see(off_line(place, [first.position, last.position]), &last.at);
        }
    }

    /// The samples of one control cycle against the straight line between its first and last.
    pub fn chord(&mut self, cycle: &[Sample<N>]) {
        let Some(worst) = &mut self.chord else { return };
        let (Some(first), Some(last)) = (cycle.first(), cycle.last()) else { return };
        for sample in cycle {
            worst.see(off_line(sample.position, [first.position, last.position]), &sample.at);
        }
    }

    pub fn finish(self, samples: usize) -> Verification {
        let tool = [
            self.feed,
            self.tangential,
            self.tangential_jerk,
            self.normal,
            self.normal_jerk,
            self.angular,
            self.acceleration,
            self.jerk,
            self.chord,
            self.off_path,
            self.turned,
        ];
        let (limits, continuity) = self.joints.into_parts();
        let joints = limits.chain(self.torque.into_iter().flatten());
        let rest = self.off_joints.into_iter().flatten().chain(continuity).chain([self.ends, self.agreement]);
        sum_up(joints.chain(tool.into_iter().flatten()).chain(rest), samples)
    }
}

/// Distance of a point from the straight line between two others.
fn off_line(point: Vector3<f64>, [first, last]: [Vector3<f64>; 2]) -> f64 {
    let (along, d) = (last - first, point - first);
    let length2 = along.norm_squared();
    let f = if length2 > 0.0 { (d.dot(&along) / length2).max(0.0).min(1.0) } else { 0.0 };
    (d - along * f).norm()
}

/// Joint velocities that have the direction of the path and no size.
fn creeping<const N: usize>(r: &Requirement<'_, N>, at: &Setpoint<N>) -> Joints<N> {
    r.path.jet(at.s, &at.q).map_or(at.qd, |jet| jet.d1 * f64::MIN_POSITIVE.sqrt())
}

/// The difference between the tool motion that a setpoint states and that of its joints, relative.
fn misfit<const N: usize>(r: &Requirement<'_, N>, sample: &Sample<N>) -> f64 {
    let at = &sample.at;
    let pose = sample.misstated / ORIENTATION_TOLERANCE * ZERO;
    let [fast, strong] = r.scales();
    match r.path.parameter() {
        PathParameter::ArcLength => {
            let speed = sample.velocity.norm();
            // A tool that steps back moves against the direction of the path.
            let along = if at.feed < 0.0 && sample.moves { -sample.tangential } else { sample.tangential };
            pose + (at.feed.abs() - speed).abs() / r.feed_at(at.s).min(fast) + (at.acceleration - along).abs() / strong
        }
        PathParameter::RotationAngle => pose + (at.feed - sample.turning).abs() / r.limits.joints().velocity().min(),
        // The parameter is no measure of the tool.
        PathParameter::JointDistance => pose + 0.0 * (at.feed + at.acceleration),
    }
}

/// The places where the curvature or the turning of a path of the tool jumps.
fn jumps<const N: usize>(path: &dyn MotionPath<N>) -> Vec<f64> {
    let Some(curve) = path.tool_curve() else { return Vec::new() };
    let jumps = |s: f64| {
        let (a, b) = (curve.jet_left(s), curve.jet(s));
        (a.d2 - b.d2).norm() > 1e-7 * (1.0 + a.d2.norm())
    };
    curve.knots().into_iter().filter(|s| jumps(*s)).collect()
}
