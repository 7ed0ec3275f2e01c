//! How far a motion can be from the fastest one, as its report states it.

use arcfeed_feedrate::LowerBound;
use serde::Serialize;

use crate::text::number;

/// A duration that no motion beats. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundReport {
    /// No motion that keeps the limits on the grid of the plan takes less time than this, in s.
    pub lower_bound_s: f64,
    /// The duration of the motion over that, less 1.
    pub gap: f64,
    /// Intervals on which the bound is known only for motions that run at 0.7 times the speed of this one at least.
    pub conditional_intervals: usize,
    /// Intervals of the grid.
    pub intervals: usize,
}

impl BoundReport {
    /// The bound beside a motion of this duration, s.
    pub fn new(duration: f64, bound: &LowerBound) -> Self {
        // The law of a scan is no spline on the grid, and may be faster by a little.
        let least = bound.duration.min(duration);
        Self {
            lower_bound_s: least,
            gap: duration / least - 1.0,
            conditional_intervals: bound.conditional,
            intervals: bound.intervals,
        }
    }

    /// The bound of a motion of this duration (s) whose parts have these bounds, and `waits` (s) between them.
    pub fn of_parts<'b>(duration: f64, waits: f64, parts: impl IntoIterator<Item = &'b LowerBound>) -> Self {
        let mut whole = LowerBound { duration: waits, conditional: 0, intervals: 0 };
        for part in parts {
            whole.duration += part.duration;
            whole.conditional += part.conditional;
            whole.intervals += part.intervals;
        }
        Self::new(duration, &whole)
    }

    /// The line of a report for a terminal.
    pub(crate) fn line(&self) -> String {
        let condition = match self.conditional_intervals {
            0 => String::new(),
            some => format!("; on {some} of {} intervals if over 0.7 of its speed", self.intervals),
        };
        format!("at least {} s, gap {:.3} %{condition}", number(self.lower_bound_s), 100.0 * self.gap)
    }
}
