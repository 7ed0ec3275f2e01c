//! Rows that are far from their bounds are left out of the iterations, and taken up again where the result exceeds one.

use super::barrier_problem::{BarrierProblem, ThirdRow, Whole};
use super::spline::Values;
use crate::constraint::Within;
use crate::problem::FeedProblem;

/// Which rows are far from their bounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distance {
    /// A row whose value is this part of half the way between its bounds away from both.
    pub part: f64,
    /// But not a jerk row of a limit that is near its bound so many places before or after, on a grid of up to
    /// [`BESIDE_UP_TO`] intervals. On a finer one the same way has more places.
    pub beside: usize,
}

/// Grids of up to so many intervals have as many places beside one as [`Distance::beside`] says.
const BESIDE_UP_TO: usize = 3000;

/// The condition that a coefficient of the squared speed is positive is far where it is this part of the squared speed beside it.
const POSITIVE_PART: f64 = 0.5;

impl Distance {
    /// From values on the way to the solution.
    pub const ON_THE_WAY: Self = Self { part: 0.6, beside: 8 };
    /// From a law on a coarser grid: its jerk is, place by place, another one.
    pub const COARSE: Self = Self { part: 0.3, beside: 32 };
    /// From a law that keeps all bounds but for a little, and is near some of them.
    pub const CLOSE: Self = Self { part: 0.2, beside: 16 };

    /// Returns true if a value is not far from its bounds.
    fn is_near(self, value: f64, lo: f64, hi: f64) -> bool {
        let size = if (hi - lo).is_finite() { 0.5 * (hi - lo) } else { hi.abs().min(lo.abs()) };
        // A bound of 0 alone has no size: such a row always stays.
        size == 0.0 || (value - lo).min(hi - value) < self.part * size
    }
}

impl BarrierProblem {
    /// Drops the rows that are far from their bounds at the given values and returns for every row whether it was left, in their
    /// order.
    pub fn drop_distant(&mut self, values: &Values, distance: Distance) -> &[bool] {
        let left = self.near_bounds(values, distance);
        let reduced = self.with_rows(&left);
        let problem = std::mem::replace(self, reduced);
        &self.whole.insert(Box::new(Whole { problem, left })).left
    }

    /// Takes up all dropped rows that are near their bounds at the given values if these exceed any. Returns for every row that is
    /// there then whether it is new.
    pub fn take_up_exceeded(&mut self, problem: &FeedProblem, values: &Values) -> Option<Vec<bool>> {
        let Whole { problem: all, left } = &**self.whole.as_ref()?;
        if !all.exceeds_any(problem, values, left) {
            return None;
        }
        let mut now = all.near_bounds(values, Distance::ON_THE_WAY);
        now.iter_mut().zip(left).for_each(|(now, left)| *now |= left);
        let mut more = all.with_rows(&now);
        // Those that were left have margins of their own by now.
        let [.., thirds, rest] = all.offsets();
        let mut own = self.thirds.iter();
        let rows = (thirds..rest).filter(|&i| now[i]).map(|i| left[i]);
        for (row, was_left) in more.thirds.iter_mut().zip(rows) {
            *row = if was_left { own.next().copied().unwrap_or(*row) } else { *row };
        }
        let is_new = now.iter().zip(left).filter(|(now, _)| **now).map(|(_, left)| !left).collect();
        let mut whole = self.whole.take();
        if let Some(whole) = &mut whole {
            whole.left = now;
        }
        *self = Self { whole, ..more };
        Some(is_new)
    }

    /// The problem with some of its rows: those of which `left` is true.
    fn with_rows(&self, left: &[bool]) -> Self {
        let [caps, inner, thirds, rest] = self.offsets();
        let (points, first) = some_of(&self.points, &self.first, &left[..caps]);
        let (inner, inner_first) = some_of(&self.inner, &self.inner_first, &left[inner..thirds]);
        let (thirds, thirds_first) = some_of(&self.thirds, &self.thirds_first, &left[thirds..rest]);
        Self {
            knots: self.knots.clone(),
            points,
            first,
            caps: self.caps.clone(),
            jerk_unit: self.jerk_unit.clone(),
            inner,
            inner_first,
            thirds,
            thirds_first,
            means: self.means.clone(),
            whole: None,
            ..*self
        }
    }

