//! The joined scan on rows: a motion under limits on jerk that needs no solver.
//!
//! Every interval gets one bound each on speed, acceleration and jerk, from the hulls of the coefficients of its rows, each row
//! shared out between the three; [`plan_joined`] runs over them. What the rows would allow together is given away, so that the
//! motion is slower than that of [`JerkLimited`](crate::JerkLimited), but there is one wherever standing still keeps all rows
//! with something to spare.

use super::joined::plan_joined;
use super::{Segment, boundaries};
use crate::constraint::Within;
use crate::error::FeedError;
use crate::grid_plan::GridPlan;
use crate::plan::SpeedPlan;
use crate::problem::{FeedPlanner, FeedProblem};
use crate::row::{JerkRow, Row, RowSource};

/// Parts of a limit on acceleration or torque, and on jerk, that the speed alone may use, and of jerk both together.
const SPEED_OF_ROW: f64 = 0.5;
const SPEED_OF_JERK: f64 = 0.3;
const BOTH_OF_JERK: f64 = 0.6;

/// The joined scan on rows: velocity, acceleration, torque and jerk, kept between the grid points too.
///
/// Needs [`FeedProblem::between_points`] with at least one jerk row. For where [`JerkLimited`](crate::JerkLimited) finds no motion.
#[derive(Debug, Clone, Copy, Default)]
pub struct JoinedScan;

impl FeedPlanner for JoinedScan {
    fn plan(&self, problem: &FeedProblem) -> Result<GridPlan, FeedError> {
        if !problem.is_between_points() {
            return Err(FeedError::Empty { what: "rows between the grid points (FeedProblem::between_points)" });
        }
        if !problem.has_jerk() {
            return Err(FeedError::Empty { what: "limits on jerk" });
        }
        let n = problem.intervals();
        let segments = (0..n).map(|k| segment(problem, k)).collect::<Result<Vec<_>, _>>()?;
        let (mut parts, mut from) = (Vec::new(), 0);
        for i in (1..=n).filter(|&i| i == n || problem.x_max(i) == 0.0) {
            let speeds = [if from == 0 { problem.v_start() } else { 0.0 }, if i == n { problem.v_end() } else { 0.0 }];
            let part = plan_joined(&segments[from..i], speeds[0], speeds[1]);
            parts.push(part.map_err(|error| placed(problem, error, from))?);
            from = i;
        }
        let length = boundaries(&segments)[n];
        GridPlan::from_phases(&SpeedPlan::chain(parts), problem.grid(), length)
    }
}

/// An error of the scan over some of the intervals in terms of the whole problem.
fn placed(problem: &FeedProblem, error: FeedError, from: usize) -> FeedError {
    let n = problem.intervals();
    let out_of_reach = |what, i: usize, speed, highest| {
        let (row, s) = (problem.cap(i).1, problem.grid()[i]);
        FeedError::SpeedOutOfReach { what, speed, lowest: 0.0, highest, row, s }
    };
    match error {
        FeedError::AboveLimit { what: "v_end", value, limit } => out_of_reach("end speed", n, value, limit),
        FeedError::AboveLimit { what: "v_start", value, limit } => out_of_reach("start speed", 0, value, limit),
        FeedError::StartTooFast { speed, segment, highest_start, .. } => {
            out_of_reach("start speed", (from + segment).min(n), speed, highest_start)
        }
        FeedError::EndTooFast { speed, highest } => out_of_reach("end speed", n, speed, highest),
        error => error,
    }
}

/// Least and greatest Bernstein coefficient of the quadratic through values at both ends and in the middle.
fn hull([p, m, q]: [f64; 3]) -> [f64; 2] {
    let inner = 2.0 * m - 0.5 * (p + q);
    [p.min(q).min(inner), p.max(q).max(inner)]
}

/// Greatest magnitudes of the coefficients of a row over an interval, and its limit.
struct Hull {
    /// By the highest derivative downwards: of `u`, `x` and `sqrt(x)`, or of `w`, `u` and `x`.
    most: [f64; 3],
    limit: f64,
    source: RowSource,
}

fn of_row(rows: [&Row; 3]) -> Hull {
    let most = |of: fn(&Row) -> f64| hull(rows.map(of)).iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let [least_d, most_d] = hull(rows.map(|row| row.d));
    let limit = (rows[1].hi - most_d).min(least_d - rows[1].lo);
    Hull { most: [most(|row| row.a), most(|row| row.b), most(|row| row.c)], limit, source: rows[1].source }
}

fn of_jerk_row(rows: [&JerkRow; 3]) -> Hull {
    let most = |of: fn(&JerkRow) -> f64| hull(rows.map(of)).iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let most = [most(|row| row.alpha), most(|row| row.beta), most(|row| row.gamma)];
    Hull { most, limit: rows[1].limit, source: rows[1].source }
}

/// The bounds on one interval.
fn segment(problem: &FeedProblem, k: usize) -> Result<Segment, FeedError> {
    let (h, s) = (problem.h(k), problem.grid()[k]);
    let rows: Vec<Hull> = problem.through(k).map(of_row).collect();
    let [near, middle, far] = [Within::Start, Within::Middle, Within::End].map(|at| problem.jerk_rows(k, at));
    let thirds: Vec<Hull> = near.iter().zip(middle).zip(far).map(|((p, m), q)| of_jerk_row([p, m, q])).collect();
    let (mut v, mut source) = (f64::INFINITY, problem.cap(k).1);
    let mut keep = |most: f64, row: RowSource| {
        if !(most >= v) {
            (v, source) = (most, row);
        }
    };
    // A cap of 0 is a stop, which is made anyway.
    for i in [k, k + 1] {
        let (x, row) = problem.cap(i);
        keep(if x > 0.0 { x.sqrt() } else { f64::INFINITY }, row);
    }
    keep(problem.middle_x_max(k).sqrt(), problem.cap(k).1);
    let bound = problem.speed_bound(k);
    keep(1.0 / bound.coefficients.iter().fold(0.0, |most: f64, c| most.max(*c)).sqrt(), bound.source);
    for Hull { most: [_, b, c], limit, source } in &rows {
        // b v^2 + c v = r, without cancellation.
        let r = SPEED_OF_ROW * limit;
        keep(if *b + *c > 0.0 { 2.0 * r / (c + (c * c + 4.0 * b * r).sqrt()) } else { f64::INFINITY }, *source);
    }
    for Hull { most: [_, _, gamma], limit, source } in &thirds {
        keep((SPEED_OF_JERK * limit / gamma).cbrt(), *source);
    }
    if v == f64::INFINITY {
        return Err(FeedError::Unbounded { index: k, s });
    }
    // Reaching the speed and the acceleration within an interval is as good as at once.
    let mut a = v * v / h;
    for Hull { most: [factor, b, c], limit, .. } in rows.iter().filter(|row| row.most[0] > 0.0) {
        a = a.min((limit - v * (b * v + c)) / factor);
    }
    for Hull { most: [_, beta, gamma], limit, .. } in thirds.iter().filter(|row| row.most[1] > 0.0) {
        a = a.min((BOTH_OF_JERK * limit - gamma * v * v * v) / (beta * v));
    }
    let mut j = v * a / h;
    for Hull { most: [alpha, beta, gamma], limit, .. } in thirds.iter().filter(|row| row.most[0] > 0.0) {
        j = j.min((limit - v * (beta * a + gamma * v * v)) / alpha);
    }
    Segment::new(h, v, a, j).map_err(|error| match error {
        FeedError::NotPositive { .. } => FeedError::Standstill { index: k, s, row: source },
        error => error,
    })
}
