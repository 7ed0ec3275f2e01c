//! Errors about one grid, told for another.

use crate::error::FeedError;

impl FeedError {
    /// The error about a grid with more points, with the index of that place on `grid`.
    pub(crate) fn on_grid(mut self, grid: &[f64]) -> Self {
        if let Self::BadRow { index, s, .. }
        | Self::StaticallyInfeasible { index, s, .. }
        | Self::Infeasible { index, s, .. }
        | Self::Standstill { index, s, .. }
        | Self::Unbounded { index, s, .. } = &mut self
        {
            *index = grid.partition_point(|at| *at < *s);
        }
        self
    }

    /// The error about a part of a grid that begins at point `first`, with the index of the whole grid.
    pub(crate) fn counted_from(mut self, first: usize) -> Self {
        if let Self::BadGrid { index, .. }
        | Self::BadRow { index, .. }
        | Self::StaticallyInfeasible { index, .. }
        | Self::Infeasible { index, .. }
        | Self::Standstill { index, .. }
        | Self::StandsStill { index, .. }
        | Self::Unbounded { index, .. }
        | Self::StartTooFast { segment: index, .. } = &mut self
        {
            *index += first;
        }
        self
    }
}
