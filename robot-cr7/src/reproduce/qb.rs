//! Quaternion-Based Velocity Scheduling for Robotic Systems (Electronics 2025, 14, 3869): its motions beside ours.

use arcfeed_feedrate::{Quantity, RowSource};
use arcfeed_geometry::{GeometryError, PoseMotion};
use arcfeed_interp::{
    ArmMotion, PlanError, Schedule, ScheduleCheck, ScheduleLimits, Scheduler, Setpoint, SpeedPlanner,
};
use arcfeed_kinematics::{Arm, Inertial, Joints, KinematicsError, models};
use nalgebra::{Isometry3, Translation3};
use serde::Deserialize;
use thiserror::Error;

use super::Reproduction;
use crate::schedule_figure::{JointFigure, JointPanel, SpeedFigure, binding_bars};
use crate::toml_check::rotation;

/// The grid of the plans whose places are compared: fine enough for three digits.
const FINE: usize = 500;
/// The grid of the plans whose violations and cost are shown; the paper does not state its own.
const COARSE: usize = 100;
/// Dense samples in every interval.
const SAMPLES: usize = 20;
/// Round-off at the grid points, relative.
const ROUNDING: f64 = 1e-9;
/// What may be left between the grid points of a certified plan at 500 intervals: the inverse kinematics is no
/// polynomial, and the error of its interpolation falls with the third power of the interval.
const BETWEEN: f64 = 1e-5;
/// Jerk limit of the motion that the paper does not have, rad/s^3.
const JERK: f64 = 40.0;

#[derive(Debug, Deserialize)]
struct Data {
    arm: String,
    inertial_scale: f64,
    #[serde(rename = "coulomb_Nm")]
    coulomb: [f64; 6],
    #[serde(rename = "viscous_Nms_per_rad")]
    viscous: [f64; 6],
    #[serde(rename = "rotor_inertia_kgm2")]
    rotor: [f64; 6],
    #[serde(rename = "velocity_rad_s")]
    velocity: [f64; 6],
    #[serde(rename = "acceleration_rad_s2")]
    acceleration: [f64; 6],
    #[serde(rename = "torque_Nm")]
    torque: [f64; 6],
    po: Way,
    to: Way,
}

#[derive(Debug, Deserialize)]
struct Way {
    start: [f64; 6],
    goal: [f64; 6],
    near_rad: [f64; 6],
}

impl Way {
    fn motion(&self) -> Result<PoseMotion, GeometryError> {
        let pose =
            |p: &[f64; 6]| Isometry3::from_parts(Translation3::new(p[0], p[1], p[2]), rotation([p[3], p[4], p[5]]));
        PoseMotion::new(&pose(&self.start), &pose(&self.goal))
    }
}

