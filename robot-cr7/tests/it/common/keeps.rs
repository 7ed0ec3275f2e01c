//! Holds a trajectory file against limits by differences of its numbers, with nothing of the library but the reader.
//!
//! The file has the shortest digits that read back as the same doubles, so that its precision is theirs: a difference of two
//! values q is good to 1e-15 (1 + |q|), and the rate it gives to that over the time between the rows.

use robot_cr7::TrajectoryRow;

/// Relative part of a limit that is rounding.
const ROUNDING: f64 = 1e-6;

/// What the rows have to keep; infinite where nothing is asked for. Angles in rad, lengths in m.
#[derive(Debug, Clone)]
pub struct Limits<const N: usize> {
    pub velocity: [f64; N],
    pub acceleration: [f64; N],
    pub jerk: [f64; N],
    pub range: [[f64; 2]; N],
    pub linear: f64,
    pub angular: f64,
}

/// The first limit that the rows do not keep, with its row.
pub fn broken<const N: usize>(rows: &[TrajectoryRow<N>], limits: &Limits<N>) -> Option<String> {
    // A motion from where it is to where it is takes no time: one row.
    let last = match rows.len() {
        0 => return Some("no rows".to_owned()),
        n => n - 1,
    };
    let period = rows[last.min(1)].t - rows[0].t;
    for (i, row) in rows.iter().enumerate() {
        for k in 0..N {
            let [low, high] = limits.range[k];
            let values = [
                ("position", if (low..=high).contains(&row.q[k]) { 0.0 } else { row.q[k] }, 1e-9),
                ("velocity", row.qd[k], limits.velocity[k]),
                ("acceleration", row.qdd[k], limits.acceleration[k]),
            ];
            for (name, value, limit) in values {
                if value.is_nan() || value.abs() > limit * (1.0 + ROUNDING) {
                    return Some(format!("{name} {value} of {limit}, J{} in row {i} of {last}", k + 1));
                }
            }
        }
        if let Some(before) = i.checked_sub(1).map(|before| &rows[before]) {
            // Times of a control cycle are multiples of the period; their difference loses digits as they grow.
            let dt = if i < last { period } else { row.t - before.t };
            if let Some(what) = jumps(before, row, dt, limits) {
                return Some(format!("{what} at row {i} of {last}"));
            }
        }
    }
    None
}

fn jumps<const N: usize>(a: &TrajectoryRow<N>, b: &TrajectoryRow<N>, dt: f64, limits: &Limits<N>) -> Option<String> {
    let exceeds = |value: f64, limit: f64, size: f64| {
        let precision = (1e-14 * (1.0 + size) + 2.0 * f64::EPSILON * b.t * size) / dt;
        value.is_nan() || value.abs() > limit * (1.0 + ROUNDING) + precision
    };
    for k in 0..N {
        let rates = [
            ("mean velocity", a.q[k], b.q[k], limits.velocity[k], a.qd[k].abs() + b.qd[k].abs() + b.q[k].abs()),
            ("mean acceleration", a.qd[k], b.qd[k], limits.acceleration[k], a.qdd[k].abs() + b.qdd[k].abs()),
            ("mean jerk", a.qdd[k], b.qdd[k], limits.jerk[k], a.qdd[k].abs() + b.qdd[k].abs()),
        ];
        for (name, from, to, limit, size) in rates {
            let rate = (to - from) / dt;
            if exceeds(rate, limit, size) {
                return Some(format!("{name} {rate} of {limit}, J{}", k + 1));
            }
        }
        let off = (b.q[k] - a.q[k]) / dt - 0.5 * (a.qd[k] + b.qd[k]);
        if exceeds(off, 0.25 * limits.acceleration[k] * dt, a.qd[k].abs() + b.qd[k].abs() + b.q[k].abs()) {
            return Some(format!("position jumps by {} J{}", off * dt, k + 1));
        }
    }
    let norm = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let speed = norm(&a.position, &b.position) / dt;
    // Half the angle between two unit quaternions, by their distance.
    let turn = norm(&a.quaternion, &b.quaternion).min(norm(&a.quaternion, &b.quaternion.map(|c| -c)));
    let turning = 4.0 * (0.5 * turn).min(1.0).asin() / dt;
    for (name, value, limit) in [("tool speed", speed, limits.linear), ("tool turning", turning, limits.angular)] {
        if exceeds(value, limit, 1.0) {
            return Some(format!("{name} {value} of {limit}"));
        }
    }
    None
}
