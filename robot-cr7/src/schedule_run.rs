//! From a [`ScheduleFile`] and a robot to a planned, sampled and checked motion with its report and figures.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use arcfeed_interp::{
    JointSpline, LimitError, Limits, Method, MotionPath, PathParameter, PlanError, Planner, ToolLimits, Trajectory,
};
use arcfeed_kinematics::{Arm, ArmDynamics, JointLimits, Joints};
use serde::Serialize;

use crate::cr7::{plan_error, trajectory_row};
use crate::cr7_error::Cr7Error;
use crate::error::InputError;
use crate::limit_line::LimitLine;
use crate::limit_lines::limit_lines;
use crate::report::{clip, duration, limit_table, number, percent};
use crate::robot::Robot;
use crate::samples::few_enough;
use crate::schedule_figure::{ShareFigure, SharePanel, SpeedFigure, speed_figure};
use crate::schedule_file::{ScheduleFile, ScheduleWay};
use crate::schedule_way::PoseWay;
use crate::series::Series;
use crate::trajectory_csv::TrajectoryRow;

const WIDTH: usize = 100;

/// Where one limit binds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BindingLine {
    /// Which limit, in words: "torque of joint 3".
    pub limit: String,
    /// From where to where, by the parameter of the motion (m or rad).
    pub intervals: Vec<[f64; 2]>,
}

/// The result of a schedule. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScheduleReport {
    /// The file.
    pub name: String,
    /// The robot.
    pub robot: String,
    /// Kind of motion: "pure translation", "pure orientation", "composite motion", "joint way-points".
    pub motion: String,
    /// What the parameter measures.
    pub parameter: String,
    /// Unit of the parameter.
    pub parameter_unit: &'static str,
    /// Its value at the end.
    pub parameter_end: f64,
    /// Rotation of the tool between poses, rad (the full angle).
    pub rotation_rad: Option<f64>,
    /// Which planner.
    pub planner: &'static str,
    /// Intervals of its grid.
    pub intervals: usize,
    /// Duration, s.
    pub duration_s: f64,
    /// Setpoints.
    pub samples: usize,
    /// Control period, s.
    pub period_s: f64,
    /// Time spent on inverse kinematics and dynamics along the path, s.
    pub following_time_s: f64,
    /// Time spent on rows and speed, s.
    pub planning_time_s: f64,
    /// Every limit with its worst place on dense samples.
    pub limits: Vec<LimitLine>,
    /// Number of dense samples.
    pub checked_samples: usize,
    /// Where each limit binds (uses 99.9 % and more).
    pub binding: Vec<BindingLine>,
    /// What a person should look at.
    pub warnings: Vec<String>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

/// A schedule with all that is written and drawn of it.
#[derive(Debug, Clone)]
pub struct ScheduleRun {
    /// The report; its limits hold or the motion is not to be run: see [`LimitsHold`](crate::LimitsHold).
    pub report: ScheduleReport,
    /// Speed over the limit curve, with what binds.
    pub speed: SpeedFigure,
    /// Joint curves in units of their limits.
    pub shares: ShareFigure,
}

/// A motion through the joint way-points of `file`. `write` is given the rows of the trajectory in their order.
///
/// # Errors
/// [`Cr7Error::Input`] for what the file says wrongly, [`Cr7Error::Plan`] for what cannot be planned, with the place.
pub fn run_way_points<const N: usize>(
    file: &ScheduleFile,
    robot: &Robot,
    method: Method,
    write: impl FnMut(&TrajectoryRow<N>) -> Result<(), InputError>,
) -> Result<ScheduleRun, Cr7Error> {
    let arm = robot.arm::<N>(file.tool)?;
    let task = SpeedTask::new(file, robot, &arm, method)?;
    let ScheduleWay::Waypoints(points) = &file.way else { return Err(wrong_kind(file)) };
    let points = points
        .iter()
        .enumerate()
        .map(|(i, point)| Ok(Joints::from(file.of::<N>(&format!("waypoint[{i}].q_deg"), point)?)));
    let spline = JointSpline::through(&points.collect::<Result<Vec<_>, Cr7Error>>()?);
    let spline = spline.map_err(|e| task.failed(e))?;
    spline.within(arm.range()).map_err(|e| task.failed(e))?;
    task.run(&arm, &spline, ("joint way-points", None), write)
}

