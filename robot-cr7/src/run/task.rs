//! From a job and a path file to a verified motion of the CR7, in one call.

use std::sync::Arc;
use std::time::{Duration, Instant};

use arcfeed_feedrate::{FeedError, FeedPlanner, StreamedScan};
use arcfeed_geometry::PosePath;
use arcfeed_interp::{
    CompileError, CompiledPlan, JointTrajectory, LimitError, Method, MotionCertificate, MotionPath, PathArm, PathError,
    PlanError, ToolLimits, ToolPath, Trajectory,
};
use arcfeed_kinematics::{AnalyticInverse, JointLimits, Joints, ParallelAxisArm};

use super::cr7::Cr7;
use super::error::Cr7Error;
use super::motion::{Motion, corner_words};
use super::outline::Outline;
use super::placed_path::{PlacedPath, PointFit, tool_of};
use super::plan_error::{line_words, plan_error, reach_hint};
use super::robot::{Drives, Robot};
use super::side_effects::{ThermalLine, VibrationLine, calm_words, check_joints};
use super::stream::StreamReport;
use super::task_limits::{TaskLimits, tables_of};
use crate::input::job::{Job, VibrationJob};
use crate::input::path_file::PathFile;

/// A job made ready: the path in the base frame, the arm with its limits and where it starts. Nothing is planned yet.
///
/// ```
/// use robot_cr7::{Job, SamplePath, Task};
///
/// let task = Task::of_cr7(&Job::default(), &SamplePath::SixPoint.load()?)?;
/// let motion = task.plan()?;
/// for setpoint in motion.setpoints()? {
///     let joints = setpoint?.q; // rad, for the controller
/// #   assert!(joints.iter().all(|q| q.is_finite()));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Task<A = ParallelAxisArm, const N: usize = 6> {
    name: String,
    file: String,
    pub(super) arm: A,
    start: Joints<N>,
    path: PosePath,
    pub(super) limits: TaskLimits<N>,
    pub(super) drives: Option<Drives<N>>,
    vibrations: Vec<VibrationJob>,
    stops: Vec<f64>,
    outline: Option<Outline>,
    fit: Option<PointFit>,
    pub(super) end_speeds: [f64; 2],
    pub(super) chord_tolerance: f64,
    pub(super) period: f64,
    /// Whether the motion lasts a whole number of them.
    pub(super) whole_cycles: bool,
    pub(super) method: Method,
    preparation: Duration,
    warnings: Vec<String>,
}

impl Task {
    /// The task of the CR7.
    ///
    /// # Errors
    /// [`Cr7Error`], naming the file and the place.
    pub fn of_cr7(job: &Job, file: &PathFile) -> Result<Self, Cr7Error> {
        let cr7 = Cr7::of(job)?;
        Self::of_six_joints(job, file, *cr7.arm(), cr7.limits(), Robot::load("cr7", None, None)?.drives::<6>(job)?)
    }
}

/// The joints that an arm of six joints starts near, where the job gives some.
pub(crate) fn start_near(job: &Job) -> Result<Option<Joints<6>>, Cr7Error> {
    let near = job.start_near.as_ref().map(|near| near.of::<6>().map(Joints::from)).transpose();
    near.map_err(|given| Cr7Error::JointCount { key: "start.near_deg", given, joints: 6 })
}

impl<A: PathArm<6> + AnalyticInverse<6>> Task<A> {
    /// The task of an arm of six joints, tool included, in the configuration that the job asks for or else in the best one.
    ///
    /// # Errors
    /// As [`Task::new`]; [`Cr7Error::JointCount`] for start.near_deg of another length.
    pub fn of_six_joints(
        job: &Job,
        file: &PathFile,
        arm: A,
        limits: &JointLimits<6>,
        drives: Option<Drives<6>>,
    ) -> Result<Self, Cr7Error> {
        let near = start_near(job)?;
        Self::new(job, file, limits, drives, |path| {
            let start = match (near, job.start_posture) {
                (Some(near), _) => ToolPath::starting_near(&arm, path.clone(), &near)?.start(),
                (None, Some(posture)) => ToolPath::in_posture(&arm, path.clone(), limits.range(), posture)?.start(),
                (None, None) => ToolPath::new(&arm, path.clone(), limits.range())?.start(),
            };
            Ok((arm, start))
        })
    }
}

