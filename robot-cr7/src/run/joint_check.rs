//! Holds a sampled joint motion against its limits, row by row, without the help of whatever made it.

use arcfeed_feedrate::AxisState;
use arcfeed_kinematics::JointLimits;

use super::limit_line::{LimitLine, LimitUnit};
use super::trajectory_row::TrajectoryRow;

/// What the joints may do at one moment, for both signs; SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates<const N: usize> {
    /// Velocity, rad/s.
    pub velocity: [f64; N],
    /// Acceleration, rad/s^2.
    pub acceleration: [f64; N],
    /// Jerk, rad/s^3.
    pub jerk: [f64; N],
}

impl<const N: usize> From<&JointLimits<N>> for Rates<N> {
    fn from(limits: &JointLimits<N>) -> Self {
        Self {
            velocity: (*limits.velocity()).into(),
            acceleration: (*limits.acceleration()).into(),
            jerk: (*limits.jerk()).into(),
        }
    }
}

/// A state at an end of the motion may miss the one asked for by this much, rad.
const END_POSITION: f64 = 1e-9;
/// And by this much of the limit on velocity and on acceleration.
const END_RATE: f64 = 1e-6;

/// The check of a sampled motion.
///
/// Every row is held against the limits on velocity and acceleration, and against the row before it: the mean velocity and
/// acceleration between two rows, jerk as the difference of accelerations over the time between them (the mean of the true
/// jerk, which never exceeds its maximum), and continuity. A motion with jerk below J has
/// `|q1 - q0 - dt (v0 + v1) / 2| <= J dt^3 / 12` and `|v1 - v0 - dt (a0 + a1) / 2| <= J dt^2 / 4`, one with acceleration
/// below A `|q1 - q0 - dt (v0 + v1) / 2| <= A dt^2 / 4`: a jump cannot hide between two rows.
///
/// Limits may change from row to row. Where they are set below the state of a joint, the joint has the time that braking
/// takes to come back inside, and no more velocity or acceleration meanwhile than its state at the change leads to.
#[derive(Debug, Clone)]
pub struct JointCheck<const N: usize> {
    lines: Vec<LimitLine>,
    ends: Vec<LimitLine>,
    range: ([f64; N], [f64; N]),
    before: Option<(TrajectoryRow<N>, Rates<N>)>,
    excesses: [Excess; N],
}

/// What is checked of every joint, in the order of the lines.
const KINDS: [(&str, LimitUnit); 5] = [
    ("joint position", LimitUnit::Radian),
    ("joint velocity", LimitUnit::RadianPerSecond),
    ("joint acceleration", LimitUnit::RadianPerSecond2),
    ("joint jerk", LimitUnit::RadianPerSecond3),
    ("continuity", LimitUnit::One),
];
const POSITION: usize = 0;
const VELOCITY: usize = 1;
const ACCELERATION: usize = 2;
const JERK: usize = 3;
const CONTINUITY: usize = 4;

impl<const N: usize> JointCheck<N> {
    /// A check of nothing yet, for joints between `lower` and `upper` (rad).
    pub fn new(lower: [f64; N], upper: [f64; N]) -> Self {
        let line = |(name, unit): (&str, LimitUnit), k: usize| LimitLine {
            name: name.to_owned(),
            joint: Some(k + 1),
            unit,
            value: 0.0,
            limit: 1.0,
            ratio: 0.0,
            at_s_m: None,
            at_t_s: 0.0,
        };
        let lines = KINDS.into_iter().flat_map(|kind| (0..N).map(move |k| line(kind, k))).collect();
        Self { lines, ends: Vec::new(), range: (lower, upper), before: None, excesses: [Excess::default(); N] }
    }

    /// The next row, `dt` (s) after the one before; `rates` are in force from it on.
    ///
    /// `dt` is given because differences of the rows' times lose digits as these grow.
    pub fn see(&mut self, row: &TrajectoryRow<N>, dt: f64, rates: &Rates<N>) {
        for k in 0..N {
            let middle = 0.5 * (self.range.0[k] + self.range.1[k]);
            self.worse(POSITION, k, row.q[k] - middle, self.range.1[k] - middle, row.t);
        }
        match self.before {
            Some((before, during)) if dt > 0.0 => self.compare(&before, row, dt, &during),
            Some(_) => {}
            None => self.change(row, rates),
        }
        if self.before.is_some_and(|(_, during)| during != *rates) {
            self.change(row, rates);
        }
        self.before = Some((*row, *rates));
    }