/// A motion between the poses of `file`, for an arm of six joints. `write` is given the rows of the trajectory in their order.
///
/// # Errors
/// As [`run_way_points`]; [`Cr7Error::Configuration`] for joints that the motion does not lead to.
pub fn run_pose_move(
    file: &ScheduleFile,
    robot: &Robot,
    method: Method,
    write: impl FnMut(&TrajectoryRow) -> Result<(), InputError>,
) -> Result<ScheduleRun, Cr7Error> {
    let arm = robot.arm::<6>(file.tool)?;
    let task = SpeedTask::new(file, robot, &arm, method)?;
    let ScheduleWay::Poses { start, goal, near } = &file.way else { return Err(wrong_kind(file)) };
    let way = PoseWay::new(file, &arm, [start, goal], near.as_ref())?;
    let motion = *way.path.motion();
    task.run(&arm, &way.path, (&motion.kind().to_string(), Some(motion.angle())), write)
}

/// The way of the file is not of the kind that was called for.
fn wrong_kind(file: &ScheduleFile) -> Cr7Error {
    let error = InputError::Value {
        file: file.file.clone(),
        line: None,
        key: "waypoint".to_owned(),
        value: "a motion of the other kind".to_owned(),
        rule: "a motion runs between poses or through way-points",
        remedy: "give [start] and [goal], or [[waypoint]]",
    };
    Cr7Error::Input(error)
}

/// What is planned, but for the path.
struct SpeedTask<'a, const N: usize> {
    file: &'a ScheduleFile,
    robot: String,
    method: Method,
    joints: JointLimits<N>,
    tool: ToolLimits,
    drives: Option<(ArmDynamics<N>, Joints<N>)>,
    warnings: Vec<String>,
}

impl<'a, const N: usize> SpeedTask<'a, N> {
    fn new(file: &'a ScheduleFile, robot: &Robot, arm: &Arm<N>, method: Method) -> Result<Self, Cr7Error> {
        let (joints, assumed) = robot.limits::<N>(&file.joints)?;
        let mut warnings = file.warnings.clone();
        warnings.extend(assumed.into_iter().filter(|text| method.limits_jerk() || !text.contains(" jerk")));
        let dynamics = match (arm.dynamics(), file.payload) {
            (Some(dynamics), Some(payload)) => Some(dynamics.with_payload(payload)?),
            (dynamics, _) => dynamics.copied(),
        };
        let torque = match &file.torque {
            Some(values) => Some(Joints::from(file.of::<N>("limits.torque_nm", values)?)),
            None => arm.drive_limits().torque.filter(|_| dynamics.is_some()),
        };
        let drives = match (torque, dynamics) {
            (Some(torque), Some(dynamics)) => Some((dynamics, torque)),
            (Some(_), None) => {
                return Err(Cr7Error::NoDynamics {
                    robot: robot.description().name.clone(),
                    missing: "the masses of its links are",
                    remedy: "give masses and inertias of the links, or drop limits.torque_nm",
                });
            }
            (None, _) => None,
        };
        if file.payload.is_some() && drives.is_none() {
            warnings.push("the payload has no effect: no torques are limited".to_owned());
        }
        if !method.limits_jerk() && file.joints.jerk.is_some() {
            warnings.push(format!("--planner {method} does not limit jerk; jerk-limited does"));
        }
        let robot = robot.description().name.clone();
        let mut task = Self { file, robot, method, joints, tool: ToolLimits::new(), drives, warnings };
        if let Some(speed) = file.linear_speed {
            task.tool = task.tool.with_feed(speed).map_err(|e| task.failed(e))?;
        }
        if let Some(speed) = file.angular_speed {
            task.tool = task.tool.with_angular_speed(speed).map_err(|e| task.failed(e))?;
        }
        Ok(task)
    }

    fn failed(&self, source: impl Into<PlanError>) -> Cr7Error {
        let source = source.into();
        // A motion that is too long to be planned has too many samples to be written.
        if let PlanError::Limit(LimitError::TooLong { duration, .. }) = source
            && let Err(error) = self.few_enough(duration)
        {
            return error;
        }
        plan_error(&self.file.file.display().to_string(), source)
    }

