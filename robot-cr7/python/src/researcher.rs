//! The problem of a plan as arrays, and speed laws of a researcher's own.

use arcfeed_feedrate::{FeedProblem, MotionState, SpeedLaw};
use arcfeed_interp::{MotionPath, PathArm, RowsNeeded};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_cr7::{OnToolPath, Task, limit_lines};

use crate::array::Table;
use crate::error::{input, unplanned};
use crate::input::{Job, Path};
use crate::plan::{Failure, job_and_path};
use crate::robot::{RobotArgument, robot_of};

/// The limits of a plan on a grid along the path: v(s) is sought with x = v^2 and u = dv/dt.
///
/// At grid point i each row demands lo <= a u + b x + c sqrt(x) + d <= hi, and x is at most cap[i].
#[pyclass(module = "arcfeed", frozen)]
pub struct Problem {
    job: robot_cr7::Job,
    file: robot_cr7::PathFile,
    robot: robot_cr7::Robot,
    rows: Rows,
}

/// The rows, without the path.
struct Rows {
    s: Vec<f64>,
    cap: Vec<f64>,
    at: Vec<i64>,
    values: Table,
    sources: Vec<String>,
}

impl Rows {
    fn new(problem: &FeedProblem) -> Self {
        let places = problem.grid().len();
        let mut rows = Self {
            s: problem.grid().to_vec(),
            cap: (0..places).map(|i| problem.cap(i).0).collect(),
            at: Vec::new(),
            values: Table::new(6, 0),
            sources: Vec::new(),
        };
        for i in 0..places {
            for row in problem.rows(i) {
                rows.at.push(i as i64);
                rows.values.push(&[row.a, row.b, row.c, row.d, row.lo, row.hi]);
                rows.sources.push(row.source.to_string());
            }
        }
        rows
    }
}

struct Build;

impl OnToolPath for Build {
    type Output = Rows;
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, _: Vec<String>) -> Result<Rows, Failure> {
        let path = task.tool_path()?;
        let planner = task.planner()?;
        let fail = |error| Failure::Raised(unplanned(format!("{}: {error}", task.name()), &error));
        let problem = planner.prepare(&path, RowsNeeded::Points).map_err(fail)?;
        let rows = problem.rows(RowsNeeded::Points).map_err(|error| fail(error.into()))?;
        Ok(Rows::new(&rows))
    }
}

struct Check {
    law: SpeedLaw,
    jerk_limited: bool,
}

impl OnToolPath for Check {
    type Output = (bool, String);
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, _: Vec<String>) -> Result<(bool, String), Failure> {
        let path = task.tool_path()?;
        let planner = task.planner()?;
        let fail = |error| Failure::Raised(unplanned(format!("{}: {error}", task.name()), &error));
        let problem = planner.prepare(&path, RowsNeeded::Points).map_err(fail)?;
        let verification = planner.verify(&problem, &self.law, self.jerk_limited).map_err(fail)?;
        let lines = limit_lines(&verification, path.parameter());
        let holds = lines.iter().all(robot_cr7::LimitLine::holds);
        let json = serde_json::to_string(&lines).map_err(|error| Failure::Raised(input(error)))?;
        Ok((holds, json))
    }
}

/// The limits of a job on a grid along its path, as arrays; arguments as those of plan().
#[pyfunction]
#[pyo3(signature = (path=None, robot=None, job=None))]
pub fn problem(
    py: Python<'_>,
    path: Option<&Path>,
    robot: Option<RobotArgument<'_>>,
    job: Option<&Job>,
) -> PyResult<Problem> {
    let robot = robot_of(robot)?;
    let (job, file) = job_and_path(job, path)?;
    let rows = py.detach(|| robot.on_tool_path(&job, &file, Build))?;
    Ok(Problem { job, file, robot, rows })
}

impl Problem {
    fn held(&self, py: Python<'_>, law: SpeedLaw, jerk_limited: bool) -> PyResult<Py<PyDict>> {
        let duration = arcfeed_feedrate::MotionLaw::duration(&law);
        let (holds, json) =
            py.detach(|| self.robot.on_tool_path(&self.job, &self.file, Check { law, jerk_limited }))?;
        let dict = PyDict::new(py);
        dict.set_item("holds", holds)?;
        dict.set_item("duration", duration)?;
        dict.set_item("limits", py.import("json")?.call_method1("loads", (json,))?)?;
        Ok(dict.unbind())
    }
}

#[pymethods]
impl Problem {
    /// The grid along the path, m (n,).
    #[getter]
    fn s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.rows.s)
    }

    /// Greatest v^2 at each grid point, m^2/s^2 (n,); inf for none.
    #[getter]
    fn cap<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.rows.cap)
    }

    /// The rows: a dict of at (grid point), a, b, c, d, lo, hi (arrays of one length) and source (a list of names).
    #[getter]
    fn rows<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("at", PyArray1::from_slice(py, &self.rows.at))?;
        let table = self.rows.values.to_array(py)?;
        for (k, name) in ["a", "b", "c", "d", "lo", "hi"].into_iter().enumerate() {
            dict.set_item(name, table.get_item((pyo3::types::PySlice::full(py), k))?)?;
        }
        dict.set_item("source", self.rows.sources.clone())?;
        Ok(dict)
    }

    /// Holds a speed law of your own by all limits of the job: speeds v (m/s) at places s (m, the whole path), with constant
    /// acceleration between. A dict of holds, duration (s) and limits (each with its worst place). Jerk counts if jerk_limited.
    #[pyo3(signature = (s, v, *, jerk_limited=false))]
    fn verify(&self, py: Python<'_>, s: Vec<f64>, v: Vec<f64>, jerk_limited: bool) -> PyResult<Py<PyDict>> {
        self.held(py, SpeedLaw::from_knots(&s, &v).map_err(input)?, jerk_limited)
    }

    /// The same for phases of constant jerk, (jerk in m/s^3, duration in s) each, from a start speed (m/s) on.
    #[pyo3(signature = (phases, *, start_speed=0.0, jerk_limited=true))]
    fn verify_phases(
        &self,
        py: Python<'_>,
        phases: Vec<(f64, f64)>,
        start_speed: f64,
        jerk_limited: bool,
    ) -> PyResult<Py<PyDict>> {
        let start = MotionState { v: start_speed, ..MotionState::default() };
        self.held(py, SpeedLaw::from_phases(start, &phases).map_err(input)?, jerk_limited)
    }

    fn __repr__(&self) -> String {
        format!("Problem({} grid points, {} rows)", self.rows.s.len(), self.rows.at.len())
    }
}