    /// Holds the state of each joint at one end of the motion against the one asked for, in the rates of the last row seen.
    pub fn see_end(&mut self, end: &str, t: f64, states: &[AxisState; N], wanted: &[AxisState; N]) {
        let rates = self.before.map(|(_, rates)| rates);
        let (velocity, acceleration) = rates.map_or(([0.0; N], [0.0; N]), |r| (r.velocity, r.acceleration));
        let mut worst: Option<LimitLine> = None;
        for (k, (s, w)) in states.iter().zip(wanted).enumerate() {
            for (unit, value, limit) in [
                (LimitUnit::Radian, s.p - w.p, END_POSITION.max(4.0 * f64::EPSILON * w.p.abs())),
                (LimitUnit::RadianPerSecond, s.v - w.v, END_RATE * velocity[k]),
                (LimitUnit::RadianPerSecond2, s.a - w.a, END_RATE * acceleration[k]),
            ] {
                let ratio = if value == 0.0 { 0.0 } else { value.abs() / limit };
                let (name, joint) = (format!("state at the {end}"), Some(k + 1));
                let line = LimitLine { name, joint, unit, value, limit, ratio, at_s_m: None, at_t_s: t };
                // A NaN, once seen, stays.
                if worst.as_ref().is_none_or(|w| !w.ratio.is_nan() && (ratio > w.ratio || ratio.is_nan())) {
                    worst = Some(line);
                }
            }
        }
        self.ends.extend(worst);
    }

    /// Every limit with its worst place, those that are infinite left out.
    pub fn into_lines(self) -> Vec<LimitLine> {
        self.lines.into_iter().filter(|line| !line.limit.is_infinite()).chain(self.ends).collect()
    }

    fn worse(&mut self, kind: usize, k: usize, value: f64, limit: f64, t: f64) {
        let line = &mut self.lines[kind * N + k];
        let ratio = value.abs() / limit;
        // A NaN, once seen, stays.
        if !line.ratio.is_nan() && (ratio >= line.ratio || ratio.is_nan()) {
            (line.value, line.limit, line.ratio, line.at_t_s) = (value, limit, ratio, t);
        }
    }

    /// What the joints do at `row`, and from `before` to it, under the rates `during` that time.
    fn compare(&mut self, before: &TrajectoryRow<N>, row: &TrajectoryRow<N>, dt: f64, during: &Rates<N>) {
        for k in 0..N {
            let (q, v, a) = ([before.q[k], row.q[k]], [before.qd[k], row.qd[k]], [before.qdd[k], row.qdd[k]]);
            let size = |pair: [f64; 2]| pair[0].abs() + pair[1].abs();
            // The resolution of the time at which a row is taken, and of its values.
            let clock = 2.0 * f64::EPSILON * row.t;
            let noise_q = 1e-14 * (1.0 + size(q)) + clock * size(v);
            let noise_v = 1e-14 * (1.0 + size(v)) + clock * size(a);
            let beyond = |value: f64, noise: f64| value.signum() * (value.abs() - noise).max(0.0);
            let [velocity, acceleration] =
                self.excesses[k].limits(before.t, during.velocity[k], during.acceleration[k]);
            let jerk = during.jerk[k];
            self.worse(VELOCITY, k, v[1], velocity, row.t);
            self.worse(VELOCITY, k, beyond(q[1] - q[0], noise_q) / dt, velocity, row.t);
            self.worse(ACCELERATION, k, a[1], acceleration, row.t);
            self.worse(ACCELERATION, k, beyond(v[1] - v[0], noise_v) / dt, acceleration, row.t);
            self.worse(JERK, k, beyond(a[1] - a[0], 4.0 * f64::EPSILON * size(a)) / dt, jerk, row.t);
            let misfit_q = (q[1] - q[0] - 0.5 * dt * (v[0] + v[1])).abs();
            let misfit_v = (v[1] - v[0] - 0.5 * dt * (a[0] + a[1])).abs();
            let allowed_q = (jerk * dt * dt * dt / 12.0).min(acceleration * dt * dt / 4.0) + noise_q;
            let allowed_v = (jerk * dt * dt / 4.0).min(2.0 * acceleration * dt) + noise_v;
            let (by_q, by_v) = (misfit_q / allowed_q, misfit_v / allowed_v);
            self.worse(CONTINUITY, k, by_q, 1.0, row.t);
            self.worse(CONTINUITY, k, by_v, 1.0, row.t);
        }
    }

    /// New limits are in force from `row` on.
    fn change(&mut self, row: &TrajectoryRow<N>, rates: &Rates<N>) {
        for k in 0..N {
            let limits = [rates.velocity[k], rates.acceleration[k], rates.jerk[k]];
            self.excesses[k] = Excess::new(row.t, row.qd[k], row.qdd[k], limits);
        }
    }
}

/// How far and how long one joint is outside limits that were set below its state.
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
