//! Third order: the fastest speed law under limits on velocity, acceleration, torque and jerk.
//!
//! # Formulation
//! The unknown is `x(s) = sdot^2`, a quadratic B-spline on the grid, so that `u = x' / 2` is continuous and `w = u'` constant on
//! every interval. The duration `integral of x^(-1/2) ds` is minimised directly; it is convex. Rows on velocity, acceleration
//! and torque are linear in the coefficients of the spline. A jerk row
//!
//! ```text
//! |alpha w + beta u + gamma x| <= J x^(-1/2)
//! ```
//!
//! has a convex right side, whose tangent at the current iterate is below it: every step of the interior-point method
//! (module `interior_point`) stays inside the true bound, and no sequence of convex programs is needed. The Newton matrix has two
//! diagonals beside the main one.
//!
//! From and to rest the first and last interval have constant jerk, `x = (4.5 j s^2)^(2/3)`, which no quadratic spline can
//! follow; the spline continues their speed and acceleration. Where that interval is longer than the acceleration takes to
//! build up, it is split there (module `refine`).
//!
//! # Between the grid points
//! On an interval of a piecewise cubic path a joint's acceleration is a cubic in `s` and `|q'|^2 x` a polynomial of degree six;
//! their inner Bernstein coefficients are rows too (module `stretch`). Jerk is kept by margins that follow the iterate. At the end
//! everything is checked between the points in closed form, and what is left, of the order of 1e-5, is taken off the speed
//! (module `between`). On other paths (inverse kinematics, torque) the same holds for the rows as interpolated through both ends
//! and the middle of each interval.
// Knots, values, coefficients and rows run in step.
#![allow(clippy::needless_range_loop, reason = "rows of several arrays are read side by side")]
mod band;
mod between;
#[cfg(feature = "clarabel")]
pub(crate) mod conic;
mod end_speed;
mod interior_point;
mod parts;
mod refine;
mod spline;
mod start;
mod stretch;

use crate::error::{FeedError, positive};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::row::LimitId;
use crate::speed_law::{Builder, SpeedLaw};
use between::largest_scale;
use interior_point::Solver;
use parts::{Part, Prepared, prepare};
use spline::{End, Values};
use stretch::Stretch;

/// The jerk-limited planner: velocity, acceleration, torque and jerk, kept between the grid points too, in the least time
/// that a quadratic spline on the grid allows.
///
/// Needs [`FeedProblem::between_points`] with at least one jerk row, and four intervals between two stops. Where the
/// path starts or ends in motion the acceleration there is 0. It stops at grid points whose cap is 0. Put the knots of a spline
/// path on the grid.
///
/// Time and memory grow with the number of rows, the iterations slowly with the number of intervals (about 12 for 1000, 20 for
/// 10 000, 25 to 45 for 100 000). More than 200 000 intervals or five million rows (some 160 000 intervals of a six-axis arm) are
/// refused: such a path is better planned on a coarser grid, which keeps the limits between its points as well.
///
/// ```
/// use arcfeed_feedrate::constraint::{Feed, TangentialAcceleration, TangentialJerk};
/// use arcfeed_feedrate::{FeedPlanner, FeedProblem, JerkLimited, MotionLaw};
///
/// // A straight path of 0.2 m: the answer is nearly the seven-phase profile, which takes 1.15 s.
/// let grid: Vec<f64> = (0..=200).map(|i| 0.001 * f64::from(i)).collect();
/// let feed = Feed::new(&[0.2; 200])?;
/// let (acceleration, jerk) = (TangentialAcceleration::new(2.0)?, TangentialJerk::new(40.0)?);
/// let problem = FeedProblem::between_points(&grid, &[&feed, &acceleration, &jerk])?;
/// let plan = JerkLimited::default().plan(&problem)?;
/// assert!((plan.duration() - 1.15).abs() < 0.005, "{}", plan.duration());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JerkLimited {
    tolerance: f64,
}

impl Default for JerkLimited {
    /// Stops within 2e-4 of the optimal duration.
    fn default() -> Self {
        Self { tolerance: 2e-4 }
    }
}

