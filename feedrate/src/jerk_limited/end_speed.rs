//! Speeds at the ends that cannot be had: the largest that can, and the limit in the way.

use super::passes::Passes;
use super::solution::{Binding, NotSolved};
use crate::error::{FeedError, PathEnd};
use crate::problem::FeedProblem;
use crate::row::{LimitId, Quantity};

/// Problems solved to find the largest speed: fewer on long grids, where one takes seconds.
const MOST_TRIALS: usize = 14;
const LEAST_TRIALS: usize = 4;

/// Intervals that all trials together may plan on.
const INTERVALS: usize = 100_000;

/// The error of the passes, or, where a speed at an end is the cause, the largest speed that is
/// possible there.
pub(super) fn explain(passes: &Passes<'_>, problem: &FeedProblem, why: NotSolved) -> FeedError {
    let to_blame = matches!(why.error, FeedError::NotConverged { .. } | FeedError::SpeedOutOfReach { .. });
    let asked = [problem.v_start(), problem.v_end()];
    if !to_blame || asked == [0.0; 2] {
        return why.error;
    }
    let trials = (INTERVALS / problem.intervals()).clamp(LEAST_TRIALS, MOST_TRIALS);
    // A law near the plan is not near those with other speeds.
    let search = Search { passes: Passes { near: None, ..*passes }, problem, trials };
    if let FeedError::SpeedOutOfReach { end, highest, .. } = why.error {
        // What is possible without limits on jerk may be so with them.
        let speeds = if end == PathEnd::Start { [highest, asked[1]] } else { [asked[0], highest] };
        if search.is_possible(speeds).is_ok() {
            return why.error;
        }
    }
    // Which end alone is too fast; if neither is, the end for this start.
    let [start, end] = asked;
    let found = if start > 0.0 && search.is_possible([start, 0.0]).is_err() {
        search.largest(start, |v| [v, 0.0]).map(|found| (PathEnd::Start, start, problem.grid()[0], found))
    } else if end == 0.0 {
        None
    } else {
        search.largest(end, |v| [start, v]).map(|found| (PathEnd::End, end, problem.grid()[problem.intervals()], found))
    };
    let Some((end, speed, place, (highest, binding))) = found else { return why.error };
    let (row, s) = binding.or(why.binding).unwrap_or((LimitId::path(Quantity::ControllableSet), place));
    FeedError::SpeedOutOfReach { end, speed, lowest: 0.0, highest, row, s }
}

struct Search<'a> {
    passes: Passes<'a>,
    problem: &'a FeedProblem,
    trials: usize,
}

impl Search<'_> {
    fn is_possible(&self, [start, end]: [f64; 2]) -> Result<(), NotSolved> {
        let problem = self.problem.clone().with_end_speeds(start, end)?;
        self.passes.plan(&problem).map(|_| ())
    }

    /// The largest speed below `asked` with which there is a motion, and what stands against more;
    /// nothing where even rest is too much.
    fn largest(&self, asked: f64, speeds: impl Fn(f64) -> [f64; 2]) -> Option<(f64, Option<Binding>)> {
        self.is_possible(speeds(0.0)).ok()?;
        let (mut possible, mut too_much, mut binding) = (0.0, asked, None);
        for _ in 0..self.trials {
            let middle = 0.5 * (possible + too_much);
            match self.is_possible(speeds(middle)) {
                Ok(()) => possible = middle,
                Err(why) => (too_much, binding) = (middle, why.binding.or(binding)),
            }
        }
        Some((possible, binding))
    }
}
