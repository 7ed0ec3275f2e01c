//! Third order: the fastest speed law under limits on velocity, acceleration, torque and jerk.
mod band;
mod between;
mod interior_point;
mod spline;
mod start;
mod stretch;

use crate::error::FeedError;
use crate::grid_plan::{Builder, GridPlan};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::scan::both_ends::squared_speeds;
use interior_point::Solver;
use stretch::Stretch;

/// The jerk-limited planner.
#[derive(Debug, Clone, Copy)]
pub struct JerkLimited {
    /// relative gap
    pub tolerance: f64,
}

impl FeedPlanner for JerkLimited {
    fn plan(&self, problem: &FeedProblem) -> Result<GridPlan, FeedError> {
        let n = problem.intervals();
        let limit = squared_speeds(problem)?;
        let mut solver = Solver::default();
        let mut stretch = Stretch::new(problem, [0, n], [0.0; 2], &limit);
        let start = start::start(problem, &mut stretch, &limit);
        let outcome = solver.minimise(&mut stretch, start, self.tolerance, |stretch, values| stretch.set_margins(problem, values));
        if std::env::var("OUT").is_ok() { eprintln!("{outcome:?}"); }
        let g = problem.grid();
        let mut plan = GridPlan::from_squared_speeds(&[0.0, 1.0], &[1.0, 1.0])?;
        for _ in 0..2 {
            let v = &solver.values;
            let m = stretch.knots.intervals();
            let mut builder = Builder::with_capacity(n);
            builder.push_from_rest(g[0], g[1] - g[0], v.x[0]);
            for k in 0..m {
                builder.push_slope(g[k + 1], stretch.knots.h[k], v.x[k], v.u[k], v.w[k], v.x[k + 1]);
            }
            builder.push_to_rest(g[n - 1], g[n] - g[n - 1], v.x[m]);
            plan = builder.finish(g[n], 0.0)?;
            let scale = between::largest_scale(problem, &plan);
            if std::env::var("OUT").is_ok() { eprintln!("scale - 1 {}", scale - 1.0); }
            solver.c.iter_mut().for_each(|c| *c *= scale);
            stretch.knots.evaluate(&solver.c, &mut solver.values);
        }
        Ok(plan)
    }
}