impl JerkLimited {
    /// Stops once the duration is within this fraction of the optimum of its problem; 1e-8 at the least is used.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn new(tolerance: f64) -> Result<Self, FeedError> {
        Ok(Self { tolerance: positive("tolerance", tolerance)?.clamp(1e-8, 1e-2) })
    }

    /// The law, and whether the iterations converged.
    ///
    /// # Errors
    /// As [`FeedPlanner::plan`].
    pub fn plan_noting_convergence(&self, problem: &FeedProblem) -> Result<JerkLimitedPlan, FeedError> {
        self.plan_or_why(problem).map_err(|why| end_speed::explain(self, problem, why))
    }

    /// The fastest iterate inside all bounds, of one stretch.
    fn solve(
        &self,
        prepared: &Prepared,
        solver: &mut Solver,
        part: &Part,
        attempt: Attempt<'_>,
    ) -> Result<Solution, NotSolved> {
        let Prepared { problem, fastest, .. } = prepared;
        let fresh = || {
            let mut stretch = Stretch::new(problem, [part.grid.start, part.grid.end], part.speeds, fastest);
            if attempt.factor < 1.0 {
                stretch.tighten(attempt.factor);
            }
            stretch
        };
        let mut stretch = fresh();
        if let Some(before) = attempt.before {
            stretch.knots.evaluate(&before.c, &mut solver.values);
            stretch.demand_margins(problem, &solver.values);
        }
        let start = start::start(problem, &mut stretch, fastest);
        let outcome = solver.minimise(problem, &mut stretch, start, self.tolerance, attempt.drop_distant);
        if outcome.wider <= 10.0 * self.tolerance {
            // Inside all bounds: a motion, however far it is from the optimum.
            return Ok(Solution { stretch, c: solver.c.clone(), converged: outcome.is_close() });
        }
        if part.slows(problem) {
            // The bounds were widened for the start and could not be taken back: from a start that is inside.
            let mut stretch = fresh();
            if let Some(start) = start::inside(problem, &stretch, fastest) {
                let outcome = solver.minimise(problem, &mut stretch, start, self.tolerance, false);
                return Ok(Solution { stretch, c: solver.c.clone(), converged: outcome.is_close() });
            }
        }
        let error = FeedError::NotConverged {
            what: "the jerk-limited planner",
            iterations: outcome.iterations,
            residual: outcome.wider,
        };
        let binding = solver.binding(&stretch).filter(|_| !attempt.drop_distant);
        let binding = binding.and_then(|i| stretch.limit(problem, i));
        Err(NotSolved { error, binding })
    }

    /// The plan, or why there is none, with all rows.
    fn plan_or_why(&self, problem: &FeedProblem) -> Result<JerkLimitedPlan, NotSolved> {
        self.plan_with(problem, DROP_UP_TO).or_else(|why| match why.error {
            FeedError::NotConverged { .. } => self.plan_with(problem, 0),
            _ => Err(why),
        })
    }

    /// The plan. Rows far from their bounds are dropped on stretches of up to `drop_up_to` intervals.
    fn plan_with(&self, problem: &FeedProblem, drop_up_to: usize) -> Result<JerkLimitedPlan, NotSolved> {
        let prepared = &prepare(problem)?;
        let Prepared { problem, parts, .. } = prepared;
        let mut solver = Solver::default();
        let mut solutions = Vec::with_capacity(parts.len());
        for part in parts {
            let attempt = Attempt { drop_distant: part.grid.len() <= drop_up_to, factor: 1.0, before: None };
            solutions.push(self.solve(prepared, &mut solver, part, attempt)?);
        }
        let mut plan = assemble(problem, &solutions)?;
        let mut factors = vec![1.0; parts.len()];
        for attempt in 0..ATTEMPTS {
            let mut changed = false;
            for ((part, solution), factor) in parts.iter().zip(&mut solutions).zip(&mut factors) {
                let scale = largest_scale(problem, &plan, part.grid.clone());
                if scale >= 1.0 - ROUND_OFF {
                    continue;
                }
                changed = true;
                if scale < 1.0 - TAKEN_OFF && attempt == 0 {
                    let careful = Attempt { drop_distant: false, factor: 1.0, before: Some(solution) };
                    *solution = self.solve(prepared, &mut solver, part, careful)?;
                } else if part.slows(problem) && attempt < SLOWED {
                    solution.scale(scale);
                } else {
                    // With less for all rows: friction gains on the rest where the motion is slowed down.
                    *factor *= 1.0 - 2.0 * (1.0 - scale);
                    let lower = Attempt { drop_distant: false, factor: *factor, before: None };
                    *solution = self.solve(prepared, &mut solver, part, lower)?;
                }
            }
            if !changed {
                return Ok(JerkLimitedPlan::of(plan, &solutions));
            }
            plan = assemble(problem, &solutions)?;
        }
        self.slow_down(prepared, solutions, plan)
    }

    /// Takes off the speed what is still too much, as long as that helps.
    fn slow_down(
        &self,
        prepared: &Prepared,
        mut solutions: Vec<Solution>,
        mut plan: SpeedLaw,
    ) -> Result<JerkLimitedPlan, NotSolved> {
        let Prepared { problem, parts, .. } = prepared;
        for _ in 0..SLOWED_AT_LAST {
            let mut changed = false;
            for (part, solution) in parts.iter().zip(&mut solutions) {
                let scale = largest_scale(problem, &plan, part.grid.clone());
                if scale < 1.0 - ROUND_OFF && scale > 0.0 && part.slows(problem) {
                    solution.scale(scale);
                    changed = true;
                }
            }
            if !changed {
                break;
            }
            plan = assemble(problem, &solutions)?;
        }
        let left = 1.0 - largest_scale(problem, &plan, 0..problem.intervals());
        if left <= EXCEEDED {
            return Ok(JerkLimitedPlan::of(plan, &solutions));
        }
        Err(FeedError::NotConverged {
            what: "the jerk-limited planner between the grid points",
            iterations: ATTEMPTS,
            residual: left,
        }
        .into())
    }
}

