//! From a [`ScheduleFile`] and a robot to a planned, sampled and checked motion with its report and figures.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use arcfeed_interp::{
    ArmMotion, JointSpline, PlanError, ScheduleCheck, ScheduleLimits, ScheduleParameter, SchedulePath, SpeedPlanner,
};
use arcfeed_kinematics::{Arm, ArmDynamics, Joints};
use serde::Serialize;

use crate::cr7::Cr7Error;
use crate::error::InputError;
use crate::report::{LimitLine, clip, duration, limit_table, number};
use crate::robot::Robot;
use crate::samples::few_enough;
use crate::schedule_figure::{ShareFigure, SpeedFigure, speed_figure};
use crate::schedule_file::{ScheduleFile, ScheduleWay};
use crate::schedule_plan::{CheckedSchedule, SpeedTask};
use crate::schedule_rows::ScheduleRows;
use crate::schedule_way::PoseWay;
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

/// A motion between poses for an arm of six joints, or through way-points for any. `write` is given the rows of the
/// trajectory in their order.
///
/// # Errors
/// [`Cr7Error::Input`] for what the file says wrongly, [`Cr7Error::Plan`] for what cannot be planned, with the place,
/// [`Cr7Error::Configuration`] for joints that the motion does not lead to.
pub fn run_schedule<const N: usize>(
    file: &ScheduleFile,
    robot: &Robot,
    planner: SpeedPlanner,
    write: impl FnMut(&TrajectoryRow<N>) -> Result<(), InputError>,
) -> Result<ScheduleRun, Cr7Error> {
    let arm = robot.arm::<N>(file.tool)?;
    let setting = Setting::new(file, robot, &arm, planner)?;
    match &file.way {
        ScheduleWay::Waypoints(points) => {
            let points = points
                .iter()
                .enumerate()
                .map(|(i, point)| Ok(Joints::from(file.of::<N>(&format!("waypoint[{i}].q_deg"), point)?)));
            let spline = JointSpline::through(&points.collect::<Result<Vec<_>, Cr7Error>>()?);
            let spline = spline.map_err(|e| setting.failed(e))?;
            spline.within(arm.range()).map_err(|e| setting.failed(e))?;
            let ends = [spline.points().first().copied(), spline.points().last().copied()];
            setting.run(&arm, (&spline, ends), ("joint way-points", None), write)
        }
        ScheduleWay::Poses { start, goal, near } => {
            // A pose has six freedoms: the arm is one of six joints by another name.
            let six = robot.arm::<6>(file.tool).map_err(|_| {
                setting.failed(PlanError::Missing {
                    needed: "an arm of six joints",
                    purpose: "a motion between poses",
                    remedy: "take another --robot, or give joint way-points",
                })
            })?;
            let way = PoseWay::new(file, &six, [start, goal], near.as_ref())?;
            let ends = way.ends.map(|q| q.map(|q| renamed(&q)));
            let motion = *way.path.motion();
            let words = motion.kind().to_string();
            setting.run(&arm, (&Renamed(way.path), ends), (&words, Some(motion.angle())), write)
        }
    }
}

/// A path of six joints for an arm of `N`, which are six.
struct Renamed<'a>(ArmMotion<'a, Arm<6>, 6>);

impl<const N: usize> SchedulePath<N> for Renamed<'_> {
    fn parameter(&self) -> ScheduleParameter {
        self.0.parameter()
    }

    fn end(&self) -> f64 {
        self.0.end()
    }

    fn start(&self) -> Joints<N> {
        renamed(&self.0.start())
    }

    fn jet(&self, s: f64, near: &Joints<N>) -> Result<arcfeed_interp::JointJet<N>, PlanError> {
        let jet = self.0.jet(s, &renamed(near))?;
        let (q, d1, d2, d3) = (renamed(&jet.q), renamed(&jet.d1), renamed(&jet.d2), renamed(&jet.d3));
        Ok(arcfeed_interp::JointJet { s, q, d1, d2, d3 })
    }
}

fn renamed<const N: usize, const M: usize>(q: &Joints<N>) -> Joints<M> {
    Joints::from_fn(|i, _| q.get(i).copied().unwrap_or(0.0))
}

/// Everything but the path.
struct Setting<'a, const N: usize> {
    file: &'a ScheduleFile,
    robot: String,
    planner: SpeedPlanner,
    limits: ScheduleLimits<N>,
    dynamics: Option<ArmDynamics<N>>,
    warnings: Vec<String>,
}