    fn few_enough(&self, duration: f64) -> Result<(), Cr7Error> {
        few_enough(duration, self.file.period, "the [limits] of the file")
            .map_err(|source| Cr7Error::TooManySamples { file: self.file.file.display().to_string(), source })
    }

    fn plan<'p>(&'p self, arm: &'p Arm<N>, path: &'p dyn MotionPath<N>) -> Result<Trajectory<'p, N>, PlanError> {
        let to_si = if path.parameter() == PathParameter::ArcLength { 1e-3 } else { 1f64.to_radians() };
        let [v_start, v_end] = self.file.speeds.map(|v| v * to_si);
        let mut limits = Limits::new(self.joints).with_tool(self.tool);
        if let Some((dynamics, torque)) = &self.drives {
            limits = limits.with_torque(dynamics, *torque)?;
        }
        Planner::new(arm, limits)
            .with_method(self.method)
            .with_period(self.file.period)?
            .with_intervals(self.file.intervals)?
            .with_end_speeds(v_start, v_end)?
            .plan(path)
    }

    fn run(
        &self,
        arm: &Arm<N>,
        path: &dyn MotionPath<N>,
        (motion, rotation): (&str, Option<f64>),
        mut write: impl FnMut(&TrajectoryRow<N>) -> Result<(), InputError>,
    ) -> Result<ScheduleRun, Cr7Error> {
        let trajectory = self.plan(arm, path).map_err(|e| self.failed(e))?;
        self.few_enough(trajectory.duration())?;
        let setpoints = trajectory.setpoints(self.file.period).map_err(|e| self.failed(e))?;
        let samples = setpoints.samples();
        let panels = self.panels();
        let mut series = Series::new(1 + panels.len() * N, samples);
        for setpoint in setpoints {
            let at = setpoint.map_err(|e| self.failed(e))?;
            write(&trajectory_row(&at))?;
            let torque = trajectory.torque(&at).unwrap_or(Joints::zeros());
            let shares = panels.iter().flat_map(|(label, limit)| {
                let value = match *label {
                    "velocity" => &at.qd,
                    "acceleration" => &at.qdd,
                    "torque" => &torque,
                    _ => &at.jerk,
                };
                (0..N).map(move |j| value[j] / limit[j])
            });
            series.push(std::iter::once(at.t).chain(shares));
        }
        series.cut();

        let (info, verification) = (trajectory.info(), trajectory.verification());
        let planner = info.method.unwrap_or(self.method).name();
        let worst = verification.worst();
        let facts = format!(
            "{motion}, {planner}: {} s; {} uses {} on {}",
            number(trajectory.duration()),
            worst.id,
            percent(worst.ratio),
            self.robot
        );
        let name = self.file.file.display().to_string();
        let line = |column: usize| {
            series.column(0).iter().copied().zip(series.column(column).iter().copied()).collect::<Vec<_>>()
        };
        let panel = |(i, (label, _)): (usize, &(&str, Joints<N>))| SharePanel {
            label: (*label).to_owned(),
            joints: (0..N).map(|j| line(1 + i * N + j)).collect(),
        };
        let shares = ShareFigure {
            file: "joints.svg".to_owned(),
            title: format!("{name}: joints in units of their limits"),
            facts: facts.clone(),
            panels: panels.iter().enumerate().map(panel).collect(),
        };
        let (parameter, times) = (path.parameter(), trajectory.timings());
        let report = ScheduleReport {
            robot: self.robot.clone(),
            motion: motion.to_owned(),
            parameter: parameter.to_string(),
            parameter_unit: parameter.unit(),
            parameter_end: path.length(),
            rotation_rad: rotation,
            planner,
            intervals: info.intervals,
            duration_s: trajectory.duration(),
            samples,
            period_s: self.file.period,
            following_time_s: (times.grid + times.joint_path).as_secs_f64(),
            planning_time_s: times.speed.as_secs_f64(),
            limits: limit_lines(verification, parameter),
            checked_samples: verification.samples(),
            binding: verification
                .bindings()
                .iter()
                .map(|b| BindingLine {
                    limit: b.id.to_string(),
                    intervals: b.intervals.iter().map(|&(from, to)| [from, to]).collect(),
                })
                .collect(),
            warnings: self.warnings.iter().cloned().chain(self.notes(&trajectory)).collect(),
            files: Vec::new(),
            name,
        };
        let speed = speed_figure(&trajectory, &report.name, &facts).map_err(|e| self.failed(e))?;
        Ok(ScheduleRun { report, speed, shares })
    }

    /// Quantities that are limited, with the limits.
    fn panels(&self) -> Vec<(&'static str, Joints<N>)> {
        let mut panels = vec![("velocity", *self.joints.velocity()), ("acceleration", *self.joints.acceleration())];
        panels.extend(self.drives.as_ref().map(|(_, torque)| ("torque", *torque)));
        panels.extend(self.method.limits_jerk().then(|| ("jerk", *self.joints.jerk())));
        panels
    }

    /// What was done to make the limits hold, and who planned.
    fn notes(&self, trajectory: &Trajectory<'_, N>) -> Vec<String> {
        let info = trajectory.info();
        let mut notes = Vec::new();
        if let Some(why) = &info.fallback {
            notes.push(format!("continuous-acceleration made the motion instead of jerk-limited: {why}"));
        }
        if info.rounds > 1 {
            let rounds = info.rounds;
            let mut words = format!("planned {rounds} times, so that the limits hold between the grid points");
            if info.refined > 1 {
                words += &format!("; intervals raised to {}", info.intervals);
            }
            if info.slowed < 1.0 {
                words += &format!("; all limits lowered by {} %", number(100.0 * (1.0 - info.slowed)));
            }
            for (id, fraction) in &info.lowered {
                words += &format!("; {id} lowered by {} %", number(100.0 * (1.0 - fraction)));
            }
            notes.push(words);
        }
        notes
    }
}

