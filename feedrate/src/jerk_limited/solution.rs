//! Solutions of the parts of a path, and the law they make together.

use super::barrier_problem::BarrierProblem;
use super::parts::Prepared;
use super::spline::{End, Values};
use crate::error::FeedError;
use crate::problem::FeedProblem;
use crate::row::LimitId;
use crate::speed_law::{Builder, SpeedLaw};

/// A law of [`JerkLimited`](crate::JerkLimited), and whether its iterations came close to the
/// optimum.
#[derive(Debug, Clone, PartialEq)]
pub struct JerkLimitedPlan {
    /// The law. It keeps all limits whether the iterations converged or not.
    pub law: SpeedLaw,
    /// True if the law is within 2 % of the optimum of its problem; where not, another grid or
    /// planner may find a faster one.
    pub converged: bool,
    /// The time that each interval of the grid costs by its length, s: about what the motion gains where shorter intervals take its
    /// place. 0 where no limit on jerk binds.
    pub grid_costs: Vec<f64>,
}

/// A draft of a plan ([`JerkLimited::draft`](crate::JerkLimited::draft)), which is no motion: its law may exceed limits.
#[derive(Debug, Clone, PartialEq)]
pub struct JerkLimitedDraft {
    /// A law near the optimum, from which a plan can start. Between grid points its jerk can be several times the limit.
    pub law: SpeedLaw,
    /// As [`JerkLimitedPlan::grid_costs`].
    pub grid_costs: Vec<f64>,
}

impl JerkLimitedPlan {
    pub(super) fn of(prepared: &Prepared<'_>, law: SpeedLaw, solutions: &[Solution]) -> Self {
        let (original, refined) = (prepared.original.grid(), prepared.problem.grid());
        let mut grid_costs = vec![0.0; original.len() - 1];
        let mut k = 0;
        for solution in solutions {
            let from = solution.barrier_problem.from;
            for (i, cost) in solution.grid_costs.iter().enumerate() {
                // Next to rest an interval may be split.
                while k + 2 < original.len() && original[k + 1] <= refined[from + i] {
                    k += 1;
                }
                grid_costs[k] += cost;
            }
        }
        Self { law, converged: solutions.iter().all(|solution| solution.converged), grid_costs }
    }
}

/// A limit and where it stands against a motion.
pub(super) type Binding = (LimitId, f64);

/// Why there is no solution.
#[derive(Debug, Clone, Copy)]
pub(super) struct NotSolved {
    pub error: FeedError,
    pub binding: Option<Binding>,
}

impl From<FeedError> for NotSolved {
    fn from(error: FeedError) -> Self {
        Self { error, binding: None }
    }
}

#[derive(Debug)]
pub(super) struct Solution {
    pub barrier_problem: BarrierProblem,
    pub c: Vec<f64>,
    /// True if the iterations came close to the optimum.
    pub converged: bool,
    /// The time that each interval costs by its length, s.
    pub grid_costs: Vec<f64>,
}

impl Solution {
    pub fn scale(&mut self, factor: f64) {
        self.c.iter_mut().for_each(|c| *c *= factor);
    }

    fn push(&self, problem: &FeedProblem, builder: &mut Builder, values: &mut Values) {
        let Self { barrier_problem, c, .. } = self;
        barrier_problem.knots.evaluate(c, values);
        let (m, a, grid) = (barrier_problem.knots.intervals(), barrier_problem.from, problem.grid());
        if let End::Rest { h } = barrier_problem.ends[0] {
            builder.push_from_rest(grid[a - 1], h, values.x[0]);
        }
        for k in 0..m {
            let h = barrier_problem.knots.h[k];
            builder.push_slope(grid[a + k], h, [values.x[k], values.x[k + 1]], values.u[k], values.w[k]);
        }
        if let End::Rest { h } = barrier_problem.ends[1] {
            builder.push_to_rest(grid[a + m], h, values.x[m]);
        }
    }
}

pub(super) fn assemble(problem: &FeedProblem, solutions: &[Solution]) -> Result<SpeedLaw, FeedError> {
    let mut builder = Builder::with_capacity(problem.intervals());
    let mut values = Values::default();
    for solution in solutions {
        solution.push(problem, &mut builder, &mut values);
    }
    builder.finish(problem.grid()[problem.intervals()], problem.v_end())
}
