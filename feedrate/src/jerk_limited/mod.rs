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
mod interior_point;
mod refine;
mod spline;
mod start;
mod stretch;

use std::ops::Range;

use crate::constraint::Within;
use crate::error::{FeedError, positive};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::scan::both_ends::{moves, squared_speeds};
use crate::scan::reachability::Reachability;
use crate::speed_law::{Builder, SpeedLaw};
use between::largest_scale;
use interior_point::Solver;
use refine::refined;
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

    fn solve(
        &self,
        problem: &FeedProblem,
        solver: &mut Solver,
        fastest: &[f64],
        part: &Part,
        attempt: Attempt<'_>,
    ) -> Result<Solution, FeedError> {
        let mut stretch = Stretch::new(problem, [part.grid.start, part.grid.end], part.speeds, fastest);
        if attempt.factor < 1.0 {
            stretch.tighten(attempt.factor);
        }
        if let Some(before) = attempt.before {
            stretch.knots.evaluate(&before.c, &mut solver.values);
            stretch.demand_margins(problem, &solver.values);
        }
        let start = start::start(problem, &mut stretch, fastest);
        let outcome = solver.minimise(problem, &mut stretch, start, self.tolerance, attempt.drop_distant);
        let left = outcome.gap.max(outcome.ahead);
        if outcome.wider > 10.0 * self.tolerance || !(left < CLOSE) {
            return Err(FeedError::NotConverged {
                what: "the jerk-limited planner",
                iterations: outcome.iterations,
                residual: outcome.wider.max(left),
            });
        }
        Ok(Solution { stretch, c: solver.c.clone() })
    }
}

/// A stretch of grid between two stops, or an end of the path at a speed.
#[derive(Debug, Clone)]
struct Part {
    /// First and last grid point.
    grid: Range<usize>,
    speeds: [f64; 2],
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
}

impl Solution {
    fn scale(&mut self, factor: f64) {
        self.c.iter_mut().for_each(|c| *c *= factor);
    }

    /// Whether the motion can be slowed down as a whole.
    fn rests(&self) -> bool {
        self.stretch.ends.iter().all(|end| matches!(end, End::Rest { .. }))
    }

