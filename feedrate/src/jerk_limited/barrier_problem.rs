//! One stretch of path between two stops as the interior-point method sees it: spline, rows in
//! units of their limits, caps.

use std::ops::Range;

use super::spline::{End, Knots, Values};
use crate::constraint::Within;
use crate::problem::FeedProblem;
use crate::row::{JerkRow, Row};

/// `lo <= a u + b x + c sqrt(x) <= hi`, for the time being with bounds that are `wider`.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointRow {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub lo: f64,
    pub hi: f64,
    /// Widening of the lower and the upper bound; taken back as the iterations go.
    pub wider: Sides,
}

/// `|alpha w + beta u + gamma x| <= 1 / sqrt(x) - step sqrt(x)`: a jerk row in units of the part of
/// its limit that is used. The right side is convex.
#[derive(Debug, Clone, Copy)]
pub(super) struct ThirdRow {
    pub alpha: f64,
    pub beta: f64,
    pub gamma: f64,
    pub step: f64,
    /// That part, at most 1; the rest is a margin for what happens between the knots.
    pub part: f64,
    /// That part is no more than this, which is what a check of the converged iterate asked for.
    pub at_most: f64,
    /// Index of the jerk row in the problem.
    pub id: u32,
}

/// `lo <= alpha w + beta u + gamma x <= hi`: an inner Bernstein coefficient of a row that is a
/// cubic on an interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct InnerRow {
    pub alpha: f64,
    pub beta: f64,
    pub gamma: f64,
    pub lo: f64,
    pub hi: f64,
    /// Widening of the lower and the upper bound; taken back as the iterations go.
    pub wider: Sides,
}

/// `root m + constant - fall x`, with `m` the mean of `1 / sqrt(x)` over an interval and `x` that of `x`: the bound on the mean of jerk.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeanBound {
    pub root: f64,
    pub constant: f64,
    pub fall: f64,
}

impl Default for MeanBound {
    /// The mean of `1 / sqrt(x)`.
    fn default() -> Self {
        Self { root: 1.0, constant: 0.0, fall: 0.0 }
    }
}

/// A stretch between two stops (or ends at a speed), ready to be iterated on.
#[derive(Debug, Clone)]
pub(super) struct BarrierProblem {
    /// True if the motion can be slowed down as a whole: from rest to rest, and every row, dropped ones too, holds at rest with slack on
    /// both sides.
    pub slows: bool,
    /// Grid point of the first knot.
    pub from: usize,
    pub knots: Knots,
    pub ends: [End; 2],
    /// Rows at knot `k` are `points[first[k]..first[k + 1]]`.
    pub points: Vec<PointRow>,
    pub first: Vec<usize>,
    /// Greatest `x` per knot, and by how much it is raised for the time being.
    pub caps: Vec<[f64; 2]>,
    /// By what the bounds `1 / sqrt(x)` on jerk are raised for the time being: this times
    /// `jerk_unit` of the knot.
    pub jerk_wider: f64,
    pub jerk_unit: Vec<f64>,
    /// Rows between the knots: place `2 k` is the start of interval `k`, place `2 k + 1` its end,
    /// and those of place `p` are `inner[inner_first[p]..inner_first[p + 1]]`.
    pub inner: Vec<InnerRow>,
    pub inner_first: Vec<usize>,
    /// Jerk rows, by place likewise.
    pub thirds: Vec<ThirdRow>,
    pub thirds_first: Vec<usize>,
    /// The part of the limits on jerk that may be used at all.
    pub most: f64,
    /// Of a relaxed problem, per interval: the one bound on the mean of jerk over it. None where jerk is bounded at both ends.
    pub means: Vec<MeanBound>,
    /// Jerk in the rest interval at the first and at the last knot: `|r x| <= 1 / sqrt(x)`.
    pub rest: [f64; 2],
    /// The problem with the rows that were dropped.
    pub whole: Option<Box<Whole>>,
}

/// A problem with all its rows, of which some were dropped.
#[derive(Debug, Clone)]
pub(super) struct Whole {
    pub problem: BarrierProblem,
    /// For every row whether it was left, in their order.
    pub left: Vec<bool>,
}

