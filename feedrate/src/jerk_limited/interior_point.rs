//! Primal-dual interior-point iterations for the fastest `x(s)` on a stretch of path.
//!
//! Every row is a barrier with a multiplier; the Newton matrix by spline coefficients has two
//! diagonals beside the main one, so an iteration costs two passes over the rows and one over the
//! coefficients.

use super::band::Pentadiagonal;
use super::barrier_problem::{BarrierProblem, Sides};
use super::drop_distant::Distance;
use super::outcome::{Goal, Outcome, Polished};
use super::side::{Side, lesser};
use super::solution::Solution;
use super::spline::{AtKnot, OnInterval, Values, gradient_to_coefficients, tie_gradient, tie_matrix, to_coefficients};
use crate::problem::FeedProblem;

/// Iterates and their scratch space.
#[derive(Debug, Default)]
pub(super) struct Solver {
    /// Spline coefficients: the solution.
    pub c: Vec<f64>,
    pub values: Values,
    delta: Values,
    pub(super) at: Vec<AtKnot>,
    pub(super) on: Vec<OnInterval>,
    matrix: Pentadiagonal,
    pub(super) step: Vec<f64>,
    /// All rows: those at the knots, caps, jerk rows, rest intervals.
    pub(super) barrier: Vec<[Side; 2]>,
}

/// Sums over all sides.
#[derive(Debug, Clone, Copy)]
struct Sums {
    /// Sum of multiplier times slack.
    complementarity: f64,
    count: f64,
    /// Smallest slack found; not positive means outside.
    least: f64,
}

/// Part of the way to the boundary that a step may go.
const STEP_FRACTION: f64 = 0.95;

/// Relative gap from which on margins are set.
const MARGINS_FROM: f64 = 0.1;

/// Gap that is aimed at, in units of what the last step gained.
const AHEAD_GAP: f64 = 0.3;

/// So many times the tolerance away from convergence the iterate is checked first between the knots and against dropped rows.
const EARLY: f64 = 20.0;

/// Many times what is needed.
const MOST_ITERATIONS: usize = 100;

impl Solver {
    /// Minimises the duration from coefficients `c` that keep the ends and are strictly inside all
    /// bounds as they are widened at present. With `drop_distant`, rows far from their bounds are
    /// left out once the shape shows.
    pub fn minimise(
        &mut self,
        problem: &FeedProblem,
        barrier_problem: &mut BarrierProblem,
        c: Vec<f64>,
        goal: Goal,
        drop_distant: bool,
    ) -> Outcome {
        self.c = c;
        self.barrier.clear();
        self.barrier.resize(barrier_problem.offsets()[3] + 2, [Side::default(); 2]);
        let mut outcome = Outcome::at_start(barrier_problem.narrow(0.0), goal);
        let mut before = f64::NAN;
        let mut steps = [0.0; 2];
        let (mut to_drop, mut polishes) = (drop_distant, goal.polishes);
        while outcome.iterations < MOST_ITERATIONS {
            barrier_problem.knots.evaluate(&self.c, &mut self.values);
            // Once the shape shows, and not so late that every change would have to be caught up with.
            let shown = outcome.gap.max(outcome.ahead);
            if shown < MARGINS_FROM && outcome.gap > 4.0 * outcome.tolerance {
                barrier_problem.set_margins(problem, &self.values);
            }
            if to_drop && shown < goal.drop_below && outcome.gap > outcome.tolerance {
                to_drop = false;
                self.drop_distant(barrier_problem);
            }
            let mut sums = self.slacks(barrier_problem, steps[1]);
            if !(sums.least > 0.0) {
                // Only friction can do this: its rows are not straight. Back half of the way, or to the iterate before, which was inside.
                let half = steps[0] > 1e-6;
                steps = [if half { 0.5 * steps[0] } else { steps[0] }, 0.0];
                self.c.iter_mut().zip(&self.step).for_each(|(c, d)| *c -= steps[0] * d);
                if !half {
                    break;
                }
                outcome.iterations += 1;
                continue;
            }
            let duration = self.duration(barrier_problem);
            outcome.tolerance = goal.at(duration);
            let centred = outcome.gap == f64::INFINITY;
            if centred {
                sums.complementarity = goal.start_gap * duration;
                self.centre(sums.complementarity / sums.count);
            }
            outcome.gap = sums.complementarity / duration;
            // The multipliers alone tell nothing while steps are short: then they do not fit the iterate yet.
            outcome.ahead = if centred { f64::INFINITY } else { (before / duration - 1.0).abs() / steps[0] };
            before = duration;
            let mu = sums.complementarity / sums.count;
            let converged = outcome.is_within(1.0);
            // For the first time so early that the iterations to come are needed anyway.
            let early = polishes == goal.polishes && outcome.is_within(EARLY);
            if polishes > 0 && (converged || early) {
                polishes -= 1;
                match self.polish(problem, barrier_problem, mu) {
                    Polished::Kept => {}
                    Polished::Lost => break,
                    changed => {
                        outcome.note(changed, barrier_problem.jerk_wider);
                        (before, steps) = (f64::NAN, [1.0, 0.0]);
                        continue;
                    }
                }
            }
            if converged {
                break;
            }
            // While the duration falls fast, complementarity must not fall faster, or the iterates creep along the bounds.
            let least = if outcome.ahead.is_finite() { AHEAD_GAP * outcome.ahead * duration / sums.count } else { 0.0 };
            steps = self.direction(barrier_problem, [mu, least], outcome.wider > 0.0, centred);
            self.c.iter_mut().zip(&self.step).for_each(|(c, d)| *c += steps[0] * d);
            if outcome.wider > 0.0 {
                outcome.wider = barrier_problem.narrow(steps[0]);
            }
            outcome.iterations += 1;
        }
        barrier_problem.knots.evaluate(&self.c, &mut self.values);
        outcome
    }

