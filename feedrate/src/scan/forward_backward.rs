//! The bidirectional scan that keeps every row at both ends of every interval.
//!
//! # Why it holds
//! Let `X_i` be the greatest `x` up to which every row at grid point `i` holds at `u = 0` (the
//! "initial velocity limit", Electronics 2025, 14, 3869, eq. 16), and `R_k` the set of pairs
//! `(x_k, x_k+1)` below `X` that satisfy the rows at both ends of interval `k` with
//! `u = (x_k+1 - x_k) / 2h`. `R_k` contains the diagonal. The forward pass takes the greatest
//! `x_k+1` up to which `R_k` contains the whole segment from the diagonal, so the backward pass
//! `x_k`. Let `F` and `B` be the passes and `m = min(F, B)`.
//! * `m = F` at `k` and `m = B` at `k+1`: if `F_k <= B_k+1`, the pair lies between the diagonal and
//!   `(F_k, F_k+1)`; otherwise between the diagonal and `(B_k, B_k+1)`, since `F_k <= B_k`. The
//!   mirrored case likewise.
//! * `m = F` at both: an ascending `F` is such a pair itself. A descending one has `F_k+1 = X_k+1`,
//!   hence `B_k+1 = X_k+1 < F_k <= B_k`, and the pair lies between the diagonal and `(B_k, B_k+1)`.
//!   The same for `B`.
//!
//! So `m` is in every `R_k`. This needs no convexity, only segments along the axes: it holds for
//! viscous friction too.

use crate::error::{FeedError, PathEnd};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::row::{LimitId, Quantity, Row};
use crate::speed_law::SpeedLaw;

/// The bidirectional scan of Electronics 2025, 14, 3869 with every row tested at both ends of an
/// interval.
///
/// O(N), two tests per row and pass and a division where one fails; about 0.1 % to 1 % slower
/// motion than the optimum at N = 1000. It needs every grid point to be statically feasible. Rows
/// hold at the grid points; in between they may be exceeded by what they vary there.
#[derive(Debug, Clone, Copy, Default)]
pub struct ForwardBackwardScan;

impl FeedPlanner for ForwardBackwardScan {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        let x = squared_speeds(problem)?;
        moves(problem, &x)?;
        SpeedLaw::from_squared_speeds(problem.grid(), &x)
    }
}

/// Squared speeds at the grid points.
pub(crate) fn squared_speeds(problem: &FeedProblem) -> Result<Vec<f64>, FeedError> {
    scan(problem, &static_limits(problem)?)
}

/// Smallest root above `from` (0 if not positive) of `p w^2 + c w = r` in `w = sqrt(x)`, squared;
/// infinite if there is none.
fn first_crossing(p: f64, c: f64, r: f64, from: f64) -> f64 {
    if r.is_infinite() {
        return f64::INFINITY;
    }
    if c == 0.0 {
        let x = r / p;
        return if x >= from { x } else { f64::INFINITY };
    }
    // In units of c, so that its square does not overflow.
    let (p, r, c) = (p / c.abs(), r / c.abs(), c.signum());
    let square = 1.0 + 4.0 * p * r;
    if square < 0.0 {
        return f64::INFINITY;
    }
    if !square.is_finite() {
        // What cannot be judged must not grow.
        return from;
    }
    // The pair of roots without cancellation.
    let q = -0.5 * (c + square.sqrt().copysign(c));
    let w_from = from.max(0.0).sqrt();
    // A root at the start of the search counts: there the row is already tight.
    [q / p, -r / q]
        .into_iter()
        .filter(|&w| w >= w_from * (1.0 - 1e-14) && w > 0.0)
        .fold(f64::INFINITY, |least, w| least.min(w * w))
}

/// The value at which `p x + c sqrt(x)` leaves `[lo, hi]` when `x` grows from `from`, at which it
/// is inside.
#[inline(always)]
fn leaves(p: f64, c: f64, lo: f64, hi: f64, from: f64) -> f64 {
    if c == 0.0 {
        // The common case, with a single division and no branch; p = 0 gives infinity, or NaN that
        // no comparison takes.
        let left = if p > 0.0 { hi } else { -lo };
        return left / p.abs();
    }
    if from == 0.0 && (hi <= 0.0 && c > 0.0 || lo >= 0.0 && c < 0.0) {
        // Tight at rest: the root outgrows every other term.
        return 0.0;
    }
    first_crossing(p, c, hi, from).min(first_crossing(p, c, lo, from))
}

/// The end of the part of `from..to` on which the row `p x + c sqrt(x)` holds. Most rows hold all
/// the way, which takes no division.
#[inline(always)]
fn held(p: f64, c: f64, lo: f64, hi: f64, from: f64, to: f64) -> f64 {
    let value = p * to;
    // Not so for NaN, of an infinite `to`.
    if (c == 0.0) & (lo <= value) & (value <= hi) { to } else { lesser(to, leaves(p, c, lo, hi, from)) }
}

/// The lesser, which is the first if the second is NaN.
#[inline(always)]
fn lesser(x: f64, y: f64) -> f64 {
    if y < x { y } else { x }
}

