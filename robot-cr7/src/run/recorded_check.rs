//! The check of anybody's joint trajectory against the limits of an arm and a job.

use arcfeed_interp::{JointCheck, JointRates, JointSample, PathParameter};
use arcfeed_kinematics::{Arm, Dynamics, ForwardKinematics, JointLimits, Joints};
use nalgebra::Vector3;

use super::limit_line::{LimitLine, LimitUnit};
use super::limit_lines::limit_lines;
use super::robot::Drives;
use super::worst_sample::WorstSample;
use crate::input::recorded_rows::RecordedRow;

/// Names and units of what differences of positions bound.
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
/// smooth curve through them. What the rounding of the file can explain is taken off. Where a file states velocities and accelerations, these are
/// checked as well, and that they belong to the positions.
#[derive(Debug, Clone)]
pub struct RecordedCheck<const N: usize> {
    limits: RecordedLimits<N>,
    /// For files with velocities and accelerations.
    whole: JointCheck<N>,
    has_rates: bool,
    position: [WorstSample; N],
    differences: [[WorstSample; N]; 3],
    torque: [WorstSample; N],
    speed: WorstSample,
    last: Vec<RecordedRow<N>>,
    rows: usize,
    /// The largest jerk that the rounding of the positions can feign, over its limit.
    blur: f64,
}

impl<const N: usize> RecordedCheck<N> {
    /// A check of nothing yet.
    pub fn new(limits: RecordedLimits<N>) -> Self {
        let none = [WorstSample::default(); N];
        Self {
            whole: JointCheck::new(limits.joints.range()),
            limits,
            has_rates: false,
            position: none,
            differences: [none; 3],
            torque: none,
            speed: WorstSample::default(),
            last: Vec::with_capacity(4),
            rows: 0,
            blur: 0.0,
        }
    }

    /// The next row.
    pub fn see(&mut self, row: &RecordedRow<N>) {
        self.rows += 1;
        let (lower, upper) = (self.limits.joints.lower(), self.limits.joints.upper());
        for k in 0..N {
            let (value, middle) = (row.q[k], 0.5 * (lower[k] + upper[k]));
            let bound = if value < middle { lower[k] } else { upper[k] };
            self.position[k].see_ratio(row.t, value, bound, (value - middle) / (bound - middle));
        }
        if let (Some(qd), Some(qdd)) = (row.qd, row.qdd) {
            self.has_rates = true;
            let dt = self.last.last().map_or(0.0, |before| row.t - before.t);
            let sample = JointSample { t: row.t, q: row.q, qd, qdd };
            self.whole.see(&sample, dt, &JointRates::from(&self.limits.joints));
            if let Some(drives) = &self.limits.drives {
                let torque = drives.dynamics.torque(&row.q, &qd, &qdd);
                for (k, worst) in self.torque.iter_mut().enumerate() {
                    worst.see(row.t, torque[k], drives.torque[k]);
                }
            }
        }
        if let Some((feed, before)) = self.limits.feed.zip(self.last.last()) {
            let place = |q: &Joints<N>| -> Vector3<f64> { self.limits.arm.forward(q).translation.vector };
            let way = (place(&row.q) - place(&before.q)).norm();
            // A joint that is rounded moves the tool by less than its reach, which no arm has more than 10 m of.
            let rounded = 10.0 * N as f64 * (row.rounding + before.rounding);
            self.speed.see(row.t, (way - rounded).max(0.0) / (row.t - before.t), feed);
        }
        if self.last.len() == 4 {
            self.last.remove(0);
        }
        self.last.push(*row);
        self.look_at_differences();
    }

    /// The differences that end in the last row.
    fn look_at_differences(&mut self) {
        let joints = &self.limits.joints;
        let limits = [joints.velocity(), joints.acceleration(), joints.jerk()];
        let rows = &self.last;
        for order in 1..rows.len() {
            let part = &rows[rows.len() - 1 - order..];
            let factorial: f64 = (1..=order).map(|i| i as f64).product();
            let mut value = Joints::<N>::zeros();
            let mut noise = 0.0;
            for (i, row) in part.iter().enumerate() {
                let others = part.iter().enumerate().filter(|(j, _)| *j != i);
                let weight = factorial / others.map(|(_, other)| row.t - other.t).product::<f64>();
                value += row.q * weight;
                noise += weight.abs() * (row.rounding + 4.0 * f64::EPSILON * row.q.amax());
            }
            for (k, worst) in self.differences[order - 1].iter_mut().enumerate() {
                let beyond = value[k].signum() * (value[k].abs() - noise).max(0.0);
                worst.see(part[order].t, beyond, limits[order - 1][k]);
                if order == 3 {
                    self.blur = self.blur.max(noise / limits[2][k]);
                }
            }
        }
    }

    /// Number of rows seen.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The last time, s.
    pub fn end(&self) -> f64 {
        self.last.last().map_or(0.0, |row| row.t)
    }

    /// The largest jerk that the rounding of the positions can feign, over its limit: where it is large, jerk is not checked sharply.
    pub fn blur(&self) -> f64 {
        self.blur
    }

    /// For every limit the place where the motion comes closest to it.
    pub fn finish(self) -> Vec<LimitLine> {
        let mut lines = if self.has_rates {
            limit_lines(&self.whole.finish(), PathParameter::JointDistance)
        } else {
            each("joint position", LimitUnit::Radian, &self.position)
        };
        for ((name, unit), worst) in RATES.into_iter().zip(&self.differences) {
            let of_positions = each(name, unit, worst);
            if self.has_rates {
                lines.extend(
                    of_positions.into_iter().map(|line| LimitLine { name: format!("{name}, by positions"), ..line }),
                );
            } else {
                lines.extend(of_positions);
            }
        }
        if self.limits.drives.is_some() && self.has_rates {
            lines.extend(each("joint torque", LimitUnit::NewtonMetre, &self.torque));
        }
        if self.limits.feed.is_some() {
            lines.push(self.speed.line("tool speed", None, LimitUnit::MetrePerSecond));
        }
        lines
    }
}

fn each<const N: usize>(name: &str, unit: LimitUnit, worst: &[WorstSample; N]) -> Vec<LimitLine> {
    worst.iter().enumerate().map(|(k, worst)| worst.line(name, Some(k + 1), unit)).collect()
}
