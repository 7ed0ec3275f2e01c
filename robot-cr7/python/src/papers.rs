//! The figures of the papers beside ours.

use pyo3::prelude::*;
use robot_cr7::reproduce::Overview;

/// Runs the papers' examples and sets their figures beside ours: a dict with a list of claims for each paper. Takes some minutes.
#[pyfunction]
pub fn reproduce(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let json = py.detach(|| Overview::new().map(|all| all.to_json())).map_err(crate::error::raised)?;
    py.import("json")?.call_method1("loads", (json,))
}
