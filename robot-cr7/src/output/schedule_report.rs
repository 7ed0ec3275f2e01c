//! The report and the figures of a motion between poses or through way-points.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use arcfeed_interp::Trajectory;
use arcfeed_kinematics::Joints;
use serde::Serialize;

use super::binding_line::BindingLine;
use super::limit_table::{ending, limit_table};
use super::schedule_figure::{ShareFigure, SharePanel, SpeedFigure, speed_figure};
use super::series::Series;
use crate::input::error::InputError;
use crate::run::error::Cr7Error;
use crate::run::limit_line::LimitLine;
use crate::run::limit_lines::limit_lines;
use crate::run::speed_task::SpeedTask;
use crate::run::trajectory_row::TrajectoryRow;
use crate::text::{WIDTH, clip, duration, number, percent};

/// The result of a schedule. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScheduleReport {
    /// The file.
    pub name: String,
    /// The robot, which the JSON form has in its head.
    #[serde(skip)]
    pub robot: String,
    /// Kind of motion: "pure translation", "pure orientation", "composite motion", "joint way-points".
    pub motion: String,
    /// The quantity that the parameter measures.
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
    /// The intervals in which each limit binds (99.9 % of it and more is used).
    pub binding: Vec<BindingLine>,
    /// Warnings.
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

impl ScheduleRun {
    /// Plans and samples the motion. `write` is given the rows of the trajectory in their order.
    ///
    /// # Errors
    /// As [`SpeedTask::plan`]; what `write` returns.
    pub fn of<const N: usize>(
        task: &SpeedTask<'_, N>,
        write: impl FnMut(&TrajectoryRow<N>) -> Result<(), InputError>,
    ) -> Result<Self, Cr7Error> {
        let trajectory = task.plan()?;
        let (samples, panels) = sampled(task, &trajectory, write)?;
        let report = ScheduleReport::new(task, &trajectory, samples);
        let worst = trajectory.verification().worst();
        let facts = format!(
            "{}, {}: {} s; {} uses {} on {}",
            task.motion,
            report.planner,
            number(trajectory.duration()),
            worst.id,
            percent(worst.ratio),
            task.robot
        );
        let speed = speed_figure(&trajectory, &report.name, &facts).map_err(|e| task.error(e))?;
        let title = format!("{}: joints in units of their limits", report.name);
        let shares = ShareFigure { file: "joints.svg".to_owned(), title, facts, panels };
        Ok(Self { report, speed, shares })
    }
}

/// Writes every setpoint; their number, and the joint curves in units of their limits.
fn sampled<const N: usize>(
    task: &SpeedTask<'_, N>,
    trajectory: &Trajectory<'_, N>,
    mut write: impl FnMut(&TrajectoryRow<N>) -> Result<(), InputError>,
) -> Result<(usize, Vec<SharePanel>), Cr7Error> {
    let setpoints = trajectory.setpoints(trajectory.period()).map_err(|e| task.error(e))?;
    let samples = setpoints.samples();
    let limited = task.limited();
    let mut series = Series::new(1 + limited.len() * N, samples);
    for setpoint in setpoints {
        let at = setpoint.map_err(|e| task.error(e))?;
        write(&TrajectoryRow::from(&at))?;
        let torque = trajectory.torque(&at).unwrap_or(Joints::zeros());
        let shares = limited.iter().flat_map(|(label, limit)| {
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
    let panel = |(i, (label, _)): (usize, &(&str, Joints<N>))| SharePanel {
        label: (*label).to_owned(),
        joints: (0..N).map(|j| series.pairs(0, 1 + i * N + j)).collect(),
    };
    Ok((samples, limited.iter().enumerate().map(panel).collect()))
}

impl ScheduleReport {
    fn new<const N: usize>(task: &SpeedTask<'_, N>, trajectory: &Trajectory<'_, N>, samples: usize) -> Self {
        let (info, verification) = (trajectory.info(), trajectory.verification());
        let (parameter, times) = (trajectory.path().parameter(), trajectory.timings());
        Self {
            name: task.file.file.display().to_string(),
            robot: task.robot.clone(),
            motion: task.motion.clone(),
            parameter: parameter.to_string(),
            parameter_unit: parameter.unit(),
            parameter_end: trajectory.path().length(),
            rotation_rad: task.rotation,
            planner: info.method.unwrap_or(task.method).name(),
            intervals: info.intervals,
            duration_s: trajectory.duration(),
            samples,
            period_s: trajectory.period(),
            following_time_s: (times.grid + times.joint_path).as_secs_f64(),
            planning_time_s: times.speed.as_secs_f64(),
            limits: limit_lines(verification, parameter),
            checked_samples: verification.samples(),
            binding: BindingLine::of(verification.bindings(), 0.0),
            warnings: task.warnings.iter().cloned().chain(notes(trajectory)).collect(),
            files: Vec::new(),
        }
    }
}

/// Remarks on the plan: what made the limits hold, and which planner made it.
fn notes<const N: usize>(trajectory: &Trajectory<'_, N>) -> Vec<String> {
    let info = trajectory.info();
    let mut notes = Vec::new();
    if let Some(why) = &info.fallback {
        notes.push(format!("continuous-acceleration made the motion instead of jerk-limited: {why}"));
    }
    if let Some(windows) = &info.windows {
        notes.push(format!("planned in {windows}"));
    }
    if info.rounds > 1 {
        let rounds = info.rounds;
        let mut words = format!("planned {rounds} times, so that the limits hold between the grid points");
        if info.refined > 1 {
            words += &format!("; intervals raised to {}", info.intervals);
        }
        if info.slower < 1.0 {
            words += &format!("; slowed down as a whole by {} %", number(100.0 * (1.0 - info.slower)));
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
        ending(f, &self.warnings, &self.files, [usize::MAX; 2])
    }
}
