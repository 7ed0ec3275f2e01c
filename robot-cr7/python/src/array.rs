//! Numbers from and to NumPy.

use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1, PyArrayLike2, PyArrayMethods};
use pyo3::prelude::*;

/// An array of numbers, or what NumPy makes one of.
pub type Array1<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;
/// The same of two dimensions.
pub type Array2<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;

/// Rows of equal length, one after the other.
#[derive(Debug, Clone, Default)]
pub struct Table {
    columns: usize,
    values: Vec<f64>,
}

impl Table {
    /// An empty table for rows of so many values.
    pub fn new(columns: usize, rows: usize) -> Self {
        Self { columns, values: Vec::with_capacity(columns * rows) }
    }

    /// Adds a row.
    pub fn push(&mut self, row: &[f64]) {
        debug_assert_eq!(row.len(), self.columns);
        self.values.extend_from_slice(row);
    }

    /// As an array of shape (rows, columns).
    ///
    /// # Errors
    /// Those of NumPy.
    pub fn to_array<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.values.len().checked_div(self.columns).unwrap_or(0);
        PyArray1::from_slice(py, &self.values).reshape([rows, self.columns])
    }
}
