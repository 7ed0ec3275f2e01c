//! The start of the iterations: a smooth `x(s)` below the second-order solution.

use std::collections::VecDeque;

use super::barrier_problem::BarrierProblem;
use super::drop_distant::Distance;
use super::parts::Prepared;
use super::refine::greatest_u;
use super::spline::{End, Values};
use crate::problem::FeedProblem;
use crate::speed_law::SpeedLaw;

/// A start that takes so many times the time of the second-order law makes for many iterations.
const SLOW: f64 = 2.5;

/// A motion that has to be slowed down by more than this, on its squared speeds, is no start.
const POOR: f64 = 0.1;

/// The same for a start along a law that the solution is close to, and what is not close any more.
const NEAR_FRACTION: f64 = 0.98;
const NEAR: f64 = 0.5;

/// A law whose squared speeds would have to be lowered to less than this part to be inside is no start where limits are widened.
const FAR: f64 = 0.02;

/// A law that keeps all bounds if its squared speeds are lowered or raised by this part is close to the solution, row by row.
const CLOSE: f64 = 0.02;

/// The part of the way to the nearest limit that the start takes.
const START_FRACTION: f64 = 0.9;

/// Intervals for which the windows are chosen; more of them make the windows wider.
const SHAPE_POINTS: usize = 1000;

/// Coefficients to start from; where need be the bounds of the stretch are widened so that these
/// are strictly inside.
///
/// The squared speeds `limit` of a second-order planner are lowered to the least and then the mean
/// over a window, and kept below a jerk-limited departure from and approach to rest. Of several
/// windows the one is taken that has to be slowed down least as a whole. Where a speed is given at
/// an end, slowing down is no option; there the limits are widened instead.
pub(super) fn start(prepared: &Prepared<'_>, barrier_problem: &mut BarrierProblem) -> Vec<f64> {
    let Prepared { problem, fastest: limit, .. } = prepared;
    let slowing = barrier_problem.slows;
    let (mut values, (_, mut c)) = (Values::default(), shape(problem, barrier_problem, limit, slowing));
    let last = barrier_problem.from + barrier_problem.knots.intervals();
    let shortest = duration(&limit[barrier_problem.from..=last], &barrier_problem.knots.h);
    if slowing
        && time(barrier_problem, &c, &mut values) > SLOW * shortest
        && let Some(law) = prepared.scanned()
    {
        let along = along(problem, barrier_problem, law);
        if time(barrier_problem, &along, &mut values) < time(barrier_problem, &c, &mut values) {
            c = along;
        }
    }
    if !slowing {
        barrier_problem.knots.evaluate(&c, &mut values);
        let jerk_ratio = barrier_problem.largest_scales(&values)[1].powf(-1.5);
        widen(barrier_problem, &values, jerk_ratio);
    }
    c
}

/// The coefficients of a motion that may exceed its bounds, slowed down as a whole to be strictly inside; none where that is no way
/// back inside.
pub(super) fn again(barrier_problem: &BarrierProblem, c: &[f64]) -> Option<Vec<f64>> {
    let mut values = Values::default();
    barrier_problem.knots.evaluate(c, &mut values);
    let [scale, jerk_scale] = barrier_problem.largest_scales(&values);
    let factor = START_FRACTION * scale.min(jerk_scale).min(1.0);
    let slower: Vec<f64> = c.iter().map(|c| c * factor).collect();
    barrier_problem.knots.evaluate(&slower, &mut values);
    let rests = barrier_problem.ends.iter().all(|end| matches!(end, End::Rest { .. }));
    (rests && factor > POOR && barrier_problem.is_inside(&values)).then_some(slower)
}

/// Coefficients from rest to rest that are strictly inside all bounds, slow as they may be; none
/// where standing still is not.
pub(super) fn inside(problem: &FeedProblem, barrier_problem: &BarrierProblem, limit: &[f64]) -> Option<Vec<f64>> {
    /// Friction falls with the root of the squared speed.
    const HALVINGS: usize = 200;
    let (mut values, (_, mut c)) = (Values::default(), shape(problem, barrier_problem, limit, true));
    for _ in 0..HALVINGS {
        barrier_problem.knots.evaluate(&c, &mut values);
        if barrier_problem.is_inside(&values) {
            return Some(c);
        }
        c.iter_mut().for_each(|c| *c *= 0.5);
    }
    None
}

