//! Motions through way-points without a stop.

use arcfeed_sync::{Route, WayPoint, WayPointPlanner, WayPointTrajectory};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::array::{Array1, Array2, Table};
use crate::axes::{self, Arrays, for_axes};
use crate::error::input;
use crate::online::refused;

trait Erased: Send + Sync {
    fn axes(&self) -> usize;
    fn durations(&self) -> &[f64];
    fn at(&self, t: f64, into: &mut [Table; 3]);
}

impl<const N: usize> Erased for WayPointTrajectory<N> {
    fn axes(&self) -> usize {
        N
    }

    fn durations(&self) -> &[f64] {
        self.section_durations()
    }

    fn at(&self, t: f64, into: &mut [Table; 3]) {
        let at = Self::at(self, t);
        for (table, values) in into.iter_mut().zip([at.q, at.qd, at.qdd]) {
            table.push(values.as_slice());
        }
    }
}

/// A motion of several axes through way-points, which all axes pass at the same times.
#[pyclass(module = "arcfeed", frozen)]
pub struct WayPointMotion {
    inner: Box<dyn Erased>,
}

#[pymethods]
impl WayPointMotion {
    /// Duration, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.durations().iter().sum()
    }

    /// The times at which the way-points are passed (points,), s.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let durations = self.inner.durations();
        let sum = |sum: &mut f64, duration: &f64| {
            *sum += duration;
            Some(*sum)
        };
        let times: Vec<f64> = durations[..durations.len() - 1].iter().scan(0.0, sum).collect();
        axes::row(py, &times)
    }

    /// Position, velocity and acceleration at the times t (n,), s: three arrays (n, axes).
    ///
    /// Before 0 it is the start. After the end the axes go on from the target: its acceleration is brought to 0 with the greatest jerk, and its
    /// velocity stays; a target at rest stays where it is. A time that is not finite raises InputError.
    fn sample<'py>(&self, py: Python<'py>, t: Array1<'py>) -> PyResult<Arrays<'py>> {
        axes::sampled(py, self.inner.axes(), &t, |t, into| self.inner.at(t, into))
    }

    fn __repr__(&self) -> String {
        let (points, axes) = (self.inner.durations().len() - 1, self.inner.axes());
        format!("WayPointMotion({:.4} s, {points} way-points, {axes} axes)", self.duration())
    }
}

/// A motion through way-points without a stop, in nearly the shortest time under limits on velocity, acceleration and jerk.
///
/// start and target: lists of rows, position alone or with velocity and acceleration, a number an axis. points: positions (points, axes), at
/// most 64. velocity, acceleration, jerk: greatest magnitudes, a number an axis. passing: velocities in the points (points, axes), NaN where
/// free.
#[pyfunction]
#[pyo3(signature = (start, points, target, velocity, acceleration, jerk, *, passing=None))]
pub fn way_points(
    start: Vec<Vec<f64>>,
    points: Array2<'_>,
    target: Vec<Vec<f64>>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    jerk: Vec<f64>,
    passing: Option<Array2<'_>>,
) -> PyResult<WayPointMotion> {
    let axes = velocity.len();
    let start = axes::states("start", &start, axes, "velocity has")?;
    let target = axes::states("target", &target, axes, "velocity has")?;
    let limits = axes::limits(&velocity, &acceleration, &jerk)?;
    let points = points.as_array();
    if points.ncols() != axes {
        return Err(input(format!(
            "points have {} columns, and velocity {axes} numbers: give one an axis",
            points.ncols()
        )));
    }
    let passing = passing.as_ref().map(|passing| passing.as_array());
    if let Some(passing) = passing.as_ref().filter(|passing| passing.dim() != points.dim()) {
        return Err(input(format!("passing has the shape {:?}, and points {:?}", passing.dim(), points.dim())));
    }
    for_axes!(axes, N => {
        let point = |i: usize| {
            let mut point = WayPoint::<N>::new(std::array::from_fn(|k| points[[i, k]]));
            for k in 0..N {
                let given = passing.as_ref().map(|passing| passing[[i, k]]).filter(|v| !v.is_nan());
                point = given.map_or(point, |v| point.with_velocity(k, v));
            }
            point
        };
        let points: Vec<WayPoint<N>> = (0..points.nrows()).map(point).collect();
        let route = Route::new(&points, axes::of(&target), axes::of(&limits));
        let motion = WayPointPlanner::new().plan(&axes::of(&start), &route).map_err(refused)?;
        Ok(WayPointMotion { inner: Box::new(motion) })
    })
}
