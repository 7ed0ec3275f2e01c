//! What the iterations left out, looked at when they have converged: dropped rows, and jerk between the knots.

use super::barrier_problem::BarrierProblem;
use super::interior_point::Solver;
use super::outcome::Polished;
use crate::problem::FeedProblem;

/// The least factor on the squared speeds after which the multipliers still suit, the least from which the iterations start
/// anew, and how far inside all bounds the iterate is then.
const SUITS: f64 = 0.95;
const STARTS: f64 = 0.1;
const INSIDE: f64 = 1.0 - 2e-5;
const WELL_INSIDE: f64 = 0.98;

impl Solver {
    /// Takes up dropped rows and sets margins between the knots where the iterate exceeds them, and slows it down to be inside.
    /// Multipliers of new rows are such that they times the slack are `mu`. There is no step to go back on then.
    pub fn polish(&mut self, problem: &FeedProblem, barrier_problem: &mut BarrierProblem, mu: f64) -> Polished {
        let slows = barrier_problem.slows;
        let taken_up = if slows { barrier_problem.take_up_exceeded(problem, &self.values) } else { None };
        if let Some(is_new) = &taken_up {
            let mut old = self.barrier.iter();
            let sides = |is_new: &bool| if *is_new { None } else { old.next().copied() };
            self.barrier = is_new.iter().map(sides).map(Option::unwrap_or_default).collect();
        }
        let exceeded = barrier_problem.demand_exceeded(problem, &self.values);
        if taken_up.is_none() && !exceeded {
            return Polished::Kept;
        }
        self.step.fill(0.0);
        if !slows {
            return Polished::Wider;
        }
        let [scale, jerk_scale] = barrier_problem.largest_scales(&self.values);
        let scale = scale.min(jerk_scale).min(1.0);
        // Written so that NaN is lost.
        if !(scale > STARTS) {
            return Polished::Lost;
        }
        let suits = scale > SUITS;
        let factor = scale * if suits { INSIDE } else { WELL_INSIDE };
        self.c.iter_mut().for_each(|c| *c *= factor);
        if let Some(is_new) = taken_up {
            barrier_problem.knots.evaluate(&self.c, &mut self.values);
            let barrier = &mut self.barrier;
            let mut inside = true;
            barrier_problem.each_slack(&self.values, |i, slacks| {
                if is_new[i] {
                    // Written so that NaN is outside.
                    inside &= slacks.iter().all(|slack| *slack > 0.0);
                    barrier[i].iter_mut().zip(slacks).for_each(|(side, slack)| side.multiplier = mu / slack);
                }
            });
            if !inside {
                return Polished::Lost;
            }
        }
        if suits { Polished::Slower } else { Polished::FarSlower }
    }
}
