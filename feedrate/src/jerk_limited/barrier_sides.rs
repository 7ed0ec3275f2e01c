//! The sides of all bounds of a barrier problem in a fixed order: widening, slack and its change,
//! and the limit of each.

use super::barrier_problem::{BarrierProblem, Sides, is_nothing};
use super::spline::Values;
use crate::constraint::Within;
use crate::problem::FeedProblem;
use crate::row::{JerkRow, LimitId};

impl BarrierProblem {
    /// Visits the widening of every side.
    pub fn each_widening(&self, mut visit: impl FnMut(usize, Sides)) {
        let [caps, inner, thirds, rest] = self.offsets();
        self.points.iter().enumerate().for_each(|(i, row)| visit(i, row.wider));
        self.caps.iter().enumerate().for_each(|(k, cap)| visit(caps + k, [0.0, cap[1]]));
        self.inner.iter().enumerate().for_each(|(i, row)| visit(inner + i, row.wider));
        for (_, end, _, rows) in self.places() {
            let wider = self.jerk_wider * self.jerk_unit[end];
            rows.for_each(|i| visit(thirds + i, [wider; 2]));
        }
        for (i, end) in [0, self.knots.intervals()].into_iter().enumerate() {
            visit(rest + i, [0.0, self.jerk_wider * self.jerk_unit[end]]);
        }
    }

    /// The limit and the position of a row, as long as no row has been dropped.
    pub fn limit(&self, problem: &FeedProblem, i: usize) -> Option<(LimitId, f64)> {
        let [caps, inner, thirds, rest] = self.offsets();
        // The last of the places that begin at an index or before.
        let place = |first: &[usize], i: usize| first.partition_point(|&from| from <= i) - 1;
        let within = |p: usize| if p.is_multiple_of(2) { Within::Start } else { Within::End };
        let (source, knot) = if i < caps {
            let k = place(&self.first, i);
            let row = problem.rows(self.from + k).iter().filter(|row| !is_nothing(row)).nth(i - self.first[k])?;
            (row.source, k)
        } else if i < inner {
            (problem.cap(self.from + i - caps).1, i - caps)
        } else if i < thirds {
            let p = place(&self.inner_first, i - inner);
            let k = self.from + p / 2;
            let mut rows = problem.inner_rows(k, within(p)).filter(|row| !row.is_nothing());
            let row = rows.nth(i - inner - self.inner_first[p]);
            (row.map_or(problem.speed_bound(k).source, |row| row.source), p / 2 + p % 2)
        } else if i < rest {
            let p = place(&self.thirds_first, i - thirds);
            let rows = problem.jerk_rows(self.from + p / 2, within(p));
            (rows.get(self.thirds.get(i - thirds)?.id as usize)?.source, p / 2 + p % 2)
        } else {
            let (k, at) = if i == rest {
                (self.from, 0)
            } else {
                (self.from + self.knots.intervals() - 1, self.knots.intervals())
            };
            let part = |row: &&JerkRow| row.alpha.abs() / row.limit;
            let rows = problem.jerk_rows(k, if at == 0 { Within::Start } else { Within::End });
            (rows.iter().max_by(|p, q| part(p).total_cmp(&part(q)))?.source, at)
        };
        Some((source, problem.grid()[self.from + knot]))
    }

    /// Index of the first cap, inner row, jerk row and rest interval among all rows.
    pub fn offsets(&self) -> [usize; 4] {
        let caps = self.points.len();
        let inner = caps + self.caps.len();
        let thirds = inner + self.inner.len();
        [caps, inner, thirds, thirds + self.thirds.len()]
    }

    /// `c[1] / c[0]` at both ends.
    pub fn ratios(&self) -> Sides {
        [self.ends[0].ratio(self.knots.h[0]), self.ends[1].ratio(self.knots.h[self.knots.intervals() - 1])]
    }

    /// The slack of every side at the given values.
    pub fn each_slack(&self, values: &Values, mut visit: impl FnMut(usize, Sides)) {
        let Values { x, u, w, .. } = values;
        let [caps, inner, thirds, rest] = self.offsets();
        for k in 0..x.len() {
            for i in self.first[k]..self.first[k + 1] {
                let row = &self.points[i];
                let friction = if row.c == 0.0 { 0.0 } else { row.c * x[k].sqrt() };
                let value = row.a * u[k] + row.b * x[k] + friction;
                let [low, high] = row.wider;
                visit(i, [value - row.lo + low, row.hi + high - value]);
            }
            visit(caps + k, [f64::INFINITY, self.caps[k][0] + self.caps[k][1] - x[k]]);
        }
        for (k, end, inner_rows, third_rows) in self.places() {
            let (x, y, u, w) = (x[end], values.y[end], u[end], w[k]);
            for i in inner_rows {
                let row = &self.inner[i];
                let value = row.alpha * w + row.beta * u + row.gamma * x;
                let [low, high] = row.wider;
                visit(inner + i, [value - row.lo + low, row.hi + high - value]);
            }
            let root = x * y;
            let least = self.jerk_bound(k, end, values) + self.jerk_wider * self.jerk_unit[end];
            for i in third_rows {
                let row = &self.thirds[i];
                let value = row.alpha * w + row.beta * u + row.gamma * x;
                let bound = least - row.step * root;
                visit(thirds + i, [bound + value, bound - value]);
            }
        }
        for (i, end) in [0, x.len() - 1].into_iter().enumerate() {
            let bound = values.y[end] + self.jerk_wider * self.jerk_unit[end];
            let slack = if self.rest[i] == 0.0 { f64::INFINITY } else { bound - self.rest[i] * x[end] };
            visit(rest + i, [f64::INFINITY, slack]);
        }
    }

    /// Visits the change of the slack of every side with the values, to first order, while all
    /// relaxation is taken back.
    pub fn each_change(&self, values: &Values, delta: &Values, mut visit: impl FnMut(usize, Sides)) {
        let (Values { x, .. }, Values { x: dx, u: du, w: dw, .. }) = (values, delta);
        let [caps, inner, thirds, rest] = self.offsets();
        for k in 0..x.len() {
            for i in self.first[k]..self.first[k + 1] {
                let row = &self.points[i];
                let by = row.a * du[k] + row.slope(x[k]) * dx[k];
                visit(i, [by - row.wider[0], -by - row.wider[1]]);
            }
            visit(caps + k, [0.0, -dx[k] - self.caps[k][1]]);
        }
        for (k, end, inner_rows, third_rows) in self.places() {
            let (dx, du, dw) = (dx[end], du[end], dw[k]);
            for i in inner_rows {
                let row = &self.inner[i];
                let by = row.alpha * dw + row.beta * du + row.gamma * dx;
                visit(inner + i, [by - row.wider[0], -by - row.wider[1]]);
            }
            let y = values.y[end];
            let [by_x, by_u, by_w] = self.jerk_falls(k, end, values);
            let least = -(by_x * dx + by_u * du + by_w * dw) - self.jerk_wider * self.jerk_unit[end];
            let half = 0.5 * y * dx;
            for i in third_rows {
                let row = &self.thirds[i];
                let bound = least - row.step * half;
                let by = row.alpha * dw + row.beta * du + row.gamma * dx;
                visit(thirds + i, [bound + by, bound - by]);
            }
        }
        for (i, end) in [0, x.len() - 1].into_iter().enumerate() {
            let y = values.y[end];
            let slope = self.rest[i] + 0.5 * y * y * y;
            visit(rest + i, [0.0, -slope * dx[end] - self.jerk_wider * self.jerk_unit[end]]);
        }
    }
}