impl ScheduleReport {
    /// The whole report as one JSON object on one line.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_else(|e| serde_json::json!({ "error": e.to_string() }).to_string())
    }

    /// The largest part of a limit that is used.
    pub fn worst_ratio(&self) -> f64 {
        self.limits.iter().map(|l| l.ratio).fold(0.0, |a: f64, r| if r > a || r.is_nan() { r } else { a })
    }
}

impl Display for ScheduleReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (factor, unit) = if self.parameter_unit == "m" { (1e3, "mm") } else { (1f64.to_degrees(), "deg") };
        writeln!(f, "{} on {}", clip(&self.name, 70), self.robot)?;
        let mut way = format!("{} of {} {unit} ({})", self.motion, number(self.parameter_end * factor), self.parameter);
        if let Some(angle) = self.rotation_rad.filter(|a| *a > 0.0 && self.parameter_unit == "m") {
            way += &format!(", turning by {} deg", number(angle.to_degrees()));
        }
        writeln!(f, "  {:<11}{way}", "motion")?;
        writeln!(
            f,
            "  {:<11}{} s, {} samples at {} ms",
            "duration",
            number(self.duration_s),
            self.samples,
            number(self.period_s * 1e3)
        )?;
        writeln!(
            f,
            "  {:<11}{}, {} intervals: {} path and dynamics, {} speed",
            "planner",
            self.planner,
            self.intervals,
            duration(self.following_time_s),
            duration(self.planning_time_s)
        )?;
        limit_table(f, &self.limits)?;
        writeln!(f, "\n  {:<26}{}", "binds at 99.9 %", format_args!("{} s [{unit}]", self.parameter))?;
        for line in &self.binding {
            let places =
                line.intervals.iter().map(|[from, to]| format!("{} .. {}", number(from * factor), number(to * factor)));
            let places = places.collect::<Vec<_>>().join(", ");
            writeln!(f, "  {:<26}{}", line.limit, clip(&places, WIDTH - 28))?;
        }
        if !(self.warnings.is_empty() && self.files.is_empty()) {
            writeln!(f)?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning: {}", clip(warning, WIDTH + 60))?;
        }
        for file in &self.files {
            writeln!(f, "  wrote {}", clip(&file.display().to_string(), WIDTH - 8))?;
        }
        Ok(())
    }
}