/// Coefficients of a smooth law of motion; with `slowing`, friction aside, inside all bounds that
/// hold at rest.
fn shape(problem: &FeedProblem, barrier_problem: &BarrierProblem, limit: &[f64], slowing: bool) -> (f64, Vec<f64>) {
    let (m, a) = (barrier_problem.knots.intervals(), barrier_problem.from);
    let grid = problem.grid();
    let (first, last) =
        (a - barrier_problem.ends[0].rest_intervals(), a + m + barrier_problem.ends[1].rest_intervals());
    let ratios = barrier_problem.ratios();
    let mut departure = vec![f64::INFINITY; m + 1];
    for (i, at) in [(0, first), (1, last)] {
        if let End::Rest { h } = barrier_problem.ends[i] {
            let next = if i == 0 { at + 1 } else { at - 1 };
            let u = greatest_u(problem.rows(at)).min(greatest_u(problem.rows(next)));
            let law = Departure::new(barrier_problem.rest[i], h, u);
            for (k, x) in departure.iter_mut().enumerate() {
                *x = x.min(law.squared_speed((grid[a + k] - grid[at]).abs()));
            }
        }
    }
    let mut values = Values::default();
    let mut best = (f64::NEG_INFINITY, Vec::new());
    let (mut low, mut x) = (Vec::with_capacity(m + 1), Vec::with_capacity(m + 1));
    // Windows are parts of the path, not numbers of points, or a fine grid would be followed too
    // closely.
    for width in [1, 4, 16, 64].map(|width| width * ((m + SHAPE_POINTS / 2) / SHAPE_POINTS).max(1)) {
        let reach = |k: usize| width.min((k + 1) / 4).min((m - k + 1) / 4);
        least_within(&limit[a..=a + m], reach, &mut low);
        // The mean of steps has kinks, where the acceleration would jump; the mean of that has
        // none.
        mean_within(&low, |k| reach(k).div_ceil(2), &mut x);
        mean_within(&x, |k| reach(k) / 2, &mut low);
        std::mem::swap(&mut low, &mut x);
        // Below both, without a kink.
        x.iter_mut().zip(&departure).for_each(|(x, most)| *x /= (1.0 + (*x / most).powi(2)).sqrt());
        let mut c: Vec<f64> = (0..m + 2).map(|i| 0.5 * (x[i.saturating_sub(1).min(m)] + x[i.min(m)])).collect();
        for (i, (outer, inner)) in [(0, 1), (m + 1, m)].into_iter().enumerate() {
            if let End::Moving { x, .. } = barrier_problem.ends[i] {
                c[outer] = x;
            }
            c[inner] = c[outer] * ratios[i];
        }
        barrier_problem.knots.evaluate(&c, &mut values);
        let [scale, jerk_scale] = barrier_problem.largest_scales(&values);
        let factor = START_FRACTION * scale.min(jerk_scale).min(1.0);
        if factor > best.0 || best.1.is_empty() {
            if slowing {
                c.iter_mut().for_each(|c| *c *= factor);
            }
            best = (factor, c);
        }
    }
    best
}

/// Coefficients along another law that are strictly inside all bounds, or those that the planner starts from.
pub(super) fn along_law(prepared: &Prepared<'_>, barrier_problem: &mut BarrierProblem, law: &SpeedLaw) -> Vec<f64> {
    const TRIALS: usize = 20;
    if barrier_problem.slows {
        let (mut c, mut values) = (along(&prepared.problem, barrier_problem, law), Values::default());
        for _ in 0..TRIALS {
            barrier_problem.knots.evaluate(&c, &mut values);
            if barrier_problem.is_inside(&values) {
                return c;
            }
            c.iter_mut().for_each(|c| *c *= START_FRACTION);
        }
    }
    start(prepared, barrier_problem)
}

/// A law that the solution is close to.
#[derive(Debug)]
pub(super) struct NearLaw {
    /// Coefficients along it.
    pub law: Vec<f64>,
    /// The same, slowed down as a whole to be strictly inside.
    pub start: Vec<f64>,
    /// Which rows are far from their bounds along the law.
    pub distance: Distance,
}

