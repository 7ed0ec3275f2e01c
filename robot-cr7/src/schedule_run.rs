//! From a [`ScheduleFile`] and a robot to a planned, sampled and checked motion with its report and figures.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use arcfeed_feedrate::{Quantity, RowSource};
use arcfeed_geometry::PoseMotion;
use arcfeed_interp::{
    ArmMotion, JointSpline, PlanError, Schedule, ScheduleCheck, ScheduleLimits, ScheduleParameter, SchedulePath,
    Scheduler, Setpoint, SpeedPlanner,
};
use arcfeed_kinematics::{Arm, ArmDynamics, ForwardKinematics, Joints};
use nalgebra::Isometry3;
use serde::Serialize;

use crate::cr7::Cr7Error;
use crate::report::{LimitLine, LimitUnit, clip, duration, limit_table, number};
use crate::robot::Robot;
use crate::schedule_figure::{BindingBar, ShareFigure, SharePanel, SpeedFigure};
use crate::schedule_file::{ScheduleFile, SchedulePlace, ScheduleWay};

/// Dense samples of the check in every interval of the grid.
const SAMPLES: usize = 20;
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
pub struct ScheduleRun<const N: usize> {
    /// The report.
    pub report: ScheduleReport,
    /// Setpoints at the control period.
    pub setpoints: Vec<Setpoint<N>>,
    /// Speed over the limit curve, with what binds.
    pub speed: SpeedFigure,
    /// Joint curves in units of their limits.
    pub shares: ShareFigure,
}

