//! Long paths, window by window.

use std::ops::Range;

use super::parts::most_like;
use super::passes::Passes;
use super::planner::JerkLimited;
use super::solution::JerkLimitedPlan;
use crate::error::FeedError;
use crate::problem::FeedProblem;
use crate::speed_law::SpeedLaw;

/// The fewest intervals of a window: the law of a shorter one is not near that of the whole path.
const LEAST: usize = 64;

/// The last window may have half as many intervals more, and is planned at once.
const MOST: usize = 100_000;

/// Where a window is left for the next one, in sixteenths of it: the first that a motion goes on from.
const CUTS: [usize; 6] = [8, 7, 9, 6, 10, 4];

/// Two laws are alike whose squared speeds are apart by no more than this part of them, and they join where the slower one has come that
/// near.
const ALIKE: f64 = 0.05;
const JOIN: f64 = 0.04;

/// A jerk-limited planner for paths of any number of intervals, in memory that does not grow with
/// the rows of the path.
///
/// A window of the grid is planned to rest at its end, by [`JerkLimited`]. About the first half of
/// the motion is kept. The next window begins where that half ends, at the speed and acceleration
/// reached there, so that both are continuous along the whole path. Where the planner finds no motion by itself, it starts near that of
/// the window before, joined to a rough one from rest.
///
/// # It always has a motion
/// The rest of a window leads to standstill within all limits. If no motion is found that goes on
/// from the middle of the window, other points of it are tried. If none is found from these either,
/// the window is taken as a whole, and the path goes on from rest: [`WindowedPlan::stops`] names
/// these places.
///
/// # Choice of the window
/// The half that is not kept only has to be longer than the way in which the motion brakes to rest
/// from its highest speed. Then the rest at its end does not slow down what is kept. A window of
/// four times that way loses little. Longer windows need more memory, shorter ones lose time.
///
/// Standing still must be possible at the end of every window. A stop of the path fewer than four
/// intervals behind such a place cannot be planned from rest.
///
/// ```
/// use arcfeed_feedrate::constraint::{Feed, TangentialAcceleration, TangentialJerk};
/// use arcfeed_feedrate::{FeedPlanner, FeedProblem, JerkLimited, WindowedJerkLimited};
///
/// let (acceleration, jerk) = (TangentialAcceleration::new(2.0)?, TangentialJerk::new(40.0)?);
/// // 2 m in steps of 1 mm, with a feed that changes. Only rows of one window exist at a time.
/// let stretch = |range: std::ops::Range<usize>| {
///     let grid: Vec<f64> = (range.start..=range.end).map(|i| 0.001 * i as f64).collect();
///     let feeds: Vec<f64> = range.map(|k| if k / 250 % 2 == 0 { 0.2 } else { 0.1 }).collect();
///     FeedProblem::between_points(&grid, &[&Feed::new(&feeds)?, &acceleration, &jerk])
/// };
/// let plan = WindowedJerkLimited::new(JerkLimited::default(), 400)?.plan(2000, stretch)?;
/// let whole = JerkLimited::default().plan(&stretch(0..2000)?)?;
/// assert!(plan.stops.is_empty() && plan.law.duration() < 1.005 * whole.duration());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowedJerkLimited {
    planner: JerkLimited,
    window: usize,
}

/// A law of [`WindowedJerkLimited`].
#[derive(Debug, Clone, PartialEq)]
pub struct WindowedPlan {
    /// The law.
    pub law: SpeedLaw,
    /// Number of windows that were planned.
    pub windows: usize,
    /// Positions (m) at which the motion rests because no motion was found that goes on.
    pub stops: Vec<f64>,
    /// True if the iterations of all windows converged.
    pub converged: bool,
}

impl WindowedJerkLimited {
    /// Plans windows of so many grid intervals, 64 at the least and 100 000 at the most.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`] for a shorter window, [`FeedError::TooMany`] for a longer one.
    pub fn new(planner: JerkLimited, window: usize) -> Result<Self, FeedError> {
        if window < LEAST {
            return Err(FeedError::LengthMismatch { what: "a window (intervals)", got: window, expected: LEAST });
        }
        if window > MOST {
            return Err(FeedError::TooMany { what: "intervals of a window", got: window, most: MOST });
        }
        Ok(Self { planner, window })
    }

    /// The longest window that is planned where intervals have as many rows as those of `problem`: its rows, and those of a last window
    /// that is half as long again, are no more than [`JerkLimited`] takes.
    pub fn longest(problem: &FeedProblem) -> usize {
        (most_like(problem) / 3 * 2).clamp(LEAST, MOST)
    }

