//! Bounds on whole intervals, interval by interval.

use crate::constraint::PathConstraint;
use crate::row::IntervalBound;

/// Bounds of one interval after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct BoundTable {
    bounds: Vec<IntervalBound>,
    first: Vec<usize>,
}

impl BoundTable {
    /// The bounds that `constraints` give on every interval of `grid`.
    pub fn collect(grid: &[f64], constraints: &[&dyn PathConstraint]) -> Self {
        let mut table = Self { bounds: Vec::new(), first: vec![0] };
        for (k, pair) in grid.windows(2).enumerate() {
            for constraint in constraints {
                constraint.interval_bounds(k, pair[1] - pair[0], &mut table.bounds);
            }
            table.first.push(table.bounds.len());
            if k == 0 {
                // About as many on every interval.
                table.bounds.reserve((grid.len() - 1) * table.bounds.len());
                table.first.reserve(grid.len() - 1);
            }
        }
        table
    }

    /// The bounds of all intervals.
    pub fn all(&self) -> &[IntervalBound] {
        &self.bounds
    }

    /// The same, to be changed.
    pub fn of_mut(&mut self, k: usize) -> &mut [IntervalBound] {
        match (self.first.get(k), self.first.get(k + 1)) {
            (Some(&from), Some(&to)) => &mut self.bounds[from..to],
            _ => &mut [],
        }
    }

    /// The bounds of interval `k`.
    pub fn of(&self, k: usize) -> &[IntervalBound] {
        match (self.first.get(k), self.first.get(k + 1)) {
            (Some(&from), Some(&to)) => &self.bounds[from..to],
            _ => &[],
        }
    }
}