/// A start along a law that the solution is close to; none where it has to be slowed down much. Where it cannot be slowed down, the
/// limits are widened instead, unless by very much.
pub(super) fn near(problem: &FeedProblem, barrier_problem: &mut BarrierProblem, law: &SpeedLaw) -> Option<NearLaw> {
    let (m, grid) = (barrier_problem.knots.intervals(), &problem.grid()[barrier_problem.from..]);
    let states: Vec<_> = grid[..=m].iter().map(|&s| law.at_position(s)).collect();
    let mut c = Vec::with_capacity(m + 2);
    c.push(0.0);
    // The middle Bernstein coefficient of an interval, from either end: the same where the law is a quadratic there.
    c.extend(states.windows(2).zip(&barrier_problem.knots.h).map(|(pair, h)| {
        let [from, to] = [pair[0].v.powi(2) + h * pair[0].a, pair[1].v.powi(2) - h * pair[1].a];
        0.5 * (from + to)
    }));
    c.push(0.0);
    let ratios = barrier_problem.ratios();
    for (i, (outer, inner)) in [(0, 1), (m + 1, m)].into_iter().enumerate() {
        if let End::Moving { x, .. } = barrier_problem.ends[i] {
            (c[outer], c[inner]) = (x, x * ratios[i]);
        } else {
            c[outer] = c[inner] / ratios[i];
        }
    }
    let mut values = Values::default();
    barrier_problem.knots.evaluate(&c, &mut values);
    let [scale, jerk_scale] = barrier_problem.largest_scales(&values);
    if !barrier_problem.slows {
        let moves = c.iter().chain(&values.x).all(|x| *x > 0.0 && x.is_finite());
        if !moves || scale.min(jerk_scale) <= FAR || !(scale + jerk_scale).is_finite() {
            return None;
        }
        widen(barrier_problem, &values, jerk_scale.powf(-1.5));
        return Some(NearLaw { law: c.clone(), start: c, distance: Distance::COARSE });
    }
    let scale = scale.min(jerk_scale);
    let factor = NEAR_FRACTION * scale.min(1.0);
    let start: Vec<f64> = c.iter().map(|c| c * factor).collect();
    barrier_problem.knots.evaluate(&start, &mut values);
    let distance = if (scale - 1.0).abs() < CLOSE { Distance::CLOSE } else { Distance::COARSE };
    (factor > NEAR && barrier_problem.is_inside(&values)).then_some(NearLaw { law: c, start, distance })
}

/// Coefficients along another law from rest to rest, slowed down as a whole to be strictly inside.
fn along(problem: &FeedProblem, barrier_problem: &BarrierProblem, law: &SpeedLaw) -> Vec<f64> {
    let (m, grid) = (barrier_problem.knots.intervals(), &problem.grid()[barrier_problem.from..]);
    // A quadratic spline is about its coefficients in the middles of the intervals.
    let mut c: Vec<f64> = std::iter::once(grid[0])
        .chain((0..m).map(|k| 0.5 * (grid[k] + grid[k + 1])))
        .chain([grid[m]])
        .map(|s| law.at_position(s).v.powi(2))
        .collect();
    let ratios = barrier_problem.ratios();
    for (i, (outer, inner)) in [(0, 1), (m + 1, m)].into_iter().enumerate() {
        c[outer] = c[inner] / ratios[i];
    }
    let mut values = Values::default();
    barrier_problem.knots.evaluate(&c, &mut values);
    let [scale, jerk_scale] = barrier_problem.largest_scales(&values);
    let factor = START_FRACTION * scale.min(jerk_scale).min(1.0);
    c.iter_mut().for_each(|c| *c *= factor);
    c
}

/// About the duration of the motion of coefficients `c`.
fn time(barrier_problem: &BarrierProblem, c: &[f64], values: &mut Values) -> f64 {
    barrier_problem.knots.evaluate(c, values);
    duration(&values.x, &barrier_problem.knots.h)
}

/// Duration at squared speeds `x` between intervals of length `h`.
fn duration(x: &[f64], h: &[f64]) -> f64 {
    h.iter().enumerate().map(|(k, h)| 2.0 * h / (x[k].sqrt() + x[k + 1].sqrt())).sum()
}

