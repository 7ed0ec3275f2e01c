//! What one cycle of motion generated cycle by cycle gave.

use arcfeed_sync::JointState;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::axes;

/// Position, velocity, acceleration and jerk of every axis.
pub fn values<const N: usize>(state: &JointState<N>) -> [Vec<f64>; 4] {
    [state.q, state.qd, state.qdd, state.qddd].map(|values| values.as_slice().to_vec())
}

/// What one cycle of an OnlineGenerator gave: the state at its end and what happened in it.
#[pyclass(module = "arcfeed", frozen)]
pub struct OnlineStep {
    pub values: [Vec<f64>; 4],
    /// True in the cycle in which the last axis arrives, or rests after a stop.
    #[pyo3(get)]
    pub reached: bool,
    /// True in the first cycle of a new plan.
    #[pyo3(get)]
    pub replanned: bool,
    /// True while a state is outside the limits: it was when they were set, and is brought back inside.
    #[pyo3(get)]
    pub outside_limits: bool,
    /// For each axis, True in the cycle in which it arrives.
    #[pyo3(get)]
    pub arrived: Vec<bool>,
    /// For each axis, True when it brakes after its target because its range ends.
    #[pyo3(get)]
    pub range_ends: Vec<bool>,
}

#[pymethods]
impl OnlineStep {
    /// Positions (axes,), rad or m.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        axes::row(py, &self.values[0])
    }

    /// Velocities (axes,), 1/s.
    #[getter]
    fn qd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        axes::row(py, &self.values[1])
    }

    /// Accelerations (axes,), 1/s^2.
    #[getter]
    fn qdd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        axes::row(py, &self.values[2])
    }

    /// Jerks (axes,), 1/s^3.
    #[getter]
    fn jerk<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        axes::row(py, &self.values[3])
    }
}
