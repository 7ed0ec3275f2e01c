//! Joint trajectories: polynomials of the time.

use std::sync::Arc;

use arcfeed_interp::JointTrajectory as Pieces;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{Array1, Table};
use crate::axes::check_times;
use crate::error::input;

/// A trajectory of any number of joints.
trait Erased: Send + Sync {
    fn joint_names(&self) -> Vec<String>;
    fn duration(&self) -> f64;
    fn pieces(&self) -> usize;
    fn deviation_bound(&self) -> Option<f64>;
    /// Position, velocity, acceleration and jerk.
    fn at(&self, t: f64, into: &mut [Table; 4]);
    fn to_json(&self) -> String;
    fn reversed(&self) -> Arc<dyn Erased>;
}

struct Named<const N: usize> {
    names: [String; N],
    pieces: Pieces<N>,
}

impl<const N: usize> Erased for Named<N> {
    fn joint_names(&self) -> Vec<String> {
        self.names.to_vec()
    }

    fn duration(&self) -> f64 {
        self.pieces.duration()
    }

    fn pieces(&self) -> usize {
        self.pieces.len()
    }

    fn deviation_bound(&self) -> Option<f64> {
        self.pieces.deviation().map(|deviation| deviation.bound)
    }

    fn at(&self, t: f64, into: &mut [Table; 4]) {
        let at = self.pieces.at(t);
        for (table, values) in into.iter_mut().zip([at.q, at.qd, at.qdd, at.jerk]) {
            table.push(values.as_slice());
        }
    }

    fn to_json(&self) -> String {
        self.pieces.to_json(&self.names)
    }

    fn reversed(&self) -> Arc<dyn Erased> {
        Arc::new(Self { names: self.names.clone(), pieces: self.pieces.reversed() })
    }
}

/// Joints as polynomials of the time, of degree five in pieces. Independent of path and arm.
#[pyclass(module = "arcfeed", frozen)]
#[derive(Clone)]
pub struct JointTrajectory {
    inner: Arc<dyn Erased>,
}

impl JointTrajectory {
    /// The trajectory with the names of its joints.
    pub fn of<const N: usize>(pieces: Pieces<N>, names: &[String]) -> Self {
        let names = std::array::from_fn(|k| names.get(k).cloned().unwrap_or_default());
        Self { inner: Arc::new(Named { names, pieces }) }
    }
}

/// One array of shape (n, N) for each of position, velocity, acceleration and jerk.
type Arrays<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl JointTrajectory {
    /// From JSON in the format "joint-trajectory/1".
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let value: serde_json::Value = serde_json::from_str(text).map_err(input)?;
        let joints = value["joint_names"].as_array().map_or(0, Vec::len);
        macro_rules! read {
            ($($n:literal)*) => {
                match joints {
                    $($n => {
                        let (pieces, names) = Pieces::<$n>::from_json(text).map_err(input)?;
                        Ok(Self::of(pieces, &names))
                    })*
                    n => Err(input(format!("joint_names lists {n} joints: a trajectory has 1 to 10 of them"))),
                }
            };
        }
        read!(1 2 3 4 5 6 7 8 9 10)
    }

    /// As JSON in the format "joint-trajectory/1". Reading it gives the same numbers.
    fn to_json(&self) -> String {
        self.inner.to_json()
    }

    /// Names of the joints.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.inner.joint_names()
    }

    /// Duration, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration()
    }

    /// Distance from the plan that no joint exceeds, rad; None where there is no plan.
    #[getter]
    fn deviation_bound(&self) -> Option<f64> {
        self.inner.deviation_bound()
    }

    /// Position, velocity, acceleration and jerk of the joints at the times t (n,), s: four arrays (n, N). Times outside count as the
    /// nearest end; a time that is not finite raises InputError.
    fn sample<'py>(&self, py: Python<'py>, t: Array1<'py>) -> PyResult<Arrays<'py>> {
        let times = t.as_array();
        check_times(times.iter())?;
        let joints = self.inner.joint_names().len();
        let mut tables: [Table; 4] = std::array::from_fn(|_| Table::new(joints, times.len()));
        times.iter().for_each(|&t| self.inner.at(t, &mut tables));
        let [q, qd, qdd, jerk] = &tables;
        Ok((q.to_array(py)?, qd.to_array(py)?, qdd.to_array(py)?, jerk.to_array(py)?))
    }

    /// Times of samples at a period, s: its multiples, and the end.
    fn times<'py>(&self, py: Python<'py>, period: f64) -> PyResult<Bound<'py, PyArray1<f64>>> {
        if !(period.is_finite() && period > 0.0) {
            return Err(input(format!("period = {period}: give a number above 0, in s")));
        }
        robot_cr7::few_enough(self.duration(), period, "the period").map_err(input)?;
        Ok(PyArray1::from_vec(py, robot_cr7::sample_times(self.duration(), period).collect()))
    }

    /// The motion backwards in time.
    fn reversed(&self) -> Self {
        Self { inner: self.inner.reversed() }
    }

    /// Number of pieces.
    fn __len__(&self) -> usize {
        self.inner.pieces()
    }

    fn __repr__(&self) -> String {
        format!("JointTrajectory({:.4} s, {} pieces)", self.duration(), self.inner.pieces())
    }
}