impl<A: PathArm<N>, const N: usize> Task<A, N> {
    /// The task of any arm: `arm_for` gives the arm, tool included, and the joints to start from, once the path is known.
    ///
    /// # Errors
    /// [`Cr7Error`], naming the file and the place.
    pub fn new(
        job: &Job,
        file: &PathFile,
        limits: &JointLimits<N>,
        drives: Option<Drives<N>>,
        arm_for: impl FnOnce(&PosePath) -> Result<(A, Joints<N>), PathError>,
    ) -> Result<Self, Cr7Error> {
        let begin = Instant::now();
        let placed = PlacedPath::new(job, file)?;
        let mut task = Self::placed(job, file, placed, (limits, drives), arm_for)?;
        let of_path = std::mem::take(&mut task.warnings);
        task.warnings.extend(file.warnings.iter().chain(&job.warnings).cloned().chain(of_path));
        task.preparation = begin.elapsed();
        Ok(task)
    }

    /// The task on a path that is placed, with the warnings about that alone.
    pub(crate) fn placed(
        job: &Job,
        file: &PathFile,
        placed: PlacedPath,
        (limits, drives): (&JointLimits<N>, Option<Drives<N>>),
        arm_for: impl FnOnce(&PosePath) -> Result<(A, Joints<N>), PathError>,
    ) -> Result<Self, Cr7Error> {
        let begin = Instant::now();
        let shown = file.file.display().to_string();
        let tool = tool_of(job, placed.fastest).map_err(|source| plan_error(&shown, source.into()))?;
        let limit_error = |source: LimitError| plan_error(&shown, source.into());
        let tables = tables_of(&job.tables).map_err(limit_error)?;
        check_joints::<N>(&job.vibrations).map_err(limit_error)?;
        let warnings = placed.warnings(job);
        let PlacedPath { path, sections, stops, outline, fit, .. } = placed;
        let (arm, start) = arm_for(&path).map_err(|source| match plan_error(&shown, source.into()) {
            Cr7Error::Plan { file, source, hint } => {
                let line = outline.as_ref().map(|outline| line_words(outline, &source));
                let reach = reach_hint(&path, &source);
                Cr7Error::Plan { file, source, hint: hint + &reach + &line.unwrap_or_default() }
            }
            other => other,
        })?;
        Ok(Self {
            name: file.name.clone(),
            file: shown,
            arm,
            start,
            path,
            limits: TaskLimits {
                joints: *limits,
                tool,
                torque: drives.as_ref().map(|drives| drives.torque),
                tables,
                sections,
            },
            drives,
            vibrations: job.vibrations.clone(),
            stops,
            outline,
            fit,
            end_speeds: job.feed.end_speeds,
            chord_tolerance: job.chord_tolerance,
            period: job.period,
            whole_cycles: job.whole_cycles,
            method: job.method,
            preparation: begin.elapsed(),
            warnings,
        })
    }

    /// Name of the path.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The arm, tool included.
    pub fn arm(&self) -> &A {
        &self.arm
    }

    /// The joints to start from.
    pub fn start(&self) -> &Joints<N> {
        &self.start
    }

    /// The path in the base frame.
    pub fn path(&self) -> &PosePath {
        &self.path
    }

    /// Warnings about the path and the job.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The lines of the file along the path, where it has such.
    pub fn outline(&self) -> Option<&Outline> {
        self.outline.as_ref()
    }

    /// Limits of the joints.
    pub fn joint_limits(&self) -> &JointLimits<N> {
        &self.limits.joints
    }

    /// Limits of the tool.
    pub fn tool_limits(&self) -> &ToolLimits {
        &self.limits.tool
    }

    /// The structures that its motion excites.
    pub(crate) fn vibrations(&self) -> &[VibrationJob] {
        &self.vibrations
    }

    /// The file, or the name of an embedded path.
    pub(crate) fn file(&self) -> &str {
        &self.file
    }

