//! Planning a path on any robot.

use arcfeed_interp::PathArm;
use pyo3::prelude::*;
use robot_cr7::{OnProgram, OnToolPath, ProgramTask, ReportHead, Task, few_enough};

use crate::error::{raised, undone};
use crate::input::{Job, Path};
use crate::motion::{Motion, PlanData};
use crate::robot::{RobotArgument, robot_of};

/// The ways to shorten a motion that has too many samples.
pub const LEVERS: &str = "the feed and the limits of the job";

/// Why there is no motion, before it becomes an exception.
pub enum Failure {
    /// Of the library.
    Cr7(robot_cr7::Cr7Error),
    /// An exception already.
    Raised(PyErr),
}

impl From<robot_cr7::Cr7Error> for Failure {
    fn from(error: robot_cr7::Cr7Error) -> Self {
        Self::Cr7(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Cr7(error) => raised(error),
            Failure::Raised(error) => error,
        }
    }
}

fn other(error: impl std::fmt::Display) -> Failure {
    Failure::Raised(undone("other", error))
}

/// What is made of a path.
struct Plan<'a> {
    job: &'a robot_cr7::Job,
    names: &'a [String],
    compile: Option<f64>,
    bound: bool,
}

impl OnToolPath for Plan<'_> {
    type Output = PlanData;
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, warnings: Vec<String>) -> Result<PlanData, Failure> {
        few_enough(task.least_duration(), task.period(), LEVERS).map_err(other)?;
        let (mut motion, compiled) = match self.compile {
            Some(tolerance) => {
                let (motion, compiled, certificate) = task.plan_compiled(tolerance)?;
                (motion, Some((tolerance, compiled, certificate)))
            }
            None => (task.plan()?, None),
        };
        motion.warn(warnings);
        few_enough(motion.trajectory().duration(), motion.trajectory().period(), LEVERS).map_err(other)?;
        PlanData::of_motion(&motion, compiled, self.names, self.bound).map_err(Failure::Raised)
    }
}

impl OnProgram for Plan<'_> {
    type Output = PlanData;
    type Error = Failure;

    fn run<A: PathArm<N> + Clone, const N: usize>(
        self,
        task: ProgramTask<A, N>,
        warnings: Vec<String>,
    ) -> Result<PlanData, Failure> {
        few_enough(task.least_duration(), task.period(), LEVERS).map_err(other)?;
        let (mut motion, compiled) = match self.compile {
            Some(tolerance) => {
                let (motion, compiled) = task.plan_compiled(tolerance)?;
                (motion, Some((tolerance, compiled)))
            }
            None => (task.plan()?, None),
        };
        motion.warn(warnings);
        few_enough(motion.duration(), motion.period(), LEVERS).map_err(other)?;
        let at_rest = self.job.feed.end_speeds[1] == 0.0;
        PlanData::of_program(&motion, compiled, self.names, at_rest).map_err(Failure::Raised)
    }
}

/// Plans the motion along a path and verifies it. A motion that is returned keeps every limit.
///
/// path: a Path; left out: that of the job, else the butterfly. robot: a name of robots(), a .urdf or .json file, or a Robot.
/// job: limits and frames; left out: the documented defaults. compile_rad: also the joints as polynomials of the time, within
/// this tolerance of the plan (rad). bound: also a lower bound of the duration. The interpreter is free while it plans.
///
/// Raises InputError for what cannot be used, PlanError for what cannot be done, with the place.
#[pyfunction]
#[pyo3(signature = (path=None, robot=None, job=None, *, compile_rad=None, bound=false))]
pub fn plan(
    py: Python<'_>,
    path: Option<&Path>,
    robot: Option<RobotArgument<'_>>,
    job: Option<&Job>,
    compile_rad: Option<f64>,
    bound: bool,
) -> PyResult<Motion> {
    if let Some(value) = compile_rad.filter(|value| !(value.is_finite() && *value > 0.0)) {
        return Err(crate::error::input(format!("compile_rad = {value}: give a number above 0, such as 1e-6")));
    }
    let robot = robot_of(robot)?;
    let (job, file) = job_and_path(job, path)?;
    let data = py.detach(|| {
        let names = robot.any().joint_names();
        let work = Plan { job: &job, names, compile: compile_rad, bound };
        match ProgramTask::is_needed(&job, &file) {
            true => robot.on_program(&job, &file, work),
            false => robot.on_tool_path(&job, &file, work),
        }
    })?;
    Ok(Motion::new(ReportHead::new("plan", &robot), data))
}

/// The job given or the default one, and the path given, that of the job, or the butterfly.
pub fn job_and_path(job: Option<&Job>, path: Option<&Path>) -> PyResult<(robot_cr7::Job, robot_cr7::PathFile)> {
    let job = job.map_or_else(robot_cr7::Job::default, |job| job.inner.clone());
    let file = match (path, &job.path_file) {
        (Some(path), _) => path.inner.clone(),
        (None, Some(file)) => robot_cr7::PathFile::read_for_job(file, None, &job).map_err(crate::error::input)?,
        (None, None) => robot_cr7::butterfly().map_err(crate::error::input)?,
    };
    Ok((job, file))
}

struct Compare {
    head: ReportHead,
}

impl OnToolPath for Compare {
    type Output = String;
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, warnings: Vec<String>) -> Result<String, Failure> {
        let mut comparison = robot_cr7::compare(&task, |_| {})?;
        comparison.warnings.extend(warnings);
        Ok(self.head.json(&comparison))
    }
}

/// Every planner on one job, as a dict: duration, ratio to the lower bound, planning time and worst use of each limit.
#[pyfunction]
#[pyo3(signature = (path=None, robot=None, job=None))]
pub fn compare<'py>(
    py: Python<'py>,
    path: Option<&Path>,
    robot: Option<RobotArgument<'py>>,
    job: Option<&Job>,
) -> PyResult<Bound<'py, PyAny>> {
    let robot = robot_of(robot)?;
    let (job, file) = job_and_path(job, path)?;
    let head = ReportHead::new("compare", &robot);
    let json = py.detach(|| robot.on_tool_path(&job, &file, Compare { head }))?;
    py.import("json")?.call_method1("loads", (json,))
}