/// Lower and upper side of a row.
pub(super) type Sides = [f64; 2];

/// Returns true if a row holds whatever the motion: that of a joint that stands still. It has no
/// inside where its limit is 0.
pub(super) fn is_nothing(row: &Row) -> bool {
    row.a == 0.0 && row.b == 0.0 && row.c == 0.0 && row.lo <= row.d && row.d <= row.hi
}

/// The middle Bernstein coefficient of an interval of length `h` is not negative: `x(s)` is positive between the knots, too.
pub(super) fn positive(h: f64) -> InnerRow {
    InnerRow { alpha: 0.0, beta: h, gamma: 1.0, lo: 0.0, hi: f64::INFINITY, wider: [0.0; 2] }
}

impl PointRow {
    /// Derivative by `x`.
    pub fn slope(&self, x: f64) -> f64 {
        if self.c == 0.0 { self.b } else { self.b + 0.5 * self.c / x.sqrt() }
    }
}

impl ThirdRow {
    /// Lets so large a part of the limit be used.
    pub fn use_part(&mut self, part: f64) {
        let factor = self.part / part;
        self.alpha *= factor;
        self.beta *= factor;
        self.gamma *= factor;
        self.step *= factor;
        self.part = part;
    }
}

impl BarrierProblem {
    /// The stretch from grid point `from` to grid point `to`, at rest at an end unless a speed is
    /// given for it.
    ///
    /// `fastest` are squared speeds at all grid points that the solution is not expected to exceed
    /// by much.
    pub fn new(problem: &FeedProblem, [from, to]: [usize; 2], speeds: [f64; 2], fastest: &[f64]) -> Self {
        let end = |v: f64, u: f64, h: f64| if v > 0.0 { End::Moving { x: v * v, u } } else { End::Rest { h } };
        let ends = [end(speeds[0], problem.a_start(), problem.h(from)), end(speeds[1], 0.0, problem.h(to - 1))];
        let (a, b) = (from + ends[0].rest_intervals(), to - ends[1].rest_intervals());
        let knots = Knots::new((a..b).map(|k| problem.h(k)).collect());
        let mut barrier_problem = Self {
            slows: false,
            from: a,
            knots,
            ends,
            points: Vec::with_capacity((b - a + 1) * problem.rows(a).len()),
            first: Vec::with_capacity(b - a + 2),
            caps: Vec::with_capacity(b - a + 1),
            // Those of the speed too: five, one that it is positive, one for a cap.
            inner: Vec::with_capacity((b - a) * (2 * problem.rows(a).len() + 7)),
            inner_first: vec![0],
            thirds: Vec::with_capacity(2 * (b - a) * problem.jerk_rows(a, Within::Start).len()),
            thirds_first: vec![0],
            jerk_wider: 0.0,
            jerk_unit: vec![0.0; b - a + 1],
            most: 1.0,
            means: Vec::new(),
            rest: [0.0; 2],
            whole: None,
        };
        barrier_problem.first.push(0);
        for i in a..=b {
            // Speed and acceleration at a moving end are given: the planner has checked them,
            // nothing is left to decide.
            let given = matches!((&ends, i), ([End::Moving { .. }, _], i) if i == a)
                || matches!((&ends, i), ([_, End::Moving { .. }], i) if i == b);
            if !given {
                barrier_problem.points.extend(problem.rows(i).iter().filter(|row| !is_nothing(row)).map(|row| {
                    let (lo, hi) = (row.lo - row.d, row.hi - row.d);
                    PointRow { a: row.a, b: row.b, c: row.c, lo, hi, wider: [0.0; 2] }
                }));
            }
            barrier_problem.first.push(barrier_problem.points.len());
            barrier_problem.caps.push([if given { f64::INFINITY } else { problem.x_max(i) }, 0.0]);
        }
        for k in a..b {
            for within in [Within::Start, Within::End] {
                barrier_problem.inner.extend(problem.inner_rows(k, within).filter(|row| !row.is_nothing()).map(
                    |row| {
                        let crate::problem::InnerRow { alpha, beta, gamma, lo, hi, .. } = row;
                        InnerRow { alpha, beta, gamma, lo, hi, wider: [0.0; 2] }
                    },
                ));
                if within == Within::Start {
                    barrier_problem.push_speed(problem, k, fastest);
                }
                barrier_problem.inner_first.push(barrier_problem.inner.len());
                barrier_problem.thirds.extend(problem.jerk_rows(k, within).iter().zip(0..).map(|(row, id)| ThirdRow {
                    alpha: row.alpha / row.limit,
                    beta: row.beta / row.limit,
                    gamma: row.gamma / row.limit,
                    step: row.step / row.limit,
                    part: 1.0,
                    at_most: 1.0,
                    id,
                }));
                barrier_problem.thirds_first.push(barrier_problem.thirds.len());
            }
        }
        barrier_problem.set_rest(problem, [from, to - 1]);
        let rests = barrier_problem.ends.iter().all(|end| matches!(end, End::Rest { .. }));
        barrier_problem.slows =
            rests && barrier_problem.points.iter().all(|row| row.lo < 0.0 && 0.0 < row.hi && row.c == 0.0);
        barrier_problem
    }

