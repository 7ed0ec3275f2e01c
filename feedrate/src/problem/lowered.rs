//! Less of one limit on a part of the path.

use std::ops::RangeInclusive;

use super::feed_problem::FeedProblem;
use crate::constraint::Within;
use crate::error::FeedError;
use crate::row::{IntervalBound, LimitId};

impl FeedProblem {
    /// The problem with the part `fraction` of one limit on acceleration or jerk on some intervals, ends included. Rows of other
    /// limits stay, and caps do.
    ///
    /// # Errors
    /// [`FeedError::NotPositive`] for a fraction that is not above 0, [`FeedError::AboveLimit`] for one above 1,
    /// [`FeedError::LengthMismatch`] for intervals that the grid has not.
    pub fn with_fraction(
        mut self,
        limit: LimitId,
        intervals: RangeInclusive<usize>,
        fraction: f64,
    ) -> Result<Self, FeedError> {
        let what = "fraction of a limit";
        if !(fraction > 0.0) {
            return Err(FeedError::NotPositive { what, value: fraction });
        }
        if fraction > 1.0 {
            return Err(FeedError::AboveLimit { what, value: fraction, limit: 1.0 });
        }
        let (first, last) = (*intervals.start(), *intervals.end());
        if last >= self.intervals() {
            let what = "the grid (last interval with a fraction of a limit)";
            return Err(FeedError::LengthMismatch { what, got: last, expected: self.intervals() - 1 });
        }
        for k in first..=last {
            let middle = if self.middles.is_empty() { &mut [] } else { self.middles.rows_mut(k) };
            let ends = [k, k + 1].into_iter().skip(usize::from(k > first));
            middle.iter_mut().filter(|row| row.source == limit).for_each(|row| {
                (row.lo, row.hi) = (row.d + fraction * (row.lo - row.d), row.d + fraction * (row.hi - row.d));
            });
            for i in ends {
                for row in self.points.rows_mut(i).iter_mut().filter(|row| row.source == limit) {
                    (row.lo, row.hi) = (row.d + fraction * (row.lo - row.d), row.d + fraction * (row.hi - row.d));
                }
            }
            let (from, places) = (3 * k + Within::Start as usize, 3);
            let rows = from * self.jerk_rows_per_place..(from + places) * self.jerk_rows_per_place;
            self.jerk_rows[rows].iter_mut().filter(|row| row.source == limit).for_each(|row| row.limit *= fraction);
            for bound in self.bounds.of_mut(k) {
                match bound {
                    IntervalBound::Acceleration { rest, limit: most, source, .. } if *source == limit => {
                        *most = *rest + fraction * (*most - *rest);
                    }
                    IntervalBound::Jerk { limit: most, source, .. } if *source == limit => *most *= fraction,
                    _ => {}
                }
            }
        }
        Ok(self)
    }
}