    /// The load and the limits of the drives, where torque is limited.
    pub fn drives(&self) -> Option<&Drives<N>> {
        self.drives.as_ref()
    }

    /// A time that the motion certainly takes, s: along the whole path at its highest feed.
    pub fn least_duration(&self) -> f64 {
        let feed = self.limits.tool.feed().unwrap_or(f64::INFINITY);
        self.path.length() / self.limits.sections.iter().fold(feed, |feed, section| feed.max(section.feed))
    }

    /// Control period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The planner of the speed.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The path of the tool as the arm follows it from its start.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`] when the arm cannot stand at the start.
    pub fn tool_path(&self) -> Result<ToolPath<'_, N>, Cr7Error> {
        self.tool_path_near(&self.start)
    }

    /// The same from the joints at its start that are nearest to `near` (rad).
    fn tool_path_near(&self, near: &Joints<N>) -> Result<ToolPath<'_, N>, Cr7Error> {
        let path = ToolPath::starting_near(&self.arm, self.path.clone(), near);
        Ok(path.map_err(|source| self.error(source.into()))?.with_stops(&self.stops))
    }

    /// The error of a planner, with the file and a likely cause.
    pub(crate) fn error(&self, source: PlanError) -> Cr7Error {
        let slow = match source {
            PlanError::Limit(LimitError::TooLong { longest, .. }) => self.slow_key(longest),
            _ => String::new(),
        };
        match plan_error(&self.file, source) {
            Cr7Error::Plan { file, source, hint } => {
                let line = self.outline.as_ref().map(|outline| line_words(outline, &source));
                let reach = reach_hint(&self.path, &source);
                Cr7Error::Plan { file, source, hint: hint + &reach + &line.unwrap_or_default() + &slow }
            }
            other => other,
        }
    }

    /// The key of the job that makes the motion longer than `longest` (s).
    fn slow_key(&self, longest: f64) -> String {
        let (length, tool) = (self.path.length(), &self.limits.tool);
        let or_none = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
        let feed = or_none(tool.feed());
        let (a, j) = (or_none(tool.tangential_acceleration()), or_none(tool.tangential_jerk()));
        // The times that feed, acceleration and jerk take alone, from rest to rest.
        let alone = [
            ("feed.feed_mm_s", feed * 1e3, length / feed),
            ("feed.tangential_acceleration_mm_s2", a * 1e3, 2.0 * (length / a).sqrt()),
            ("feed.tangential_jerk_mm_s3", j * 1e3, (32.0 * length / j).cbrt()),
        ];
        match alone.iter().max_by(|x, y| x.2.total_cmp(&y.2)) {
            Some((key, value, time)) if *time > 0.5 * longest => {
                format!("; {key} = {value} alone makes it {time:.3e} s")
            }
            _ => "; look at the keys of [joints] and at feed_mm_s of the sections".to_owned(),
        }
    }

    /// The planned and verified motion.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`].
    pub fn plan(&self) -> Result<Motion<'_, N>, Cr7Error> {
        self.plan_near(&self.start)
    }

    /// The same from the joints at the start of the path that are nearest to `near` (rad).
    ///
    /// # Errors
    /// As [`Task::plan`].
    pub fn plan_near(&self, near: &Joints<N>) -> Result<Motion<'_, N>, Cr7Error> {
        let path: Arc<dyn MotionPath<N> + '_> = Arc::new(self.tool_path_near(near)?);
        let (trajectory, jerk) = self.calm_trajectory(&path)?;
        let mut motion = self.motion(trajectory, None)?;
        motion.warnings.extend(calm_words(jerk));
        Ok(motion)
    }

    /// The same with its motion as polynomials of the time, which keep the limits that the certificate lists, and deviate from the plan by
    /// no more than `tolerance` (rad).
    ///
    /// # Errors
    /// As [`Task::plan`]; [`Cr7Error::Compile`] where no such polynomials are found.
    pub fn plan_compiled(
        &self,
        tolerance: f64,
    ) -> Result<(Motion<'_, N>, JointTrajectory<N>, MotionCertificate), Cr7Error> {
        self.plan_compiled_near(&self.start, tolerance)
    }

    /// The same from the joints at the start of the path that are nearest to `near` (rad).
    ///
    /// # Errors
    /// As [`Task::plan_compiled`].
    pub fn plan_compiled_near(
        &self,
        near: &Joints<N>,
        tolerance: f64,
    ) -> Result<(Motion<'_, N>, JointTrajectory<N>, MotionCertificate), Cr7Error> {
        let path: Arc<dyn MotionPath<N> + '_> = Arc::new(self.tool_path_near(near)?);
        let calm = self.vibrations.iter().any(|vibration| vibration.limit.is_some());
        let jerk = if calm { self.calm_trajectory(&path)?.1 } else { 1.0 };
        let planner = self.planner_beside(&self.limits_with_jerk(jerk)?, &self.limits.tables)?;
        let plan = planner.plan_compiled(path, tolerance).map_err(|source| match source {
            CompileError::Plan(source) => self.error(source),
            source => Cr7Error::Compile { file: self.name.clone(), source: Box::new(source) },
        })?;
        let CompiledPlan { trajectory, compiled, certificate } = plan;
        let mut motion = self.motion(trajectory, None)?;
        if motion.vibration().iter().any(|line| !line.holds()) {
            return Err(self.residual("the motion was made slower for its polynomials, which shakes more: raise the limit, or leave out --compile-rad"));
        }
        motion.warnings.extend(calm_words(jerk));
        Ok((motion, compiled, certificate))
    }

    fn motion<'t>(
        &'t self,
        trajectory: Trajectory<'t, N>,
        stream: Option<StreamReport>,
    ) -> Result<Motion<'t, N>, Cr7Error> {
        let mut warnings = self.warnings.clone();
        if stream.is_none() {
            warnings.extend(corner_words(trajectory.stops().len()));
        }
        let outline = self.outline.as_ref();
        let (preparation, fit) = (self.preparation, self.fit);
        let fail = |source| self.error(source);
        let vibration = VibrationLine::all(&self.vibrations, &trajectory).map_err(fail)?;
        let rated = self.drives.as_ref().and_then(|drives| drives.rated.as_ref());
        let thermal = ThermalLine::all(rated, &trajectory).map_err(fail)?;
        let name = &self.name;
        Ok(Motion { name, trajectory, preparation, stream, outline, fit, vibration, thermal, warnings })
    }
}

