//! The convex optimum of the same rows, by a general conic solver: the yardstick for every other planner.
//!
//! Second-order cone program of D. Verscheure et al., "Time-optimal path tracking for robots: a convex optimization approach",
//! IEEE Trans. Autom. Control 2009, 54, 2318, with the rows at both ends of every interval, as the scans have them:
//!
//! ```text
//! minimise  sum of 2 h_k d_k    over x, c, d
//! with      (2 c_i, x_i - 1, x_i + 1)  and  (2, c_k + c_k+1 - d_k, c_k + c_k+1 + d_k)   in the second-order cone
//! ```
//!
//! so that `c_i <= sqrt(x_i)` and `d_k >= 1 / (c_k + c_k+1)`. Whatever feasible dual point the solver ends at bounds the duration of
//! every plan of these rows from below.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::error::FeedError;
use crate::grid_plan::GridPlan;
use crate::problem::{FeedPlanner, FeedProblem};
use crate::scan::both_ends::squared_speeds;

/// The second-order optimum by clarabel; hundreds of milliseconds, needed for comparison only.
///
/// Rows with a term in `sqrt(x)` are not convex and are refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct ClarabelBaseline;

/// A plan and how far from the optimum it can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounded {
    /// The plan.
    pub plan: GridPlan,
    /// No plan that keeps the rows at both ends of every interval takes less than this (s), to the solver's tolerance.
    pub lower_bound: f64,
    /// Whether the solver reached its full accuracy.
    pub accurate: bool,
}

impl FeedPlanner for ClarabelBaseline {
    fn plan(&self, problem: &FeedProblem) -> Result<GridPlan, FeedError> {
        self.solve(problem).map(|bounded| bounded.plan)
    }
}

/// Rows `a . v + s = b` with their nonzeros, in the order of the cones.
#[derive(Debug, Default)]
struct Rows {
    row: Vec<usize>,
    column: Vec<usize>,
    value: Vec<f64>,
    b: Vec<f64>,
}

impl Rows {
    /// `sum of terms <= bound` in the nonnegative cone, or one entry `bound - terms` of another.
    fn push(&mut self, bound: f64, terms: &[(usize, f64)]) {
        for &(column, value) in terms {
            self.row.push(self.b.len());
            self.column.push(column);
            self.value.push(value);
        }
        self.b.push(bound);
    }
}

impl ClarabelBaseline {
    /// The optimum together with the bound of the dual problem.
    ///
    /// # Errors
    /// [`FeedError::NotConverged`] if the solver fails, [`FeedError::BadRow`] for a row with friction, and those of the
    /// scan, which supplies the scale.
    pub fn solve(&self, problem: &FeedProblem) -> Result<Bounded, FeedError> {
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
        let variables = 3 * n + 2;
        let mut rows = Rows::default();
        let (x_start, x_end) = (problem.v_start().powi(2) / x_unit, problem.v_end().powi(2) / x_unit);
        rows.push(x_start, &[(0, 1.0)]);
        rows.push(x_end, &[(n, 1.0)]);
        for i in 0..=n {
            rows.push(0.0, &[(i, -1.0)]);
            let cap = problem.x_max(i);
            if cap < f64::INFINITY {
                rows.push(cap / x_unit, &[(i, 1.0)]);
            }
        }
        for k in 0..n {
            let per_u = 0.5 / problem.h(k);
            for i in [k, k + 1] {
                for row in problem.rows(i) {
                    if row.c != 0.0 {
                        return Err(FeedError::BadRow { index: i, s: grid[i], row: row.source });
                    }
                    let a = row.a * per_u;
                    let (start, end) = if i == k { (row.b - a, a) } else { (-a, a + row.b) };
                    // Each row in units of its bound.
                    for (sign, bound) in [(1.0, row.hi - row.d), (-1.0, row.d - row.lo)] {
                        if bound < f64::INFINITY {
                            let unit = if bound > 0.0 { sign / bound } else { sign };
                            rows.push(bound * unit * sign, &[(k, start * unit * x_unit), (k + 1, end * unit * x_unit)]);
                        }
                    }
                }
            }
        }
        let mut cones = vec![SupportedConeT::ZeroConeT(2), SupportedConeT::NonnegativeConeT(rows.b.len() - 2)];
        for i in 0..=n {
            rows.push(1.0, &[(i, -1.0)]);
            rows.push(-1.0, &[(i, -1.0)]);
            rows.push(0.0, &[(c(i), -2.0)]);
            cones.push(SupportedConeT::SecondOrderConeT(3));
        }
        for k in 0..n {
            let both = [(c(k), -1.0), (c(k + 1), -1.0)];
            rows.push(0.0, &[both[0], both[1], (d(k), -1.0)]);
            rows.push(0.0, &[both[0], both[1], (d(k), 1.0)]);
            rows.push(2.0, &[]);
            cones.push(SupportedConeT::SecondOrderConeT(3));
        }
        let mut cost = vec![0.0; variables];
        for k in 0..n {
            cost[d(k)] = 2.0 * problem.h(k) / length;
        }
        let matrix = CscMatrix::new_from_triplets(rows.b.len(), variables, rows.row, rows.column, rows.value);
        let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
        let failed = |iterations: u32, residual: f64| FeedError::NotConverged {
            what: "clarabel",
            iterations: usize::try_from(iterations).unwrap_or(usize::MAX),
            residual,
        };
        let nothing = CscMatrix::zeros((variables, variables));
        let mut solver =
            DefaultSolver::new(&nothing, &cost, &matrix, &rows.b, &cones, settings).map_err(|_| failed(0, f64::NAN))?;
        solver.solve();
        let solution = &solver.solution;
        let accurate = solution.status == SolverStatus::Solved;
        if !accurate && solution.status != SolverStatus::AlmostSolved {
            return Err(failed(solution.iterations, solution.r_prim));
        }
        let mut x: Vec<f64> = solution.x[..=n].iter().map(|x| x.max(0.0) * x_unit).collect();
        (x[0], x[n]) = (problem.v_start().powi(2), problem.v_end().powi(2));
        let plan = GridPlan::from_squared_speeds(grid, &x)?;
        Ok(Bounded { plan, lower_bound: solution.obj_val_dual * time, accurate })
    }
}
