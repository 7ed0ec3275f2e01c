//! A lower bound on the duration, from multipliers of the jerk rows.
//!
//! Take the relaxed problem (module `relaxed`) and add its rows, times their multipliers, to the duration. All but the jerk rows
//! are linear. Of a jerk row with multiplier `l` on an interval of length `h` the mean of `1 / sqrt(x)` is left over, so
//! that this mean has the factor `h - l`, with `l` summed over the rows. Where no such factor is negative the sum is convex,
//! although the problem is not. A tangent of it is then below it everywhere, and it is below the duration of every motion that
//! keeps the rows.
//!
//! Where the multipliers add up to more than `h`, a part of the bound is replaced by the straight line above it between the slowest
//! and the fastest speed that are looked at, and the problem is solved again.

use super::barrier_problem::{BarrierProblem, MeanBound};
use super::interior_point::Solver;
use super::outcome::Goal;
use super::parts::{Part, Prepared, prepare};
use super::spline::End;
use super::start;
use crate::error::FeedError;
use crate::problem::FeedProblem;
use crate::speed_law::SpeedLaw;

/// Part of the speed of the given law below which motions are not looked at where that matters.
const SLOWEST: f64 = 0.7;

/// The same above: of the squared speed without limits on jerk. Motions do not come near it.
const FASTEST: f64 = 4.0;

/// Of that where bounds are straight: the grids of both problems differ a little.
const FASTEST_ON_LINES: f64 = 1.1;

/// Part of the length of an interval that multipliers are to have after a bound was made straight: they grow again.
const AIM: f64 = 0.6;

/// Ratio of this part from one interval to the next, as the multipliers move there: at first, how it approaches 1 from round to round,
/// and the least. On short intervals a single multiplier moves by some twenty of them in each round.
const SPREAD: f64 = 1.5;
const WIDER: f64 = 0.9;
const LEAST_SPREAD: f64 = 1.01;

/// Times that the problem is solved.
const ROUNDS: usize = 40;

/// Part of the sum that its tangent may fall by. Where it falls more, the iterations have not ended near the optimum and the bound is
/// true, but low.
const LEVEL: f64 = 1e-3;

/// Relative gaps that the iterations start with: the first, and those after the tangent was not level.
const START_GAPS: [f64; 3] = [0.3, 1.0, 0.1];

/// A duration that no motion beats, of those that keep the rows of a problem with limits on jerk.
///
/// The motions are those whose squared speed is a quadratic spline on the grid of the problem, as that of
/// [`JerkLimited`](crate::JerkLimited) is. Rows have to hold at the grid points, and those on jerk in the mean over each interval.
///
/// ```
/// use arcfeed_feedrate::constraint::{Feed, TangentialAcceleration, TangentialJerk};
/// use arcfeed_feedrate::{FeedPlanner, FeedProblem, JerkLimited, LowerBound, MotionLaw};
///
/// let grid: Vec<f64> = (0..=200).map(|i| 0.001 * f64::from(i)).collect();
/// let feed = Feed::new(&[0.2; 200])?;
/// let (acceleration, jerk) = (TangentialAcceleration::new(2.0)?, TangentialJerk::new(40.0)?);
/// let problem = FeedProblem::between_points(&grid, &[&feed, &acceleration, &jerk])?;
/// let plan = JerkLimited::default().plan(&problem)?;
/// let bound = LowerBound::new(&problem, &plan)?;
/// assert!(bound.duration < plan.duration() && plan.duration() < 1.001 * bound.duration);
/// // It holds for all motions on the grid.
/// assert_eq!(bound.conditional, 0);
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowerBound {
    /// The duration, s.
    pub duration: f64,
    /// Number of intervals on which the bound is known only for motions that run at 0.7 times the speed of the given law at least:
    /// those on which the problem is not convex. Where it is 0 the bound holds for all motions.
    pub conditional: usize,
    /// Number of all intervals.
    pub intervals: usize,
}

impl LowerBound {
    /// The bound for a problem, from its solution or another law that keeps its rows.
    ///
    /// Takes a few times as long as [`JerkLimited`](crate::JerkLimited) where the problem is convex, and some forty times where it is
    /// not in many places.
    ///
    /// # Errors
    /// As [`JerkLimited`](crate::JerkLimited) for problems without limits on jerk, without rows between the points or with too many
    /// rows; [`FeedError::NotConverged`].
    pub fn new(problem: &FeedProblem, law: &SpeedLaw) -> Result<Self, FeedError> {
        let prepared = prepare(problem)?;
        let mut sum = Self { duration: 0.0, conditional: 0, intervals: prepared.problem.intervals() };
        let mut solver = Solver::default();
        for part in &prepared.parts {
            let (duration, conditional) = Problem::new(&prepared, part, law).solve(&mut solver, law)?;
            sum.duration += duration;
            sum.conditional += conditional;
        }
        Ok(sum)
    }
}

