//! A problem that every motion within the limits keeps, and that stays convex where it counts.
//!
//! Of the rows of the planner those are left that any motion on the grid keeps: rows and caps at the knots, and of each
//! jerk row its mean over an interval by Gauss's rule with two points,
//!
//! ```text
//! mean of |alpha w + beta u + gamma x|  <=  mean of (1 / sqrt(x) - step sqrt(x)).
//! ```
//!
//! The root of a step is replaced by a line below it, and so is friction where it is not convex. What is there for the sake of
//! the motion between the knots is left out.

use super::barrier_problem::{BarrierProblem, MeanBound, ThirdRow, positive};
use super::spline::Values;
use crate::constraint::Within;
use crate::problem::FeedProblem;

/// Gauss's points of the unit interval; both have the weight 1 / 2. Of a function that falls and bends like the inverse of a speed
/// from rest the rule gives a little less than the integral.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];

impl BarrierProblem {
    /// The relaxed problem; `most` are squared speeds at its knots beyond which no motion is looked at.
    pub fn relax(&mut self, problem: &FeedProblem, most: &[f64]) {
        self.relax_friction(most);
        let intervals = self.knots.intervals();
        self.means = vec![MeanBound::default(); intervals];
        self.inner.clear();
        self.thirds.clear();
        for k in 0..intervals {
            let h = self.knots.h[k];
            self.inner.push(positive(h));
            let rows =
                [Within::Start, Within::Middle, Within::End].map(|within| problem.jerk_rows(self.from + k, within));
            for id in 0..rows[0].len() {
                let (mut alpha, mut beta, mut gamma, mut step) = (0.0, 0.0, 0.0, 0.0);
                for part in GAUSS {
                    // Rows in between are interpolated.
                    let weights =
                        [(1.0 - part) * (1.0 - 2.0 * part), 4.0 * part * (1.0 - part), part * (2.0 * part - 1.0)];
                    let t = part * h;
                    for (rows, weight) in rows.iter().zip(weights) {
                        let row = &rows[id];
                        let weight = 0.5 * weight / row.limit;
                        // By the values at the start: x + 2 u t + w t^2, u + w t and w.
                        gamma += weight * row.gamma;
                        beta += weight * (row.beta + 2.0 * t * row.gamma);
                        alpha += weight * (row.alpha + t * row.beta + t * t * row.gamma);
                        // `x` is at most `limit / step`, up to which the root is above this line.
                        step += weight * row.limit * (row.step / row.limit).powf(1.5);
                    }
                }
                let row = ThirdRow { alpha, beta, gamma, step: 0.0, part: 1.0, at_most: 1.0, id: id as u32 };
                if step == 0.0 {
                    self.thirds.push(row);
                } else {
                    for sign in [1.0, -1.0] {
                        let (alpha, beta, gamma) = (sign * alpha, sign * beta, sign * gamma);
                        let (alpha, beta, gamma) = (alpha + step * h * h / 3.0, beta + step * h, gamma + step);
                        self.thirds.push(ThirdRow { alpha, beta, gamma, ..row });
                    }
                }
            }
            for place in [2 * k, 2 * k + 1] {
                self.inner_first[place + 1] = self.inner.len();
                self.thirds_first[place + 1] = self.thirds.len();
            }
        }
    }

    /// Friction is convex for one side of a row. For the other a line between rest and the most takes its place.
    fn relax_friction(&mut self, most: &[f64]) {
        let (mut points, mut first) = (Vec::with_capacity(self.points.len()), vec![0]);
        for (k, most) in most.iter().enumerate() {
            for row in &self.points[self.first[k]..self.first[k + 1]] {
                if row.c == 0.0 {
                    points.push(*row);
                    continue;
                }
                let (mut convex, mut straight) = (*row, *row);
                (straight.b, straight.c) = (row.b + row.c / most.sqrt(), 0.0);
                if row.c > 0.0 {
                    (convex.hi, straight.lo) = (f64::INFINITY, f64::NEG_INFINITY);
                } else {
                    (convex.lo, straight.hi) = (f64::NEG_INFINITY, f64::INFINITY);
                }
                points.extend([convex, straight]);
            }
            first.push(points.len());
        }
        (self.points, self.first) = (points, first);
    }

