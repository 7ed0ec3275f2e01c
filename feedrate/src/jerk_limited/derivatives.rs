//! The duration and the rows with their multipliers: values, first and second derivatives.

use super::barrier_problem::BarrierProblem;
use super::interior_point::Solver;
use super::side::lesser;
use super::spline::{AtKnot, End, OnInterval, Values, gradient_to_coefficients, tie_gradient};

/// Weighted sums of products of the factors of `x`, `u` and `w`.
#[derive(Debug, Clone, Copy, Default)]
struct Products {
    xx: f64,
    xu: f64,
    uu: f64,
    xw: f64,
    uw: f64,
    ww: f64,
}

impl Products {
    fn add(&mut self, weight: f64, [gamma, beta, alpha]: [f64; 3]) {
        let (x, u, w) = (weight * gamma, weight * beta, weight * alpha);
        self.xx += x * gamma;
        self.xu += x * beta;
        self.xw += x * alpha;
        self.uu += u * beta;
        self.uw += u * alpha;
        self.ww += w * alpha;
    }

    /// The products of two sets of factors both ways round.
    fn add_pair(&mut self, [ax, au, aw]: [f64; 3], [bx, bu, bw]: [f64; 3]) {
        self.xx += 2.0 * ax * bx;
        self.xu += ax * bu + au * bx;
        self.uu += 2.0 * au * bu;
        self.xw += ax * bw + aw * bx;
        self.uw += au * bw + aw * bu;
        self.ww += 2.0 * aw * bw;
    }
}

impl Solver {
    /// The duration plus all rows times their multipliers, at the current values, s.
    pub fn with_rows(&self, barrier_problem: &BarrierProblem) -> f64 {
        let mut sum = self.duration(barrier_problem);
        barrier_problem.each_slack(&self.values, |i, slacks| {
            // A bound at infinity has the multiplier 0.
            self.barrier[i]
                .iter()
                .zip(slacks)
                .for_each(|(side, slack)| sum -= side.multiplier * lesser(slack, f64::MAX));
        });
        sum
    }

    /// The same less what it may fall from here on a straight line to coefficients between 0 and `most`, s. Where it is convex
    /// it is nowhere less.
    pub fn least(&mut self, barrier_problem: &BarrierProblem, most: &[f64]) -> f64 {
        let sum = self.with_rows(barrier_problem);
        self.at.clear();
        self.at.resize(self.values.x.len(), AtKnot::default());
        self.on.clear();
        self.on.resize(self.values.middle.len(), OnInterval::default());
        self.barrier.iter_mut().flatten().for_each(|side| (side.change, side.inverse) = (1.0, 0.0));
        self.objective_gradient(barrier_problem);
        self.barrier_gradient(barrier_problem, 0.0, 1.0);
        gradient_to_coefficients(&barrier_problem.knots, &self.at, &self.on, &mut self.step);
        tie_gradient(barrier_problem.ends, barrier_problem.ratios(), &mut self.step);
        let fall = |((slope, c), most): ((f64, f64), f64)| if slope > 0.0 { slope * c } else { -slope * (most - c) };
        let (slopes, c) = (self.step.iter().copied(), self.c.iter().copied());
        sum - slopes.zip(c).zip(most.iter().copied()).map(fall).sum::<f64>()
    }

    /// Duration of the current iterate, by Simpson's rule on every interval; that of a relaxed problem by Gauss's.
    pub fn duration(&self, barrier_problem: &BarrierProblem) -> f64 {
        let Values { y, middle_y, .. } = &self.values;
        let on_interval = |(k, h): (usize, &f64)| {
            if barrier_problem.means.is_empty() {
                h / 6.0 * (y[k] + 4.0 * middle_y[k] + y[k + 1])
            } else {
                barrier_problem.gauss(k, &self.values).into_iter().map(|(x, _)| 0.5 * h / x.sqrt()).sum()
            }
        };
        let inner: f64 = barrier_problem.knots.h.iter().enumerate().map(on_interval).sum();
        let rest = |end: End, y: f64| if let End::Rest { h } = end { 3.0 * h * y } else { 0.0 };
        inner + rest(barrier_problem.ends[0], y[0]) + rest(barrier_problem.ends[1], y[y.len() - 1])
    }

