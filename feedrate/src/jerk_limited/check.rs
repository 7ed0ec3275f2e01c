//! The check of the result between the grid points.
//!
//! The coefficients of a row vary between two grid points; they are interpolated through both ends
//! and the middle, which is exact where the path is piecewise cubic. A row then is a cubic in `s`,
//! whose extremes are found in closed form.

use std::ops::Range;

use super::between::parabola_overshoot;
use crate::constraint::Within;
use crate::problem::{FeedProblem, matching, quadratic};
use crate::row::{JerkRow, Row};
use crate::speed_law::SpeedLaw;
use crate::state::MotionState;

/// The excess of the cubic through two values with two slopes, over the unit interval, over the range of both ends, below and above.
fn cubic_overshoot([start, end]: [f64; 2], [slope, end_slope]: [f64; 2]) -> [f64; 2] {
    let (lowest, highest) = (start.min(end), start.max(end));
    // The inner Bernstein coefficients.
    let (p, q) = (start + slope / 3.0, end - end_slope / 3.0);
    if p.min(q) >= lowest && p.max(q) <= highest {
        return [0.0; 2];
    }
    let rise = end - start;
    let (square, cube) = (3.0 * rise - 2.0 * slope - end_slope, slope + end_slope - 2.0 * rise);
    let mut over = [0.0_f64; 2];
    // Zeros of slope + 2 square t + 3 cube t^2, without cancellation.
    let root = (square * square - 3.0 * cube * slope).sqrt();
    let sum = -(square + root.copysign(square));
    for t in [sum / (3.0 * cube), slope / sum] {
        if t > 0.0 && t < 1.0 {
            let value = start + t * (slope + t * (square + t * cube));
            over = [over[0].max(lowest - value), over[1].max(value - highest)];
        }
    }
    over
}

/// State at one end of an interval of a spline.
#[derive(Debug, Clone, Copy)]
struct Edge {
    x: f64,
    u: f64,
    root: f64,
}

/// Values and slopes (over the unit interval) of a row without friction at both ends of an interval of length `h`,
/// from the row at the start, in the middle and at the end.
fn along([p, m, q]: [&Row; 3], [near, far]: [Edge; 2], h: f64) -> ([f64; 2], [f64; 2]) {
    let w = (far.u - near.u) / h;
    let at = |edge: Edge, row: &Row, slope: &dyn Fn(fn(&Row) -> f64) -> f64| {
        let value = row.a * edge.u + row.b * edge.x + row.d;
        let moving = slope(|row| row.a) * edge.u + slope(|row| row.b) * edge.x + slope(|row| row.d);
        (value, moving + h * (row.a * w + 2.0 * row.b * edge.u))
    };
    let (start, slope) = at(near, p, &|of| 4.0 * of(m) - 3.0 * of(p) - of(q));
    let (end, end_slope) = at(far, q, &|of| 3.0 * of(q) - 4.0 * of(m) + of(p));
    ([start, end], [slope, end_slope])
}

/// Parts of an interval at whose ends what is no polynomial is sampled.
const SAMPLES: usize = 8;

/// The place at which the parabola through three equidistant values turns, in steps from the middle
/// one, and its value there; nothing where it does not turn between them.
fn turning([start, middle, end]: [f64; 3]) -> Option<(f64, f64)> {
    let (slope, bend) = (0.5 * (end - start), start - 2.0 * middle + end);
    let at = -slope / bend;
    (at.abs() <= 1.0).then_some((at, middle + 0.5 * slope * at))
}

/// Least and greatest value of a smooth function over 0..1 of which equidistant samples are known.
/// Only turning points whose value is `worth` it are looked for.
fn extremes(samples: &[f64; SAMPLES + 1], value: impl Fn(f64) -> f64, worth: impl Fn(f64) -> bool) -> [f64; 2] {
    /// Each step is this part of the one before; a parabola's error falls with the third power.
    const FINER: f64 = 0.125;
    let widen = |[least, most]: [f64; 2], value: f64| [least.min(value), most.max(value)];
    let mut range = samples.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |range, value| widen(range, *value));
    for i in 1..SAMPLES {
        let Some((at, peak)) = turning([samples[i - 1], samples[i], samples[i + 1]]) else { continue };
        if !worth(peak) {
            continue;
        }
        let (mut step, mut turn) = (1.0 / SAMPLES as f64, samples[i]);
        let mut centre = (i as f64 + at) * step;
        for _ in 0..3 {
            step *= FINER;
            centre = centre.clamp(step, 1.0 - step);
            let near = [-step, 0.0, step].map(|by| value(centre + by));
            range = near.iter().fold(range, |range, value| widen(range, *value));
            let Some((at, peak)) = turning(near) else { break };
            turn = peak;
            centre += at * step;
        }
        // Of the finest parabola alone: it may turn between the places looked at.
        range = widen(range, turn);
    }
    range
}