    /// The row that stands most against taking back what bounds are widened by.
    pub fn binding(&self, barrier_problem: &BarrierProblem) -> Option<usize> {
        let mut most = (0.0, None);
        barrier_problem.each_widening(|i, wider| {
            let Some(sides) = self.barrier.get(i) else { return };
            let against = sides[0].multiplier * wider[0] + sides[1].multiplier * wider[1];
            if against > most.0 {
                most = (against, Some(i));
            }
        });
        most.1
    }

    /// Multipliers of both sides of a row.
    pub fn multipliers(&self, i: usize) -> Sides {
        self.barrier[i].map(|side| side.multiplier)
    }

    /// What the iterations ended at.
    pub fn solution(&self, problem: &FeedProblem, mut barrier_problem: BarrierProblem, outcome: Outcome) -> Solution {
        barrier_problem.whole = None;
        let grid_costs = self.grid_costs(problem, &barrier_problem);
        Solution { barrier_problem, c: self.c.clone(), converged: outcome.is_close(), grid_costs }
    }

    /// Slacks of both sides of a row.
    pub fn slacks_of(&self, i: usize) -> Sides {
        self.barrier[i].map(|side| 1.0 / side.inverse)
    }

    fn drop_distant(&mut self, barrier_problem: &mut BarrierProblem) {
        let mut stays = barrier_problem.drop_distant(&self.values, Distance::ON_THE_WAY).iter();
        self.barrier.retain(|_| *stays.next().unwrap_or(&true));
    }

    /// Takes the last step of the multipliers and evaluates the slacks anew.
    fn slacks(&mut self, barrier_problem: &BarrierProblem, dual_step: f64) -> Sums {
        let mut sums = Sums { complementarity: 0.0, count: 0.0, least: f64::INFINITY };
        if self.values.x.iter().chain(&self.values.middle).any(|&x| !(x > 0.0)) {
            return Sums { least: 0.0, ..sums };
        }
        let barrier = &mut self.barrier;
        barrier_problem.each_slack(&self.values, |i, slacks| {
            for (side, slack) in barrier[i].iter_mut().zip(slacks) {
                side.multiplier += dual_step * side.change;
                side.change = 0.0;
                side.inverse = 1.0 / slack;
                // A bound at infinity has the multiplier 0.
                sums.complementarity += side.multiplier * lesser(slack, f64::MAX);
                sums.count += f64::from(u8::from(slack < f64::INFINITY));
                // Written so that NaN is outside.
                if !(slack > sums.least) {
                    sums.least = slack;
                }
            }
        });
        sums
    }

