//! The check of anybody's joint trajectory against the limits of an arm and a job.

use arcfeed_kinematics::{Arm, Dynamics, ForwardKinematics, JointLimits, Joints};
use nalgebra::Vector3;

use super::limit_line::{LimitLine, LimitUnit};
use super::robot::Drives;
use super::worst_sample::WorstSample;
use crate::input::recorded_rows::{RecordedRounding, RecordedRow};

/// Names and units of the rates.
const RATES: [(&str, LimitUnit); 3] = [
    ("joint velocity", LimitUnit::RadianPerSecond),
    ("joint acceleration", LimitUnit::RadianPerSecond2),
    ("joint jerk", LimitUnit::RadianPerSecond3),
];

/// What a recorded motion is held against.
#[derive(Debug, Clone)]
pub struct RecordedLimits<const N: usize> {
    /// The arm with its tool.
    pub arm: Arm<N>,
    /// The limits of its joints.
    pub joints: JointLimits<N>,
    /// Those of its drives, where torque is limited.
    pub drives: Option<Drives<N>>,
    /// Highest speed of the tool, m/s, where one is given.
    pub feed: Option<f64>,
}

/// Holds a recorded motion against its limits, row by row.
///
/// Positions are held against their range, and their divided differences against the limits on velocity, acceleration and jerk: n! times
/// the nth divided difference is the nth derivative somewhere between the rows, so that what exceeds a limit there does so on any
/// smooth curve through them. Velocities and accelerations that the file states are held against their limits, and against the differences:
/// a mean velocity is the velocity at some moment, from which the stated one is no further than the acceleration allows.
/// What the rounding of the file can explain is taken off everywhere; of times it moves a joint by what its greatest velocity allows.
#[derive(Debug, Clone)]
pub struct RecordedCheck<const N: usize> {
    limits: RecordedLimits<N>,
    rounding: RecordedRounding<N>,
    position: [WorstSample; N],
    /// Velocity, acceleration, jerk.
    rates: [[WorstSample; N]; 3],
    continuity: [WorstSample; N],
    torque: [WorstSample; N],
    speed: WorstSample,
    last: Vec<RecordedRow<N>>,
    rows: usize,
    begin: f64,
    /// Time between the first two rows, s.
    period: f64,
    /// What rounding can feign of velocity, acceleration, jerk and of the speed of the tool, over their limits.
    blur: [f64; 4],
}

impl<const N: usize> RecordedCheck<N> {
    /// A check of nothing yet, for rows that are rounded so.
    pub fn new(limits: RecordedLimits<N>, rounding: RecordedRounding<N>) -> Self {
        let none = [WorstSample::default(); N];
        Self {
            limits,
            rounding,
            position: none,
            rates: [none; 3],
            continuity: none,
            torque: none,
            speed: WorstSample::default(),
            last: Vec::with_capacity(4),
            rows: 0,
            begin: 0.0,
            period: 0.0,
            blur: [0.0; 4],
        }
    }

    /// The next row.
    pub fn see(&mut self, row: &RecordedRow<N>) {
        self.rows += 1;
        if self.last.is_empty() {
            self.begin = row.t;
        }
        if self.rows == 2 {
            self.period = row.t - self.begin;
        }
        let (lower, upper) = (self.limits.joints.lower(), self.limits.joints.upper());
        for k in 0..N {
            let (value, middle) = (row.q[k], 0.5 * (lower[k] + upper[k]));
            let bound = if value < middle { lower[k] } else { upper[k] };
            let away = ((value - middle).abs() - self.rounding.joints[0][k]).max(0.0);
            self.position[k].see_ratio(row.t, value, bound, away / (bound - middle).abs());
        }
        let stated = [row.qd, row.qdd];
        let most = [*self.limits.joints.velocity(), *self.limits.joints.acceleration()];
        for (order, values) in stated.iter().enumerate() {
            let Some(values) = values else { continue };
            for k in 0..N {
                let value = beyond(values[k], self.rounding.joints[order + 1][k]);
                self.rates[order][k].see(row.t, value, most[order][k]);
            }
        }
        if let (Some(qd), Some(qdd), Some(drives)) = (row.qd, row.qdd, &self.limits.drives) {
            let torque = drives.dynamics.torque(&row.q, &qd, &qdd);
            for (k, worst) in self.torque.iter_mut().enumerate() {
                worst.see(row.t, torque[k], drives.torque[k]);
            }
        }
        if let Some(before) = self.last.last().copied() {
            self.compare(&before, row);
        }
        if self.last.len() == 4 {
            self.last.remove(0);
        }
        self.last.push(*row);
        self.look_at_differences();
    }