/// The least factor by which any bound has been met so far.
#[derive(Debug, Clone, Copy)]
struct Scale(f64);

impl Scale {
    /// `factor * value <= bound`. A bound below 0, which standing still breaks, allows no factor
    /// but 1.
    fn keep(&mut self, value: f64, bound: f64) {
        if value > bound.min(0.0) && value * self.0 > bound {
            self.0 = if value > 0.0 { bound.max(0.0) / value } else { 0.0 };
        }
    }
}

/// The greatest factor on `x`, `u` and `w` of a plan, 1 at most, at which everything is kept in the
/// given intervals, between the grid points too.
pub(super) fn largest_scale(problem: &FeedProblem, plan: &SpeedLaw, intervals: Range<usize>) -> f64 {
    let mut scale = Scale(1.0);
    for k in intervals {
        let inside = Inside::new(problem, plan, k);
        inside.keep_rows(&mut scale);
        inside.keep_speed(&mut scale);
        inside.keep_jerk(&mut scale);
    }
    scale.0
}

/// A plan inside one interval.
struct Inside<'a> {
    problem: &'a FeedProblem,
    plan: &'a SpeedLaw,
    k: usize,
    h: f64,
    /// Start, middle and end.
    edges: [Edge; 3],
    /// True if it is next to rest, where `x(s)` is no polynomial; at a stop round-off may leave a
    /// trace of speed.
    rests: bool,
}

impl<'a> Inside<'a> {
    fn new(problem: &'a FeedProblem, plan: &'a SpeedLaw, k: usize) -> Self {
        let h = problem.h(k);
        let edges = [0.0, 0.5 * h, h].map(|ds| {
            let state = plan.within(k, ds);
            Edge { x: state.v * state.v, u: state.a, root: state.v }
        });
        let rests = edges[0].root.min(edges[2].root) < 1e-4 * edges[1].root;
        Self { problem, plan, k, h, edges, rests }
    }

    /// Equidistant states.
    fn states(&self) -> [MotionState; SAMPLES + 1] {
        std::array::from_fn(|i| self.state(i as f64 / SAMPLES as f64))
    }

    fn state(&self, fraction: f64) -> MotionState {
        self.plan.within(self.k, self.h * fraction)
    }

    fn keep_rows(&self, scale: &mut Scale) {
        let (problem, k, edges) = (self.problem, self.k, &self.edges);
        let (near, middle, far) = (problem.rows(k), problem.middle_rows(k), problem.rows(k + 1));
        for (j, row) in middle.iter().enumerate() {
            let Some(p) = matching(near, middle, j, false).map(|j| &near[j]) else { continue };
            let Some(q) = matching(far, middle, j, true).map(|j| &far[j]) else { continue };
            let [least, most] = if self.rests || row.c != 0.0 {
                self.range_of([p, row, q])
            } else {
                let ([start, end], slopes) = along([p, row, q], [edges[0], edges[2]], self.h);
                let over = cubic_overshoot([start, end], slopes);
                [start.min(end) - over[0], start.max(end) + over[1]]
            };
            let rest = p.d.max(q.d);
            scale.keep(most - rest, row.hi - rest);
            let rest = p.d.min(q.d);
            scale.keep(rest - least, rest - row.lo);
        }
    }

    /// Least and greatest value of a row, by samples.
    fn range_of(&self, [p, m, q]: [&Row; 3]) -> [f64; 2] {
        let value = |fraction: f64| {
            let (mix, at) = (quadratic(fraction), self.state(fraction));
            let of = |of: fn(&Row) -> f64| mix(of(p), of(m), of(q));
            of(|row| row.a) * at.a + at.v * (of(|row| row.b) * at.v + of(|row| row.c)) + of(|row| row.d)
        };
        let samples = std::array::from_fn(|i| value(i as f64 / SAMPLES as f64));
        let (middle, half) = (0.5 * (m.lo + m.hi), 0.5 * (m.hi - m.lo));
        // A bound at infinity leaves no middle: then all turning points are looked for.
        extremes(&samples, value, |peak| !((peak - middle).abs() < 0.9 * half))
    }

    fn keep_speed(&self, scale: &mut Scale) {
        let (problem, k, edges) = (self.problem, self.k, &self.edges);
        // At a stop round-off may leave a trace of speed.
        let part = |x: f64, cap: f64| if cap < f64::INFINITY && cap > 0.0 { x / cap } else { 0.0 };
        let [start, mid, end] = [
            part(edges[0].x, problem.x_max(k)),
            part(edges[1].x, problem.middle_x_max(k)),
            part(edges[2].x, problem.x_max(k + 1)),
        ];
        scale.keep(start.max(mid).max(end), 1.0);
        if self.rests || problem.is_capped_within(k) {
            scale.keep(start.max(end) + parabola_overshoot([start, mid, end])[1], 1.0);
        } else {
            let x = [edges[0].x, edges[0].x + self.h * edges[0].u, edges[2].x];
            for weights in problem.speed_rows(k) {
                scale.keep(weights.iter().zip(x).map(|(weight, x)| weight * x).sum(), 1.0);
            }
        }
    }