impl<A: PathArm<N>, const N: usize> Task<A, N> {
    /// The verified motion of a controller that holds `look_ahead` segments behind the present one and gets another every `gap`
    /// (s), or as soon as it can take one if that is 0. The planner of the job does not matter.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`], also for an end speed above 0, which a stream does not know in time.
    pub fn plan_streamed<'t>(
        &'t self,
        path: &'t ToolPath<'t, N>,
        look_ahead: usize,
        gap: f64,
    ) -> Result<Motion<'t, N>, Cr7Error> {
        if self.vibrations.iter().any(|vibration| vibration.limit.is_some()) {
            return Err(self.residual("a stream is not made calmer: leave out --stream, or the limit"));
        }
        let fail = |source| self.error(source);
        let speed = |error: FeedError| fail(PlanError::Speed(error.into()));
        let scan = Method::PerSegment { window: None };
        let planner = self.planner()?.with_method(scan);
        let problem = planner.prepare(path, scan.needs()).map_err(fail)?;
        let rows = problem.rows(scan.needs()).map_err(|e| fail(PlanError::Speed(e)))?;
        let stream = StreamedScan { look_ahead, gap, period: self.period };
        let run = stream.run(&rows).map_err(speed)?;
        let known = StreamedScan { look_ahead: problem.intervals().max(1), gap: 0.0, ..stream };
        let whole_duration_s = known.plan(&rows).map_err(speed)?.duration();
        let trajectory = planner.finish(problem, run.law, true).map_err(fail)?;
        let (held_back_m, waits_m_s) = (run.held_back, run.waits);
        let stream = StreamReport { look_ahead, gap_s: gap, whole_duration_s, held_back_m, waits_m_s };
        self.motion(trajectory, Some(stream))
    }
}