    /// Jerk in the rest intervals `at`.
    fn set_rest(&mut self, problem: &FeedProblem, at: [usize; 2]) {
        for (i, k) in at.into_iter().enumerate() {
            let End::Rest { h } = self.ends[i] else { continue };
            // At the knot u = 2 x / 3h away from rest and w = x / 4.5 h^2; at rest only the
            // constant jerk itself is left.
            let (at_rest, at_knot) = if i == 0 { (Within::Start, Within::End) } else { (Within::End, Within::Start) };
            let u = if i == 0 { 2.0 / (3.0 * h) } else { -2.0 / (3.0 * h) };
            let w = 1.0 / (4.5 * h * h);
            let worst = |rest: f64, row: &JerkRow, u: f64, x: f64| {
                rest.max(((row.alpha * w + row.beta * u + row.gamma * x) / row.limit).abs())
            };
            let rest = problem.jerk_rows(k, at_rest).iter().fold(0.0, |rest, row| worst(rest, row, 0.0, 0.0));
            let rest = problem.jerk_rows(k, Within::Middle).iter().fold(rest, |rest, row| {
                // sqrt(x) grows with s^(2/3), u with s^(1/3).
                worst(rest, row, u * 0.5, 0.25)
            });
            self.rest[i] = problem.jerk_rows(k, at_knot).iter().fold(rest, |rest, row| worst(rest, row, u, 1.0));
        }
    }

    /// Speed inside interval `k`, by the values at its start.
    fn push_speed(&mut self, problem: &FeedProblem, k: usize, fastest: &[f64]) {
        let h = problem.h(k);
        self.inner.push(positive(h));
        let mut push = |[of_start, of_middle, of_end]: [f64; 3], hi: f64| {
            let (beta, alpha) = (h * (of_middle + 2.0 * of_end), h * h * of_end);
            let gamma = of_start + of_middle + of_end;
            self.inner.push(InnerRow { alpha, beta, gamma, lo: f64::NEG_INFINITY, hi, wider: [0.0; 2] });
        };
        // Well above what can bind.
        let most = 2.0 * fastest[k].max(fastest[k + 1]);
        let largest = problem.speed_bound(k).coefficients.iter().copied().fold(0.0, f64::max);
        if largest * most > 1.0 {
            problem.speed_rows(k).into_iter().for_each(|weights| push(weights, 1.0));
        }
        // A cap from elsewhere.
        let middle = problem.middle_x_max(k);
        if middle < most && problem.is_capped_within(k) {
            push([0.25, 0.5, 0.25], middle);
        }
    }

