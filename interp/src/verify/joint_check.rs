//! The check of a joint motion that is recorded sample by sample, under limits that may change.

use arcfeed_feedrate::{AxisState, Quantity};
use arcfeed_kinematics::{JointRange, Joints};

use super::check::Verification;
use super::joints::{EachJoint, JointRates, JointSample, JointTally, each};
use super::worst::{Moment, sum_up};

/// A state at an end of the motion may miss the one asked for by this much, rad.
const END_POSITION: f64 = 1e-9;
/// And by this much of the limit on velocity and on acceleration.
const END_RATE: f64 = 1e-6;

/// What is asked of both ends.
const ENDS: [Quantity; 3] = [Quantity::EndPosition, Quantity::EndVelocity, Quantity::EndAcceleration];

/// Holds a recorded joint motion against the limits, without the help of whatever made it.
///
/// Every sample is held against the limits on position, velocity and acceleration, and against the
/// sample before it: the mean velocity and acceleration between the two, jerk as the difference of
/// accelerations over the time between them (the mean of the true jerk, which never exceeds its
/// maximum), and continuity. A jump cannot hide between two samples.
///
/// Limits may change from sample to sample. Where they are set below the state of a joint, the joint
/// has the time that braking takes to come back inside, and no more velocity or acceleration
/// meanwhile than its state at the change leads to.
///
/// ```
/// use arcfeed_interp::{JointCheck, JointRates, JointSample, Quantity};
/// use arcfeed_kinematics::{JointRange, Joints};
///
/// let range = JointRange::new(Joints::from([-1.0]), Joints::from([1.0]))?;
/// let rates = JointRates { velocity: [1.0].into(), acceleration: [5.0].into(), jerk: [50.0].into() };
/// let mut check = JointCheck::new(&range);
/// for (t, q) in [(0.0, 0.0), (1e-3, 0.1)] {
///     // A jump: the joint moves while its velocity says that it stands.
///     let sample = JointSample { t, q: [q].into(), qd: [0.0].into(), qdd: [0.0].into() };
///     check.see(&sample, 1e-3, &rates);
/// }
/// assert_eq!(check.finish().worst().id.quantity, Quantity::Continuity);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone)]
pub struct JointCheck<const N: usize> {
    tally: JointTally<N>,
    ends: [EachJoint; 3],
    before: Option<(JointSample<N>, JointRates<N>)>,
    excesses: [Excess; N],
    samples: usize,
}

impl<const N: usize> JointCheck<N> {
    /// A check of nothing yet, for joints inside `range`.
    pub fn new(range: &JointRange<N>) -> Self {
        let none = Joints::repeat(f64::INFINITY);
        let rates = JointRates { velocity: none, acceleration: none, jerk: none };
        Self {
            tally: JointTally::new(range, &rates, true),
            ends: ENDS.map(|quantity| each::<N>(quantity, &none)),
            before: None,
            excesses: [Excess::default(); N],
            samples: 0,
        }
    }

    /// The next sample, `dt` (s) after the one before; `rates` are in force from it on.
    ///
    /// `dt` is given because differences of the samples' times lose digits as these grow.
    pub fn see(&mut self, sample: &JointSample<N>, dt: f64, rates: &JointRates<N>) {
        self.samples += 1;
        self.tally.see_position(&sample.q, Moment::at_time(sample.t));
        match self.before {
            Some((before, during)) if dt > 0.0 => self.compare(&before, sample, dt, &during),
            Some(_) => {}
            None => {
                self.change(sample, rates);
                self.look(sample, rates);
            }
        }
        if self.before.is_some_and(|(_, during)| during != *rates) {
            self.change(sample, rates);
        }
        self.before = Some((*sample, *rates));
    }

    /// Holds the state of each joint at one end of the motion, at the time `t` (s), against the one
    /// asked for, in the rates of the last sample seen.
    pub fn see_end(&mut self, t: f64, states: &[AxisState; N], wanted: &[AxisState; N]) {
        let (velocity, acceleration) =
            self.before.map_or((Joints::zeros(), Joints::zeros()), |(_, r)| (r.velocity, r.acceleration));
        for (k, (s, w)) in states.iter().zip(wanted).enumerate() {
            let misses = [
                (s.p - w.p, END_POSITION.max(4.0 * f64::EPSILON * w.p.abs())),
                (s.v - w.v, END_RATE * velocity[k]),
                (s.a - w.a, END_RATE * acceleration[k]),
            ];
            for (each, (miss, zero)) in self.ends.iter_mut().zip(misses) {
                each[k].see_against(miss, zero, Moment::at_time(t));
            }
        }
    }

    /// For every limit the place where the motion comes closest to it.
    pub fn finish(self) -> Verification {
        // Of the joints the one that misses its state most.
        let ends = self.ends.into_iter().filter_map(|each| {
            each.into_iter().reduce(|m, w| if w.ratio() > m.ratio() || w.ratio().is_nan() { w } else { m })
        });
        let (limits, continuity) = self.tally.into_parts();
        sum_up(limits.chain(continuity).chain(ends), self.samples)
    }

