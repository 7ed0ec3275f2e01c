//! A problem made ready: checked, split next to rest, cut at its stops.

use std::borrow::Cow;
use std::cell::OnceCell;
use std::ops::Range;

use super::refine::refined;
use crate::constraint::Within;
use crate::error::{FeedError, PathEnd};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::scan::forward_backward::{moves, squared_speeds};
use crate::scan::on_problem::ContinuousAccelerationScan;
use crate::scan::reachability::Reachability;
use crate::speed_law::SpeedLaw;

/// A stretch of grid between two stops, or an end of the path at a speed.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// First and last grid point.
    pub grid: Range<usize>,
    pub speeds: [f64; 2],
}

impl Part {
    /// Duration at the squared speeds `fastest`.
    pub fn shortest(&self, problem: &FeedProblem, fastest: &[f64]) -> f64 {
        self.grid.clone().map(|k| 2.0 * problem.h(k) / (fastest[k].sqrt() + fastest[k + 1].sqrt())).sum()
    }

    /// Returns true if the motion can be slowed down as a whole: it starts and ends at rest, and
    /// every row holds at rest.
    pub fn slows(&self, problem: &FeedProblem) -> bool {
        self.speeds == [0.0; 2] && self.grid.clone().all(|i| stands(problem, i).is_ok())
    }
}

/// The stretches between stops: grid points with a cap of 0.
fn parts(problem: &FeedProblem) -> Result<Vec<Part>, FeedError> {
    let n = problem.intervals();
    let mut parts = Vec::new();
    let mut from = 0;
    for i in (1..=n).filter(|&i| i == n || problem.x_max(i) == 0.0) {
        let speeds = [if from == 0 { problem.v_start() } else { 0.0 }, if i == n { problem.v_end() } else { 0.0 }];
        let expected = 2 + speeds.iter().filter(|&&v| v == 0.0).count();
        if i - from < expected {
            return Err(FeedError::LengthMismatch {
                what: "a barrier_problem between two stops (intervals)",
                got: i - from,
                expected,
            });
        }
        parts.push(Part { grid: from..i, speeds });
        from = i;
    }
    Ok(parts)
}

/// Acceleration starts and ends at 0, so standing still must be possible where the motion does.
fn stands(problem: &FeedProblem, i: usize) -> Result<(), FeedError> {
    match problem.rows(i).iter().find(|row| !(row.lo <= row.d && row.d <= row.hi)) {
        Some(row) => Err(FeedError::StaticallyInfeasible {
            index: i,
            s: problem.grid()[i],
            row: row.source,
            value: row.d,
            limit: if row.d > row.hi { row.hi } else { row.lo },
        }),
        None => Ok(()),
    }
}

/// As many intervals are taken on; with more of them the iterations get many.
const MOST_INTERVALS: usize = 200_000;

/// As many rows are taken on: with all that belongs to them, some two gigabytes.
const MOST_ROWS: usize = 5_000_000;

/// Refuses what would take minutes, or not fit into the memory of an ordinary machine.
fn fits(problem: &FeedProblem) -> Result<(), FeedError> {
    let got = problem.intervals();
    if got > MOST_INTERVALS {
        return Err(FeedError::TooMany { what: "intervals for the jerk-limited planner", got, most: MOST_INTERVALS });
    }
    let got = rows(problem);
    let what = "rows of all intervals of the jerk-limited planner";
    if got <= MOST_ROWS { Ok(()) } else { Err(FeedError::TooMany { what, got, most: MOST_ROWS }) }
}

/// Rows at points and both ends of every interval; those that bound the speed inside come on top.
fn rows(problem: &FeedProblem) -> usize {
    let of = |k: usize| {
        problem.rows(k).len() + 2 * (problem.middle_rows(k).len() + problem.jerk_rows(k, Within::Start).len())
    };
    (0..problem.intervals()).map(of).sum()
}

/// As many intervals are taken on where each has as many rows as those of `problem`.
pub(super) fn most_like(problem: &FeedProblem) -> usize {
    MOST_INTERVALS.min(MOST_ROWS.saturating_mul(problem.intervals()) / rows(problem).max(1))
}

/// A problem made ready.
#[derive(Debug)]
pub(super) struct Prepared<'a> {
    /// As it was handed in.
    pub original: &'a FeedProblem,
    scanned: OnceCell<Option<SpeedLaw>>,
    /// With the intervals next to rest split.
    pub problem: Cow<'a, FeedProblem>,
    /// Squared speeds of a second-order planner.
    pub fastest: Vec<f64>,
    pub parts: Vec<Part>,
}

impl Prepared<'_> {
    /// The law of the scan with S-profiles; none where it finds none.
    pub fn scanned(&self) -> Option<&SpeedLaw> {
        self.scanned.get_or_init(|| ContinuousAccelerationScan.plan(self.original).ok()).as_ref()
    }
}

/// Squared speeds of a second-order planner.
fn fastest(problem: &FeedProblem) -> Result<Vec<f64>, FeedError> {
    let of = |problem: &FeedProblem| {
        squared_speeds(problem).or_else(|error| match error {
            // Reachability passes points at which standing still is impossible.
            FeedError::StaticallyInfeasible { .. } => Reachability.squared_speeds(problem),
            error => Err(error),
        })
    };
    match of(problem) {
        // A motion with constant acceleration between the points cannot always go on as one can whose acceleration changes there.
        Err(FeedError::SpeedOutOfReach { end: PathEnd::Start, highest, .. }) if problem.a_start() != 0.0 => {
            let mut speeds = of(&problem.clone().with_end_speeds((1.0 - 1e-9) * highest, problem.v_end())?)?;
            speeds[0] = problem.v_start().powi(2);
            Ok(speeds)
        }
        speeds => speeds,
    }
}

pub(super) fn prepare(original: &FeedProblem) -> Result<Prepared<'_>, FeedError> {
    if !original.is_between_points() {
        return Err(FeedError::Empty { what: "rows between the grid points (FeedProblem::between_points)" });
    }
    if !original.has_jerk() {
        return Err(FeedError::Empty { what: "limits on jerk" });
    }
    fits(original)?;
    let problem = refined(original);
    let fastest = fastest(&problem)?;
    moves(&problem, &fastest)?;
    let parts = parts(&problem)?;
    for part in &parts {
        for (i, speed) in [part.grid.start, part.grid.end].into_iter().zip(part.speeds) {
            if speed == 0.0 {
                stands(&problem, i)?;
            }
        }
    }
    Ok(Prepared { original, scanned: OnceCell::new(), problem, fastest, parts })
}