/// The relaxed problem of one part, and where motions are looked for.
struct Problem<'a> {
    prepared: &'a Prepared<'a>,
    barrier_problem: BarrierProblem,
    /// Greatest coefficients.
    most: Vec<f64>,
    /// Least and greatest squared speed on each interval with a straight bound.
    ranges: Vec<[f64; 2]>,
}

impl<'a> Problem<'a> {
    fn new(prepared: &'a Prepared<'a>, part: &Part, law: &SpeedLaw) -> Self {
        let Prepared { problem, fastest, .. } = prepared;
        let mut barrier_problem = BarrierProblem::new(problem, [part.grid.start, part.grid.end], part.speeds, fastest);
        let (from, n) = (barrier_problem.from, barrier_problem.knots.intervals());
        let cap = |k: usize, part: f64| (part * fastest[from + k]).min(barrier_problem.caps[k][0]);
        let most_x: Vec<f64> = (0..=n).map(|k| cap(k, FASTEST)).collect();
        let ranges = (0..n)
            .map(|k| {
                let x = [k, k + 1].map(|k| law.at_position(problem.grid()[from + k]).v.powi(2));
                let hi = cap(k, FASTEST_ON_LINES).max(cap(k + 1, FASTEST_ON_LINES));
                // Speeds vary between the knots.
                [SLOWEST * SLOWEST * x[0].min(x[1]), hi.max(1.01 * x[0].max(x[1]))]
            })
            .collect();
        // `x = pa c[k] + pb c[k + 1]` is at most that, and no coefficient is negative.
        let mut most = vec![f64::INFINITY; n + 2];
        for (k, &[pa, pb, _]) in barrier_problem.knots.weights.iter().enumerate() {
            most[k] = most[k].min(most_x[k] / pa);
            most[k + 1] = most[k + 1].min(most_x[k] / pb);
        }
        barrier_problem.relax(problem, &most_x);
        Self { prepared, barrier_problem, most, ranges }
    }

    /// The bound, and the number of intervals with straight bounds.
    fn solve(&mut self, solver: &mut Solver, law: &SpeedLaw) -> Result<(f64, usize), FeedError> {
        let Self { prepared, barrier_problem, most, ranges } = self;
        let goal = Goal { tolerance: 1e-5, shortest: 0.0, start_gap: START_GAPS[0], drop_below: 0.0, polishes: 0 };
        let (mut duration, mut left) = (f64::NAN, 0);
        let (mut best, mut tries) = (None, 0);
        let mut spread = SPREAD;
        for _ in 0..ROUNDS {
            let start_gap = START_GAPS[tries];
            let c = start::along_law(prepared, barrier_problem, law);
            solver.minimise(&prepared.problem, barrier_problem, c, Goal { start_gap, ..goal }, false);
            let sum = solver.with_rows(barrier_problem);
            duration = solver.least(barrier_problem, most);
            left = straighten(barrier_problem, solver, ranges, spread);
            spread = (1.0 + WIDER * (spread - 1.0)).max(LEAST_SPREAD);
            if left > 0 || !duration.is_finite() {
                continue;
            }
            let conditional = barrier_problem.means.iter().filter(|mean| mean.root < 1.0).count();
            // One for all motions is worth more than a slightly higher one for some.
            let worth =
                |(before, of): (f64, usize)| if of == 0 && conditional > 0 { before * (1.0 + LEVEL) } else { before };
            if best.is_none_or(|best| duration > worth(best)) {
                best = Some((duration, conditional));
            }
            tries += 1;
            if tries == START_GAPS.len() || duration > (1.0 - LEVEL) * sum {
                break;
            }
        }
        if let Some(best) = best {
            return Ok(best);
        }
        let what = "the lower bound on the duration (intervals that are not convex)";
        let residual = if left > 0 { left as f64 } else { duration };
        Err(FeedError::NotConverged { what, iterations: ROUNDS, residual })
    }
}

