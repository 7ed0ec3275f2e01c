//! The passes of the planner: solve every part, check between the grid points, and solve again with
//! less.

use super::barrier_problem::BarrierProblem;
use super::check::largest_scale;
use super::drop_distant::Distance;
use super::interior_point::Solver;
use super::outcome::Goal;
use super::parts::{Part, Prepared, prepare};
use super::solution::{JerkLimitedPlan, NotSolved, Solution, assemble};
use super::start;
use crate::error::FeedError;
use crate::problem::FeedProblem;
use crate::speed_law::SpeedLaw;

/// Rows far from their bounds are dropped on stretches of as many intervals. On finer ones
/// acceleration builds up over many intervals, whose rows all are distant at one time or another,
/// and dropping them means solving twice.
const DROP_UP_TO: usize = 1_000_000;

/// If more than this has to be taken off the speed at the end, something was left out.
const LARGE_REDUCTION: f64 = 1e-3;

/// Reduction of the speed that round-off alone can require.
const ROUND_OFF: f64 = 1e-12;

/// Times that something too fast between the grid points is dealt with, and how many of them by
/// slowing down.
const ATTEMPTS: usize = 9;
const SLOWED_ATTEMPTS: usize = 5;

/// Times that it is solved anew with margins from where it was: first with the rows that are near
/// there, then with all.
const CAREFUL_ATTEMPTS: usize = 2;

/// Slowing down at last: with friction each time takes off half of what is too much.
const LAST_SLOWED_ATTEMPTS: usize = 60;

/// Relative gaps that the multipliers start with and below which rows far from their bounds are dropped: from scratch, and from a law
/// that is close to the solution.
const GAPS: [f64; 2] = [0.3, 0.04];
const NEAR_GAPS: [f64; 2] = [0.02, 0.004];

/// Grids of more intervals than this are planned on one point of so many first, to so much of the duration, and these likewise if they
/// have more than `ROUGH_FROM`: then the number of iterations hardly grows with the number of intervals.
const COARSE_FROM: usize = 800;
const ROUGH_FROM: usize = 250;
const COARSER: usize = 3;
const COARSE_TOLERANCE: f64 = 1e-2;

/// Times that dropped rows and jerk between the knots are looked at once the iterations have converged.
const POLISHES: usize = 5;

/// Largest excess over a limit between the grid points of a motion that cannot be slowed down.
const LARGEST_EXCESS: f64 = 1e-7;

/// Settings for solving one part.
#[derive(Debug, Clone, Copy)]
struct Attempt<'a> {
    drop_distant: bool,
    /// By which all bounds are lowered.
    factor: f64,
    /// A solution that is too fast between the grid points: margins follow it from the start.
    before: Option<&'a Solution>,
}

/// What a law is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Aim {
    /// Motion: it keeps all limits.
    Motion,
    /// A grid, and another law to start from: what it exceeds between the grid points does not matter.
    Draft,
    /// Another law to start from, on a part of the points and with all rows.
    Rough,
}

/// The passes with one tolerance on the duration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passes<'a> {
    pub tolerance: f64,
    /// A law that the solution is expected to be close to.
    pub near: Option<&'a SpeedLaw>,
    pub aim: Aim,
}

