//! The shortest motion of several axes from one state to another.

use arcfeed_sync::{MotionOptions, Trajectory};
use pyo3::prelude::*;

use crate::array::{Array1, Table};
use crate::axes::{self, Arrays, for_axes};
use crate::error::{input, undone};

trait Erased: Send + Sync {
    fn axes(&self) -> usize;
    fn duration(&self) -> f64;
    fn at(&self, t: f64, into: &mut [Table; 3]);
}

impl<const N: usize> Erased for Trajectory<N> {
    fn axes(&self) -> usize {
        N
    }

    fn duration(&self) -> f64 {
        Trajectory::duration(self)
    }

    fn at(&self, t: f64, into: &mut [Table; 3]) {
        let at = Trajectory::at(self, t);
        for (table, values) in into.iter_mut().zip([at.q, at.qd, at.qdd]) {
            table.push(values.as_slice());
        }
    }
}

/// A motion of several axes between two states.
#[pyclass(module = "arcfeed", frozen)]
pub struct StateToState {
    inner: Box<dyn Erased>,
}

#[pymethods]
impl StateToState {
    /// Duration, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration()
    }

    /// Position, velocity and acceleration at the times t (n,), s: three arrays (n, axes).
    ///
    /// Before 0 it is the start. After the end the axes go on from the target: its acceleration is brought to 0 with the greatest jerk, and its
    /// velocity stays; a target at rest stays where it is. A time that is not finite raises InputError.
    fn sample<'py>(&self, py: Python<'py>, t: Array1<'py>) -> PyResult<Arrays<'py>> {
        axes::sampled(py, self.inner.axes(), &t, |t, into| self.inner.at(t, into))
    }

    fn __repr__(&self) -> String {
        format!("StateToState({:.4} s, {} axes)", self.duration(), self.inner.axes())
    }
}

/// The shortest motion from one state to another under limits on velocity, acceleration and jerk.
///
/// start and target: lists of rows, position alone or with velocity and acceleration, a number an axis. velocity, acceleration, jerk:
/// greatest magnitudes, a number an axis. synchronisation: "time" (all axes arrive together), "none", "straight" (on the line
/// where that is possible) or "forced-straight". least_duration: it takes at least this long, s.
#[pyfunction]
#[pyo3(signature = (start, target, velocity, acceleration, jerk, *, synchronisation="time", least_duration=0.0))]
pub fn state_to_state(
    start: Vec<Vec<f64>>,
    target: Vec<Vec<f64>>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    jerk: Vec<f64>,
    synchronisation: &str,
    least_duration: f64,
) -> PyResult<StateToState> {
    let axes = velocity.len();
    let start = axes::states("start", &start, axes, "velocity has")?;
    let target = axes::states("target", &target, axes, "velocity has")?;
    let limits = axes::limits(&velocity, &acceleration, &jerk)?;
    let options = MotionOptions::new(axes::synchronisation(synchronisation)?);
    let options = options.with_least_duration(least_duration).map_err(input)?;
    for_axes!(axes, N => {
        let motion = Trajectory::<N>::new(&axes::of(&start), &axes::of(&target), &axes::of(&limits), &options);
        Ok(StateToState { inner: Box::new(motion.map_err(|error| undone("other", error))?) })
    })
}
