//! Rows that are far from their bounds are left out of the iterations.

use super::barrier_problem::BarrierProblem;
use super::spline::Values;

/// A row is dropped where its value is closer to the middle between its bounds than to either, by
/// this measure.
const DISTANT_FROM_BOUND: f64 = 0.6;

/// But not a jerk row of a limit that is near its bound so many places before or after, on a grid of up to so many intervals. On a
/// finer one the same way has more places.
const BESIDE_NEAR: usize = 8;
const BESIDE_NEAR_UP_TO: usize = 3000;

impl BarrierProblem {
    /// Drops the rows that are far from their bounds at the given values and calls `keep` for every
    /// row with whether it stays, in their order.
    pub fn drop_distant(&mut self, values: &Values, mut keep: impl FnMut(bool)) {
        let Values { x, u, w, .. } = values;
        let mut write = 0;
        let mut start = 0;
        for k in 0..x.len() {
            for i in start..self.first[k + 1] {
                let row = self.points[i];
                let friction = if row.c == 0.0 { 0.0 } else { row.c * x[k].sqrt() };
                let stays = is_near(row.a * u[k] + row.b * x[k] + friction, row.lo, row.hi);
                keep(stays);
                if stays {
                    self.points[write] = row;
                    write += 1;
                }
            }
            start = self.first[k + 1];
            self.first[k + 1] = write;
        }
        self.points.truncate(write);
        self.caps.iter().for_each(|_| keep(true));
        let (mut write, mut start) = (0, 0);
        for p in 0..2 * w.len() {
            for i in start..self.inner_first[p + 1] {
                let row = self.inner[i];
                let end = p / 2 + p % 2;
                let stays = is_near(row.alpha * w[p / 2] + row.beta * u[end] + row.gamma * x[end], row.lo, row.hi);
                keep(stays);
                if stays {
                    self.inner[write] = row;
                    write += 1;
                }
            }
            start = self.inner_first[p + 1];
            self.inner_first[p + 1] = write;
        }
        self.inner.truncate(write);
        self.drop_distant_jerk(values, &mut keep);
        (0..2).for_each(|_| keep(true));
    }

    /// The same for jerk rows. Where jerk changes its sign it is far from its bounds for a moment, and would change at
    /// once without its rows: those of a limit that is near its bound a few places before or after stay.
    fn drop_distant_jerk(&mut self, values: &Values, keep: &mut impl FnMut(bool)) {
        let Values { x, u, w, .. } = values;
        let rows = self.thirds_first.get(1).copied().unwrap_or(0);
        let beside = BESIDE_NEAR * w.len().div_ceil(BESIDE_NEAR_UP_TO);
        let mut far = vec![true; self.thirds.len()];
        let mut last_near = vec![None; rows];
        for p in 0..2 * w.len() {
            for i in self.thirds_first[p]..self.thirds_first[p + 1] {
                let (row, end) = (self.thirds[i], p / 2 + p % 2);
                let value = row.alpha * w[p / 2] + row.beta * u[end] + row.gamma * x[end];
                let bound = 1.0 / x[end].sqrt() - row.step * x[end].sqrt();
                let which = i - p * rows;
                if row.step > 0.0 || is_near(value, -bound, bound) {
                    (p.saturating_sub(beside)..=p).for_each(|p| far[p * rows + which] = false);
                    last_near[which] = Some(p);
                } else if last_near[which].is_some_and(|last| p - last <= beside) {
                    far[i] = false;
                }
            }
        }
        let (mut write, mut start) = (0, 0);
        for p in 0..2 * w.len() {
            for i in start..self.thirds_first[p + 1] {
                keep(!far[i]);
                if !far[i] {
                    self.thirds[write] = self.thirds[i];
                    write += 1;
                }
            }
            start = self.thirds_first[p + 1];
            self.thirds_first[p + 1] = write;
        }
        self.thirds.truncate(write);
    }
}

/// Returns true if a value is not far from its bounds.
fn is_near(value: f64, lo: f64, hi: f64) -> bool {
    let size = if (hi - lo).is_finite() { 0.5 * (hi - lo) } else { hi.abs().min(lo.abs()) };
    // A bound of 0 alone has no size: such a row always stays.
    size == 0.0 || (value - lo).min(hi - value) < DISTANT_FROM_BOUND * size
}