/// The least value within `reach(k)` of every `k`, with ends that never go back.
fn least_within(values: &[f64], reach: impl Fn(usize) -> usize, out: &mut Vec<f64>) {
    out.clear();
    // Indices whose values increase: the first is the least of the window, the others may become
    // so.
    let mut rising = VecDeque::new();
    let mut next = 0;
    for k in 0..values.len() {
        while next <= k + reach(k) {
            while rising.back().is_some_and(|&last: &usize| values[last] >= values[next]) {
                rising.pop_back();
            }
            rising.push_back(next);
            next += 1;
        }
        while rising.front().is_some_and(|&first| first < k - reach(k)) {
            rising.pop_front();
        }
        out.push(rising.front().map_or(values[k], |&first| values[first]));
    }
}

/// The mean of the values within `reach(k)` of every `k`.
fn mean_within(values: &[f64], reach: impl Fn(usize) -> usize, out: &mut Vec<f64>) {
    out.clear();
    // Sums of blocks, so that neither many small windows nor few large ones cost much, and nothing
    // cancels.
    let block = (values.len() as f64).sqrt() as usize + 1;
    let sums: Vec<f64> = values.chunks(block).map(|block| block.iter().sum()).collect();
    for k in 0..values.len() {
        let (from, to) = (k - reach(k), k + reach(k) + 1);
        let (first, last) = (from.div_ceil(block), to / block);
        let sum: f64 = if first < last {
            values[from..first * block].iter().chain(&sums[first..last]).chain(&values[last * block..to]).sum()
        } else {
            values[from..to].iter().sum()
        };
        out.push(sum / (to - from) as f64);
    }
}

/// Widens all bounds such that the values are strictly inside.
fn widen(barrier_problem: &mut BarrierProblem, values: &Values, jerk_ratio: f64) {
    // At least this part of a bound is left as slack.
    const SLACK: f64 = 0.1;
    let wider = |value: f64, lo: f64, hi: f64| {
        let slack = SLACK * if (hi - lo).is_finite() { hi - lo } else { value.abs() };
        [(slack - (value - lo)).max(0.0), (slack - (hi - value)).max(0.0)]
    };
    let Values { x, u, .. } = values;
    for k in 0..x.len() {
        for row in &mut barrier_problem.points[barrier_problem.first[k]..barrier_problem.first[k + 1]] {
            let friction = if row.c == 0.0 { 0.0 } else { row.c * x[k].sqrt() };
            let value = row.a * u[k] + row.b * x[k] + friction;
            row.wider = wider(value, row.lo, row.hi);
        }
        let [cap, wider] = &mut barrier_problem.caps[k];
        *wider = (x[k] * (1.0 + SLACK) - *cap).max(0.0);
    }
    for place in 0..2 * barrier_problem.knots.intervals() {
        let (k, end) = (place / 2, place / 2 + place % 2);
        for row in
            &mut barrier_problem.inner[barrier_problem.inner_first[place]..barrier_problem.inner_first[place + 1]]
        {
            let value = row.alpha * values.w[k] + row.beta * u[end] + row.gamma * x[end];
            row.wider = wider(value, row.lo, row.hi);
        }
    }
    barrier_problem.jerk_unit.iter_mut().zip(x).for_each(|(unit, x)| *unit = 1.0 / x.sqrt());
    barrier_problem.jerk_wider = ((1.0 + SLACK) * jerk_ratio - 1.0).max(0.0);
}

/// From rest with constant jerk up to an acceleration, then with that.
#[derive(Debug, Clone, Copy)]
struct Departure {
    jerk: f64,
    u: f64,
}

impl Departure {
    /// The jerk is such that `|rest x| <= 1 / sqrt(x)` at distance `h`, and that `u` is not reached
    /// before.
    fn new(rest: f64, h: f64, u: f64) -> Self {
        // x = (4.5 jerk h^2)^(2/3) there.
        let jerk = 1.0 / (4.5 * h * h * rest);
        Self { jerk: jerk.min((u * u * u / (6.0 * h)).sqrt()), u }
    }

    fn squared_speed(self, distance: f64) -> f64 {
        let Self { jerk, u } = self;
        let until = u * u * u / (6.0 * jerk * jerk);
        if distance <= until {
            return (4.5 * jerk * distance * distance).cbrt().powi(2);
        }
        let x = (0.5 * u * u / jerk).powi(2);
        x + 2.0 * u * (distance - until)
    }
}

#[cfg(test)]
#[path = "start_tests.rs"]
mod tests;