    /// What the tool and the stated rates do from one row to the next.
    fn compare(&mut self, before: &RecordedRow<N>, row: &RecordedRow<N>) {
        let dt = row.t - before.t;
        if let Some(feed) = self.limits.feed {
            let place = |q: &Joints<N>| -> Vector3<f64> { self.limits.arm.forward(q).translation.vector };
            let way = (place(&row.q) - place(&before.q)).norm();
            // No joint is further from the tip than all links together.
            let chain = self.limits.arm.chain();
            let links = chain.joints().iter().map(|joint| joint.origin()).chain([chain.flange(), chain.tool()]);
            let reach: f64 = links.map(|link| link.translation.vector.norm()).sum();
            let noise = 2.0 * (reach * self.rounding.joints[0].sum() + feed * self.rounding.t) / dt;
            self.speed.see(row.t, (way / dt - noise).max(0.0), feed);
            self.blur[3] = self.blur[3].max(noise / feed);
        }
        let joints = &self.limits.joints;
        let [of_q, of_qd, of_qdd] = self.rounding.joints;
        for k in 0..N {
            // How far a mean rate may be from the one stated at the start of the step, and the roundings of both.
            let mut see = |change: f64, stated: f64, steepest: f64, noise: f64| {
                let off = beyond(change / dt - stated, noise);
                self.continuity[k].see(row.t, off / (steepest * dt), 1.0);
            };
            let late = |rate: f64| 2.0 * self.rounding.t * rate / dt;
            if let Some(qd) = before.qd {
                let noise = 2.0 * of_q[k] / dt + of_qd[k] + late(joints.velocity()[k]);
                see(row.q[k] - before.q[k], qd[k], joints.acceleration()[k], noise);
            }
            if let (Some(qdd), Some(from), Some(to)) = (before.qdd, before.qd, row.qd) {
                let noise = 2.0 * of_qd[k] / dt + of_qdd[k] + late(joints.acceleration()[k]);
                see(to[k] - from[k], qdd[k], joints.jerk()[k], noise);
            }
            if let (Some(from), Some(to)) = (before.qdd, row.qdd) {
                let noise = 2.0 * of_qdd[k] / dt + late(joints.jerk()[k]);
                self.rates[2][k].see(row.t, beyond((to[k] - from[k]) / dt, noise), joints.jerk()[k]);
            }
        }
    }

    /// The differences that end in the last row.
    fn look_at_differences(&mut self) {
        let joints = &self.limits.joints;
        let limits = [joints.velocity(), joints.acceleration(), joints.jerk()];
        let rows = &self.last;
        for order in 1..rows.len() {
            let part = &rows[rows.len() - 1 - order..];
            let factorial: f64 = (1..=order).map(|i| i as f64).product();
            let (mut value, mut weights) = (Joints::<N>::zeros(), 0.0);
            for (i, row) in part.iter().enumerate() {
                let others = part.iter().enumerate().filter(|(j, _)| *j != i);
                let weight = factorial / others.map(|(_, other)| row.t - other.t).product::<f64>();
                value += row.q * weight;
                weights += weight.abs();
            }
            for (k, worst) in self.rates[order - 1].iter_mut().enumerate() {
                let noise = weights * (self.rounding.joints[0][k] + self.rounding.t * joints.velocity()[k]);
                worst.see(part[order].t, beyond(value[k], noise), limits[order - 1][k]);
                self.blur[order - 1] = self.blur[order - 1].max(noise / limits[order - 1][k]);
            }
        }
    }

    /// Number of rows seen.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Time between the first two rows, s: the last one may come earlier, as the end of a motion does. 0 before the second row.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Time from the first to the last row, s.
    pub fn duration(&self) -> f64 {
        self.last.last().map_or(0.0, |row| row.t - self.begin)
    }

    /// What rounding can feign of velocity, acceleration, jerk and of the speed of the tool, over their limits: where it is large, that limit is
    /// not checked sharply.
    pub fn blur(&self) -> [f64; 4] {
        self.blur
    }

    /// For every limit the place where the motion comes closest to it.
    pub fn finish(self) -> Vec<LimitLine> {
        let mut lines = each("joint position", LimitUnit::Radian, &self.position);
        for ((name, unit), worst) in RATES.into_iter().zip(&self.rates) {
            lines.extend(each(name, unit, worst));
        }
        let Some(last) = self.last.last() else { return lines };
        if last.qd.is_some() {
            lines.extend(each("continuity", LimitUnit::One, &self.continuity));
        }
        if self.limits.drives.is_some() && last.qdd.is_some() && last.qd.is_some() {
            lines.extend(each("joint torque", LimitUnit::NewtonMetre, &self.torque));
        }
        if self.limits.feed.is_some() {
            lines.push(self.speed.line("tool speed", None, LimitUnit::MetrePerSecond));
        }
        lines
    }
}

/// A value less what noise can explain of it.
fn beyond(value: f64, noise: f64) -> f64 {
    value.signum() * (value.abs() - noise).max(0.0)
}

fn each<const N: usize>(name: &str, unit: LimitUnit, worst: &[WorstSample; N]) -> Vec<LimitLine> {
    worst.iter().enumerate().map(|(k, worst)| worst.line(name, Some(k + 1), unit)).collect()
}
