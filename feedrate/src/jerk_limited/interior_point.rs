//! Primal-dual interior-point iterations for the fastest `x(s)` on a stretch of path.
//!
//! Every row is a barrier with a multiplier; the Newton matrix by spline coefficients has two
//! diagonals beside the main one, so an iteration costs two passes over the rows and one over the
//! coefficients.

use super::band::Pentadiagonal;
use super::barrier_problem::{BarrierProblem, Sides};
use super::outcome::{Goal, Outcome};
use super::spline::{
    AtKnot, End, OnInterval, Values, gradient_to_coefficients, tie_gradient, tie_matrix, to_coefficients,
};
use crate::problem::FeedProblem;

/// One side of a row: a multiplier, its change, and the inverse of the slack (0 for a bound at
/// infinity).
#[derive(Debug, Clone, Copy, Default)]
struct Side {
    multiplier: f64,
    /// While a direction is sought, the predictor's second-order term in units of the multiplier;
    /// then the change to take.
    change: f64,
    inverse: f64,
}

impl Side {
    fn weight(&self) -> f64 {
        self.multiplier * self.inverse
    }

    /// The barrier's force at `mu`: `mu / slack`, the second-order term, and what narrowing the
    /// bound adds.
    fn force(&self, mu: f64, wider: f64) -> f64 {
        mu * self.inverse + self.multiplier * (self.change + self.inverse * wider)
    }
}

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

/// Iterates and their scratch space.
#[derive(Debug, Default)]
pub(super) struct Solver {
    /// Spline coefficients: the solution.
    pub c: Vec<f64>,
    pub values: Values,
    delta: Values,
    at: Vec<AtKnot>,
    on: Vec<OnInterval>,
    matrix: Pentadiagonal,
    step: Vec<f64>,
    /// All rows: those at the knots, caps, jerk rows, rest intervals.
    barrier: Vec<[Side; 2]>,
}

/// Sums over all sides.
#[derive(Debug, Clone, Copy)]
struct Sums {
    /// Sum of multiplier times slack.
    complementarity: f64,
    count: f64,
    /// Smallest slack found; not positive means outside.
    least: f64,
}

/// Part of the way to the boundary that a step may go.
const STEP_FRACTION: f64 = 0.95;

/// Relative gap the multipliers start with.
const START_GAP: f64 = 0.3;

/// Relative gap from which on margins are set.
const MARGINS_FROM: f64 = 0.1;

/// Relative gap below which rows far from their bounds are dropped.
const DROP_BELOW: f64 = 0.04;

/// The lesser of two numbers, neither of which is NaN: cheaper than `f64::min`.
fn lesser(x: f64, y: f64) -> f64 {
    if x < y { x } else { y }
}

/// Gain of the last step at which the iterations end, in units of the tolerance: the next one gains
/// a small part of that.
const LAST_STEP_GAIN: f64 = 10.0;

/// Gap that is aimed at, in units of what the last step gained.
const AHEAD_GAP: f64 = 0.1;

/// Many times what is needed.
const MOST_ITERATIONS: usize = 100;

