//! Many jobs: each planned, verified and told as one line, whatever becomes of the others.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use arcfeed_interp::{PathArm, PlanError};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::error::Cr7Error;
use super::limit_line::worst;
use super::on_robot::{OnProgram, OnToolPath};
use super::plan_error::plan_error;
use super::program_task::ProgramTask;
use super::robot::Robot;
use super::samples::few_enough;
use super::task::Task;
use super::trajectory_row::TrajectoryRow;
use crate::input::error::InputError;
use crate::input::job::Job;
use crate::input::path_file::PathFile;
use crate::input::sample_paths::butterfly;
use crate::output::report::Report;
use crate::output::trajectory_csv::TrajectoryWriter;
use crate::output::whole_file::{unwritten, write_whole};

/// The keys that make a motion faster that has too many samples.
const LEVERS: &str = "feed.feed_mm_s and the limits of the job";

/// A job with its name.
///
/// In a file of jobs each line is a JSON object: the tables of a job file, beside them `id` (the name, else the number of the line) and
/// `robot` (else the CR7). Files are named from the folder of that file.
///
/// ```
/// use robot_cr7::BatchItem;
/// let item = BatchItem::from_line(r#"{"id": "a", "robot": "ur5e", "feed": {"feed_mm_s": 50}}"#, 1, "jobs.jsonl".as_ref());
/// let result = item.run(None);
/// assert_eq!((result.id.as_str(), result.error), ("a", None));
/// assert!(result.duration_s > Some(7.0));
/// ```
#[derive(Debug, Clone)]
pub struct BatchItem {
    /// The name of the job.
    pub id: String,
    /// The robot, as on the command line.
    pub robot: String,
    job: Result<Box<Job>, String>,
}

/// The result of one job. Its fields are the keys of the line of JSON, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BatchResult {
    /// The name of the job.
    pub id: String,
    /// The robot.
    pub robot: String,
    /// Why there is no motion.
    pub error: Option<String>,
    /// Duration of the motion, s.
    pub duration_s: Option<f64>,
    /// Length of the path, m.
    pub length_m: Option<f64>,
    /// The planner whose speed law it is.
    pub planner: Option<String>,
    /// The limit that is used most, and the part of it.
    pub worst_limit: Option<String>,
    /// See there.
    pub worst_ratio: Option<f64>,
    /// Number of warnings.
    pub warnings: usize,
    /// Time of computing, s.
    pub computing_s: f64,
}

impl BatchItem {
    /// A job of a line of JSON; `number` is that of the line, from 1, `file` the file that it stands in. What is wrong with it shows in the
    /// result.
    pub fn from_line(line: &str, number: usize, file: &Path) -> Self {
        let wrong = |id: String, what: String| Self { id, robot: String::new(), job: Err(what) };
        let place = format!("{}:{number}", file.display());
        let mut tables: Map<String, Value> = match serde_json::from_str(line) {
            Ok(tables) => tables,
            Err(error) => return wrong(number.to_string(), format!("{place}: no JSON object: {error}")),
        };
        let in_line = |what: String| format!("{place}: {what}");
        let id = match taken(&mut tables, "id") {
            Ok(id) => id.unwrap_or_else(|| number.to_string()),
            Err(what) => return wrong(number.to_string(), in_line(what)),
        };
        let robot = match taken(&mut tables, "robot") {
            Ok(robot) => robot.unwrap_or_else(|| "cr7".to_owned()),
            Err(what) => return wrong(id, in_line(what)),
        };
        if tables.is_empty() {
            return Self { id, robot, job: Ok(Box::default()) };
        }
        let job = toml::to_string(&tables).map_err(|error| format!("{place}: {error}")).and_then(|text| {
            Job::from_bytes(text.as_bytes(), file).map_err(|error| {
                // The lines that it names are those of another form of the job.
                let text = error.to_string();
                let own = text.strip_prefix(&file.display().to_string()).unwrap_or(&text);
                let own = own.trim_start_matches(|c: char| c == ':' || c.is_ascii_digit()).trim_start();
                format!("{place}: {own}")
            })
        });
        Self { id, robot, job: job.map(Box::new) }
    }

    /// The name that [`BatchItem::from_line`] gives the job of a line.
    pub fn id_of(line: &str, number: usize) -> String {
        let tables = serde_json::from_str::<Map<String, Value>>(line).ok();
        tables.and_then(|mut tables| taken(&mut tables, "id").ok()?).unwrap_or_else(|| number.to_string())
    }

    /// A job of a job file, with the name of the file.
    pub fn from_file(file: &Path, robot: &str) -> Self {
        let id = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let job = Job::read(file).map(Box::new).map_err(|error| error.to_string());
        Self { id, robot: robot.to_owned(), job }
    }

    /// Plans the job; its trajectory is written to `folder` as `ID.csv`, where one is given. A failure, even a defect of this program, is a
    /// result like others.
    pub fn run(&self, folder: Option<&Path>) -> BatchResult {
        let begin = Instant::now();
        let planned = catch_unwind(AssertUnwindSafe(|| self.planned(folder)))
            .unwrap_or_else(|_| Err("a defect of this program: please report the job".to_owned()));
        let computing_s = begin.elapsed().as_secs_f64();
        let (id, robot) = (self.id.clone(), self.robot.clone());
        match planned {
            Err(error) => BatchResult {
                id,
                robot,
                error: Some(error),
                duration_s: None,
                length_m: None,
                planner: None,
                worst_limit: None,
                worst_ratio: None,
                warnings: 0,
                computing_s,
            },
            Ok(report) => {
                let worst = worst(&report.limits);
                BatchResult {
                    id,
                    robot,
                    error: None,
                    duration_s: Some(report.duration_s),
                    length_m: Some(report.length_m),
                    planner: Some(report.planner.clone()),
                    worst_limit: worst.map(|line| line.name.clone()),
                    worst_ratio: worst.map(|line| line.ratio),
                    warnings: report.warnings.len(),
                    computing_s,
                }
            }
        }
    }

