//! The convex optimum of the same rows, by a general conic solver: the yardstick for every other
//! planner.
//!
//! Second-order cone program of D. Verscheure et al., "Time-optimal path tracking for robots: a
//! convex optimization approach", IEEE Trans. Autom. Control 2009, 54, 2318, with the rows at both
//! ends of every interval, as the scans have them:
//!
//! ```text
//! minimise  sum of 2 h_k d_k    over x, c, d
//! with      (2 c_i, x_i - 1, x_i + 1)  and  (2, c_k + c_k+1 - d_k, c_k + c_k+1 + d_k)   in the second-order cone
//! ```
//!
//! so that `c_i <= sqrt(x_i)` and `d_k >= 1 / (c_k + c_k+1)`. Whatever feasible dual point the
//! solver ends at bounds the duration of every plan of these rows from below.
//!
//! With limits on jerk the problem is not convex. Divided by `sqrt(x)` a jerk row has the convex
//! right side `J x^(-1/2)`, whose tangent at any `x` is below it; with the tangents at one motion
//! in its place the program is convex, and its optimum keeps the true rows. Solved again with the
//! tangents there, a few times, it ends at a motion that no such program betters. Unknown is the
//! same quadratic B-spline `x(s)` as in [`crate::jerk_limited`], with the same rows at the same
//! places, jerk in the middle of the intervals besides.

use crate::conic_program::{Program, straight};
use crate::error::FeedError;
use crate::jerk_limited::conic;
use crate::problem::{FeedPlanner, FeedProblem};
use crate::scan::forward_backward::squared_speeds;
use crate::speed_law::SpeedLaw;

/// The optimum by clarabel; hundreds of milliseconds to seconds, needed for comparison only.
///
/// A problem without limits on jerk is solved as it is. One with them needs what
/// [`crate::JerkLimited`] needs ([`FeedProblem::between_points`] besides) and is solved by a
/// sequence of programs: its plan keeps the jerk at both ends and in the middle of every interval,
/// to the solver's tolerance, not between these.
///
/// Rows with a term in `sqrt(x)` are not convex and are refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct ClarabelBaseline;

/// A plan and how far from the optimum it can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounded {
    /// The plan: with limits on jerk the best of the sequence, a local optimum.
    pub plan: SpeedLaw,
    /// No plan with constant acceleration on every interval that keeps the rows at both ends of
    /// each takes less than this (s), to the solver's tolerance.
    ///
    /// With limits on jerk this is the bound without them. Such a plan has to keep more, so it
    /// bounds those too, but for what varying acceleration inside the intervals is worth: of first
    /// order in their length, 0.3 % at N = 100 and a few 0.01 % at N = 1000. How far a jerk-limited
    /// plan is from its own optimum it does not tell.
    pub lower_bound: f64,
    /// True if the solver reached its full accuracy, in every program.
    pub accurate: bool,
}

impl FeedPlanner for ClarabelBaseline {
    /// [`ClarabelBaseline::solve`] without its bound.
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        if problem.has_jerk() {
            return conic::solve(problem).map(|(plan, _)| plan);
        }
        self.solve(problem).map(|bounded| bounded.plan)
    }
}

impl ClarabelBaseline {
    /// The optimum together with the bound of the dual problem.
    ///
    /// # Errors
    /// [`FeedError::NotConverged`] if the solver fails, [`FeedError::BadRow`] for a row with
    /// friction, and those of the scan, which supplies the scale; with limits on jerk those of
    /// [`crate::JerkLimited`] too.
    pub fn solve(&self, problem: &FeedProblem) -> Result<Bounded, FeedError> {
        let bounded = second_order(problem)?;
        if !problem.has_jerk() {
            return Ok(bounded);
        }
        let (plan, accurate) = conic::solve(problem)?;
        Ok(Bounded { plan, accurate: accurate && bounded.accurate, ..bounded })
    }
}

fn second_order(problem: &FeedProblem) -> Result<Bounded, FeedError> {
    straight(problem)?;
    let (n, grid) = (problem.intervals(), problem.grid());
    let scan = squared_speeds(problem)?;
    let length = grid[n] - grid[0];
    // In units of the path and of the scan's duration all numbers are near 1.
    let time: f64 = (0..n).map(|k| 2.0 * problem.h(k) / (scan[k].sqrt() + scan[k + 1].sqrt())).sum();
    if !(time > 0.0 && time < f64::INFINITY) {
        return Err(FeedError::OutOfRange { what: "duration of the plan" });
    }
    let x_unit = (length / time).powi(2);
    let (c, d) = (|i: usize| n + 1 + i, |k: usize| 2 * (n + 1) + k);
    let mut program = Program::new(3 * n + 2);
    program.equal(problem.v_start().powi(2) / x_unit, &[(0, 1.0)]);
    program.equal(problem.v_end().powi(2) / x_unit, &[(n, 1.0)]);
    for i in 0..=n {
        program.at_most(0.0, &[(i, -1.0)]);
        let cap = problem.x_max(i);
        if cap < f64::INFINITY {
            program.at_most(cap / x_unit, &[(i, 1.0)]);
        }
    }
    for k in 0..n {
        let per_u = 0.5 / problem.h(k);
        for i in [k, k + 1] {
            for row in problem.rows(i) {
                let a = row.a * per_u;
                let (start, end) = if i == k { (row.b - a, a) } else { (-a, a + row.b) };
                // Each row in units of its bound.
                for (sign, bound) in [(1.0, row.hi - row.d), (-1.0, row.d - row.lo)] {
                    if bound < f64::INFINITY {
                        let unit = if bound > 0.0 { sign / bound } else { sign };
                        let terms = [(k, start * unit * x_unit), (k + 1, end * unit * x_unit)];
                        program.at_most(bound * unit * sign, &terms);
                    }
                }
            }
        }
    }
    for i in 0..=n {
        program.root(c(i), [(i, 1.0)]);
    }
    for k in 0..n {
        program.inverse(d(k), [c(k), c(k + 1)]);
        program.cost(d(k), 2.0 * problem.h(k) / length);
    }
    let optimum = program.solve()?;
    let mut x: Vec<f64> = optimum.variables[..=n].iter().map(|x| x.max(0.0) * x_unit).collect();
    (x[0], x[n]) = (problem.v_start().powi(2), problem.v_end().powi(2));
    let plan = SpeedLaw::from_squared_speeds(grid, &x)?;
    Ok(Bounded { plan, lower_bound: optimum.dual * time, accurate: optimum.accurate })
}
