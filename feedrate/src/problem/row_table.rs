//! Rows and caps of all places of one kind.

use crate::constraint::{PathConstraint, Place, RowSink};
use crate::row::{LimitId, Quantity, Row};

/// Rows of one place after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct RowTable {
    pub rows: Vec<Row>,
    first: Vec<usize>,
    x_max: Vec<f64>,
    source: Vec<LimitId>,
}

impl RowTable {
    pub fn with_capacity(places: usize) -> Self {
        let mut first = Vec::with_capacity(places + 1);
        first.push(0);
        let (x_max, source) = (Vec::with_capacity(places), Vec::with_capacity(places));
        Self { rows: Vec::new(), first, x_max, source }
    }

    /// A table for so many places with about as many rows each as this one.
    pub fn emptied(&self, places: usize) -> Self {
        let mut new = Self::with_capacity(places);
        // The product of two counts can be beyond a number of 32 bits.
        let rows = (places as u64 * self.rows.len() as u64).div_ceil(self.x_max.len().max(1) as u64);
        new.rows.reserve(usize::try_from(rows).unwrap_or(0));
        new
    }

    /// Collects the rows of the next place; tells which one is not sound.
    #[inline(always)]
    pub fn collect(&mut self, place: Place, constraints: &[&dyn PathConstraint]) -> Result<(), LimitId> {
        let start = self.rows.len();
        let source = LimitId::path(Quantity::Other);
        let mut sink = RowSink { rows: &mut self.rows, sound: true, x_max: f64::INFINITY, source };
        for constraint in constraints {
            constraint.rows(place, &mut sink);
        }
        let (x_max, source) = (sink.x_max, sink.source);
        if !sink.sound
            && let Some(row) = self.rows[start..].iter().find(|row| !row.is_sound())
        {
            return Err(row.source);
        }
        if !(x_max >= 0.0) {
            return Err(source);
        }
        self.x_max.push(x_max);
        self.source.push(source);
        self.first.push(self.rows.len());
        Ok(())
    }

    pub fn push(&mut self, rows: &[Row], x_max: f64, source: LimitId) {
        self.rows.extend_from_slice(rows);
        self.first.push(self.rows.len());
        self.x_max.push(x_max);
        self.source.push(source);
    }

    pub fn rows(&self, i: usize) -> &[Row] {
        &self.rows[self.first[i]..self.first[i + 1]]
    }

    pub fn rows_mut(&mut self, i: usize) -> &mut [Row] {
        &mut self.rows[self.first[i]..self.first[i + 1]]
    }

    pub fn x_max(&self, i: usize) -> f64 {
        self.x_max[i]
    }

    pub fn source(&self, i: usize) -> LimitId {
        self.source[i]
    }

    pub fn is_empty(&self) -> bool {
        self.x_max.is_empty()
    }
}