impl Solver {
    /// Minimises the duration from coefficients `c` that keep the ends and are strictly inside all
    /// bounds as they are widened at present. With `drop_distant`, rows far from their bounds are
    /// left out once the shape shows.
    pub fn minimise(
        &mut self,
        problem: &FeedProblem,
        barrier_problem: &mut BarrierProblem,
        c: Vec<f64>,
        goal: Goal,
        drop_distant: bool,
    ) -> Outcome {
        self.c = c;
        self.barrier.clear();
        self.barrier.resize(barrier_problem.offsets()[3] + 2, [Side::default(); 2]);
        let start = f64::INFINITY;
        let wider = barrier_problem.narrow(0.0);
        let mut outcome = Outcome { iterations: 0, gap: start, ahead: start, wider, tolerance: goal.tolerance };
        let mut before = f64::NAN;
        let mut steps = [0.0; 2];
        let mut to_drop = drop_distant;
        while outcome.iterations < MOST_ITERATIONS {
            barrier_problem.knots.evaluate(&self.c, &mut self.values);
            // Once the shape shows, and not so late that every change would have to be caught up
            // with.
            let shown = outcome.gap.max(outcome.ahead);
            if shown < MARGINS_FROM && outcome.gap > 4.0 * outcome.tolerance {
                barrier_problem.set_margins(problem, &self.values);
            }
            if to_drop && shown < DROP_BELOW && outcome.gap > outcome.tolerance {
                to_drop = false;
                self.drop_distant(barrier_problem);
            }
            let mut sums = self.slacks(barrier_problem, steps[1]);
            if !(sums.least > 0.0) {
                // Only friction can do this: its rows are not straight. Back half of the way.
                if !(steps[0] > 1e-6) {
                    // Back to the iterate before, which was inside.
                    self.c.iter_mut().zip(&self.step).for_each(|(c, d)| *c -= steps[0] * d);
                    break;
                }
                steps = [0.5 * steps[0], 0.0];
                self.c.iter_mut().zip(&self.step).for_each(|(c, d)| *c -= steps[0] * d);
                outcome.iterations += 1;
                continue;
            }
            let duration = self.duration(barrier_problem);
            outcome.tolerance = goal.at(duration);
            let tolerance = outcome.tolerance;
            let centred = outcome.gap == f64::INFINITY;
            if centred {
                sums.complementarity = START_GAP * duration;
                self.centre(sums.complementarity / sums.count);
            }
            outcome.gap = sums.complementarity / duration;
            // The multipliers alone tell nothing while steps are short: then they do not fit the
            // iterate yet.
            outcome.ahead = if centred { f64::INFINITY } else { (before / duration - 1.0).abs() / steps[0] };
            before = duration;
            if outcome.gap < tolerance && outcome.ahead < LAST_STEP_GAIN * tolerance && outcome.wider < tolerance {
                break;
            }
            // While the duration falls fast, complementarity must not fall faster, or the iterates creep along the bounds.
            let least = if outcome.ahead.is_finite() { AHEAD_GAP * outcome.ahead * duration / sums.count } else { 0.0 };
            let mu = [sums.complementarity / sums.count, least];
            steps = self.direction(barrier_problem, mu, outcome.wider > 0.0, centred);
            self.c.iter_mut().zip(&self.step).for_each(|(c, d)| *c += steps[0] * d);
            if outcome.wider > 0.0 {
                outcome.wider = barrier_problem.narrow(steps[0]);
            }
            outcome.iterations += 1;
        }
        barrier_problem.knots.evaluate(&self.c, &mut self.values);
        outcome
    }

    /// The row that stands most against taking back what bounds are widened by.
    pub fn binding(&self, barrier_problem: &BarrierProblem) -> Option<usize> {
        let mut most = (0.0, None);
        barrier_problem.each_widening(|i, wider| {
            let Some(sides) = self.barrier.get(i) else { return };
            let against = sides[0].multiplier * wider[0] + sides[1].multiplier * wider[1];
            if against > most.0 {
                most = (against, Some(i));
            }
        });
        most.1
    }

