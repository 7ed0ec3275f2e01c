//! Limits of the joints and the continuity of their motion.

use arcfeed_feedrate::{LimitId, Quantity};
use arcfeed_kinematics::{JointLimits, JointRange, Joints};

use super::worst::{Moment, Worst};

/// Rounding moves a joint by less than this between two samples, rad (m): at the least singular
/// value that a plan comes to, an arm of 20 m is off by less.
const MOST_ROUNDING: f64 = 1e-9;

/// The limits of each joint.
pub(super) type EachJoint = Vec<Worst>;

/// One check for each joint, with its limit.
pub(super) fn each<const N: usize>(quantity: Quantity, limits: &Joints<N>) -> EachJoint {
    (0..N).map(|joint| Worst::new(LimitId::joint(quantity, joint), limits[joint])).collect()
}

/// Largest velocity, acceleration and jerk of the joints, for both signs; SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRates<const N: usize> {
    /// Velocity, rad/s.
    pub velocity: Joints<N>,
    /// Acceleration, rad/s^2.
    pub acceleration: Joints<N>,
    /// Jerk, rad/s^3; infinite where it is not limited.
    pub jerk: Joints<N>,
}

impl<const N: usize> From<&JointLimits<N>> for JointRates<N> {
    fn from(limits: &JointLimits<N>) -> Self {
        Self { velocity: *limits.velocity(), acceleration: *limits.acceleration(), jerk: *limits.jerk() }
    }
}

/// Position, velocity and acceleration of the joints at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSample<const N: usize> {
    /// Time, s.
    pub t: f64,
    /// Positions, rad.
    pub q: Joints<N>,
    /// Velocities, rad/s.
    pub qd: Joints<N>,
    /// Accelerations, rad/s^2.
    pub qdd: Joints<N>,
}

/// The worst places of all joints.
#[derive(Debug, Clone)]
pub(super) struct JointTally<const N: usize> {
    middle: Joints<N>,
    pub position: EachJoint,
    pub velocity: EachJoint,
    pub acceleration: EachJoint,
    pub jerk: Option<EachJoint>,
    pub continuity: EachJoint,
}

impl<const N: usize> JointTally<N> {
    pub fn new(range: &JointRange<N>, rates: &JointRates<N>, jerk_limited: bool) -> Self {
        Self {
            middle: (range.lower() + range.upper()) / 2.0,
            position: each::<N>(Quantity::JointPosition, &((range.upper() - range.lower()) / 2.0)),
            velocity: each::<N>(Quantity::JointVelocity, &rates.velocity),
            acceleration: each::<N>(Quantity::JointAcceleration, &rates.acceleration),
            jerk: jerk_limited.then(|| each(Quantity::JointJerk, &rates.jerk)),
            continuity: each::<N>(Quantity::Continuity, &Joints::repeat(1.0)),
        }
    }

    /// Positions against the ranges.
    pub fn see_position(&mut self, q: &Joints<N>, at: Moment) {
        for k in 0..N {
            self.position[k].see(q[k] - self.middle[k], at);
        }
    }

    /// The motion from sample `a` to sample `b`, `dt` (s) later.
    ///
    /// A motion with jerk below J satisfies `|q1 - q0 - dt (v0 + v1) / 2| <= J dt^3 / 12` and
    /// `|v1 - v0 - dt (a0 + a1) / 2| <= J dt^2 / 4`; one with acceleration below A satisfies
    /// `|q1 - q0 - dt (v0 + v1) / 2| <= A dt^2 / 4` and `|v1 - v0| <= A dt`. Where the acceleration may
    /// step within a time `step` (s), the step counts as a jerk J over it. `rounding` gives what
    /// rounding adds to a difference of positions; it is asked for where it decides. `of_speed`
    /// gives what it adds to a difference of velocities of a joint.
    pub fn see_step(
        &mut self,
        [a, b]: [&JointSample<N>; 2],
        (dt, step): (f64, f64),
        rates: &JointRates<N>,
        (rounding, of_speed): (impl Fn() -> Joints<N>, impl Fn(usize) -> f64),
        at: Moment,
    ) {
        let mut rounded: Option<Joints<N>> = None;
        for k in 0..N {
            let (acceleration, jerk) = (rates.acceleration[k], rates.jerk[k]);
            let q = (b.q[k] - a.q[k] - 0.5 * dt * (a.qd[k] + b.qd[k])).abs();
            let v = (b.qd[k] - a.qd[k] - 0.5 * dt * (a.qdd[k] + b.qdd[k])).abs();
            let allowed_q = (jerk * (dt / 12.0 + step / 8.0)).min(0.25 * acceleration) * dt * dt;
            let worse = q > allowed_q * self.continuity[k].ratio().max(1.0);
            let ratio_q = match worse && q < allowed_q + MOST_ROUNDING {
                true => q / (allowed_q + rounded.get_or_insert_with(&rounding)[k]),
                false => q / allowed_q,
            };
            let noise_v = of_speed(k);
            let ratio_v = v / ((jerk * (dt / 4.0 + step / 2.0)).min(2.0 * acceleration) * dt + noise_v);
            // One by one, so that a NaN of either stays.
            self.continuity[k].see(ratio_q, at);
            self.continuity[k].see(ratio_v, at);
            if jerk == f64::INFINITY {
                let change = (b.qd[k] - a.qd[k]).abs();
                self.continuity[k].see(change / (acceleration * dt + noise_v), at);
            }
        }
    }

    /// The limits of position, velocity, acceleration and jerk; and continuity.
    pub fn into_parts(self) -> (impl Iterator<Item = Worst>, EachJoint) {
        let limits = [Some(self.position), Some(self.velocity), Some(self.acceleration), self.jerk];
        (limits.into_iter().flatten().flatten(), self.continuity)
    }
}