/// A law of [`JerkLimited`], and whether its iterations came close to the optimum.
#[derive(Debug, Clone, PartialEq)]
pub struct JerkLimitedPlan {
    /// The law. It keeps all limits whether the iterations converged or not.
    pub law: SpeedLaw,
    /// Whether the law is within 2 % of the optimum of its problem; where not, another grid or planner may find a faster one.
    pub converged: bool,
}

impl JerkLimitedPlan {
    fn of(law: SpeedLaw, solutions: &[Solution]) -> Self {
        Self { law, converged: solutions.iter().all(|solution| solution.converged) }
    }
}

/// A limit and where it stands against a motion.
type Binding = (LimitId, f64);

/// Why there is no solution.
#[derive(Debug, Clone, Copy)]
struct NotSolved {
    error: FeedError,
    binding: Option<Binding>,
}

impl From<FeedError> for NotSolved {
    fn from(error: FeedError) -> Self {
        Self { error, binding: None }
    }
}

/// How a stretch is solved.
#[derive(Debug, Clone, Copy)]
struct Attempt<'a> {
    drop_distant: bool,
    /// By which all bounds are lowered.
    factor: f64,
    /// What came out too fast between the grid points: margins follow it from the start.
    before: Option<&'a Solution>,
}

#[derive(Debug)]
struct Solution {
    stretch: Stretch,
    c: Vec<f64>,
    /// Whether the iterations came close to the optimum.
    converged: bool,
}

impl Solution {
    fn scale(&mut self, factor: f64) {
        self.c.iter_mut().for_each(|c| *c *= factor);
    }

    fn push(&self, problem: &FeedProblem, builder: &mut Builder, values: &mut Values) {
        let Self { stretch, c, .. } = self;
        stretch.knots.evaluate(c, values);
        let (m, a, grid) = (stretch.knots.intervals(), stretch.from, problem.grid());
        if let End::Rest { h } = stretch.ends[0] {
            builder.push_from_rest(grid[a - 1], h, values.x[0]);
        }
        for k in 0..m {
            let h = stretch.knots.h[k];
            builder.push_slope(grid[a + k], h, [values.x[k], values.x[k + 1]], values.u[k], values.w[k]);
        }
        if let End::Rest { h } = stretch.ends[1] {
            builder.push_to_rest(grid[a + m], h, values.x[m]);
        }
    }
}

fn assemble(problem: &FeedProblem, solutions: &[Solution]) -> Result<SpeedLaw, FeedError> {
    let mut builder = Builder::with_capacity(problem.intervals());
    let mut values = Values::default();
    for solution in solutions {
        solution.push(problem, &mut builder, &mut values);
    }
    builder.finish(problem.grid()[problem.intervals()], problem.v_end())
}

/// Rows far from their bounds are dropped on stretches of as many intervals. On finer ones acceleration builds up over many
/// intervals, whose rows all are distant at one time or another, and dropping them means solving twice.
const DROP_UP_TO: usize = 2500;

/// Where more than this has to be taken off the speed at the end, something was left out.
const TAKEN_OFF: f64 = 1e-3;

/// What has to be taken off the speed by round-off.
const ROUND_OFF: f64 = 1e-12;

/// Times that something too fast between the grid points is dealt with, and how many of them by slowing down.
const ATTEMPTS: usize = 8;
const SLOWED: usize = 4;

/// Slowing down at last: with friction each time takes off half of what is too much.
const SLOWED_AT_LAST: usize = 60;

/// What a motion that cannot be slowed down may exceed its limits by, between the grid points.
const EXCEEDED: f64 = 1e-7;

impl FeedPlanner for JerkLimited {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        self.plan_noting_convergence(problem).map(|plan| plan.law)
    }
}