    /// Multipliers of both sides of a row.
    pub fn multipliers(&self, i: usize) -> Sides {
        self.barrier[i].map(|side| side.multiplier)
    }

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
        self.barrier_gradient(barrier_problem, 0.0);
        gradient_to_coefficients(&barrier_problem.knots, &self.at, &self.on, &mut self.step);
        tie_gradient(barrier_problem.ends, barrier_problem.ratios(), &mut self.step);
        let fall = |((slope, c), most): ((f64, f64), f64)| if slope > 0.0 { slope * c } else { -slope * (most - c) };
        let (slopes, c) = (self.step.iter().copied(), self.c.iter().copied());
        sum - slopes.zip(c).zip(most.iter().copied()).map(fall).sum::<f64>()
    }

    fn drop_distant(&mut self, barrier_problem: &mut BarrierProblem) {
        let (mut read, mut write) = (0, 0);
        let barrier = &mut self.barrier;
        barrier_problem.drop_distant(&self.values, |stays| {
            if stays {
                barrier[write] = barrier[read];
                write += 1;
            }
            read += 1;
        });
        barrier.truncate(write);
    }

    /// Duration of the current iterate, by Simpson's rule on every interval; that of a relaxed problem by Gauss's.
    pub fn duration(&self, barrier_problem: &BarrierProblem) -> f64 {
        let Values { x, middle, .. } = &self.values;
        let on_interval = |(k, h): (usize, &f64)| {
            if barrier_problem.means.is_empty() {
                h / 6.0 * (1.0 / x[k].sqrt() + 4.0 / middle[k].sqrt() + 1.0 / x[k + 1].sqrt())
            } else {
                barrier_problem.gauss(k, &self.values).into_iter().map(|(x, _)| 0.5 * h / x.sqrt()).sum()
            }
        };
        let inner: f64 = barrier_problem.knots.h.iter().enumerate().map(on_interval).sum();
        let rest = |end: End, x: f64| if let End::Rest { h } = end { 3.0 * h / x.sqrt() } else { 0.0 };
        inner + rest(barrier_problem.ends[0], x[0]) + rest(barrier_problem.ends[1], x[x.len() - 1])
    }

    /// Takes the last step of the multipliers and evaluates the slacks anew.
    fn slacks(&mut self, barrier_problem: &BarrierProblem, dual_step: f64) -> Sums {
        let mut sums = Sums { complementarity: 0.0, count: 0.0, least: f64::INFINITY };
        if self.values.x.iter().chain(&self.values.middle).any(|&x| !(x > 0.0)) {
            return Sums { least: 0.0, ..sums };
        }
        let barrier = &mut self.barrier;
        barrier_problem.each_slack(&self.values, |i, slacks| {
            for (side, slack) in barrier[i].iter_mut().zip(slacks) {
                side.multiplier += dual_step * side.change;
                side.change = 0.0;
                side.inverse = 1.0 / slack;
                // A bound at infinity has the multiplier 0.
                sums.complementarity += side.multiplier * lesser(slack, f64::MAX);
                sums.count += f64::from(u8::from(slack < f64::INFINITY));
                // Written so that NaN is outside.
                if !(slack > sums.least) {
                    sums.least = slack;
                }
            }
        });
        sums
    }

    /// Puts all multipliers on the central path.
    fn centre(&mut self, mu: f64) {
        self.barrier.iter_mut().flatten().for_each(|side| side.multiplier = mu * side.inverse);
    }

    /// Mehrotra's predictor and corrector, into `self.step`; how far to go along it for
    /// coefficients and multipliers.
    fn direction(
        &mut self,
        barrier_problem: &BarrierProblem,
        [mu, least]: [f64; 2],
        wider: bool,
        centred: bool,
    ) -> Sides {
        self.assemble(barrier_problem);
        to_coefficients(&barrier_problem.knots, &self.at, &self.on, &mut self.matrix);
        tie_matrix(barrier_problem.ends, barrier_problem.ratios(), &mut self.matrix);
        self.matrix.factor();
        let mut mu = mu;
        // On the central path there is nothing to predict.
        if !centred {
            self.objective_gradient(barrier_problem);
            if wider {
                self.barrier_gradient(barrier_problem, 0.0);
            }
            self.solve(barrier_problem);
            let [slack, multiplier] = self.predict(barrier_problem);
            let far = slack.min(multiplier);
            let left = 1.0 - far;
            mu = (mu * (left * left * left).max(1e-3)).max(least);
            // Second-order terms of a step that cannot be taken mislead.
            let part = lesser(2.0 * far, 1.0);
            self.barrier.iter_mut().flatten().for_each(|side| side.change *= part);
        }
        self.objective_gradient(barrier_problem);
        self.barrier_gradient(barrier_problem, mu);
        self.solve(barrier_problem);
        self.changes(barrier_problem, mu)
    }

    /// Newton's step from the first derivatives.
    fn solve(&mut self, barrier_problem: &BarrierProblem) {
        let ratios = barrier_problem.ratios();
        gradient_to_coefficients(&barrier_problem.knots, &self.at, &self.on, &mut self.step);
        tie_gradient(barrier_problem.ends, ratios, &mut self.step);
        self.step.iter_mut().for_each(|d| *d = -*d);
        self.matrix.solve(&mut self.step);
        let n = self.step.len();
        self.step[0] = self.step[1] / ratios[0];
        self.step[n - 1] = self.step[n - 2] / ratios[1];
        barrier_problem.knots.evaluate(&self.step, &mut self.delta);
    }

    /// Second derivatives of duration plus barriers by the values at knots and on intervals.
    fn assemble(&mut self, barrier_problem: &BarrierProblem) {
        let Values { x, middle, .. } = &self.values;
        let [caps, inner, thirds, rest] = barrier_problem.offsets();
        self.at.clear();
        self.at.resize(x.len(), AtKnot::default());
        self.on.clear();
        self.on.resize(middle.len(), OnInterval::default());
        // Second derivative of h x^(-1/2).
        let time = |h: f64, x: f64| 0.75 * h / (x * x * x.sqrt());
        for (k, h) in barrier_problem.knots.h.iter().enumerate().filter(|_| barrier_problem.means.is_empty()) {
            self.at[k].xx += time(h / 6.0, x[k]);
            self.at[k + 1].xx += time(h / 6.0, x[k + 1]);
            self.on[k].mm = time(4.0 / 6.0 * h, middle[k]);
        }
        for (i, end) in [0, x.len() - 1].into_iter().enumerate() {
            if let End::Rest { h } = barrier_problem.ends[i] {
                self.at[end].xx += time(3.0 * h, x[end]);
            }
            let slope = barrier_problem.rest[i] + 0.5 / (x[end] * x[end].sqrt());
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
            let x = x[end];
            let falls = barrier_problem.jerk_falls(k, end, &self.values);
            let mut sum = Products::default();
            for (row, [low, high]) in
                barrier_problem.inner[inner_rows.clone()].iter().zip(&self.barrier[inner + inner_rows.start..])
            {
                sum.add(low.weight() + high.weight(), [row.gamma, row.beta, row.alpha]);
            }
            let rise = 0.5 / x.sqrt();
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
                    .for_each(|(x, factors)| sum.add(time(h, x), factors));
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
    fn objective_gradient(&mut self, barrier_problem: &BarrierProblem) {
        let Values { x, middle, .. } = &self.values;
        let time = |h: f64, x: f64| -0.5 * h / (x * x.sqrt());
        self.at.iter_mut().for_each(|at| (at.x, at.u) = (0.0, 0.0));
        self.on.iter_mut().for_each(|on| (on.m, on.w) = (0.0, 0.0));
        for (k, h) in barrier_problem.knots.h.iter().enumerate() {
            if barrier_problem.means.is_empty() {
                self.at[k].x += time(h / 6.0, x[k]);
                self.at[k + 1].x += time(h / 6.0, x[k + 1]);
                self.on[k].m = time(4.0 / 6.0 * h, middle[k]);
            } else {
                for (x, [by_x, by_u, by_w]) in barrier_problem.gauss(k, &self.values) {
                    let slope = time(0.5 * h, x);
                    self.at[k].x += slope * by_x;
                    self.at[k].u += slope * by_u;
                    self.on[k].w += slope * by_w;
                }
            }
        }
        for (i, end) in [0, x.len() - 1].into_iter().enumerate() {
            if let End::Rest { h } = barrier_problem.ends[i] {
                self.at[end].x += time(3.0 * h, x[end]);
            }
        }
    }

    /// Adds the first derivatives of the barriers at `mu`.
    fn barrier_gradient(&mut self, barrier_problem: &BarrierProblem, mu: f64) {
        let x = &self.values.x;
        let [caps, inner, thirds, rest] = barrier_problem.offsets();
        for (i, end) in [0, x.len() - 1].into_iter().enumerate() {
            let y = 1.0 / x[end].sqrt();
            let slope = barrier_problem.rest[i] + 0.5 * y / x[end];
            self.at[end].x += slope
                * self.barrier[rest + i][1].force(mu, barrier_problem.jerk_wider * barrier_problem.jerk_unit[end]);
        }
        for k in 0..x.len() {
            let at = &mut self.at[k];
            for i in barrier_problem.first[k]..barrier_problem.first[k + 1] {
                let row = &barrier_problem.points[i];
                let [low, high] = &self.barrier[i];
                let force = high.force(mu, row.wider[1]) - low.force(mu, row.wider[0]);
                at.x += force * row.slope(x[k]);
                at.u += force * row.a;
            }
            at.x += self.barrier[caps + k][1].force(mu, barrier_problem.caps[k][1]);
        }
        for (k, end, inner_rows, third_rows) in barrier_problem.places() {
            let (mut sx, mut su, mut sw, mut forces, mut stepped) = (0.0, 0.0, 0.0, 0.0, 0.0);
            let sides = &self.barrier[inner + inner_rows.start..];
            for (row, [low, high]) in barrier_problem.inner[inner_rows].iter().zip(sides) {
                let force = high.force(mu, row.wider[1]) - low.force(mu, row.wider[0]);
                sx += force * row.gamma;
                su += force * row.beta;
                sw += force * row.alpha;
            }
            let y = 1.0 / x[end].sqrt();
            let falls = barrier_problem.jerk_falls(k, end, &self.values);
            let taken = barrier_problem.jerk_wider * barrier_problem.jerk_unit[end];
            let sides = &self.barrier[thirds + third_rows.start..];
            for (row, [low, high]) in barrier_problem.thirds[third_rows].iter().zip(sides) {
                let (low, high) = (low.force(mu, taken), high.force(mu, taken));
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

    /// The longest step of slacks and multipliers towards `mu = 0`; leaves the second-order terms
    /// of that step.
    fn predict(&mut self, barrier_problem: &BarrierProblem) -> Sides {
        // Relative changes of slacks; multipliers change by the opposite less 1.
        let (mut least, mut most) = (0.0, 0.0);
        let barrier = &mut self.barrier;
        barrier_problem.each_change(&self.values, &self.delta, |i, by| {
            for (side, by) in barrier[i].iter_mut().zip(by) {
                let relative = by * side.inverse;
                side.change = relative * (1.0 + relative);
                least = lesser(relative, least);
                most = -lesser(-relative, -most);
            }
        });
        [1.0 / f64::max(1.0, -least), 1.0 / (1.0 + most)]
    }

    /// Changes of all multipliers for the step, and how far slacks and multipliers can follow it.
    fn changes(&mut self, barrier_problem: &BarrierProblem, mu: f64) -> Sides {
        let (mut least, mut fall) = (0.0, 0.0);
        let barrier = &mut self.barrier;
        barrier_problem.each_change(&self.values, &self.delta, |i, by| {
            for (side, by) in barrier[i].iter_mut().zip(by) {
                let relative = by * side.inverse;
                side.change = mu * side.inverse + side.multiplier * (side.change - 1.0 - relative);
                least = lesser(relative, least);
                // A bound at infinity has multiplier and change 0. Few sides take the division.
                if -side.change > fall * side.multiplier {
                    fall = -side.change / side.multiplier;
                }
            }
        });
        // The duration is a barrier at x = 0, but Newton's step may jump over it.
        let (Values { x, middle, .. }, Values { x: dx, middle: dm, .. }) = (&self.values, &self.delta);
        for (x, d) in x.iter().zip(dx).chain(middle.iter().zip(dm)) {
            least = lesser(d / x, least);
        }
        [-least, fall].map(|decrease| if decrease < STEP_FRACTION { 1.0 } else { STEP_FRACTION / decrease })
    }
}