impl Passes<'_> {
    /// The fastest iterate inside all bounds, of one stretch.
    fn solve(
        &self,
        prepared: &Prepared<'_>,
        solver: &mut Solver,
        part: &Part,
        attempt: Attempt<'_>,
    ) -> Result<Solution, NotSolved> {
        let Prepared { problem, fastest, .. } = prepared;
        let fresh = || {
            let mut barrier_problem =
                BarrierProblem::new(problem, [part.grid.start, part.grid.end], part.speeds, fastest);
            if attempt.factor < 1.0 {
                barrier_problem.tighten(attempt.factor);
            }
            barrier_problem
        };
        let mut barrier_problem = fresh();
        if let Some(before) = attempt.before {
            barrier_problem.knots.evaluate(&before.c, &mut solver.values);
            barrier_problem.demand_margins(problem, &solver.values);
        }
        let again = attempt.before.and_then(|before| start::again(&barrier_problem, &before.c));
        let near = if again.is_none() && attempt.factor == 1.0 {
            self.near.and_then(|law| start::near(problem, &mut barrier_problem, law))
        } else {
            None
        };
        let is_near = near.is_some() && barrier_problem.slows;
        // The shape is known: that of the law itself, as the start may be much slower.
        let by_near = near.as_ref().map(|near| (&near.law, near.distance));
        let shape = attempt.before.map(|before| (&before.c, Distance::CLOSE)).or(by_near);
        let shape = shape.filter(|_| attempt.drop_distant && barrier_problem.slows);
        if let Some((c, distance)) = shape {
            barrier_problem.knots.evaluate(c, &mut solver.values);
            barrier_problem.drop_distant(&solver.values, distance);
        }
        let to_drop = attempt.drop_distant && shape.is_none();
        let start =
            again.or(near.map(|near| near.start)).unwrap_or_else(|| start::start(prepared, &mut barrier_problem));
        let [start_gap, drop_below] = if is_near { NEAR_GAPS } else { GAPS };
        // A law to start from is a part of the duration off, however little there is to gain.
        let shortest = if self.aim == Aim::Rough { 0.0 } else { part.shortest(problem, fastest) };
        let goal = Goal {
            tolerance: self.tolerance,
            shortest,
            start_gap,
            drop_below,
            polishes: if self.aim == Aim::Motion { POLISHES } else { 0 },
        };
        let outcome = solver.minimise(problem, &mut barrier_problem, start, goal, to_drop);
        if outcome.wider <= 10.0 * self.tolerance {
            // Inside all bounds: a motion, however far it is from the optimum.
            return Ok(solver.solution(problem, barrier_problem, outcome));
        }
        if part.slows(problem) {
            // The bounds were widened for the start and could not be taken back: from a start that
            // is inside.
            let mut barrier_problem = fresh();
            if let Some(start) = start::inside(problem, &barrier_problem, fastest) {
                let outcome = solver.minimise(problem, &mut barrier_problem, start, goal, false);
                return Ok(solver.solution(problem, barrier_problem, outcome));
            }
        }
        let error = FeedError::NotConverged {
            what: "the jerk-limited planner",
            iterations: outcome.iterations,
            residual: outcome.wider,
        };
        let binding = solver.binding(&barrier_problem).filter(|_| !attempt.drop_distant);
        let binding = binding.and_then(|i| barrier_problem.limit(problem, i));
        Err(NotSolved { error, binding })
    }

    /// A law near the plan, on a part of the points.
    pub fn rough(problem: &FeedProblem) -> Option<SpeedLaw> {
        let coarse = Passes { tolerance: COARSE_TOLERANCE, near: None, aim: Aim::Rough };
        coarse.plan(&problem.thinned(COARSER)).ok().map(|plan| plan.law)
    }

    /// The plan, or why there is none. On a long grid it starts from that on a part of the points.
    pub fn plan(&self, problem: &FeedProblem) -> Result<JerkLimitedPlan, NotSolved> {
        let rests = problem.v_start() == 0.0 && problem.v_end() == 0.0;
        let from = if self.aim == Aim::Rough { ROUGH_FROM } else { COARSE_FROM };
        if self.near.is_none() && rests && problem.is_between_points() && problem.intervals() > from {
            let coarse = Passes { tolerance: COARSE_TOLERANCE, near: None, aim: Aim::Rough };
            let thin = problem.thinned(COARSER);
            // Short stretches between stops keep their points: what does not get shorter would be thinned for ever.
            if 2 * thin.intervals() <= problem.intervals()
                && let Ok(plan) = coarse.plan(&thin)
            {
                return Passes { near: Some(&plan.law), ..*self }.plan_near(problem);
            }
        }
        self.plan_near(problem)
    }

    /// The plan on all points; where a law to start from leads nowhere, or the iterations from it have not converged, that from a start
    /// of its own if it is shorter, or as short and converged.
    fn plan_near(&self, problem: &FeedProblem) -> Result<JerkLimitedPlan, NotSolved> {
        /// What is longer by this part of itself is as short.
        const AS_SHORT: f64 = 1e-6;
        let near = self.plan_on_all(problem);
        let is_sure = match &near {
            Ok(plan) => plan.converged,
            // What no start changes.
            Err(why) => matches!(why.error, FeedError::StaticallyInfeasible { .. }),
        };
        if self.near.is_none() || is_sure {
            return near;
        }
        let own = Passes { near: None, ..*self }.plan_on_all(problem);
        match (near, own) {
            (Ok(near), Ok(own)) => {
                let longer = own.law.duration() / near.law.duration();
                let is_better = longer < 1.0 || (own.converged && longer < 1.0 + AS_SHORT);
                Ok(if is_better { own } else { near })
            }
            (Ok(near), _) => Ok(near),
            (Err(_), own) => own,
        }
    }

    /// The plan on all points, with all rows in the end.
    pub fn plan_on_all(&self, problem: &FeedProblem) -> Result<JerkLimitedPlan, NotSolved> {
        self.plan_with(problem, DROP_UP_TO).or_else(|why| match why.error {
            FeedError::NotConverged { .. } => self.plan_with(problem, 0),
            _ => Err(why),
        })
    }

    /// The plan. Rows far from their bounds are dropped on stretches of up to `drop_up_to`
    /// intervals.
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
        if self.aim != Aim::Motion {
            return Ok(JerkLimitedPlan::of(prepared, plan, &solutions));
        }
        let mut factors = vec![1.0; parts.len()];
        for attempt in 0..ATTEMPTS {
            let mut changed = false;
            for ((part, solution), factor) in parts.iter().zip(&mut solutions).zip(&mut factors) {
                let scale = largest_scale(problem, &plan, part.grid.clone());
                if scale >= 1.0 - ROUND_OFF {
                    continue;
                }
                changed = true;
                if scale < 1.0 - LARGE_REDUCTION && attempt < CAREFUL_ATTEMPTS {
                    let drop_distant = attempt == 0 && part.grid.len() <= drop_up_to;
                    let careful = Attempt { drop_distant, factor: 1.0, before: Some(solution) };
                    *solution = self.solve(prepared, &mut solver, part, careful)?;
                } else if part.slows(problem) && attempt < SLOWED_ATTEMPTS {
                    solution.scale(scale);
                } else {
                    // With less for all rows: friction gains on the rest where the motion is slowed
                    // down.
                    *factor *= 1.0 - 2.0 * (1.0 - scale);
                    let lower = Attempt { drop_distant: false, factor: *factor, before: None };
                    *solution = self.solve(prepared, &mut solver, part, lower)?;
                }
            }
            if !changed {
                return Ok(JerkLimitedPlan::of(prepared, plan, &solutions));
            }
            plan = assemble(problem, &solutions)?;
        }
        self.slow_down(prepared, solutions, plan)
    }

    /// Takes off the speed what is still too much, as long as that helps.
    fn slow_down(
        &self,
        prepared: &Prepared<'_>,
        mut solutions: Vec<Solution>,
        mut plan: SpeedLaw,
    ) -> Result<JerkLimitedPlan, NotSolved> {
        let Prepared { problem, parts, .. } = prepared;
        for _ in 0..LAST_SLOWED_ATTEMPTS {
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
        if left <= LARGEST_EXCESS {
            return Ok(JerkLimitedPlan::of(prepared, plan, &solutions));
        }
        Err(FeedError::NotConverged {
            what: "the jerk-limited planner between the grid points",
            iterations: ATTEMPTS,
            residual: left,
        }
        .into())
    }
}