    /// For every row whether it is near a bound at the given values.
    fn near_bounds(&self, values: &Values, distance: Distance) -> Vec<bool> {
        let Values { x, u, w, .. } = values;
        let [_, inner, thirds, rest] = self.offsets();
        let mut near = vec![true; rest + 2];
        for k in 0..x.len() {
            for i in self.first[k]..self.first[k + 1] {
                let row = &self.points[i];
                let friction = if row.c == 0.0 { 0.0 } else { row.c * x[k].sqrt() };
                near[i] = distance.is_near(row.a * u[k] + row.b * x[k] + friction, row.lo, row.hi);
            }
        }
        for (k, end, rows, _) in self.places() {
            for i in rows {
                let row = &self.inner[i];
                let value = row.alpha * w[k] + row.beta * u[end] + row.gamma * x[end];
                // That a coefficient of `x` is above 0 is in doubt where it is far below the values beside it.
                let positive = row.lo == 0.0 && row.hi == f64::INFINITY && value > POSITIVE_PART * x[end];
                near[inner + i] = !positive && distance.is_near(value, row.lo, row.hi);
            }
        }
        self.near_limits_on_jerk(values, distance, &mut near[thirds..rest]);
        near
    }

    /// The same for jerk rows. Where jerk changes its sign it is far from its bounds for a moment, and would change at
    /// once without its rows: those of a limit that is near its bound a few places before or after count as near.
    fn near_limits_on_jerk(&self, values: &Values, distance: Distance, near: &mut [bool]) {
        let w = &values.w;
        let rows = self.thirds_first.get(1).copied().unwrap_or(0);
        let beside = distance.beside * w.len().div_ceil(BESIDE_UP_TO);
        near.fill(false);
        let mut last_near = vec![None; rows];
        for p in 0..2 * w.len() {
            for i in self.thirds_first[p]..self.thirds_first[p + 1] {
                let row = &self.thirds[i];
                let (value, bound) = jerk_and_bound(row, values, p);
                let which = i - p * rows;
                if row.step > 0.0 || distance.is_near(value, -bound, bound) {
                    let from = last_near[which].map_or(0, |last| last + 1).max(p.saturating_sub(beside));
                    (from..=p).for_each(|p| near[p * rows + which] = true);
                    last_near[which] = Some(p);
                } else if last_near[which].is_some_and(|last| p - last <= beside) {
                    near[i] = true;
                }
            }
        }
    }

    /// Returns true if the given values exceed a row of which `left` is false; jerk counts in the middle of intervals, too.
    fn exceeds_any(&self, problem: &FeedProblem, values: &Values, left: &[bool]) -> bool {
        let Values { x, u, w, .. } = values;
        let [_, inner, thirds, _] = self.offsets();
        let beyond = |value: f64, lo: f64, hi: f64| !(lo <= value && value <= hi);
        let at_points = (0..x.len()).any(|k| {
            let rows = self.first[k]..self.first[k + 1];
            rows.filter(|&i| !left[i]).any(|i| {
                let row = &self.points[i];
                let friction = if row.c == 0.0 { 0.0 } else { row.c * x[k].sqrt() };
                beyond(row.a * u[k] + row.b * x[k] + friction, row.lo, row.hi)
            })
        });
        at_points
            || self.places().any(|(k, end, inner_rows, third_rows)| {
                let between = inner_rows.filter(|&i| !left[inner + i]).any(|i| {
                    let row = &self.inner[i];
                    beyond(row.alpha * w[k] + row.beta * u[end] + row.gamma * x[end], row.lo, row.hi)
                });
                between || {
                    let bound = values.y[end];
                    let root = x[end] * bound;
                    let (middle_u, middle_x) = (0.5 * (u[k] + u[k + 1]), values.middle[k]);
                    let middle = problem.jerk_rows(self.from + k, Within::Middle);
                    third_rows.filter(|&i| !left[thirds + i]).any(|i| {
                        let row = &self.thirds[i];
                        let bound = bound - row.step * root;
                        beyond(row.alpha * w[k] + row.beta * u[end] + row.gamma * x[end], -bound, bound) || {
                            let row = &middle[row.id as usize];
                            row.value(w[k], middle_u, middle_x).abs() > self.most * row.limit
                        }
                    })
                }
            })
    }
}

/// The value of a jerk row at place `p`, and its bound.
fn jerk_and_bound(row: &ThirdRow, values: &Values, p: usize) -> (f64, f64) {
    let Values { x, u, w, y, .. } = values;
    let (k, end) = (p / 2, p / 2 + p % 2);
    (row.alpha * w[k] + row.beta * u[end] + row.gamma * x[end], y[end] - row.step * (x[end] * y[end]))
}

/// The rows of which `left` is true, with the first index of each place.
fn some_of<T: Copy>(rows: &[T], first: &[usize], left: &[bool]) -> (Vec<T>, Vec<usize>) {
    let (mut some, mut some_first) = (Vec::with_capacity(rows.len() / 2), Vec::with_capacity(first.len()));
    some_first.push(0);
    for place in first.windows(2) {
        some.extend((place[0]..place[1]).filter(|&i| left[i]).map(|i| rows[i]));
        some_first.push(some.len());
    }
    (some, some_first)
}