    /// The plan for a path of so many grid intervals. `stretch` yields the problem of a range of
    /// them, built by [`FeedProblem::between_points`] on their grid points, both ends included.
    /// The speed at the start is that of the first such problem, the speed at the end that of the
    /// last one; the others are not used.
    ///
    /// # Errors
    /// Those of `stretch`, and those of [`JerkLimited`] for a window that begins at rest; an `index`
    /// in the latter is a point of the whole grid.
    pub fn plan(
        &self,
        intervals: usize,
        mut stretch: impl FnMut(Range<usize>) -> Result<FeedProblem, FeedError>,
    ) -> Result<WindowedPlan, FeedError> {
        let mut parts = Vec::new();
        let (mut windows, mut stops, mut from, mut converged) = (0, Vec::new(), 0, true);
        while from < intervals {
            let (problem, to) = self.problem(from, intervals, &mut stretch)?;
            let planned = self.planner.plan_noting_convergence(&problem).map_err(|error| error.counted_from(from))?;
            let mut window = Window::new(&problem, from..to, planned);
            windows += 1;
            converged &= window.converged;
            while window.range.end < intervals && !window.rests {
                let Some((next, s)) = self.next(&window, intervals, &mut stretch)? else {
                    stops.push(window.law.end().p);
                    break;
                };
                parts.push(window.law.until(s));
                window = next;
                windows += 1;
                converged &= window.converged;
            }
            parts.push(window.law);
            from = window.range.end;
        }
        let start = parts.first().map_or(0.0, SpeedLaw::start);
        Ok(WindowedPlan { law: SpeedLaw::chain(start, parts), windows, stops, converged })
    }

    /// The window that goes on from another one, and where it does so (m); none where no motion is found.
    fn next(
        &self,
        window: &Window,
        intervals: usize,
        stretch: &mut impl FnMut(Range<usize>) -> Result<FeedProblem, FeedError>,
    ) -> Result<Option<(Window, f64)>, FeedError> {
        for cut in CUTS {
            let i = window.range.len() * cut / 16;
            let (from, state) = (window.range.start + i, window.law.at_position(window.grid[i]));
            let (problem, to) = self.problem(from, intervals, stretch)?;
            let going_on = problem.clone().going_on_from(state);
            let planned = self.planner.plan_if_any(&going_on, None).or_else(|| {
                let near = window.joined_to(&Passes::rough(&problem)?, problem.grid())?;
                self.planner.plan_if_any(&going_on, Some(&near))
            });
            if let Some(planned) = planned {
                return Ok(Some((Window::new(&going_on, from..to, planned), state.p)));
            }
        }
        Ok(None)
    }

    /// The problem from an interval on, and where it ends: at the last stop inside the window, where the motion rests anyway, else at
    /// the end of the window. No short window is left for the end of the path.
    fn problem(
        &self,
        from: usize,
        intervals: usize,
        stretch: &mut impl FnMut(Range<usize>) -> Result<FeedProblem, FeedError>,
    ) -> Result<(FeedProblem, usize), FeedError> {
        let left = intervals - from;
        let to = if left <= self.window + self.window / 2 { intervals } else { from + self.window };
        let mut at_rest = |range: Range<usize>| {
            let problem = stretch(range.clone())?;
            let start = if range.start == 0 { problem.v_start() } else { 0.0 };
            let end = if range.end == intervals { problem.v_end() } else { 0.0 };
            problem.with_end_speeds(start, end)
        };
        let problem = at_rest(from..to)?;
        let stop = (1..problem.intervals()).rev().find(|&i| problem.cap(i).0 == 0.0);
        match stop {
            Some(stop) => Ok((at_rest(from..from + stop)?, from + stop)),
            None => Ok((problem, to)),
        }
    }
}

/// A window with its motion.
struct Window {
    range: Range<usize>,
    grid: Vec<f64>,
    law: SpeedLaw,
    /// True if the motion rests at its end whatever follows.
    rests: bool,
    converged: bool,
}

impl Window {
    fn new(problem: &FeedProblem, range: Range<usize>, planned: JerkLimitedPlan) -> Self {
        let rests = problem.cap(problem.intervals()).0 == 0.0;
        let JerkLimitedPlan { law, converged, .. } = planned;
        Self { range, grid: problem.grid().to_vec(), law, rests, converged }
    }

    /// A law along `grid`, which begins inside this window: that of this window at first, and `next`, which begins at rest, where both
    /// are about as fast.
    fn joined_to(&self, next: &SpeedLaw, grid: &[f64]) -> Option<SpeedLaw> {
        let end = self.law.end().p;
        let squared = |law: &SpeedLaw, s: f64| law.v_at_s(s).powi(2);
        let common = grid.partition_point(|&s| s < end);
        let pairs: Vec<[f64; 2]> = grid[..common].iter().map(|&s| [squared(&self.law, s), squared(next, s)]).collect();
        let first = pairs.iter().position(|[a, b]| *b > (1.0 - JOIN) * a)?;
        let alike = pairs[first..].iter().take_while(|[a, b]| (a - b).abs() < ALIKE * a).count();
        let speed = |(i, &s): (usize, &f64)| {
            let w = ((i as f64 - first as f64) / (alike as f64 + 1.0)).clamp(0.0, 1.0);
            let w = w * w * (3.0 - 2.0 * w);
            let [a, b] = pairs.get(i).copied().unwrap_or_else(|| [0.0, squared(next, s)]);
            (a + w * (b - a)).sqrt()
        };
        let speeds: Vec<f64> = grid.iter().enumerate().map(speed).collect();
        SpeedLaw::from_knots(grid, &speeds).ok()
    }
}
