//! The shortest motion of several axes from one state to another.

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::array::{Array1, Table};
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

/// One array of shape (n, axes) for each of position, velocity and acceleration.
type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

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
    fn sample<'py>(&self, py: Python<'py>, t: Array1<'py>) -> PyResult<Arrays<'py>> {
        let times = t.as_array();
        let mut tables: [Table; 3] = std::array::from_fn(|_| Table::new(self.inner.axes(), times.len()));
        times.iter().for_each(|&t| self.inner.at(t, &mut tables));
        let [q, qd, qdd] = &tables;
        Ok((q.to_array(py)?, qd.to_array(py)?, qdd.to_array(py)?))
    }

    fn __repr__(&self) -> String {
        format!("StateToState({:.4} s, {} axes)", self.duration(), self.inner.axes())
    }
}

/// Three rows of a state: position, velocity, acceleration.
fn state<const N: usize>(rows: &[Vec<f64>]) -> [AxisState; N] {
    let value = |row: usize, k: usize| rows.get(row).map_or(0.0, |values| values[k]);
    std::array::from_fn(|k| AxisState::new(value(0, k), value(1, k), value(2, k)))
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
    for (what, rows) in [("start", &start), ("target", &target)] {
        if !(1..=3).contains(&rows.len()) {
            return Err(input(format!("{what} has {} rows: give position, velocity, acceleration", rows.len())));
        }
        if let Some(row) = rows.iter().find(|row| row.len() != axes) {
            return Err(input(format!(
                "{what} has a row of {} numbers, and velocity has {axes}: give one an axis",
                row.len()
            )));
        }
    }
    for (what, values) in [("acceleration", &acceleration), ("jerk", &jerk)] {
        if values.len() != axes {
            return Err(input(format!("{what} lists {} numbers, and velocity {axes}: give one an axis", values.len())));
        }
    }
    let synchronisation = match synchronisation {
        "time" => Synchronisation::Time,
        "none" => Synchronisation::None,
        "straight" => Synchronisation::StraightLine,
        "forced-straight" => Synchronisation::ForcedStraight,
        other => {
            return Err(input(format!(
                "synchronisation {other:?}: use \"time\", \"none\", \"straight\" or \"forced-straight\""
            )));
        }
    };
    let limits = (0..axes)
        .map(|k| AxisLimits::symmetric(velocity[k], acceleration[k], jerk[k]))
        .collect::<Result<Vec<_>, _>>()
        .map_err(input)?;
    let options = MotionOptions::new(synchronisation).with_least_duration(least_duration).map_err(input)?;
    macro_rules! solve {
        ($($n:literal)*) => {
            match axes {
                $($n => {
                    let limits: [AxisLimits; $n] = std::array::from_fn(|k| limits[k]);
                    let motion = Trajectory::<$n>::new(&state(&start), &state(&target), &limits, &options)
                        .map_err(|error| undone("other", error))?;
                    Ok(StateToState { inner: Box::new(motion) })
                })*
                n => Err(input(format!("{n} axes: give 1 to 10"))),
            }
        };
    }
    solve!(1 2 3 4 5 6 7 8 9 10)
}
