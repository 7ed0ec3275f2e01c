//! A motion in joint space, sampled and checked: what `cr7 move` and `cr7 online` have in common.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use serde::Serialize;

use crate::report::{LimitLine, LimitUnit, clip, limit_table, number};
use crate::trajectory_csv::TrajectoryRow;

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

/// Something that happened during a motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Happening {
    /// When, in s.
    pub t_s: f64,
    /// What, in words.
    pub what: String,
}

/// The result of a motion in joint space. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointReport {
    /// What was done.
    pub name: String,
    /// Duration in s.
    pub duration_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Control period in s.
    pub period_s: f64,
    /// Facts in words, each a name and a value.
    pub facts: Vec<(String, String)>,
    /// What happened on the way.
    pub events: Vec<Happening>,
    /// Every limit with its worst place.
    pub limits: Vec<LimitLine>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

impl JointReport {
    /// The whole report as one JSON object on one line.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_else(|e| serde_json::json!({ "error": e.to_string() }).to_string())
    }

    /// The largest part of a limit that is used; not a number where a sample is none.
    pub fn worst_ratio(&self) -> f64 {
        self.limits.iter().map(|l| l.ratio).fold(0.0, |a: f64, r| if r > a || r.is_nan() { r } else { a })
    }
}

const WIDTH: usize = 100;
const MOST_EVENTS: usize = 12;

impl Display for JointReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", clip(&self.name, WIDTH))?;
        let samples =
            format!("{} s, {} samples at {} ms", number(self.duration_s), self.samples, number(self.period_s * 1e3));
        writeln!(f, "  {:<16}{samples}", "duration")?;
        for (name, value) in &self.facts {
            writeln!(f, "  {name:<16}{}", clip(value, WIDTH - 18))?;
        }
        for event in self.events.iter().take(MOST_EVENTS) {
            writeln!(f, "  {:>10} s  {}", format!("{:.4}", event.t_s), clip(&event.what, WIDTH - 16))?;
        }
        if self.events.len() > MOST_EVENTS {
            writeln!(f, "  and {} more events (all in the JSON report)", self.events.len() - MOST_EVENTS)?;
        }
        limit_table(f, &self.limits)?;
        if !self.files.is_empty() {
            writeln!(f)?;
        }
        for file in &self.files {
            writeln!(f, "  wrote {}", clip(&file.display().to_string(), WIDTH - 8))?;
        }
        Ok(())
    }
}

/// Holds a sampled motion against its limits, without the help of whatever made it: velocity and acceleration as they
/// are, jerk as the difference of accelerations over the time between samples (the mean of the true jerk, which never
/// exceeds its maximum), and each sample against the one before, so that a jump cannot hide between two of them.
///
/// `rates` gives the limits in force from row `i` to the next; `range` the joint range (lower, upper) in rad.
pub fn check_joints<const N: usize>(
    rows: &[TrajectoryRow<N>],
    rates: impl Fn(usize) -> Rates<N>,
    range: (&[f64; N], &[f64; N]),
) -> Vec<LimitLine> {
    let names = ["joint position", "joint velocity", "joint acceleration", "joint jerk", "continuity"];
    let units = [
        LimitUnit::Radian,
        LimitUnit::RadianPerSecond,
        LimitUnit::RadianPerSecond2,
        LimitUnit::RadianPerSecond3,
        LimitUnit::One,
    ];
    let mut lines: Vec<LimitLine> = Vec::with_capacity(5 * N);
    for (name, unit) in names.into_iter().zip(units) {
        lines.extend((0..N).map(|k| LimitLine {
            name: name.to_owned(),
            joint: Some(k + 1),
            unit,
            value: 0.0,
            limit: 1.0,
            ratio: 0.0,
            at_s_m: None,
            at_t_s: 0.0,
        }));
    }
    let mut see = |kind: usize, k: usize, value: f64, limit: f64, t: f64| {
        let line = &mut lines[kind * N + k];
        let ratio = value.abs() / limit;
        // A NaN, once seen, stays.
        if !line.ratio.is_nan() && (ratio >= line.ratio || ratio.is_nan()) {
            (line.value, line.limit, line.ratio, line.at_t_s) = (value, limit, ratio, t);
        }
    };
    for (i, row) in rows.iter().enumerate() {
        let at = rates(i);
        for k in 0..N {
            let middle = 0.5 * (range.0[k] + range.1[k]);
            see(0, k, row.q[k] - middle, range.1[k] - middle, row.t);
            see(1, k, row.qd[k], at.velocity[k], row.t);
            see(2, k, row.qdd[k], at.acceleration[k], row.t);
        }
        let Some(before) = i.checked_sub(1).map(|i| &rows[i]) else { continue };
        let dt = row.t - before.t;
        if dt <= 0.0 {
            continue;
        }
        let during = rates(i - 1);
        for k in 0..N {
            let limit = during.jerk[k];
            // Rounding of an acceleration over a short time is no jerk.
            let noise = 4.0 * f64::EPSILON * (row.qdd[k].abs() + before.qdd[k].abs()) / dt;
            let jerk = (row.qdd[k] - before.qdd[k]) / dt;
            see(3, k, jerk.signum() * (jerk.abs() - noise).max(0.0), limit, row.t);
            // With the jerk below J: |q1 - q0 - dt (v0 + v1) / 2| <= J dt^3 / 12, |v1 - v0 - dt (a0 + a1) / 2| <= J dt^2 / 4.
            let q = row.q[k] - before.q[k] - 0.5 * dt * (row.qd[k] + before.qd[k]);
            let v = row.qd[k] - before.qd[k] - 0.5 * dt * (row.qdd[k] + before.qdd[k]);
            let by_position = q.abs() / (limit * dt * dt * dt / 12.0 + 1e-14 * (1.0 + row.q[k].abs()));
            let by_velocity = v.abs() / (limit * dt * dt / 4.0 + 1e-14 * (1.0 + row.qd[k].abs()));
            see(4, k, by_position.max(by_velocity), 1.0, row.t);
        }
    }
    lines
}
