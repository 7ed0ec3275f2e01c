//! The problem of some intervals of a longer grid.

use std::ops::Range;

use super::feed_problem::FeedProblem;
use crate::constraint::{PathConstraint, Place, RowSink, Within};
use crate::error::FeedError;
use crate::row::{IntervalBound, JerkRow, LimitId};

/// A constraint on some intervals of the grid that it was made for.
struct OnPart<'c> {
    whole: &'c dyn PathConstraint,
    first: usize,
    points: usize,
}

impl PathConstraint for OnPart<'_> {
    fn points(&self) -> Option<usize> {
        self.whole.points().map(|_| self.points)
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let place = match place {
            Place::Point(i) => Place::Point(self.first + i),
            Place::Middle { k, h } => Place::Middle { k: self.first + k, h },
        };
        self.whole.rows(place, out);
    }

    fn jerk_rows(&self, k: usize, h: f64, within: Within, out: &mut Vec<JerkRow>) {
        self.whole.jerk_rows(self.first + k, h, within, out);
    }

    fn interval_bounds(&self, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
        self.whole.interval_bounds(self.first + k, h, out);
    }

    fn axis_speeds(&self, k: usize, h: f64, out: &mut dyn FnMut([f64; 3], f64, LimitId)) {
        self.whole.axis_speeds(self.first + k, h, out);
    }
}

impl FeedProblem {
    /// Like [`FeedProblem::between_points`], on some intervals of the grid alone, from rest to rest: the rows of the others are not
    /// made. The constraints are those of the whole grid `s`.
    ///
    /// ```
    /// use arcfeed_feedrate::constraint::{Feed, TangentialAcceleration, TangentialJerk};
    /// use arcfeed_feedrate::{FeedPlanner, FeedProblem, JerkLimited, WindowedJerkLimited};
    ///
    /// // 2 m in steps of 1 mm, planned in windows of 400.
    /// let grid: Vec<f64> = (0..=2000).map(|i| 0.001 * f64::from(i)).collect();
    /// let (feed, acceleration) = (Feed::new(&[0.2; 2000])?, TangentialAcceleration::new(2.0)?);
    /// let jerk = TangentialJerk::new(40.0)?;
    /// let windows = WindowedJerkLimited::new(JerkLimited::default(), 400)?;
    /// let plan = windows.plan(2000, |part| FeedProblem::between_points_of(&grid, part, &[&feed, &acceleration, &jerk]))?;
    /// let whole = FeedProblem::between_points(&grid, &[&feed, &acceleration, &jerk])?;
    /// assert!(plan.law.duration() < 1.005 * JerkLimited::default().plan(&whole)?.duration());
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    ///
    /// # Errors
    /// As [`FeedProblem::between_points`]; [`FeedError::Empty`] for no interval, [`FeedError::LengthMismatch`] for intervals that the
    /// grid has not. An `index` in an error is a point or an interval of the whole grid.
    pub fn between_points_of(
        s: &[f64],
        intervals: Range<usize>,
        constraints: &[&dyn PathConstraint],
    ) -> Result<Self, FeedError> {
        for got in constraints.iter().filter_map(|constraint| constraint.points()) {
            if got != s.len() {
                return Err(FeedError::LengthMismatch { what: "a constraint (grid points)", got, expected: s.len() });
            }
        }
        if intervals.is_empty() {
            return Err(FeedError::Empty { what: "intervals of a part of a grid" });
        }
        let Some(grid) = s.get(intervals.start..=intervals.end) else {
            let (got, expected) = (intervals.end, s.len().saturating_sub(1));
            return Err(FeedError::LengthMismatch { what: "the grid (last interval of a part)", got, expected });
        };
        let (first, points) = (intervals.start, grid.len());
        let parts: Vec<OnPart<'_>> = constraints.iter().map(|&whole| OnPart { whole, first, points }).collect();
        let parts: Vec<&dyn PathConstraint> = parts.iter().map(|part| part as &dyn PathConstraint).collect();
        Self::between_points(grid, &parts).map_err(|error| error.counted_from(first))
    }
}