    fn planned(&self, folder: Option<&Path>) -> Result<Report, String> {
        let job = self.job.as_ref().map_err(Clone::clone)?;
        let to = folder.map(|folder| self.file_in(folder)).transpose()?;
        let robot = Robot::load(&self.robot, None, None).map_err(|error| error.to_string())?;
        let file = match &job.path_file {
            Some(file) => PathFile::read_for_job(file, None, job),
            None => butterfly(),
        };
        let file = file.map_err(|error| error.to_string())?;
        let work = Work { job, to: to.as_deref(), names: robot.any().joint_names() };
        let done = match ProgramTask::is_needed(job, &file) {
            true => robot.on_program(job, &file, work),
            false => robot.on_tool_path(job, &file, work),
        };
        done.map_err(|Failure(what)| {
            // What an earlier run of another job of this name has left there is not its trajectory.
            let _ = to.as_ref().map(std::fs::remove_file);
            what
        })
    }

    /// The file of the trajectory. A name that would lead elsewhere is refused.
    fn file_in(&self, folder: &Path) -> Result<PathBuf, String> {
        let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
        if self.id.is_empty() || self.id.starts_with('.') || !self.id.chars().all(plain) {
            return Err(format!("id {:?} cannot be the name of a file: use letters, digits, - and _", self.id));
        }
        Ok(folder.join(format!("{}.csv", self.id)))
    }
}

/// Takes a text, or a number as one, out of the tables of a line. Of a key that is there twice the last one counts.
fn taken(tables: &mut Map<String, Value>, key: &str) -> Result<Option<String>, String> {
    match tables.remove(key) {
        None => Ok(None),
        Some(Value::String(text)) => Ok(Some(text)),
        Some(Value::Number(number)) => Ok(Some(number.to_string())),
        Some(other) => Err(format!("{key} is {other}: give a text")),
    }
}

/// Why a job has no motion.
struct Failure(String);

impl From<Cr7Error> for Failure {
    fn from(error: Cr7Error) -> Self {
        Self(error.to_string())
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self(error.to_string())
    }
}

/// Refuses a motion that exceeds a limit, before anything is written.
fn held(report: Report) -> Result<Report, Failure> {
    match report.limits.iter().find(|line| !line.holds()) {
        Some(line) => Err(Failure(format!("{} reaches {:.4} % of its limit", line.name, 100.0 * line.ratio))),
        None => Ok(report),
    }
}

/// What is done with each job.
struct Work<'a> {
    job: &'a Job,
    to: Option<&'a Path>,
    /// Names of the joints.
    names: &'a [String],
}

impl OnToolPath for Work<'_> {
    type Output = Report;
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, warnings: Vec<String>) -> Result<Report, Failure> {
        let long = |source| Cr7Error::TooManySamples { file: task.name().to_owned(), source };
        few_enough(task.least_duration(), task.period(), LEVERS).map_err(long)?;
        let mut motion = task.plan()?;
        motion.warn(warnings);
        few_enough(motion.trajectory().duration(), motion.trajectory().period(), LEVERS).map_err(long)?;
        let begin = Instant::now();
        let setpoints = motion.setpoints().map_err(|error| task.error(error.into()))?;
        let report = held(motion.report(setpoints.samples(), begin.elapsed()))?;
        let Some(file) = self.to else { return Ok(report) };
        write_whole(file, |part| {
            let mut writer = TrajectoryWriter::new(part, self.names).map_err(unwritten(file))?;
            for setpoint in setpoints {
                let setpoint = setpoint.map_err(|error| task.error(error))?;
                writer.write(&TrajectoryRow::from(&setpoint)).map_err(unwritten(file))?;
            }
            writer.finish().map_err(unwritten(file))?;
            Ok(report)
        })
    }
}

impl OnProgram for Work<'_> {
    type Output = Report;
    type Error = Failure;

    fn run<A: PathArm<N> + Clone, const N: usize>(
        self,
        task: ProgramTask<A, N>,
        warnings: Vec<String>,
    ) -> Result<Report, Failure> {
        let long = |source| Cr7Error::TooManySamples { file: task.name().to_owned(), source };
        few_enough(task.least_duration(), task.period(), LEVERS).map_err(long)?;
        let mut motion = task.plan()?;
        motion.warn(warnings);
        few_enough(motion.duration(), motion.period(), LEVERS).map_err(long)?;
        let begin = Instant::now();
        let fail = |error: PlanError| plan_error(task.name(), error);
        let checked = |each: &mut dyn FnMut(&TrajectoryRow<N>) -> Result<(), InputError>| {
            let (mut check, mut count) = (motion.check(), 0);
            for sample in motion.samples().map_err(|error| fail(error.into()))? {
                let sample = sample.map_err(fail)?;
                check.see(&sample.row);
                each(&sample.row)?;
                count += 1;
            }
            let check = check.finish(self.job.feed.end_speeds[1] == 0.0);
            held(motion.report(&check, count, begin.elapsed()))
        };
        let Some(file) = self.to else { return checked(&mut |_| Ok(())) };
        write_whole(file, |part| {
            let mut writer = TrajectoryWriter::new(part, self.names).map_err(unwritten(file))?;
            let report = checked(&mut |row| writer.write(row).map_err(unwritten(file)))?;
            writer.finish().map_err(unwritten(file))?;
            Ok(report)
        })
    }
}