/// A motion between poses for an arm of six joints, or through way-points for any.
///
/// # Errors
/// [`Cr7Error::Input`] for what the file says wrongly, [`Cr7Error::Plan`] for what cannot be planned, with the place.
pub fn run_schedule<const N: usize>(
    file: &ScheduleFile,
    robot: &Robot,
    planner: SpeedPlanner,
) -> Result<ScheduleRun<N>, Cr7Error> {
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
            setting.run(&arm, &spline, "joint way-points", None)
        }
        ScheduleWay::Poses { start, goal, near } => {
            let motion = PoseMotion::new(&pose(file, &arm, "start", start)?, &pose(file, &arm, "goal", goal)?);
            let motion = motion.map_err(|e| setting.failed(e.into()))?;
            let near = near.as_ref().map(|near| file.of::<N>("start.near_deg", near)).transpose()?;
            // A pose has six freedoms: the arm is one of six joints by another name.
            let six = robot.arm::<6>(file.tool).map_err(|_| {
                setting.failed(PlanError::Missing {
                    needed: "an arm of six joints",
                    purpose: "a motion between poses",
                    remedy: "take another --robot, or give joint way-points",
                })
            })?;
            let path = match near {
                Some(near) => {
                    ArmMotion::new(&six, motion, &Joints::from_fn(|i, _| near.get(i).copied().unwrap_or(0.0)))
                }
                None => ArmMotion::from_best_start(&six, motion, six.range()),
            };
            let path = path.map_err(|e| setting.failed(e))?;
            setting.run(&arm, &Renamed(path), &motion.kind().to_string(), Some(motion.angle()))
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

fn pose<const N: usize>(
    file: &ScheduleFile,
    arm: &Arm<N>,
    section: &str,
    place: &SchedulePlace,
) -> Result<Isometry3<f64>, Cr7Error> {
    Ok(match place {
        SchedulePlace::Pose(pose) => *pose,
        SchedulePlace::Joints(q) => arm.forward(&Joints::from(file.of::<N>(&format!("{section}.q_deg"), q)?)),
    })
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

    fn run<P: SchedulePath<N>>(
        self,
        arm: &Arm<N>,
        path: &P,
        motion: &str,
        rotation: Option<f64>,
    ) -> Result<ScheduleRun<N>, Cr7Error> {
        let failed = |e| self.failed(e);
        let parameter = path.parameter();
        let to_si = if parameter == ScheduleParameter::ArcLength { 1e-3 } else { 1f64.to_radians() };
        let [start, end] = self.file.speeds.map(|v| v * to_si);
        let mut scheduler = Scheduler::new(arm, self.limits)
            .and_then(|s| s.with_intervals(self.file.intervals))
            .and_then(|s| s.with_end_speeds(start, end))
            .map_err(failed)?;
        if let Some(dynamics) = &self.dynamics {
            scheduler = scheduler.with_dynamics(dynamics);
        }
        let schedule = scheduler.plan(path, self.planner).map_err(failed)?;
        let check = schedule.check(SAMPLES).map_err(failed)?;
        // A period far below the motion's own would fill the memory.
        let sampler = schedule.sampler(self.file.period).map_err(failed)?;
        if sampler.samples() > 20_000_000 {
            let longest = 2e7 * self.file.period;
            return Err(failed(PlanError::TooLong { duration: schedule.duration(), longest }));
        }
        let setpoints = sampler.collect::<Result<Vec<_>, _>>().map_err(failed)?;
        let [following, planning] = schedule.timings().map(|t| t.as_secs_f64());
        let mut warnings = self.warnings.clone();
        if check.worst_ratio() > 1.0 + 1e-3 {
            let worst = check.worst().map_or(String::new(), |w| w.source.to_string());
            warnings.push(format!(
                "{worst} exceeds its limit by {} % between the grid points: take --planner certified or jerk-limited, or more intervals",
                number((check.worst_ratio() - 1.0) * 100.0)
            ));
        }
        let planner = if schedule.fallback().is_some() { "joined scan" } else { self.planner.name() };
        if let Some(why) = schedule.fallback() {
            warnings.push(format!("the joined scan made the motion instead of the jerk-limited planner: {why}"));
        }
        let report = ScheduleReport {
            name: self.file.file.display().to_string(),
            robot: self.robot.clone(),
            motion: motion.to_owned(),
            parameter: parameter.to_string(),
            parameter_unit: parameter.unit(),
            parameter_end: path.end(),
            rotation_rad: rotation,
            planner,
            intervals: schedule.problem().intervals(),
            duration_s: schedule.duration(),
            samples: setpoints.len(),
            period_s: self.file.period,
            following_time_s: following,
            planning_time_s: planning,
            limits: limit_lines(&check, parameter),
            checked_samples: check.samples,
            binding: check
                .bindings
                .iter()
                .map(|b| BindingLine {
                    limit: b.source.to_string(),
                    intervals: b.intervals.iter().map(|&(from, to)| [from, to]).collect(),
                })
                .collect(),
            warnings,
            files: Vec::new(),
        };
        let facts =
            format!("{motion}, {planner}: {} s; {} on {}", number(schedule.duration()), used_most(&check), self.robot);
        let speed = speed_figure(&schedule, &check, &report.name, &facts);
        let shares = share_figure(&schedule, &setpoints, &report.name, &facts);
        Ok(ScheduleRun { report, setpoints, speed, shares })
    }
}

fn used_most(check: &ScheduleCheck) -> String {
    check.worst().map_or("nothing is limited".to_owned(), |worst| {
        format!("{} uses {}", worst.source, crate::report::percent(worst.ratio))
    })
}

fn limit_lines(check: &ScheduleCheck, parameter: ScheduleParameter) -> Vec<LimitLine> {
    let line = |u: &arcfeed_interp::LimitUse| {
        let (name, unit) = match u.source.quantity {
            Quantity::JointVelocity => ("joint velocity", LimitUnit::RadianPerSecond),
            Quantity::JointAcceleration => ("joint acceleration", LimitUnit::RadianPerSecond2),
            Quantity::JointJerk => ("joint jerk", LimitUnit::RadianPerSecond3),
            Quantity::JointTorque => ("joint torque", LimitUnit::NewtonMetre),
            Quantity::LinearSpeed => ("linear speed of the tool", LimitUnit::MetrePerSecond),
            _ => ("angular speed of the tool", LimitUnit::RadianPerSecond),
        };
        LimitLine {
            name: name.to_owned(),
            joint: u.source.joint.map(|j| usize::from(j) + 1),
            unit,
            value: u.value,
            limit: u.limit,
            ratio: u.ratio,
            at_s_m: (parameter == ScheduleParameter::ArcLength).then_some(u.s),
            at_t_s: u.t,
        }
    };
    check.uses.iter().map(line).collect()
}

/// Factor and unit in which people read the parameter.
fn shown(parameter: ScheduleParameter) -> (f64, &'static str) {
    match parameter {
        ScheduleParameter::ArcLength => (1e3, "mm"),
        _ => (1f64.to_degrees(), "deg"),
    }
}

fn speed_figure<P: SchedulePath<N>, const N: usize>(
    schedule: &Schedule<'_, P, N>,
    check: &ScheduleCheck,
    name: &str,
    facts: &str,
) -> SpeedFigure {
    let parameter = schedule.path().parameter();
    let (factor, unit) = shown(parameter);
    let end = schedule.path().end();
    let points = 2000;
    let speed = (0..=points).map(|i| {
        let s = end * f64::from(i) / f64::from(points);
        (s * factor, schedule.law().at_position(s).v * factor)
    });
    let curve = |points: &mut dyn Iterator<Item = arcfeed_interp::LimitPoint>| {
        points.map(|p| (p.s * factor, p.speed * factor)).collect::<Vec<_>>()
    };
    SpeedFigure {
        file: "speed.svg".to_owned(),
        title: format!("{name}: speed along the motion"),
        facts: facts.to_owned(),
        x_label: format!("{parameter} s [{unit}]"),
        y_label: format!("speed [{unit}/s]"),
        speeds: vec![("speed".to_owned(), speed.collect())],
        initial: curve(&mut schedule.initial_velocity_limit()),
        ceiling: curve(&mut schedule.maximum_velocity_curve()),
        bindings: binding_bars(check, factor),
    }
}

/// The limits that bind, as bars along the motion.
pub(crate) fn binding_bars(check: &ScheduleCheck, factor: f64) -> Vec<BindingBar> {
    let bar = |b: &arcfeed_interp::Binding| BindingBar {
        name: short(b.source),
        joint: b.source.joint.map(usize::from),
        intervals: b.intervals.iter().map(|&(from, to)| (from * factor, to * factor)).collect(),
    };
    check.bindings.iter().map(bar).collect()
}

/// "J3 torque".
fn short(source: RowSource) -> String {
    match source.joint {
        Some(joint) => format!("J{} {}", joint + 1, source.quantity),
        None => source.quantity.to_string(),
    }
}

fn share_figure<P: SchedulePath<N>, const N: usize>(
    schedule: &Schedule<'_, P, N>,
    setpoints: &[Setpoint<N>],
    name: &str,
    facts: &str,
) -> ShareFigure {
    let limits = schedule.limits();
    let torque = |p: &Setpoint<N>| schedule.torque(p).unwrap_or(Joints::zeros());
    type Value<'v, const N: usize> = &'v dyn Fn(&Setpoint<N>) -> Joints<N>;
    let kinds: [(&str, Option<Joints<N>>, Value<'_, N>); 4] = [
        ("velocity", limits.velocity, &|p| p.qd),
        ("acceleration", limits.acceleration, &|p| p.qdd),
        ("torque", limits.torque, &torque),
        ("jerk", limits.jerk, &|p| p.jerk),
    ];
    let panels = kinds.into_iter().filter_map(|(label, limits, value)| {
        let limits = limits?;
        let values: Vec<Joints<N>> = setpoints.iter().map(value).collect();
        let line = |j: usize| setpoints.iter().zip(&values).map(|(p, v)| (p.t, v[j] / limits[j])).collect();
        Some(SharePanel { label: label.to_owned(), joints: (0..N).map(line).collect() })
    });
    ShareFigure {
        file: "joints.svg".to_owned(),
        title: format!("{name}: joints in units of their limits"),
        facts: facts.to_owned(),
        panels: panels.collect(),
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