    fn push(&self, problem: &FeedProblem, builder: &mut Builder, values: &mut Values) {
        let Self { stretch, c } = self;
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

/// The stretches between stops: grid points with a cap of 0.
fn parts(problem: &FeedProblem) -> Result<Vec<Part>, FeedError> {
    let n = problem.intervals();
    let mut parts = Vec::new();
    let mut from = 0;
    for i in (1..=n).filter(|&i| i == n || problem.x_max(i) == 0.0) {
        let speeds = [if from == 0 { problem.v_start() } else { 0.0 }, if i == n { problem.v_end() } else { 0.0 }];
        let expected = 2 + speeds.iter().filter(|&&v| v == 0.0).count();
        if i - from < expected {
            return Err(FeedError::LengthMismatch {
                what: "a stretch between two stops (intervals)",
                got: i - from,
                expected,
            });
        }
        parts.push(Part { grid: from..i, speeds });
        from = i;
    }
    Ok(parts)
}

/// Acceleration starts and ends at 0, so standing still must be possible where the motion does.
fn stands(problem: &FeedProblem, i: usize) -> Result<(), FeedError> {
    match problem.rows(i).iter().find(|row| !(row.lo <= row.d && row.d <= row.hi)) {
        Some(row) => Err(FeedError::StaticallyInfeasible {
            index: i,
            s: problem.grid()[i],
            row: row.source,
            value: row.d,
            limit: if row.d > row.hi { row.hi } else { row.lo },
        }),
        None => Ok(()),
    }
}

/// Rows far from their bounds are dropped on stretches of as many intervals. On finer ones acceleration builds up over many
/// intervals, whose rows all are distant at one time or another, and dropping them means solving twice.
const DROP_UP_TO: usize = 2500;

/// An iterate inside all bounds is a motion. One that is this close to the optimum is taken where round-off stops the iterations.
const CLOSE: f64 = 0.02;

/// As many intervals are taken on; with more of them the iterations get many.
const MOST_INTERVALS: usize = 200_000;

/// As many rows are taken on: with all that belongs to them, some two gigabytes.
const MOST_ROWS: usize = 5_000_000;

/// Refuses what would take minutes, or not fit into the memory of an ordinary machine.
fn fits(problem: &FeedProblem) -> Result<(), FeedError> {
    let got = problem.intervals();
    if got > MOST_INTERVALS {
        return Err(FeedError::TooMany { what: "intervals for the jerk-limited planner", got, most: MOST_INTERVALS });
    }
    // Points and both ends of every interval; those that bound the speed inside come on top.
    let of = |k: usize| {
        problem.rows(k).len() + 2 * (problem.middle_rows(k).len() + problem.jerk_rows(k, Within::Start).len())
    };
    let got = (0..problem.intervals()).map(of).sum();
    let what = "rows of all intervals of the jerk-limited planner";
    if got <= MOST_ROWS { Ok(()) } else { Err(FeedError::TooMany { what, got, most: MOST_ROWS }) }
}

/// A problem made ready.
#[derive(Debug)]
struct Prepared {
    /// With the intervals next to rest split.
    problem: FeedProblem,
    /// Squared speeds of a second-order planner.
    fastest: Vec<f64>,
    parts: Vec<Part>,
}

fn prepare(problem: &FeedProblem) -> Result<Prepared, FeedError> {
    if !problem.is_between_points() {
        return Err(FeedError::Empty { what: "rows between the grid points (FeedProblem::between_points)" });
    }
    if !problem.has_jerk() {
        return Err(FeedError::Empty { what: "limits on jerk" });
    }
    fits(problem)?;
    let problem = refined(problem);
    let fastest = squared_speeds(&problem).or_else(|error| match error {
        // Reachability passes points at which standing still is impossible.
        FeedError::StaticallyInfeasible { .. } => Reachability.squared_speeds(&problem),
        error => Err(error),
    })?;
    moves(&problem, &fastest)?;
    let parts = parts(&problem)?;
    for part in &parts {
        for (i, speed) in [part.grid.start, part.grid.end].into_iter().zip(part.speeds) {
            if speed == 0.0 {
                stands(&problem, i)?;
            }
        }
    }
    Ok(Prepared { problem, fastest, parts })
}

/// Where more than this has to be taken off the speed at the end, something was left out.
const TAKEN_OFF: f64 = 1e-3;

/// What a motion that cannot be slowed down may exceed its limits by.
const EXCEEDED: f64 = 1e-7;

impl FeedPlanner for JerkLimited {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        let Prepared { problem, fastest, parts } = &prepare(problem)?;
        let mut solver = Solver::default();
        let mut solutions = Vec::with_capacity(parts.len());
        for part in parts {
            let attempt = Attempt { drop_distant: part.grid.len() <= DROP_UP_TO, factor: 1.0, before: None };
            solutions.push(self.solve(problem, &mut solver, fastest, part, attempt)?);
        }
        let mut plan = assemble(problem, &solutions)?;
        let mut factors = vec![1.0; parts.len()];
        for attempt in 0..4 {
            let mut changed = false;
            for ((part, solution), factor) in parts.iter().zip(&mut solutions).zip(&mut factors) {
                let scale = largest_scale(problem, &plan, part.grid.clone());
                if scale < 1.0 - TAKEN_OFF && attempt == 0 {
                    let careful = Attempt { drop_distant: false, factor: 1.0, before: Some(solution) };
                    *solution = self.solve(problem, &mut solver, fastest, part, careful)?;
                } else if solution.rests() && scale < 1.0 {
                    solution.scale(scale);
                } else if scale < 1.0 - EXCEEDED {
                    *factor *= 1.0 - 2.0 * (1.0 - scale);
                    let lower = Attempt { drop_distant: false, factor: *factor, before: None };
                    *solution = self.solve(problem, &mut solver, fastest, part, lower)?;
                } else {
                    continue;
                }
                changed = true;
            }
            if !changed {
                return Ok(plan);
            }
            plan = assemble(problem, &solutions)?;
        }
        let left = 1.0 - largest_scale(problem, &plan, 0..problem.intervals());
        if left < 1e-6 {
            return Ok(plan);
        }
        Err(FeedError::NotConverged {
            what: "the jerk-limited planner between the grid points",
            iterations: 4,
            residual: left,
        })
    }
}