    /// The squared speeds at Gauss's points of interval `k`, with their derivatives by `x`, `u` and `w` at its start.
    #[inline(always)]
    pub fn gauss(&self, k: usize, values: &Values) -> [(f64, [f64; 3]); 2] {
        let (h, x, u, w) = (self.knots.h[k], values.x[k], values.u[k], values.w[k]);
        GAUSS.map(|part| {
            let t = part * h;
            (x + t * (2.0 * u + t * w), [1.0, 2.0 * t, t * t])
        })
    }

    /// The bound on jerk at a place, step aside: `1 / sqrt(x)`, or that on its mean.
    #[inline(always)]
    pub fn jerk_bound(&self, k: usize, end: usize, values: &Values) -> f64 {
        let Some(bound) = self.means.get(k) else { return values.y[end] };
        let of = |x: f64| bound.root / x.sqrt() - bound.fall * x;
        let [(first, _), (second, _)] = self.gauss(k, values);
        0.5 * (of(first) + of(second)) + bound.constant
    }

    /// By how much that falls with `x`, `u` and `w` at the place.
    #[inline(always)]
    pub fn jerk_falls(&self, k: usize, end: usize, values: &Values) -> [f64; 3] {
        let Some(bound) = self.means.get(k) else {
            let y = values.y[end];
            return [0.5 * y * y * y, 0.0, 0.0];
        };
        let fall = |x: f64| 0.5 / (x * x.sqrt());
        let mut falls = [0.0; 3];
        for (x, factors) in self.gauss(k, values) {
            let fall = 0.5 * (bound.root * fall(x) + bound.fall);
            falls.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += fall * factor);
        }
        falls
    }
}

#[cfg(test)]
mod tests {
    use super::super::barrier_problem::PointRow;
    use super::super::parts::prepare;
    use super::*;
    use crate::constraint::{JointTorque, PathConstraint, TangentialJerk};

    fn holds(rows: &[PointRow], u: f64, x: f64) -> bool {
        rows.iter().all(|row| {
            let value = row.a * u + row.b * x + row.c * x.sqrt();
            row.lo - 1e-12 <= value && value <= row.hi + 1e-12
        })
    }

    /// What takes the place of rows with friction holds wherever they hold, and it is convex: between two points where it holds, it
    /// holds as well.
    #[test]
    fn friction_is_relaxed_to_rows_that_are_convex() {
        let grid: Vec<f64> = (0..=20).map(|i| 0.05 * f64::from(i)).collect();
        let (ones, none) = (vec![1.0; grid.len()], vec![0.0; grid.len()]);
        for friction in [0.7, -0.7] {
            let friction = vec![friction; grid.len()];
            let torque = JointTorque::new(&ones, &none, &friction, &none, &[0.6]).expect("finite");
            let jerk = TangentialJerk::new(20.0).expect("positive");
            let limits: [&dyn PathConstraint; 2] = [&torque, &jerk];
            let problem = FeedProblem::between_points(&grid, &limits).expect("finite");
            let prepared = prepare(&problem).expect("moves");
            let part = &prepared.parts[0];
            let ends = [part.grid.start, part.grid.end];
            let before = BarrierProblem::new(&prepared.problem, ends, part.speeds, &prepared.fastest);
            let mut after = before.clone();
            let most = 0.8;
            after.relax_friction(&vec![most; before.first.len() - 1]);
            assert!(before.points.iter().any(|row| row.c != 0.0), "no friction");
            for k in 0..before.first.len() - 1 {
                let rows = &before.points[before.first[k]..before.first[k + 1]];
                let relaxed = &after.points[after.first[k]..after.first[k + 1]];
                let places = |i: u32| (f64::from(i % 31) / 10.0 - 1.5, most * f64::from(i / 31) / 30.0);
                let inside: Vec<_> = (0..31 * 31).map(places).filter(|&(u, x)| holds(relaxed, u, x)).collect();
                assert!((0..31 * 31).map(places).all(|(u, x)| !holds(rows, u, x) || holds(relaxed, u, x)), "point {k}");
                assert!(inside.len() > 100, "point {k}");
                for (i, &(u, x)) in inside.iter().enumerate().step_by(7) {
                    for &(other_u, other_x) in inside[i..].iter().step_by(5) {
                        let (u, x) = (0.5 * (u + other_u), 0.5 * (x + other_x));
                        assert!(holds(relaxed, u, x), "point {k}: {u} {x}");
                    }
                }
            }
        }
    }
}