    fn keep_jerk(&self, scale: &mut Scale) {
        let (problem, k) = (self.problem, self.k);
        let [near, middle, far] = [Within::Start, Within::Middle, Within::End].map(|at| problem.jerk_rows(k, at));
        let ends = [0.0, 0.5, 1.0].map(|fraction| self.state(fraction));
        let mut states = None;
        for (row, (p, q)) in middle.iter().zip(near.iter().zip(far)) {
            let value = |fraction: f64, at: &MotionState| {
                let mix = quadratic(fraction);
                let speed = mix(p.beta, row.beta, q.beta) * at.a + at.v * at.v * mix(p.gamma, row.gamma, q.gamma);
                mix(p.alpha, row.alpha, q.alpha) * at.j + at.v * speed
            };
            if row.step > 0.0 {
                self.keep_jerk_with_step(scale, row, value);
                continue;
            }
            // The hull of the parabola through three of them.
            let [start, mid, end] = [value(0.0, &ends[0]), value(0.5, &ends[1]), value(1.0, &ends[2])];
            let bound = start.abs().max(end.abs()).max((2.0 * mid - 0.5 * (start + end)).abs());
            if bound < 0.5 * row.limit {
                continue;
            }
            let of = |fraction: f64| value(fraction, &self.state(fraction));
            let states = states.get_or_insert_with(|| self.states());
            let samples = std::array::from_fn(|i| value(i as f64 / SAMPLES as f64, &states[i]));
            let [least, most] = extremes(&samples, of, |peak| peak.abs() > 0.9 * row.limit);
            // Jerk grows with the power 3/2.
            let ratio = most.max(-least) / row.limit;
            scale.keep((ratio * ratio).cbrt(), 1.0);
        }
    }

    /// A jerk row next to a jump, `value` by fraction of the interval and state.
    fn keep_jerk_with_step(&self, scale: &mut Scale, row: &JerkRow, value: impl Fn(f64, &MotionState) -> f64) {
        let states = self.states();
        for sign in [1.0, -1.0] {
            let sum = |fraction: f64, at: &MotionState| sign * value(fraction, at) + row.step * at.v * at.v;
            let samples = std::array::from_fn(|i| sum(i as f64 / SAMPLES as f64, &states[i]));
            let of = |fraction: f64| sum(fraction, &self.state(fraction));
            let [_, most] = extremes(&samples, of, |peak| peak > 0.9 * row.limit);
            // The step grows with the power 1 of the scale, the rest with a higher one.
            scale.keep(most, row.limit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::{JointJerk, PathDerivatives};

    #[test]
    fn extremes_of_what_is_no_polynomial() {
        for shift in [0.01, 0.11, 0.3, 0.52, 0.77, 0.98] {
            let value = |t: f64| (0.3 + t).sqrt() * (1.0 - 4.0 * (t - shift) * (t - shift));
            let samples = std::array::from_fn(|i| value(i as f64 / SAMPLES as f64));
            let most = (0..=1_000_000).map(|i| value(f64::from(i) * 1e-6)).fold(f64::MIN, f64::max);
            let found = extremes(&samples, value, |_| true)[1];
            assert!((found - most).abs() < 1e-9 * most, "{shift}: {found} instead of {most}");
        }
    }

    /// At a constant speed `v` a step takes `step v^2` of the jerk, in its interval alone.
    #[test]
    fn what_a_step_takes_of_the_jerk_is_seen() {
        let (grid, first, none) = ([0.0, 0.1, 0.2, 0.3], [1.0; 4], [0.0; 4]);
        let path = PathDerivatives::new(1, &first, &none).and_then(|path| path.with_third(&none)).expect("finite");
        let path = path.with_steps(&[0.0, 50.0, 0.0]).expect("one for each interval");
        let jerk = JointJerk::new(path, &[10.0]).expect("above 0");
        let problem = FeedProblem::between_points(&grid, &[&jerk]).expect("a grid");
        let plan = SpeedLaw::from_knots(&grid, &[0.5; 4]).expect("a law");
        for (intervals, scale) in [(0..1, 1.0), (1..2, 10.0 / (50.0 * 0.25)), (2..3, 1.0)] {
            let found = largest_scale(&problem, &plan, intervals.clone());
            assert!((found - scale).abs() < 1e-9, "{found} in {intervals:?}");
        }
    }
}