    /// Second derivatives of duration plus barriers by the values at knots and on intervals.
    pub fn assemble(&mut self, barrier_problem: &BarrierProblem) {
        let Values { x, y, middle_y, .. } = &self.values;
        let [caps, inner, thirds, rest] = barrier_problem.offsets();
        self.at.clear();
        self.at.resize(x.len(), AtKnot::default());
        self.on.clear();
        self.on.resize(middle_y.len(), OnInterval::default());
        let time = second_derivative_of_time;
        for (k, h) in barrier_problem.knots.h.iter().enumerate().filter(|_| barrier_problem.means.is_empty()) {
            self.at[k].xx += time(h / 6.0, y[k]);
            self.at[k + 1].xx += time(h / 6.0, y[k + 1]);
            self.on[k].mm = time(4.0 / 6.0 * h, middle_y[k]);
        }
        for (i, end) in [0, x.len() - 1].into_iter().enumerate() {
            if let End::Rest { h } = barrier_problem.ends[i] {
                self.at[end].xx += time(3.0 * h, y[end]);
            }
            let slope = barrier_problem.rest[i] + 0.5 * cube(y[end]);
            self.at[end].xx += self.barrier[rest + i][1].weight() * slope * slope;
        }
        for k in 0..x.len() {
            let at = &mut self.at[k];
            for i in barrier_problem.first[k]..barrier_problem.first[k + 1] {
                let row = &barrier_problem.points[i];
                let b = row.slope(x[k]);
                let weight = self.barrier[i][0].weight() + self.barrier[i][1].weight();
                at.xx += weight * b * b;
                at.xu += weight * b * row.a;
                at.uu += weight * row.a * row.a;
            }
            at.xx += self.barrier[caps + k][1].weight();
        }
        for (place, (k, end, inner_rows, third_rows)) in barrier_problem.places().enumerate() {
            let falls = barrier_problem.jerk_falls(k, end, &self.values);
            let mut sum = Products::default();
            for (row, [low, high]) in
                barrier_problem.inner[inner_rows.clone()].iter().zip(&self.barrier[inner + inner_rows.start..])
            {
                sum.add(low.weight() + high.weight(), [row.gamma, row.beta, row.alpha]);
            }
            let rise = 0.5 * y[end];
            // Sums of weights, of their differences between both sides times the row, and of what the step adds.
            let (mut weights, mut differences, mut stepped) = (0.0, [0.0; 3], [0.0; 3]);
            for (row, [low, high]) in
                barrier_problem.thirds[third_rows.clone()].iter().zip(&self.barrier[thirds + third_rows.start..])
            {
                let (low, high) = (low.weight(), high.weight());
                let factors = [row.gamma, row.beta, row.alpha];
                sum.add(low + high, factors);
                let difference = high - low;
                weights += low + high;
                differences.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += difference * factor);
                if row.step > 0.0 {
                    let step = rise * row.step;
                    stepped.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += step * difference * factor);
                    stepped[0] += step * (falls[0] + 0.5 * step) * (low + high);
                }
            }
            if place % 2 == 0 && !barrier_problem.means.is_empty() {
                let h = 0.5 * barrier_problem.knots.h[k];
                barrier_problem
                    .gauss(k, &self.values)
                    .into_iter()
                    .for_each(|(x, factors)| sum.add(time(h, 1.0 / x.sqrt()), factors));
            }
            sum.add(weights, falls);
            sum.add_pair(falls, differences);
            sum.add_pair([1.0, 0.0, 0.0], stepped);
            let at = &mut self.at[end];
            at.xx += sum.xx;
            at.xu += sum.xu;
            at.uu += sum.uu;
            let on = &mut self.on[k];
            let cross = if place % 2 == 0 { &mut on.start } else { &mut on.end };
            cross[0] += sum.xw;
            cross[1] += sum.uw;
            on.ww += sum.ww;
        }
    }

    /// First derivatives of the duration.
    pub fn objective_gradient(&mut self, barrier_problem: &BarrierProblem) {
        let Values { y, middle_y, .. } = &self.values;
        let time = |h: f64, y: f64| -0.5 * h * cube(y);
        self.at.iter_mut().for_each(|at| (at.x, at.u) = (0.0, 0.0));
        self.on.iter_mut().for_each(|on| (on.m, on.w) = (0.0, 0.0));
        for (k, h) in barrier_problem.knots.h.iter().enumerate() {
            if barrier_problem.means.is_empty() {
                self.at[k].x += time(h / 6.0, y[k]);
                self.at[k + 1].x += time(h / 6.0, y[k + 1]);
                self.on[k].m = time(4.0 / 6.0 * h, middle_y[k]);
            } else {
                for (x, [by_x, by_u, by_w]) in barrier_problem.gauss(k, &self.values) {
                    let slope = time(0.5 * h, 1.0 / x.sqrt());
                    self.at[k].x += slope * by_x;
                    self.at[k].u += slope * by_u;
                    self.on[k].w += slope * by_w;
                }
            }
        }
        for (i, end) in [0, y.len() - 1].into_iter().enumerate() {
            if let End::Rest { h } = barrier_problem.ends[i] {
                self.at[end].x += time(3.0 * h, y[end]);
            }
        }
    }

    /// Adds the first derivatives of the barriers at `mu`, with a part of the predictor's second-order terms.
    pub fn barrier_gradient(&mut self, barrier_problem: &BarrierProblem, mu: f64, part: f64) {
        let Values { x, y, .. } = &self.values;
        let [caps, inner, thirds, rest] = barrier_problem.offsets();
        for (i, end) in [0, x.len() - 1].into_iter().enumerate() {
            let slope = barrier_problem.rest[i] + 0.5 * cube(y[end]);
            self.at[end].x += slope
                * self.barrier[rest + i][1].force(
                    mu,
                    part,
                    barrier_problem.jerk_wider * barrier_problem.jerk_unit[end],
                );
        }
        for k in 0..x.len() {
            let at = &mut self.at[k];
            for i in barrier_problem.first[k]..barrier_problem.first[k + 1] {
                let row = &barrier_problem.points[i];
                let [low, high] = &self.barrier[i];
                let force = high.force(mu, part, row.wider[1]) - low.force(mu, part, row.wider[0]);
                at.x += force * row.slope(x[k]);
                at.u += force * row.a;
            }
            at.x += self.barrier[caps + k][1].force(mu, part, barrier_problem.caps[k][1]);
        }
        for (k, end, inner_rows, third_rows) in barrier_problem.places() {
            let (mut sx, mut su, mut sw, mut forces, mut stepped) = (0.0, 0.0, 0.0, 0.0, 0.0);
            let sides = &self.barrier[inner + inner_rows.start..];
            for (row, [low, high]) in barrier_problem.inner[inner_rows].iter().zip(sides) {
                let force = high.force(mu, part, row.wider[1]) - low.force(mu, part, row.wider[0]);
                sx += force * row.gamma;
                su += force * row.beta;
                sw += force * row.alpha;
            }
            let y = y[end];
            let falls = barrier_problem.jerk_falls(k, end, &self.values);
            let taken = barrier_problem.jerk_wider * barrier_problem.jerk_unit[end];
            let sides = &self.barrier[thirds + third_rows.start..];
            for (row, [low, high]) in barrier_problem.thirds[third_rows].iter().zip(sides) {
                let (low, high) = (low.force(mu, part, taken), high.force(mu, part, taken));
                sx += (high - low) * row.gamma;
                su += (high - low) * row.beta;
                sw += (high - low) * row.alpha;
                forces += high + low;
                stepped += 0.5 * y * row.step * (high + low);
            }
            self.at[end].x += sx + falls[0] * forces + stepped;
            self.at[end].u += su + falls[1] * forces;
            self.on[k].w += sw + falls[2] * forces;
        }
    }
}

/// Second derivative of `h y` with `y = x^(-1/2)`, the time over the length `h`, by `x`.
fn second_derivative_of_time(h: f64, y: f64) -> f64 {
    0.75 * h * cube(y) * (y * y)
}

fn cube(y: f64) -> f64 {
    y * y * y
}
