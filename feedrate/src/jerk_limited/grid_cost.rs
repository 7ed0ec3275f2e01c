//! What the length of every interval costs.
//!
//! On an interval `w = du/ds` is constant, so a limit on jerk that binds at one end leaves something of itself unused towards the
//! other end, where the speed is another one. By the multiplier of the limit, the mean of what is left unused is the time that
//! shorter intervals would gain, to first order.

use super::barrier_problem::BarrierProblem;
use super::interior_point::Solver;
use crate::constraint::Within;
use crate::problem::FeedProblem;

impl Solver {
    /// The time that each interval costs by its length, s, at the solution.
    pub fn grid_costs(&self, problem: &FeedProblem, barrier_problem: &BarrierProblem) -> Vec<f64> {
        let [.., thirds, _] = barrier_problem.offsets();
        let mut costs = vec![0.0; barrier_problem.knots.intervals()];
        if !barrier_problem.means.is_empty() {
            return costs;
        }
        for (k, end, _, rows) in barrier_problem.places() {
            let (other, within) = if end == k { (k + 1, Within::End) } else { (k, Within::Start) };
            let (x, u, w) = (self.values.x[other], self.values.u[other], self.values.w[k]);
            let there = problem.jerk_rows(barrier_problem.from + k, within);
            for i in rows {
                let third = &barrier_problem.thirds[i];
                let row = &there[third.id as usize];
                let unit = 1.0 / (row.limit * third.part);
                let value = unit * (row.alpha * w + row.beta * u + row.gamma * x);
                let bound = 1.0 / x.sqrt() - unit * row.step * x.sqrt();
                let [low, high] = self.multipliers(thirds + i);
                // Less what is left unused at this end, too.
                let [own_low, own_high] = self.slacks_of(thirds + i);
                costs[k] +=
                    0.5 * (low * (bound + value - own_low).max(0.0) + high * (bound - value - own_high).max(0.0));
            }
        }
        costs
    }
}