    /// Checks the motion of the joints at `now`, and from `before` to it, under the rates `during` that time.
    fn compare(&mut self, before: &JointSample<N>, now: &JointSample<N>, dt: f64, during: &JointRates<N>) {
        let at = Moment::at_time(now.t);
        // The resolution of the time at which a sample is taken, and of its values.
        let clock = 2.0 * f64::EPSILON * now.t;
        // The times of the samples are `dt` apart, too.
        let off = (now.t - before.t - dt) / (END_RATE * dt + 2.0 * clock);
        let size = |a: &Joints<N>, b: &Joints<N>, k: usize| a[k].abs() + b[k].abs();
        let noise_q = |k: usize| 1e-14 * (1.0 + size(&before.q, &now.q, k)) + clock * size(&before.qd, &now.qd, k);
        let noise_v = |k: usize| 1e-14 * (1.0 + size(&before.qd, &now.qd, k)) + clock * size(&before.qdd, &now.qdd, k);
        let beyond = |value: f64, noise: f64| value.signum() * (value.abs() - noise).max(0.0) / dt;
        let mut rates = *during;
        for k in 0..N {
            let [velocity, acceleration] =
                self.excesses[k].limits(before.t, during.velocity[k], during.acceleration[k]);
            rates.acceleration[k] = acceleration;
            self.tally.continuity[k].see(off, at);
            let tally = &mut self.tally;
            tally.velocity[k].see_against(now.qd[k], velocity, at);
            tally.velocity[k].see_against(beyond(now.q[k] - before.q[k], noise_q(k)), velocity, at);
            tally.acceleration[k].see_against(now.qdd[k], acceleration, at);
            tally.acceleration[k].see_against(beyond(now.qd[k] - before.qd[k], noise_v(k)), acceleration, at);
            if let Some(jerk) = &mut tally.jerk {
                let noise = 4.0 * f64::EPSILON * size(&before.qdd, &now.qdd, k);
                jerk[k].see_against(beyond(now.qdd[k] - before.qdd[k], noise), during.jerk[k], at);
            }
        }
        let rounding = || Joints::from_fn(|k, _| noise_q(k));
        self.tally.see_step([before, now], (dt, 0.0), &rates, (rounding, noise_v), at);
    }

    /// Velocity and acceleration of the first sample.
    fn look(&mut self, sample: &JointSample<N>, rates: &JointRates<N>) {
        let at = Moment::at_time(sample.t);
        for k in 0..N {
            let [velocity, acceleration] = self.excesses[k].limits(sample.t, rates.velocity[k], rates.acceleration[k]);
            self.tally.velocity[k].see_against(sample.qd[k], velocity, at);
            self.tally.acceleration[k].see_against(sample.qdd[k], acceleration, at);
            if let Some(jerk) = &mut self.tally.jerk {
                jerk[k].see_against(0.0, rates.jerk[k], at);
            }
        }
    }

    /// New limits are in force from `sample` on.
    fn change(&mut self, sample: &JointSample<N>, rates: &JointRates<N>) {
        for k in 0..N {
            let limits = [rates.velocity[k], rates.acceleration[k], rates.jerk[k]];
            self.excesses[k] = Excess::new(sample.t, sample.qd[k], sample.qdd[k], limits);
        }
    }
}

/// Excess of one joint over limits that were set below its state, and the time it lasts.
#[derive(Debug, Clone, Copy, Default)]
struct Excess {
    velocity: f64,
    velocity_until: f64,
    acceleration: f64,
    acceleration_until: f64,
}

impl Excess {
    /// For a joint with velocity `v` and acceleration `a` at time `t`.
    fn new(t: f64, v: f64, a: f64, [velocity, acceleration, jerk]: [f64; 3]) -> Self {
        // The velocity at which the acceleration is back at zero.
        let velocity_reached = v.abs().max((v + 0.5 * a * a.abs() / jerk).abs());
        let excess = (velocity_reached - velocity).max(0.0);
        // From rest of the acceleration to rest of the acceleration, over a change of velocity by the excess.
        let ramp = acceleration / jerk;
        let full = excess / acceleration + ramp;
        let brake = if excess >= acceleration * ramp { full } else { 2.0 * (excess / jerk).sqrt() };
        let back = a.abs() / jerk + brake;
        let late = |time: f64| t + time * (1.0 + 1e-9) + 1e-9;
        Self {
            velocity: velocity_reached,
            velocity_until: if excess > 0.0 { late(back) } else { t },
            acceleration: a.abs(),
            acceleration_until: if a.abs() > acceleration { late((a.abs() - acceleration) / jerk) } else { t },
        }
    }

    /// Limits of velocity and acceleration on what follows the time `t`.
    fn limits(&self, t: f64, velocity: f64, acceleration: f64) -> [f64; 2] {
        let while_outside = |limit: f64, value: f64, until: f64| if t < until { limit.max(value) } else { limit };
        [
            while_outside(velocity, self.velocity, self.velocity_until),
            while_outside(acceleration, self.acceleration, self.acceleration_until),
        ]
    }
}
