//! Margins on jerk for what it does between the knots, while iterating.
//!
//! The coefficients of a row vary between two grid points; they are interpolated through both ends
//! and the middle, which is exact where the path is piecewise cubic.

use super::barrier_problem::BarrierProblem;
use super::spline::Values;
use crate::constraint::Within;
use crate::problem::{FeedProblem, quadratic};
use crate::row::JerkRow;

/// The excess of the parabola through three equidistant values over the range of both ends, below
/// and above.
pub(super) fn parabola_overshoot([start, middle, end]: [f64; 3]) -> [f64; 2] {
    let slope = 4.0 * middle - 3.0 * start - end;
    let bend = start - 2.0 * middle + end;
    // It turns at t = -slope / 4 bend.
    if !(slope * bend < 0.0 && slope.abs() < 4.0 * bend.abs()) {
        return [0.0; 2];
    }
    let peak = start - slope * slope / (8.0 * bend);
    [(start.min(end) - peak).max(0.0), (peak - start.max(end)).max(0.0)]
}

/// Least part of its slack that a row keeps when a new margin is set, so that the iterate stays
/// strictly inside.
const KEPT_SLACK: f64 = 0.3;

/// The least part of a limit that margins leave.
const LEAST_PART: f64 = 0.5;

impl BarrierProblem {
    /// Sets margins on jerk at the ends of every interval so that the current `x(s)` keeps inside
    /// it what it keeps there. None grows past what leaves the iterate strictly inside.
    pub fn set_margins(&mut self, problem: &FeedProblem, values: &Values) {
        // Not while the bounds are widened: the iterate is outside the true ones.
        let intervals = if self.means.is_empty() && self.jerk_wider == 0.0 { self.knots.intervals() } else { 0 };
        for k in 0..intervals {
            self.set_jerk_parts(problem, k, values, |here, part| here + KEPT_SLACK * (part - here));
        }
    }

    /// Sets margins such that jerk along the given values would keep inside them; those values need
    /// not be inside.
    pub fn demand_margins(&mut self, problem: &FeedProblem, values: &Values) {
        for k in 0..self.knots.intervals() {
            self.set_jerk_parts(problem, k, values, |_, part| LEAST_PART * part);
        }
    }

    /// Sets margins where jerk along the given values is beyond its limit between the knots; returns true if it is anywhere.
    /// Where the motion cannot be slowed down to keep them, bounds are widened by as much.
    pub fn demand_exceeded(&mut self, problem: &FeedProblem, values: &Values) -> bool {
        const ROUND_OFF: f64 = 1e-10;
        /// Jerk is no parabola: one that rises this much may be beyond its limit from this part below it on.
        const LARGE: f64 = 2e-5;
        const SURE: f64 = 2e-5;
        /// Places in between at which it is looked at then.
        const SAMPLES: i32 = 8;
        /// What it is more than a parabola is less than this part of what that rises.
        const NO_PARABOLA: f64 = 0.1;
        /// The motion changes a little once more; the margin stays as it does.
        const MARGIN: f64 = 1.05;
        let mut exceeded = false;
        let mut tighter = vec![0.0_f64; self.knots.intervals() + 1];
        for p in 0..2 * self.knots.intervals() {
            let k = p / 2;
            let states = states_within(values, k);
            let rows =
                [Within::Start, Within::Middle, Within::End].map(|within| problem.jerk_rows(self.from + k, within));
            for row in &mut self.thirds[self.thirds_first[p]..self.thirds_first[p + 1]] {
                let rows = rows.map(|rows| &rows[row.id as usize]);
                let value = jerks_within(rows, values.w[k], states);
                let [low, high] = parabola_overshoot(value);
                let [start, _, end] = value;
                let (mut over, mut peak) = (low.max(high), (start.max(end) + high).max(low - start.min(end)));
                if over > LARGE && peak > self.most * (1.0 - SURE - NO_PARABOLA * over) {
                    let above = |fraction: f64| jerk_within(rows, values.w[k], states, fraction).abs() - peak;
                    let more = (1..SAMPLES).map(|i| above(f64::from(i) / f64::from(SAMPLES))).fold(0.0, f64::max);
                    (over, peak) = (over + more, peak + more);
                }
                let beyond = over > 0.0 && peak > self.most * (1.0 + ROUND_OFF);
                if beyond || (over > LARGE && peak > self.most * (1.0 - SURE)) {
                    exceeded = true;
                    let before = row.part;
                    row.at_most = (self.most - MARGIN * over - SURE).max(LEAST_PART * before).min(before);
                    row.use_part(row.at_most);
                    let end = k + p % 2;
                    tighter[end] = tighter[end].max(before / row.part - 1.0);
                }
            }
        }
        if exceeded && !self.slows {
            self.widen_for(&tighter, &values.x);
        }
        exceeded
    }