/// Puts straight lines in the place of bounds whose multipliers make the sum concave, and of those beside them, to which the
/// multipliers move next. Returns the number of such places.
fn straighten(barrier_problem: &mut BarrierProblem, solver: &Solver, ranges: &[[f64; 2]], spread: f64) -> usize {
    let (n, [_, _, thirds, rest]) = (ranges.len(), barrier_problem.offsets());
    let mut roots: Vec<f64> = barrier_problem.means.iter().map(|mean| mean.root).collect();
    let mut places = 0;
    for k in 0..n {
        let rows = barrier_problem.thirds_first[2 * k]..barrier_problem.thirds_first[2 * k + 2];
        let sum: f64 = rows.map(|i| solver.multipliers(thirds + i)).map(|[low, high]| low + high).sum();
        let used = sum * barrier_problem.means[k].root / barrier_problem.knots.h[k];
        if used <= 1.0 {
            continue;
        }
        places += 1;
        let mut root = AIM * barrier_problem.means[k].root / used;
        roots[k] = root;
        for away in 1..n {
            root *= spread;
            if root >= 1.0 || used < SPREAD {
                break;
            }
            for j in [k.checked_sub(away), Some(k + away)].into_iter().flatten().filter(|&j| j < n) {
                roots[j] = roots[j].min(root);
            }
        }
    }
    for ((mean, root), [lo, hi]) in barrier_problem.means.iter_mut().zip(roots).zip(ranges) {
        if root < mean.root {
            let [most, least] = [lo, hi].map(|x| 1.0 / x.sqrt());
            let fall = (most - least) / (hi - lo);
            let straight = 1.0 - root;
            *mean = MeanBound { root, constant: straight * (most + fall * lo), fall: straight * fall };
        }
    }
    for i in 0..2 {
        // The time at constant jerk weighs three times the length.
        let End::Rest { h } = barrier_problem.ends[i] else { continue };
        if solver.multipliers(rest + i)[1] > 3.0 * h {
            barrier_problem.rest[i] = 0.0;
            places += 1;
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FeedPlanner;
    use crate::constraint::{
        JointAcceleration, JointJerk, JointTorque, PathConstraint, PathDerivatives, TangentialAcceleration,
    };
    use crate::jerk_limited::JerkLimited;

    /// Where jerk makes the speed dip at one place, its multiplier there is large and the problem is not convex. The sum with
    /// straight bounds is: at random motions, faster and slower ones, it is never less than the bound.
    #[test]
    fn the_sum_is_nowhere_less_than_the_bound() {
        assert!(of_a_dip(None) > 0, "all of it is convex");
    }

    /// Friction in both directions: its row is convex on one side alone.
    #[test]
    fn the_sum_is_nowhere_less_than_the_bound_with_friction() {
        for friction in [1.0, -1.0] {
            of_a_dip(Some(friction));
        }
    }

    /// Holds random motions against the bound of one with a dip. Returns the number of intervals that are not convex.
    fn of_a_dip(friction: Option<f64>) -> usize {
        let n = 200;
        let grid: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
        let first: Vec<f64> = grid.iter().map(|s| 2.0 * (s - 0.5)).collect();
        let (second, mut third) = (vec![2.0; grid.len()], vec![0.0; grid.len()]);
        third[60] = 2000.0;
        let path = PathDerivatives::new(1, &first, &second).and_then(|path| path.with_third(&third)).expect("finite");
        let (acceleration, jerk) = (JointAcceleration::new(path, &[1.0]), JointJerk::new(path, &[50.0]));
        let tool = TangentialAcceleration::new(5.0).expect("positive");
        let (acceleration, jerk) = (acceleration.expect("positive"), jerk.expect("positive"));
        let (ones, none, c) = (vec![1.0; grid.len()], vec![0.0; grid.len()], vec![friction.unwrap_or(0.0); grid.len()]);
        let torque = JointTorque::new(&ones, &none, &c, &none, &[0.6]).expect("above 0");
        let mut limits: Vec<&dyn PathConstraint> = vec![&acceleration, &jerk, &tool];
        limits.extend(friction.map(|_| &torque as &dyn PathConstraint));
        let problem = FeedProblem::between_points(&grid, &limits).expect("finite");
        let law = JerkLimited::default().plan(&problem).expect("a law");
        let prepared = prepare(&problem).expect("moves");
        let mut solver = Solver::default();
        let mut part = Problem::new(&prepared, &prepared.parts[0], &law);
        let (bound, conditional) = part.solve(&mut solver, &law).expect("a bound");
        assert!(bound < law.duration(), "{conditional} {bound}");
        // The multipliers are those of the bound: no other start was tried.
        assert!(bound > (1.0 - LEVEL) * solver.with_rows(&part.barrier_problem), "{bound}");
        let best = solver.c.clone();
        let mut seed = 1_u64;
        let mut unit = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut least = f64::INFINITY;
        for _ in 0..20_000 {
            let (centre, width, depth) = (unit() * f64::from(n), 0.5 + 20.0 * unit() * unit(), 0.5 + unit());
            for (i, (c, best)) in solver.c.iter_mut().zip(&best).enumerate() {
                let away = (i as f64 - centre) / width;
                *c = best * depth.powf(2.0 * (-away * away).exp());
            }
            let (ratios, last) = (part.barrier_problem.ratios(), best.len() - 1);
            (solver.c[0], solver.c[last]) = (solver.c[1] / ratios[0], solver.c[last - 1] / ratios[1]);
            part.barrier_problem.knots.evaluate(&solver.c, &mut solver.values);
            let sum = solver.with_rows(&part.barrier_problem);
            assert!(sum >= bound, "{sum} < {bound} with a change by {depth} at {centre}, {width} wide");
            least = least.min(sum);
        }
        assert!(least < bound * 1.001, "{least} {bound}");
        conditional
    }
}
