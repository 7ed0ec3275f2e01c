//! The projection on the error of Liu et al. 2024, section 4.2, as printed and as corrected.
//!
//! The corrected limits are s+ = min over joints k of (P_ki > 0 ? max_k / P_ki : min_k / P_ki). The
//! planner of each axis is reference 37 of the paper, which it does not print; the shortest motion
//! to rest stands in its place.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use nalgebra::{Matrix6, Vector6};

/// Limits of the joints: velocity, acceleration, jerk, for both signs.
pub type Limits6 = [Vector6<f64>; 3];

/// What the corrected scheme did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProjectionOutcome {
    /// Time of arrival, s; `None` without arrival.
    pub arrival: Option<f64>,
    /// Largest share of the limits on velocity, acceleration and jerk.
    pub used: [f64; 3],
}

/// Orthogonal matrix whose first column is the direction of the error: Schmidt's method on the
/// columns of the identity, without the one nearest to the error.
pub fn frame(error: &Vector6<f64>) -> Matrix6<f64> {
    let first = error.normalize();
    let dropped = first.iamax();
    let mut columns = vec![first];
    for k in (0..6).filter(|&k| k != dropped) {
        let mut column = Vector6::zeros();
        column[k] = 1.0;
        for _ in 0..2 {
            for other in &columns {
                column -= other * other.dot(&column);
            }
        }
        columns.push(column.normalize());
    }
    Matrix6::from_columns(&columns)
}

/// Lower and upper bound along one column as printed: the least quotient for both.
pub fn printed_bounds(column: &Vector6<f64>, limit: &Vector6<f64>) -> (f64, f64) {
    let quotients = |sign: f64| column.iter().zip(limit).map(move |(p, l)| sign * l / p);
    let least = |sign: f64| quotients(sign).fold(f64::INFINITY, f64::min);
    (least(-1.0), least(1.0))
}

/// The bound along one column, corrected; the same for both signs where those of the joints are.
fn corrected_bound(column: &Vector6<f64>, limit: &Vector6<f64>) -> f64 {
    let used = column.iter().zip(limit).filter(|(p, _)| p.abs() > 1e-9);
    used.map(|(p, l)| l / p.abs()).fold(f64::INFINITY, f64::min)
}

/// Runs the corrected scheme from a state (position, velocity, acceleration) with cycles of `ts`
/// (s), for at most 10 s.
pub fn corrected(from: &[Vector6<f64>; 3], to: &Vector6<f64>, limits: &Limits6, ts: f64) -> ProjectionOutcome {
    let [mut p, mut v, mut a] = *from;
    let mut used = [0.0f64; 3];
    for cycle in 1..=(10.0 / ts) as u32 {
        let error = to - p;
        if error.amax() < 1e-4 && v.amax() < 1e-2 {
            return ProjectionOutcome { arrival: Some(f64::from(cycle - 1) * ts), used };
        }
        let axes = frame(&error);
        let mut jerk = Vector6::zeros();
        for i in 0..6 {
            let column = axes.column(i).into_owned();
            let [v_max, a_max, j_max] = [0, 1, 2].map(|k| corrected_bound(&column, &limits[k]));
            let state = AxisState::new(-error.dot(&column), v.dot(&column), a.dot(&column));
            let target = AxisState::new(0.0, 0.0, 0.0);
            let plan = AxisLimits::symmetric(v_max, a_max, j_max)
                .and_then(|limits| StateToState::new(&state, &target, &limits));
            let Ok(plan) = plan else { return ProjectionOutcome { arrival: None, used } };
            jerk += column * ((plan.at(ts).a - a.dot(&column)) / ts);
        }
        p += v * ts + a * (ts * ts / 2.0) + jerk * (ts.powi(3) / 6.0);
        v += a * ts + jerk * (ts * ts / 2.0);
        a += jerk * ts;
        for (used, (x, limit)) in used.iter_mut().zip([(&v, &limits[0]), (&a, &limits[1]), (&jerk, &limits[2])]) {
            *used = used.max(x.component_div(limit).amax());
        }
    }
    ProjectionOutcome { arrival: None, used }
}