    /// Every place between the knots: its interval, the knot at it, its inner rows and its jerk
    /// rows.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize, Range<usize>, Range<usize>)> + '_ {
        (0..2 * self.knots.intervals()).map(|p| {
            let inner = self.inner_first[p]..self.inner_first[p + 1];
            (p / 2, p / 2 + p % 2, inner, self.thirds_first[p]..self.thirds_first[p + 1])
        })
    }

    /// The greatest factors on `x` (and `u`, `w`) at which every row and cap is kept, friction
    /// aside, and every jerk row.
    pub fn largest_scales(&self, values: &Values) -> Sides {
        let Values { x, u, w, .. } = values;
        let mut scale = f64::INFINITY;
        for k in 0..x.len() {
            scale = scale.min(self.caps[k][0] / x[k]);
            for row in &self.points[self.first[k]..self.first[k + 1]] {
                let value = row.a * u[k] + row.b * x[k];
                let bound = if value > 0.0 { row.hi } else { row.lo };
                if value != 0.0 {
                    scale = scale.min(bound / value);
                }
            }
        }
        // The greatest square of a jerk in units of its limit; jerk grows with the power 3/2.
        let mut square = 0.0_f64;
        for (k, end, inner, thirds) in self.places() {
            for row in &self.inner[inner] {
                let value = row.alpha * w[k] + row.beta * u[end] + row.gamma * x[end];
                let bound = if value > 0.0 { row.hi } else { row.lo };
                if value != 0.0 {
                    scale = scale.min(bound / value);
                }
            }
            for row in &self.thirds[thirds] {
                let value = row.alpha * w[k] + row.beta * u[end] + row.gamma * x[end];
                square = square.max(value * value * x[end]);
                if row.step > 0.0 {
                    // The step grows with the power 1.
                    let sum = value.abs() * x[end].sqrt() + row.step * x[end];
                    square = square.max(if sum > 1.0 { sum.powi(3) } else { sum * sum });
                }
            }
        }
        for (rest, x) in self.rest.iter().zip([x[0], x[x.len() - 1]]) {
            square = square.max(rest * rest * x * x * x);
        }
        [scale, 1.0 / square.cbrt()]
    }

    /// Lowers all bounds by the factor `x`, `u` and `w` would be lowered by.
    pub fn tighten(&mut self, factor: f64) {
        // A bound that standing still breaks moves the other way.
        let part = 1.0 - factor;
        let inwards = |bound: f64, sign: f64| if bound.is_finite() { bound + sign * part * bound.abs() } else { bound };
        let tight = |lo: f64, hi: f64| (inwards(lo, 1.0), inwards(hi, -1.0));
        for row in &mut self.points {
            (row.lo, row.hi) = tight(row.lo, row.hi);
        }
        for row in &mut self.inner {
            (row.lo, row.hi) = tight(row.lo, row.hi);
        }
        self.caps.iter_mut().for_each(|cap| cap[0] *= factor);
        // Jerk grows with the power 3/2.
        let up = factor.powf(-1.5);
        for row in &mut self.thirds {
            (row.alpha, row.beta, row.gamma) = (up * row.alpha, up * row.beta, up * row.gamma);
            // More than its power 1 asks for.
            row.step *= up;
            row.part /= up;
        }
        self.most /= up;
        self.rest = self.rest.map(|rest| up * rest);
    }

    /// Returns true if the values are strictly inside all bounds as they are widened at present.
    pub fn is_inside(&self, values: &Values) -> bool {
        let mut inside = values.x.iter().chain(&values.middle).all(|&x| x > 0.0);
        self.each_slack(values, |_, slacks| inside &= slacks[0] > 0.0 && slacks[1] > 0.0);
        inside
    }

    /// Takes back the given part of what bounds are widened by; the largest widening left, in units
    /// of its bound.
    pub fn narrow(&mut self, part: f64) -> f64 {
        let keep = 1.0 - part;
        let mut largest = 0.0_f64;
        let mut take = |wider: &mut f64, bound: f64| {
            *wider *= keep;
            // Round-off of the bound itself.
            if *wider <= 1e-15 * bound.abs() {
                *wider = 0.0;
            } else {
                largest = largest.max(*wider / bound.abs());
            }
        };
        for row in &mut self.points {
            take(&mut row.wider[0], row.lo);
            take(&mut row.wider[1], row.hi);
        }
        for row in &mut self.inner {
            take(&mut row.wider[0], row.lo);
            take(&mut row.wider[1], row.hi);
        }
        for [cap, wider] in &mut self.caps {
            take(wider, *cap);
        }
        take(&mut self.jerk_wider, 1.0);
        largest
    }
}