impl<'a, const N: usize> Setting<'a, N> {
    fn new(file: &'a ScheduleFile, robot: &Robot, arm: &Arm<N>, planner: SpeedPlanner) -> Result<Self, Cr7Error> {
        let (joints, assumed) = robot.limits::<N>(&file.joints)?;
        let with_jerk = planner == SpeedPlanner::JerkLimited;
        let mut warnings = file.warnings.clone();
        warnings.extend(assumed.into_iter().filter(|text| with_jerk || !text.contains(" jerk")));
        let dynamics = match (arm.dynamics(), file.payload) {
            (Some(dynamics), Some(payload)) => Some(dynamics.with_payload(payload)?),
            (dynamics, _) => dynamics.copied(),
        };
        let torque = match &file.torque {
            Some(values) => Some(Joints::from(file.of::<N>("limits.torque_nm", values)?)),
            None => arm.drive_limits().torque.filter(|_| dynamics.is_some()),
        };
        if file.payload.is_some() && torque.is_none() {
            warnings.push("the payload has no effect: no torques are limited".to_owned());
        }
        if planner == SpeedPlanner::Published {
            warnings.push("the published scan breaks the limits it is given: for comparison only".to_owned());
        }
        if !with_jerk && file.joints.jerk.is_some() {
            warnings.push(format!("--planner {} does not limit jerk; jerk-limited does", planner.name()));
        }
        let limits = ScheduleLimits {
            velocity: Some(*joints.velocity()),
            acceleration: Some(*joints.acceleration()),
            jerk: with_jerk.then(|| *joints.jerk()),
            torque,
            linear_speed: file.linear_speed,
            angular_speed: file.angular_speed,
        };
        Ok(Self { file, robot: robot.description().name.clone(), planner, limits, dynamics, warnings })
    }

    fn failed(&self, source: PlanError) -> Cr7Error {
        Cr7Error::Plan { file: self.file.file.display().to_string(), source: Box::new(source), hint: String::new() }
    }

    /// `ends` are the joints asked for at start and end, where they are.
    fn run<P: SchedulePath<N>>(
        self,
        arm: &Arm<N>,
        (path, ends): (&P, [Option<Joints<N>>; 2]),
        (motion, rotation): (&str, Option<f64>),
        write: impl FnMut(&TrajectoryRow<N>) -> Result<(), InputError>,
    ) -> Result<ScheduleRun, Cr7Error> {
        let failed = |e| self.failed(e);
        let parameter = path.parameter();
        let to_si = if parameter == ScheduleParameter::ArcLength { 1e-3 } else { 1f64.to_radians() };
        let task = SpeedTask {
            arm,
            dynamics: self.dynamics.as_ref(),
            limits: self.limits,
            intervals: self.file.intervals,
            speeds: self.file.speeds.map(|v| v * to_si),
            planner: self.planner,
            period: self.file.period,
        };
        let CheckedSchedule { schedule, check, limits, notes } = task.plan(path).map_err(failed)?;
        few_enough(schedule.duration(), self.file.period, "the [limits] of the file")
            .map_err(|source| Cr7Error::TooManySamples { file: self.file.file.display().to_string(), source })?;
        let planner = if schedule.fallback().is_some() { "joined scan" } else { self.planner.name() };
        let facts =
            format!("{motion}, {planner}: {} s; {} on {}", number(schedule.duration()), used_most(&check), self.robot);
        let name = self.file.file.display().to_string();
        let mut rows = ScheduleRows::new(&schedule, &self.limits, arm.range(), self.file.period).map_err(failed)?;
        rows.write(write, failed)?;
        rows.see_ends(ends, self.file.speeds);
        let samples = rows.samples();
        let (checked, shares) = rows.finish(&name, &facts);
        let [following, planning] = schedule.timings().map(|t| t.as_secs_f64());
        let instead = schedule
            .fallback()
            .map(|why| format!("the joined scan made the motion instead of the jerk-limited planner: {why}"));
        let report = ScheduleReport {
            robot: self.robot.clone(),
            motion: motion.to_owned(),
            parameter: parameter.to_string(),
            parameter_unit: parameter.unit(),
            parameter_end: path.end(),
            rotation_rad: rotation,
            planner,
            intervals: schedule.problem().intervals(),
            duration_s: schedule.duration(),
            samples,
            period_s: self.file.period,
            following_time_s: following,
            planning_time_s: planning,
            limits: joined(limits, checked),
            checked_samples: check.samples,
            binding: check
                .bindings
                .iter()
                .map(|b| BindingLine {
                    limit: b.source.to_string(),
                    intervals: b.intervals.iter().map(|&(from, to)| [from, to]).collect(),
                })
                .collect(),
            warnings: self.warnings.iter().cloned().chain(instead).chain(notes).collect(),
            files: Vec::new(),
            name,
        };
        let speed = speed_figure(&schedule, &check, &report.name, &facts);
        Ok(ScheduleRun { report, speed, shares })
    }
}

/// The limits of both checks: of each limit that is in both the worse line.
fn joined(mut lines: Vec<LimitLine>, others: Vec<LimitLine>) -> Vec<LimitLine> {
    for other in others {
        match lines.iter_mut().find(|line| line.name == other.name && line.joint == other.joint) {
            Some(line) if other.ratio > line.ratio || other.ratio.is_nan() => *line = other,
            Some(_) => {}
            None => lines.push(other),
        }
    }
    lines
}

fn used_most(check: &ScheduleCheck) -> String {
    check.worst().map_or("nothing is limited".to_owned(), |worst| {
        format!("{} uses {}", worst.source, crate::report::percent(worst.ratio))
    })
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