/// The greatest `x` per grid point up to which all rows hold at constant speed (eq. 16).
fn static_limits(problem: &FeedProblem) -> Result<Vec<f64>, FeedError> {
    let mut limits = Vec::with_capacity(problem.grid().len());
    for i in 0..problem.grid().len() {
        let mut x_max = problem.x_max(i);
        for row in problem.rows(i) {
            if !((row.lo <= row.d) & (row.d <= row.hi)) {
                let limit = if row.d > row.hi { row.hi } else { row.lo };
                let (s, row, value) = (problem.grid()[i], row.source, row.d);
                return Err(FeedError::StaticallyInfeasible { index: i, s, row, value, limit });
            }
            x_max = held(row.b, row.c, row.lo - row.d, row.hi - row.d, 0.0, x_max);
        }
        limits.push(x_max);
    }
    Ok(limits)
}

/// An interval in the direction of a pass: its length, the sign of `u`, and the rows at the point
/// and at its neighbour.
struct Interval<'a> {
    h: f64,
    sign: f64,
    near: &'a [Row],
    far: &'a [Row],
}

/// The greatest `y` at the far end of an interval for squared speed `x < limit` at its near end.
fn step(x: f64, limit: f64, interval: &Interval<'_>) -> f64 {
    let Interval { h, sign, near, far } = *interval;
    let per_u = sign * 0.5 / h;
    let mut y = limit;
    // What the limit asks for; most rows allow it, or what another row has left of it, without
    // a division.
    let most = per_u * (limit - x);
    let mut u = most;
    for row in near {
        let friction = if row.c == 0.0 { 0.0 } else { row.c * x.sqrt() };
        let rest = row.b * x + friction + row.d;
        let value = row.a * u + rest;
        if !((row.lo <= value) & (value <= row.hi)) {
            // At u = 0 the row holds, so what is left is not negative but for round-off.
            let left = if sign * row.a > 0.0 { row.hi - rest } else { rest - row.lo };
            u = sign * lesser(sign * u, left / row.a.abs());
        }
    }
    if u != most {
        y = lesser(y, x + 2.0 * h * (sign * u));
    }
    for row in far {
        let a = row.a * per_u;
        let shift = a * x - row.d;
        y = held(a + row.b, row.c, row.lo + shift, row.hi + shift, x, y);
    }
    // At y = x every row holds.
    y.max(x)
}

fn scan(problem: &FeedProblem, limit: &[f64]) -> Result<Vec<f64>, FeedError> {
    let n = problem.intervals();
    let (x_start, x_end) = (problem.v_start().powi(2), problem.v_end().powi(2));
    for (end, i, x) in [(PathEnd::Start, 0, x_start), (PathEnd::End, n, x_end)] {
        if x > limit[i] {
            return Err(out_of_reach(problem, end, i, limit[i]));
        }
    }
    let mut forward = Vec::with_capacity(n + 1);
    forward.push(x_start);
    let mut x = x_start;
    for k in 0..n {
        let cap = limit[k + 1];
        // Descending is left to the backward pass.
        x = if x >= cap {
            cap
        } else {
            let (near, far) = (problem.rows(k), problem.rows(k + 1));
            step(x, cap, &Interval { h: problem.h(k), sign: 1.0, near, far })
        };
        if x == f64::INFINITY {
            return Err(FeedError::Unbounded { index: k + 1, s: problem.grid()[k + 1] });
        }
        forward.push(x);
    }
    if forward[n] < x_end * (1.0 - 1e-12) {
        return Err(out_of_reach(problem, PathEnd::End, n, forward[n]));
    }
    let mut x = x_end;
    forward[n] = x_end;
    for k in (0..n).rev() {
        let cap = limit[k];
        x = if x >= cap {
            cap
        } else {
            let (near, far) = (problem.rows(k + 1), problem.rows(k));
            step(x, cap, &Interval { h: problem.h(k), sign: -1.0, near, far })
        };
        forward[k] = forward[k].min(x);
    }
    if x < x_start * (1.0 - 1e-12) {
        return Err(out_of_reach(problem, PathEnd::Start, 0, x));
    }
    forward[0] = x_start;
    Ok(forward)
}

fn out_of_reach(problem: &FeedProblem, end: PathEnd, i: usize, highest: f64) -> FeedError {
    let speed = if i == 0 { problem.v_start() } else { problem.v_end() };
    let (cap, source) = problem.cap(i);
    let row = if highest >= cap { source } else { LimitId::path(Quantity::ControllableSet) };
    FeedError::SpeedOutOfReach { end, speed, lowest: 0.0, highest: highest.sqrt(), row, s: problem.grid()[i] }
}

/// Refuses a plan that rests over a whole interval, naming the limit that holds it.
pub(crate) fn moves(problem: &FeedProblem, x: &[f64]) -> Result<(), FeedError> {
    let Some(k) = (0..problem.intervals()).find(|&k| !(x[k] + x[k + 1] > 0.0)) else { return Ok(()) };
    let h = problem.h(k);
    // The end that is capped, or else the row that leaves the least to any acceleration.
    for i in [k, k + 1] {
        let (cap, row) = problem.cap(i);
        if cap == 0.0 && row.quantity != Quantity::Corner {
            return Err(FeedError::Standstill { index: i, s: problem.grid()[i], row });
        }
    }
    let left = |row: &Row| leaves(0.5 * row.a / h + row.b, row.c, row.lo - row.d, row.hi - row.d, 0.0);
    let tightest = problem.rows(k).iter().chain(problem.rows(k + 1)).min_by(|p, q| left(p).total_cmp(&left(q)));
    let row = tightest.map_or(problem.cap(k).1, |row| row.source);
    Err(FeedError::Standstill { index: k, s: problem.grid()[k], row })
}
