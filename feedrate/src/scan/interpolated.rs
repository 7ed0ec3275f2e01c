//! Reachability that keeps the limits between the grid points too.
//!
//! With `u` constant on an interval the duration is only accurate to the first power of its length
//! (0.3 % at N = 1000). [`InterpolatedReachability`] takes the optimum of the rows at the points,
//! reads off the slope of `u` on every interval, and solves again with these slopes given, which
//! leaves the programs linear. Where the path is cubic in `s` the acceleration of a joint then is
//! cubic and its squared speed of degree six; both lie in the hull of their Bernstein coefficients,
//! which are linear in `(u, x)`, so that bounding those keeps the limits everywhere on such a path.

use super::forward_backward::moves;
use super::reachability::{Solver, solve, solve_moving};
use crate::error::FeedError;
use crate::problem::{FeedPlanner, FeedProblem};
use crate::speed_law::{Builder, SpeedLaw};

/// Reachability that keeps the limits between the grid points too; needs
/// [`FeedProblem::between_points`].
///
/// Velocity and acceleration of joints and feeds are kept everywhere if the path is piecewise cubic
/// on the grid (put the knots of its spline on the grid). On other paths, and for torque, the same
/// rows hold for the interpolation of the rows through both ends and the middle: what is left is
/// the error of that, which falls with the third power of the interval.
#[derive(Debug, Clone, Copy, Default)]
pub struct InterpolatedReachability;

impl FeedPlanner for InterpolatedReachability {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        if !problem.is_between_points() {
            return Err(FeedError::Empty { what: "rows between the grid points (FeedProblem::between_points)" });
        }
        // Whatever the slopes are, the second solution is safe; without them it is complete.
        let guess = solve(problem, false)?;
        let slopes = slopes(problem, &guess);
        let sloped = Solver::new(problem, true, &guess, &slopes).solve().and_then(|x| {
            moves(problem, &x)?;
            sloped_plan(problem, &x, &slopes)
        });
        sloped.or_else(|_| {
            let x = solve_moving(problem, true)?;
            SpeedLaw::from_squared_speeds(problem.grid(), &x)
        })
    }
}

/// The slope of `u` on every interval as a first solution has it: of the differences to both
/// neighbours the lesser, and none where they disagree (jumps and turning points) or next to rest.
fn slopes(problem: &FeedProblem, x: &[f64]) -> Vec<f64> {
    let u = |k: usize| 0.5 * (x[k + 1] - x[k]) / problem.h(k);
    let difference = |k: usize| 2.0 * (u(k + 1) - u(k)) / (problem.h(k) + problem.h(k + 1));
    let n = problem.intervals();
    let slope = |k: usize| {
        if k == 0 || k + 1 == n || x[k] == 0.0 || x[k + 1] == 0.0 {
            return 0.0;
        }
        let (before, after) = (difference(k - 1), difference(k));
        if before * after > 0.0 { if before.abs() < after.abs() { before } else { after } } else { 0.0 }
    };
    (0..n).map(slope).collect()
}

fn sloped_plan(problem: &FeedProblem, x: &[f64], slopes: &[f64]) -> Result<SpeedLaw, FeedError> {
    let (n, grid) = (problem.intervals(), problem.grid());
    let mut builder = Builder::with_capacity(n);
    for k in 0..n {
        let h = problem.h(k);
        let u = 0.5 * (x[k + 1] - x[k]) / h;
        builder.push_slope(grid[k], h, [x[k], x[k + 1]], u - 0.5 * h * slopes[k], slopes[k]);
    }
    builder.finish(grid[n], x[n].sqrt())
}