    /// Puts all multipliers on the central path.
    fn centre(&mut self, mu: f64) {
        self.barrier.iter_mut().flatten().for_each(|side| side.multiplier = mu * side.inverse);
    }

    /// Mehrotra's predictor and corrector, into `self.step`; how far to go along it for
    /// coefficients and multipliers.
    fn direction(
        &mut self,
        barrier_problem: &BarrierProblem,
        [mu, least]: [f64; 2],
        wider: bool,
        centred: bool,
    ) -> Sides {
        self.assemble(barrier_problem);
        to_coefficients(&barrier_problem.knots, &self.at, &self.on, &mut self.matrix);
        tie_matrix(barrier_problem.ends, barrier_problem.ratios(), &mut self.matrix);
        self.matrix.factor();
        let (mut mu, mut part) = (mu, 1.0);
        // On the central path there is nothing to predict.
        if !centred {
            self.objective_gradient(barrier_problem);
            if wider {
                self.barrier_gradient(barrier_problem, 0.0, 1.0);
            }
            self.solve(barrier_problem);
            let [slack, multiplier] = self.predict(barrier_problem);
            let far = slack.min(multiplier);
            let left = 1.0 - far;
            mu = (mu * (left * left * left).max(1e-3)).max(least);
            // Second-order terms of a step that cannot be taken mislead.
            part = lesser(2.0 * far, 1.0);
        }
        self.objective_gradient(barrier_problem);
        self.barrier_gradient(barrier_problem, mu, part);
        self.solve(barrier_problem);
        self.changes(barrier_problem, mu, part)
    }

    /// Newton's step from the first derivatives.
    fn solve(&mut self, barrier_problem: &BarrierProblem) {
        let ratios = barrier_problem.ratios();
        gradient_to_coefficients(&barrier_problem.knots, &self.at, &self.on, &mut self.step);
        tie_gradient(barrier_problem.ends, ratios, &mut self.step);
        self.step.iter_mut().for_each(|d| *d = -*d);
        self.matrix.solve(&mut self.step);
        let n = self.step.len();
        self.step[0] = self.step[1] / ratios[0];
        self.step[n - 1] = self.step[n - 2] / ratios[1];
        barrier_problem.knots.evaluate_change(&self.step, &mut self.delta);
    }

    /// The longest step of slacks and multipliers towards `mu = 0`; leaves the second-order terms
    /// of that step.
    fn predict(&mut self, barrier_problem: &BarrierProblem) -> Sides {
        // Relative changes of slacks; multipliers change by the opposite less 1.
        let (mut least, mut most) = (0.0, 0.0);
        let barrier = &mut self.barrier;
        barrier_problem.each_change(&self.values, &self.delta, |i, by| {
            for (side, by) in barrier[i].iter_mut().zip(by) {
                let relative = by * side.inverse;
                side.change = relative * (1.0 + relative);
                least = lesser(relative, least);
                most = -lesser(-relative, -most);
            }
        });
        [1.0 / f64::max(1.0, -least), 1.0 / (1.0 + most)]
    }

    /// Changes of all multipliers for the step, and how far slacks and multipliers can follow it.
    fn changes(&mut self, barrier_problem: &BarrierProblem, mu: f64, part: f64) -> Sides {
        let (mut least, mut fall) = (0.0, 0.0);
        let barrier = &mut self.barrier;
        barrier_problem.each_change(&self.values, &self.delta, |i, by| {
            for (side, by) in barrier[i].iter_mut().zip(by) {
                let relative = by * side.inverse;
                side.change = mu * side.inverse + side.multiplier * (part * side.change - 1.0 - relative);
                least = lesser(relative, least);
                // A bound at infinity has multiplier and change 0. Few sides take the division.
                if -side.change > fall * side.multiplier {
                    fall = -side.change / side.multiplier;
                }
            }
        });
        // The duration is a barrier at x = 0, but Newton's step may jump over it.
        let (Values { x, middle, .. }, Values { x: dx, middle: dm, .. }) = (&self.values, &self.delta);
        for (x, d) in x.iter().zip(dx).chain(middle.iter().zip(dm)) {
            least = lesser(d / x, least);
        }
        [-least, fall].map(|decrease| if decrease < STEP_FRACTION { 1.0 } else { STEP_FRACTION / decrease })
    }
}