    /// Widens the bounds on jerk at each knot by what they have become tighter by, relative to them.
    fn widen_for(&mut self, tighter: &[f64], x: &[f64]) {
        let wider = tighter.iter().zip(&self.jerk_unit).zip(x);
        let wider: Vec<f64> =
            wider.map(|((tighter, unit), x)| tighter + (1.0 + tighter) * self.jerk_wider * unit * x.sqrt()).collect();
        let most = wider.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        self.jerk_unit = wider.iter().zip(x).map(|(wider, x)| wider / most / x.sqrt()).collect();
        self.jerk_wider = most;
    }

    /// The least part of a limit to be used follows from the part that the jerk is and the part it
    /// may use so far.
    fn set_jerk_parts(&mut self, problem: &FeedProblem, k: usize, values: &Values, least: impl Fn(f64, f64) -> f64) {
        let (w, states) = (values.w[k], states_within(values, k));
        let rows = [Within::Start, Within::Middle, Within::End].map(|within| problem.jerk_rows(self.from + k, within));
        for (end, p) in [(0, 2 * k), (2, 2 * k + 1)] {
            for row in &mut self.thirds[self.thirds_first[p]..self.thirds_first[p + 1]] {
                let value = jerks_within(rows.map(|rows| &rows[row.id as usize]), w, states);
                let [low, high] = parabola_overshoot(value);
                let stated = &rows[end][row.id as usize];
                let here = value[end].abs() + stated.step * states[end].x / stated.limit;
                let part = (self.most - low.max(high)).max(least(here, row.part)).min(self.most.min(row.at_most));
                row.use_part(part);
            }
        }
    }
}

/// A place of an interval.
#[derive(Debug, Clone, Copy)]
struct State {
    u: f64,
    x: f64,
    /// The root of `x`.
    root: f64,
}

/// The states at the start, in the middle and at the end of interval `k`.
fn states_within(values: &Values, k: usize) -> [State; 3] {
    let Values { x, u, middle, y, middle_y, .. } = values;
    let state = |u: f64, x: f64, y: f64| State { u, x, root: x * y };
    [
        state(u[k], x[k], y[k]),
        state(0.5 * (u[k] + u[k + 1]), middle[k], middle_y[k]),
        state(u[k + 1], x[k + 1], y[k + 1]),
    ]
}

/// Jerk there in units of its limit, the step aside.
fn jerks_within(rows: [&JerkRow; 3], w: f64, states: [State; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (JerkRow { alpha, beta, gamma, limit, .. }, State { u, x, root }) = (rows[i], states[i]);
        (alpha * w + beta * u + gamma * x) * root / limit
    })
}

/// The same at a fraction of the interval.
fn jerk_within(rows: [&JerkRow; 3], w: f64, states: [State; 3], fraction: f64) -> f64 {
    let mix = quadratic(fraction);
    let [p, m, q] = rows;
    let of = |of: fn(&State) -> f64| mix(of(&states[0]), of(&states[1]), of(&states[2]));
    let (u, x) = (of(|state| state.u), of(|state| state.x));
    let along =
        mix(p.alpha, m.alpha, q.alpha) * w + mix(p.beta, m.beta, q.beta) * u + mix(p.gamma, m.gamma, q.gamma) * x;
    along * x.sqrt() / m.limit
}