/// What cannot go wrong with the embedded data but is told if it does.
#[derive(Debug, Error)]
enum Broken {
    #[error("{0}")]
    Data(#[from] serde_json::Error),
    #[error("{0}")]
    Arm(#[from] KinematicsError),
    #[error("{0}")]
    Geometry(#[from] GeometryError),
    #[error("{0}")]
    Plan(#[from] PlanError),
    #[error("the arm {0} is not built in, or its links are unknown")]
    Model(String),
}

/// The figures of the paper, drawn anew.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScheduleFigures {
    /// Figures 2 and 6: speed along the motion.
    pub speeds: Vec<SpeedFigure>,
    /// Figures 3 to 5 and 7 to 9: joint velocities, accelerations and torques.
    pub joints: Vec<JointFigure>,
}

/// Tables 1 to 3 and Figures 2 to 9 of Quaternion-Based Velocity Scheduling for Robotic Systems, Electronics 2025, 14, 3869, beside
/// ours: what binds and where, by how much the published scan breaks its limits, and that ours do not.
///
/// The paper's arm is not published; `data/qb_arm.json` says what stands in its place. Where dynamics matter (the composite
/// motion) it is claimed **which** limits bind, not where.
pub fn huang_2025() -> (Reproduction, ScheduleFigures) {
    let mut r = Reproduction {
        paper:
            "Huang, Wong, Cheng, Quaternion-Based Velocity Scheduling for Robotic Systems, Electronics 2025, 14, 3869"
                .to_owned(),
        claims: Vec::new(),
    };
    let mut figures = ScheduleFigures::default();
    if let Err(error) = reproduce(&mut r, &mut figures) {
        r.add("data", "could not be run", "", error.to_string()).guaranteed(false);
    }
    (r, figures)
}

fn reproduce(r: &mut Reproduction, figures: &mut ScheduleFigures) -> Result<(), Broken> {
    let data: Data = serde_json::from_str(include_str!("../../data/qb_arm.json"))?;
    let arm = arm(&data)?;
    let limits = ScheduleLimits {
        velocity: Some(Joints::from(data.velocity)),
        acceleration: Some(Joints::from(data.acceleration)),
        torque: Some(Joints::from(data.torque)),
        ..ScheduleLimits::default()
    };
    table_1(r, &limits);
    pure_orientation(r, figures, &arm, &data.po, limits)?;
    composite(r, figures, &arm, &data.to, limits)
}

fn arm(data: &Data) -> Result<Arm<6>, Broken> {
    let model = || Broken::Model(data.arm.clone());
    let mut description = models::description(&data.arm).ok_or_else(model)?;
    for (i, joint) in description.joints.iter_mut().enumerate() {
        let link = joint.inertial.ok_or_else(model)?;
        let scale = data.inertial_scale;
        joint.inertial = Some(Inertial::new(link.mass() * scale, *link.centre(), *link.tensor() * scale)?);
        joint.rotor_inertia = Some(data.rotor[i]);
        joint.friction = Some([data.viscous[i], data.coulomb[i], data.coulomb[i]]);
    }
    Ok(description.build::<6>()?)
}

/// Numbers of six joints.
fn list(values: &Joints<6>) -> String {
    values.iter().map(|v| format!("{v}")).collect::<Vec<_>>().join(" ")
}

fn table_1(r: &mut Reproduction, limits: &ScheduleLimits<6>) {
    const PLACE: &str = "Table 1: limits of the joints, as planned with";
    let rows = [
        ("velocity, rad/s", limits.velocity, "1.02 0.77 1.16 1.25 1.25 1.86"),
        ("acceleration, rad/s^2", limits.acceleration, "3.06 2.31 3.47 3.74 3.74 5.5"),
        ("torque, N m", limits.torque, "44.65 40.66 18.95 9.06 10.05 5.69"),
    ];
    for (what, ours, paper) in rows {
        let ours = ours.as_ref().map_or(String::new(), list);
        let same = ours == paper;
        r.add(PLACE, what, "as below", if same { "the same" } else { "other" }).guaranteed(same).note(ours);
    }
}

/// A motion of the paper, ready to be planned by any planner.
struct Case<'a> {
    path: ArmMotion<'a, Arm<6>>,
    scheduler: Scheduler<'a>,
}

type Planned<'c> = Schedule<'c, ArmMotion<'c, Arm<6>>>;

impl<'a> Case<'a> {
    fn new(arm: &'a Arm<6>, way: &Way, limits: ScheduleLimits<6>) -> Result<Self, Broken> {
        let path = ArmMotion::new(arm, way.motion()?, &Joints::from(way.near_rad))?;
        let scheduler = Scheduler::new(arm, limits)?;
        let scheduler = match arm.dynamics() {
            Some(dynamics) => scheduler.with_dynamics(dynamics),
            None => scheduler,
        };
        Ok(Self { path, scheduler })
    }

    fn plan(&self, planner: SpeedPlanner, intervals: usize) -> Result<(Planned<'_>, ScheduleCheck), Broken> {
        let schedule = self.scheduler.with_intervals(intervals)?.plan(&self.path, planner)?;
        let check = schedule.check(SAMPLES)?;
        Ok((schedule, check))
    }
}

/// The longest interval in which one limit binds.
fn longest(check: &ScheduleCheck, source: RowSource) -> (f64, f64) {
    check.binding(source).iter().copied().fold(
        (0.0, 0.0),
        |best: (f64, f64), (from, to)| {
            if to - from > best.1 - best.0 { (from, to) } else { best }
        },
    )
}

fn joint(quantity: Quantity, number: usize) -> RowSource {
    RowSource::joint(quantity, number - 1)
}

fn pure_orientation(
    r: &mut Reproduction,
    figures: &mut ScheduleFigures,
    arm: &Arm<6>,
    way: &Way,
    limits: ScheduleLimits<6>,
) -> Result<(), Broken> {
    const PLACE: &str = "Table 2, figures 2 to 5: pure orientation (half angles where the paper has them, rad)";
    // With Table 1's velocities and accelerations: torques never bind here, as the figures show.
    let kinematic = Case::new(arm, way, ScheduleLimits { torque: None, ..limits })?;
    let motion = *kinematic.path.motion();
    r.add(PLACE, "distance of the tool points, m", "0", format!("{}", motion.length()))
        .guaranteed(motion.length() == 0.0);
    r.add(PLACE, "rotation", "", format!("{:.4} half", 0.5 * motion.angle()))
        .note(format!("the full angle is {:.4} rad; the paper's s2 = acos(Qc . Qt) is half of it", motion.angle()));
    let (ours, check) = kinematic.plan(SpeedPlanner::Certified, FINE)?;
    let (from, to) = longest(&check, joint(Quantity::JointVelocity, 5));
    for (what, printed, full) in [("from", 0.11, from), ("to", 0.54, to)] {
        let half = 0.5 * full;
        r.add(PLACE, format!("velocity of joint 5 binds {what}"), format!("{printed}"), format!("{half:.3}"))
            .guaranteed((half - printed).abs() <= 5e-3)
            .note(format!("{full:.3} rad as a full angle"));
    }
    let ends = check.binding(joint(Quantity::JointAcceleration, 5));
    let end = motion.end();
    let at_both = ends.first().is_some_and(|(a, b)| *a == 0.0 && (b - from).abs() < 0.02 * end)
        && ends.last().is_some_and(|(a, b)| (a - to).abs() < 0.02 * end && end - b < 0.02 * end);
    r.add(PLACE, "acceleration of joint 5 binds before and after", "yes", if at_both { "yes" } else { "no" })
        .guaranteed(at_both);
    let others = check.bindings.iter().filter(|b| b.source.joint != Some(4)).count();
    r.add(PLACE, "other limits that bind", "0", others.to_string()).guaranteed(others == 0);
    r.add(PLACE, "duration, s", "", format!("{:.4}", ours.duration()));

    let case = Case::new(arm, way, limits)?;
    let (_, with_torque) = case.plan(SpeedPlanner::Certified, FINE)?;
    let most = with_torque.uses.iter().filter(|u| u.source.quantity == Quantity::JointTorque);
    let most = most.map(|u| u.ratio).fold(0.0, f64::max);
    r.add(PLACE, "torques: largest part of a limit", "below 1", format!("{most:.3}"))
        .guaranteed(most < 1.0)
        .note("on the stand-in for the paper's arm");
    violations(r, PLACE, &case)?;
    draw(figures, &case, "pure orientation", ["figure_2", "figure_3", "figure_4", "figure_5"])
}

fn composite(
    r: &mut Reproduction,
    figures: &mut ScheduleFigures,
    arm: &Arm<6>,
    way: &Way,
    limits: ScheduleLimits<6>,
) -> Result<(), Broken> {
    const PLACE: &str = "Table 3, figures 6 to 9: composite motion (arc length, m)";
    let case = Case::new(arm, way, limits)?;
    let motion = *case.path.motion();
    r.add(PLACE, "length, m", "0.86", format!("{:.4}", motion.length()))
        .guaranteed((motion.length() - 0.86).abs() <= 5e-3);
    let half = 0.5 * motion.angle();
    r.add(PLACE, "rotation, half angle, rad", "0.13", format!("{half:.4}"))
        .guaranteed((half - 0.13).abs() <= 5e-3)
        .note(format!("the full angle is {:.4} rad", motion.angle()));
    let (published, check) = case.plan(SpeedPlanner::Published, FINE)?;
    for source in
        [joint(Quantity::JointAcceleration, 3), joint(Quantity::JointTorque, 1), joint(Quantity::JointTorque, 3)]
    {
        let (from, to) = longest(&check, source);
        r.add(PLACE, format!("{source} binds"), "yes", format!("{from:.3} .. {to:.3}")).guaranteed(to > from);
    }
    let clamps = clamps(&published);
    for (i, printed) in ["0.066 .. 0.32", "0.77 .. 0.84"].into_iter().enumerate() {
        let ours = clamps.get(i).map_or("none".to_owned(), |(a, b)| format!("{a:.3} .. {b:.3}"));
        r.add(PLACE, format!("clamp {} by the initial velocity limit", i + 1), printed, ours);
    }
    if let Some(last) = r.claims.last_mut() {
        last.note("the dynamics are synthetic: which limits bind is claimed, not where");
    }
    violations(r, PLACE, &case)?;
    for planner in [SpeedPlanner::BothEnds, SpeedPlanner::Reachability, SpeedPlanner::Certified] {
        let (schedule, _) = case.plan(planner, FINE)?;
        r.add(PLACE, format!("duration, {}, s", planner.name()), "", format!("{:.4}", schedule.duration()));
    }
    let jerk = Case::new(arm, way, ScheduleLimits { jerk: Some(Joints::repeat(JERK)), ..limits })?;
    let (schedule, check) = jerk.plan(SpeedPlanner::JerkLimited, FINE)?;
    r.add(PLACE, format!("with jerk {JERK} rad/s^3, s"), "not limited", format!("{:.4}", schedule.duration()))
        .guaranteed(check.worst_ratio() <= 1.0 + BETWEEN)
        .note(format!("largest part of any limit {:.6}, jerk and torque included", check.worst_ratio()));
    let fastest = (0..5).map(|_| {
        let (schedule, _) = (case.scheduler.with_intervals(COARSE)?.plan(&case.path, SpeedPlanner::BothEnds)?, ());
        Ok(schedule.timings().iter().map(std::time::Duration::as_secs_f64).sum::<f64>())
    });
    let fastest = fastest.collect::<Result<Vec<f64>, Broken>>()?.into_iter().fold(f64::INFINITY, f64::min);
    r.add(PLACE, "time to plan, both ends, ms", "5.63", format!("{:.2}", fastest * 1e3)).note(format!(
        "{COARSE} intervals (the paper states no grid), inverse kinematics and dynamics included; best of five runs"
    ));
    draw(figures, &case, "composite motion", ["figure_6", "figure_7", "figure_8", "figure_9"])
}

/// Where the speed lies on the initial velocity limit, clamps shorter than a hundredth of the motion left out.
fn clamps(schedule: &Planned<'_>) -> Vec<(f64, f64)> {
    let mut clamps: Vec<(f64, f64)> = Vec::new();
    let end = schedule.law().end().p;
    for point in schedule.initial_velocity_limit() {
        if schedule.law().at_position(point.s).v < (1.0 - 1e-3) * point.speed {
            continue;
        }
        match clamps.last_mut() {
            Some(last) if point.s - last.1 < 4e-3 * end => last.1 = point.s,
            _ => clamps.push((point.s, point.s)),
        }
    }
    clamps.retain(|(from, to)| to - from > 0.01 * end);
    clamps
}

/// By how much the published scan breaks the limits, and that the others do not.
fn violations(r: &mut Reproduction, place: &str, case: &Case<'_>) -> Result<(), Broken> {
    let at_points = |check: &ScheduleCheck| check.uses.iter().map(|u| u.ratio_at_points).fold(0.0, f64::max);
    let percent = |ratio: f64| format!("{:+.4} %", (ratio - 1.0) * 100.0);
    let (_, check) = case.plan(SpeedPlanner::Published, COARSE)?;
    let worst = check.worst().map_or(String::new(), |w| w.source.to_string());
    r.add(place, format!("published scan, N = {COARSE}: worst excess"), "none", percent(check.worst_ratio()))
        .note(format!("{worst}; at the grid points alone {}", percent(at_points(&check))));
    let (_, check) = case.plan(SpeedPlanner::BothEnds, COARSE)?;
    r.add(place, format!("both-ends scan, N = {COARSE}, at the grid points"), "", percent(at_points(&check)))
        .guaranteed(at_points(&check) <= 1.0 + ROUNDING)
        .note(format!("between them {}: the path bends there", percent(check.worst_ratio())));
    let (_, check) = case.plan(SpeedPlanner::Certified, FINE)?;
    r.add(place, format!("certified, N = {FINE}, everywhere"), "", percent(check.worst_ratio()))
        .guaranteed(check.worst_ratio() <= 1.0 + BETWEEN)
        .note(format!("{} samples", check.samples));
    Ok(())
}

fn draw(figures: &mut ScheduleFigures, case: &Case<'_>, name: &str, files: [&str; 4]) -> Result<(), Broken> {
    let (published, broken) = case.plan(SpeedPlanner::Published, COARSE)?;
    let (ours, check) = case.plan(SpeedPlanner::Certified, FINE)?;
    let turning = case.path.motion().length() == 0.0;
    // Half angles, as the paper has them.
    let (factor, x_label, y_label) = if turning {
        (0.5, "rotation s2, half angle [rad]", "half angular speed [rad/s]")
    } else {
        (1.0, "arc length s1 [m]", "speed [m/s]")
    };
    let end = case.path.motion().end();
    let curve = |schedule: &Planned<'_>| {
        let at = |i: i32| end * f64::from(i) / 2000.0;
        (0..=2000).map(|i| (at(i) * factor, schedule.law().at_position(at(i)).v * factor)).collect::<Vec<_>>()
    };
    let scaled = |p: arcfeed_interp::LimitPoint| (p.s * factor, p.speed * factor);
    let number = files[0].trim_start_matches("figure_");
    figures.speeds.push(SpeedFigure {
        file: format!("{}_speed.svg", files[0]),
        title: format!("Figure {number}: {name}"),
        facts: format!(
            "certified {:.4} s, nothing exceeded; published scan (N = {COARSE}) {:.4} s, exceeds {} by {:.2} %",
            ours.duration(),
            published.duration(),
            broken.worst().map_or(String::new(), |w| w.source.to_string()),
            (broken.worst_ratio() - 1.0) * 100.0
        ),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        speeds: vec![("certified".to_owned(), curve(&ours)), ("published scan".to_owned(), curve(&published))],
        initial: ours.initial_velocity_limit().map(scaled).collect(),
        ceiling: ours.maximum_velocity_curve().map(scaled).collect(),
        bindings: binding_bars(&check, factor),
    });
    let limits = ours.limits();
    let none = Joints::repeat(f64::INFINITY);
    let kinds: [(&str, &str, &'static str, Joints<6>); 3] = [
        (files[1], "joint velocities", "rad/s", limits.velocity.unwrap_or(none)),
        (files[2], "joint accelerations", "rad/s²", limits.acceleration.unwrap_or(none)),
        (files[3], "joint torques", "N m", limits.torque.unwrap_or(none)),
    ];
    let samples = |schedule: &Planned<'_>| schedule.sampler(1e-3)?.collect::<Result<Vec<Setpoint>, PlanError>>();
    let both = [(samples(&ours)?, &ours), (samples(&published)?, &published)];
    for (kind, (file, what, unit, limits)) in kinds.into_iter().enumerate() {
        let lines = |j: usize| -> Vec<Vec<(f64, f64)>> {
            let value = |p: &Setpoint, schedule: &Planned<'_>| match kind {
                0 => p.qd[j],
                1 => p.qdd[j],
                _ => schedule.torque(p).map_or(0.0, |torque| torque[j]),
            };
            both.iter().map(|(points, schedule)| points.iter().map(|p| (p.t, value(p, schedule))).collect()).collect()
        };
        figures.joints.push(JointFigure {
            file: format!("{file}_{}.svg", what.replace(' ', "_")),
            title: format!("Figure {}: {what}, {name}", file.trim_start_matches("figure_")),
            facts: "setpoints every millisecond; above each panel the peak of the certified plan and the limit"
                .to_owned(),
            unit,
            names: vec!["certified".to_owned(), "published scan".to_owned()],
            joints: (0..6).map(|j| JointPanel { limit: limits[j], lines: lines(j) }).collect(),
        });
    }
    Ok(())
}
