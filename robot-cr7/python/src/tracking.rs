//! Axes that follow a moving target.

use arcfeed_feedrate::{AxisLimits, AxisState, TrackStatus};
use arcfeed_sync::{SyncError, TrackingGenerator as Inner};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::axes::{self, for_axes};
use crate::error::input;
use crate::online::refused;
use crate::online_step::values;

trait Tracker: Send + Sync {
    fn axes(&self) -> usize;
    fn step(&mut self, target: &[AxisState]) -> Result<TrackingStep, SyncError>;
    fn set_limits(&mut self, limits: &[AxisLimits]) -> Result<(), SyncError>;
    fn state(&self) -> Vec<AxisState>;
}

impl<const N: usize> Tracker for Inner<N> {
    fn axes(&self) -> usize {
        N
    }

    fn step(&mut self, target: &[AxisState]) -> Result<TrackingStep, SyncError> {
        let step = Self::step(self, &axes::of(target))?;
        let name = |status: &TrackStatus| match status {
            TrackStatus::Following => "following",
            TrackStatus::Approaching => "approaching",
            TrackStatus::Saturated => "saturated",
        };
        let status = step.status.iter().map(name).collect();
        Ok(TrackingStep { values: values(&step.state), following: step.is_following(), status })
    }

    fn set_limits(&mut self, limits: &[AxisLimits]) -> Result<(), SyncError> {
        Self::set_limits(self, &axes::of(limits))
    }

    fn state(&self) -> Vec<AxisState> {
        Self::state(self).to_vec()
    }
}

/// What one cycle of a TrackingGenerator gave.
#[pyclass(module = "arcfeed", frozen)]
pub struct TrackingStep {
    values: [Vec<f64>; 4],
    /// True if every axis is in the state of its target, exactly.
    #[pyo3(get)]
    following: bool,
    /// For each axis "following", "approaching" or "saturated" (the target does more than the limits allow).
    #[pyo3(get)]
    status: Vec<&'static str>,
}

#[pymethods]
impl TrackingStep {
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

/// Follows a moving target with 1 to 10 axes, whose state is given in every cycle.
///
/// Each axis takes the shortest way to where it meets its target soonest, and is in the state of the target from then on, exactly, while the
/// target keeps the limits. start, velocity, acceleration, jerk, cycle: as of OnlineGenerator.
#[pyclass(module = "arcfeed")]
pub struct TrackingGenerator {
    inner: Box<dyn Tracker>,
}

#[pymethods]
impl TrackingGenerator {
    #[new]
    fn new(
        start: Vec<Vec<f64>>,
        velocity: Vec<f64>,
        acceleration: Vec<f64>,
        jerk: Vec<f64>,
        cycle: f64,
    ) -> PyResult<Self> {
        let axes = velocity.len();
        let start = axes::states("start", &start, axes, "velocity has")?;
        let limits = axes::limits(&velocity, &acceleration, &jerk)?;
        for_axes!(axes, N => {
            let made = Inner::<N>::new(&axes::of(&start), &axes::of(&limits), cycle).map_err(input)?;
            Ok(Self { inner: Box::new(made) })
        })
    }

    /// Sets the limits from the next cycle on: greatest magnitudes, a number an axis.
    fn set_limits(&mut self, velocity: Vec<f64>, acceleration: Vec<f64>, jerk: Vec<f64>) -> PyResult<()> {
        let (given, axes) = (velocity.len(), self.inner.axes());
        if given != axes {
            return Err(input(format!("velocity lists {given} numbers: give one for each of the {axes} axes")));
        }
        let limits = axes::limits(&velocity, &acceleration, &jerk)?;
        self.inner.set_limits(&limits).map_err(refused)
    }

    /// Moves on by one cycle, at whose end the target is in this state: rows as of start.
    fn step(&mut self, target: Vec<Vec<f64>>) -> PyResult<TrackingStep> {
        let target = axes::states("target", &target, self.inner.axes(), "the generator has")?;
        self.inner.step(&target).map_err(refused)
    }

    /// The state of the last step: position, velocity, acceleration (3, axes).
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        axes::state_array(py, &self.inner.state())
    }

    fn __repr__(&self) -> String {
        format!("TrackingGenerator({} axes)", self.inner.axes())
    }
}
