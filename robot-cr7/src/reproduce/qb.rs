//! Quaternion-Based Velocity Scheduling for Robotic Systems (Electronics 2025, 14, 3869): its motions beside ours.

use arcfeed_feedrate::{FeedPlanner, FeedProblem, LimitId, PublishedScan, Quantity, SpeedLaw};
use arcfeed_geometry::{GeometryError, PoseMotion};
use arcfeed_interp::{
    LimitError, Limits, Method, PathError, PathProblem, PlanError, Planner, PoseMove, Setpoint, SpeedError,
    Verification,
};
use arcfeed_kinematics::{Arm, Inertial, JointLimits, Joints, KinematicsError, models};
use nalgebra::{Isometry3, Translation3};
use serde::Deserialize;
use thiserror::Error;

use super::Reproduction;
use crate::input::toml_check::rotation;
use crate::output::schedule_figure::{JointFigure, JointPanel, SpeedFigure, binding_bars};

/// The grid of the plans whose places are compared: fine enough for three digits.
const FINE: usize = 500;
/// The grid of the plans whose violations and cost are shown; the paper does not state its own.
const COARSE: usize = 100;
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
    #[error("{0}")]
    Path(#[from] PathError),
    #[error("{0}")]
    Limit(#[from] LimitError),
    #[error("{0}")]
    Speed(#[from] SpeedError),
    #[error("{0}")]
    Feed(#[from] arcfeed_feedrate::FeedError),
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
    let joints =
        arm.range().with_rates(Joints::from(data.velocity), Joints::from(data.acceleration), Joints::repeat(JERK))?;
    let torque = Joints::from(data.torque);
    table_1(r, &joints, &torque);
    pure_orientation(r, figures, &arm, &data.po, (joints, torque))?;
    composite(r, figures, &arm, &data.to, (joints, torque))
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

fn table_1(r: &mut Reproduction, joints: &JointLimits<6>, torque: &Joints<6>) {
    const PLACE: &str = "Table 1: limits of the joints, as planned with";
    let rows = [
        ("velocity, rad/s", joints.velocity(), "1.02 0.77 1.16 1.25 1.25 1.86"),
        ("acceleration, rad/s^2", joints.acceleration(), "3.06 2.31 3.47 3.74 3.74 5.5"),
        ("torque, N m", torque, "44.65 40.66 18.95 9.06 10.05 5.69"),
    ];
    for (what, ours, paper) in rows {
        let ours = list(ours);
        let same = ours == paper;
        r.add(PLACE, what, "as below", if same { "the same" } else { "other" }).guaranteed(same).note(ours);
    }
}

/// A motion of the paper, ready to be planned by any planner.
struct Case<'a> {
    path: PoseMove<'a>,
    planner: Planner<'a>,
}

/// A law for a motion of the paper, as it came from its planner, and what the check says of it.
struct Planned<'c> {
    problem: PathProblem<'c>,
    rows: FeedProblem,
    law: SpeedLaw,
    check: Verification,
}

impl<'a> Case<'a> {
    fn new(arm: &'a Arm<6>, way: &Way, joints: JointLimits<6>, torque: Option<Joints<6>>) -> Result<Self, Broken> {
        let path = PoseMove::starting_near(arm, way.motion()?, &Joints::from(way.near_rad))?;
        let mut limits = Limits::new(joints);
        if let Some((dynamics, torque)) = arm.dynamics().zip(torque) {
            limits = limits.with_torque(dynamics, torque)?;
        }
        Ok(Self { path, planner: Planner::new(arm, limits) })
    }

    /// The law of one planner on one grid, planned once and checked.
    fn plan(&self, method: Method, intervals: usize) -> Result<Planned<'_>, Broken> {
        self.plan_with(&method, method, intervals)
    }

    /// The same by the scan of the paper.
    fn published(&self, intervals: usize) -> Result<Planned<'_>, Broken> {
        self.plan_with(&PublishedScan, Method::ForwardBackward, intervals)
    }

    fn plan_with(&self, by: &dyn FeedPlanner, like: Method, intervals: usize) -> Result<Planned<'_>, Broken> {
        let planner = self.planner.clone().with_intervals(intervals)?;
        let problem = planner.prepare(&self.path, like.needs())?;
        let rows = problem.rows(like.needs())?;
        let law = by.plan(&rows)?;
        let check = planner.verify(&problem, &law, like.limits_jerk())?;
        Ok(Planned { problem, rows, law, check })
    }
}

impl Planned<'_> {
    /// The largest part of a limit of joints, drives or tool that is used on dense samples, and which.
    fn worst(&self) -> (f64, LimitId) {
        let limits = self.check.checks().iter().filter(|check| !matches!(check.quantity(), Quantity::Continuity));
        limits.fold((0.0, LimitId::path(Quantity::Other)), |most, check| {
            if check.ratio > most.0 || check.ratio.is_nan() { (check.ratio, check.id) } else { most }
        })
    }

    /// The same by the rows at the grid points, for the accelerations before and after each.
    fn worst_at_points(&self) -> f64 {
        let mut worst: f64 = 0.0;
        for (i, &s) in self.rows.grid().iter().enumerate() {
            let h = 1e-9 * self.law.end().p;
            for state in [self.law.at_position(s), self.law.at_position(s - h)] {
                let v = self.law.at_position(s).v;
                for row in self.rows.rows(i) {
                    let value = row.value(state.a, v * v);
                    worst = worst.max(value / row.hi).max(value / row.lo);
                }
                worst = worst.max(v / self.rows.cap(i).0.sqrt());
            }
        }
        worst
    }
}

/// The longest interval in which one limit binds.
fn longest(check: &Verification, source: LimitId) -> (f64, f64) {
    check.binding(source).iter().copied().fold(
        (0.0, 0.0),
        |best: (f64, f64), (from, to)| {
            if to - from > best.1 - best.0 { (from, to) } else { best }
        },
    )
}

fn joint(quantity: Quantity, number: usize) -> LimitId {
    LimitId::joint(quantity, number - 1)
}

fn pure_orientation(
    r: &mut Reproduction,
    figures: &mut ScheduleFigures,
    arm: &Arm<6>,
    way: &Way,
    (joints, torque): (JointLimits<6>, Joints<6>),
) -> Result<(), Broken> {
    const PLACE: &str = "Table 2, figures 2 to 5: pure orientation (half angles where the paper has them, rad)";
    // With Table 1's velocities and accelerations: torques never bind here, as the figures show.
    let kinematic = Case::new(arm, way, joints, None)?;
    let motion = *kinematic.path.motion();
    r.add(PLACE, "distance of the tool points, m", "0", format!("{}", motion.length()))
        .guaranteed(motion.length() == 0.0);
    r.add(PLACE, "rotation", "", format!("{:.4} half", 0.5 * motion.angle()))
        .note(format!("the full angle is {:.4} rad; the paper's s2 = acos(Qc . Qt) is half of it", motion.angle()));
    let ours = kinematic.plan(Method::InterpolatedReachability, FINE)?;
    let check = &ours.check;
    let (from, to) = longest(check, joint(Quantity::JointVelocity, 5));
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
    let others = check.bindings().iter().filter(|b| b.id.joint != Some(4)).count();
    r.add(PLACE, "other limits that bind", "0", others.to_string()).guaranteed(others == 0);
    r.add(PLACE, "duration, s", "", format!("{:.4}", ours.law.duration()));

    let case = Case::new(arm, way, joints, Some(torque))?;
    let with_torque = case.plan(Method::InterpolatedReachability, FINE)?;
    let most = with_torque.check.worst_of(Quantity::JointTorque).map_or(f64::NAN, |check| check.ratio);
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
    (joints, torque): (JointLimits<6>, Joints<6>),
) -> Result<(), Broken> {
    const PLACE: &str = "Table 3, figures 6 to 9: composite motion (arc length, m)";
    let case = Case::new(arm, way, joints, Some(torque))?;
    let motion = *case.path.motion();
    r.add(PLACE, "length, m", "0.86", format!("{:.4}", motion.length()))
        .guaranteed((motion.length() - 0.86).abs() <= 5e-3);
    let half = 0.5 * motion.angle();
    r.add(PLACE, "rotation, half angle, rad", "0.13", format!("{half:.4}"))
        .guaranteed((half - 0.13).abs() <= 5e-3)
        .note(format!("the full angle is {:.4} rad", motion.angle()));
    let published = case.published(FINE)?;
    for source in
        [joint(Quantity::JointAcceleration, 3), joint(Quantity::JointTorque, 1), joint(Quantity::JointTorque, 3)]
    {
        let (from, to) = longest(&published.check, source);
        r.add(PLACE, format!("{source} binds"), "yes", format!("{from:.3} .. {to:.3}")).guaranteed(to > from);
    }
    let clamps = clamps(&published)?;
    for (i, printed) in ["0.066 .. 0.32", "0.77 .. 0.84"].into_iter().enumerate() {
        let ours = clamps.get(i).map_or("none".to_owned(), |(a, b)| format!("{a:.3} .. {b:.3}"));
        r.add(PLACE, format!("clamp {} by the initial velocity limit", i + 1), printed, ours);
    }
    if let Some(last) = r.claims.last_mut() {
        last.note("the dynamics are synthetic: which limits bind is claimed, not where");
    }
    violations(r, PLACE, &case)?;
    for method in [Method::ForwardBackward, Method::Reachability, Method::InterpolatedReachability] {
        let planned = case.plan(method, FINE)?;
        r.add(PLACE, format!("duration, {method}, s"), "", format!("{:.4}", planned.law.duration()));
    }
    let planned = case.plan(Method::JerkLimited, FINE)?;
    let (worst, _) = planned.worst();
    r.add(PLACE, format!("with jerk {JERK} rad/s^3, s"), "not limited", format!("{:.4}", planned.law.duration()))
        .guaranteed(worst <= 1.0 + BETWEEN)
        .note(format!("largest part of any limit {worst:.6}, jerk and torque included"));
    let coarse = case.planner.clone().with_intervals(COARSE)?;
    let fastest = (0..5).map(|_| {
        let begin = std::time::Instant::now();
        let needs = Method::ForwardBackward.needs();
        Method::ForwardBackward.plan(&coarse.prepare(&case.path, needs)?.rows(needs)?)?;
        Ok(begin.elapsed().as_secs_f64())
    });
    let fastest = fastest.collect::<Result<Vec<f64>, Broken>>()?.into_iter().fold(f64::INFINITY, f64::min);
    r.add(PLACE, "time to plan, forward-backward, ms", "5.63", format!("{:.2}", fastest * 1e3)).note(format!(
        "{COARSE} intervals (the paper states no grid), inverse kinematics and dynamics included; best of five runs"
    ));
    draw(figures, &case, "composite motion", ["figure_6", "figure_7", "figure_8", "figure_9"])
}

/// Where the speed lies on the initial velocity limit, clamps shorter than a hundredth of the motion left out.
fn clamps(planned: &Planned<'_>) -> Result<Vec<(f64, f64)>, Broken> {
    let mut clamps: Vec<(f64, f64)> = Vec::new();
    let end = planned.law.end().p;
    for point in planned.problem.initial_velocity_limit()? {
        if planned.law.at_position(point.s).v < (1.0 - 1e-3) * point.speed {
            continue;
        }
        match clamps.last_mut() {
            Some(last) if point.s - last.1 < 4e-3 * end => last.1 = point.s,
            _ => clamps.push((point.s, point.s)),
        }
    }
    clamps.retain(|(from, to)| to - from > 0.01 * end);
    Ok(clamps)
}

/// By how much the published scan breaks the limits, and that the others do not.
fn violations(r: &mut Reproduction, place: &str, case: &Case<'_>) -> Result<(), Broken> {
    let percent = |ratio: f64| format!("{:+.4} %", (ratio - 1.0) * 100.0);
    let published = case.published(COARSE)?;
    let (worst, id) = published.worst();
    r.add(place, format!("published scan, N = {COARSE}: worst excess"), "none", percent(worst))
        .note(format!("{id}; at the grid points alone {}", percent(published.worst_at_points())));
    let ours = case.plan(Method::ForwardBackward, COARSE)?;
    let at_points = ours.worst_at_points();
    r.add(place, format!("forward-backward, N = {COARSE}, at the grid points"), "", percent(at_points))
        .guaranteed(at_points <= 1.0 + ROUNDING)
        .note(format!("between them {}: the path bends there", percent(ours.worst().0)));
    let ours = case.plan(Method::InterpolatedReachability, FINE)?;
    let (worst, _) = ours.worst();
    r.add(place, format!("interpolated-reachability, N = {FINE}, everywhere"), "", percent(worst))
        .guaranteed(worst <= 1.0 + BETWEEN)
        .note(format!("{} samples", ours.check.samples()));
    Ok(())
}

fn draw(figures: &mut ScheduleFigures, case: &Case<'_>, name: &str, files: [&str; 4]) -> Result<(), Broken> {
    let (published, ours) = (case.published(COARSE)?, case.plan(Method::InterpolatedReachability, FINE)?);
    let (broken, id) = published.worst();
    let turning = case.path.motion().length() == 0.0;
    // Half angles, as the paper has them.
    let (factor, x_label, y_label) = if turning {
        (0.5, "rotation s2, half angle [rad]", "half angular speed [rad/s]")
    } else {
        (1.0, "arc length s1 [m]", "speed [m/s]")
    };
    let end = case.path.motion().end();
    let curve = |planned: &Planned<'_>| {
        let at = |i: i32| end * f64::from(i) / 2000.0;
        (0..=2000).map(|i| (at(i) * factor, planned.law.at_position(at(i)).v * factor)).collect::<Vec<_>>()
    };
    let scaled = |points: Vec<arcfeed_interp::LimitPoint>| {
        points.iter().map(|p| (p.s * factor, p.speed * factor)).collect::<Vec<_>>()
    };
    let number = files[0].trim_start_matches("figure_");
    figures.speeds.push(SpeedFigure {
        file: format!("{}_speed.svg", files[0]),
        title: format!("Figure {number}: {name}"),
        facts: format!(
            "interpolated-reachability {:.4} s, nothing exceeded; published scan (N = {COARSE}) {:.4} s, exceeds {id} by {:.2} %",
            ours.law.duration(),
            published.law.duration(),
            (broken - 1.0) * 100.0
        ),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        speeds: vec![("interpolated-reachability".to_owned(), curve(&ours)), ("published scan".to_owned(), curve(&published))],
        initial: scaled(ours.problem.initial_velocity_limit()?),
        ceiling: scaled(ours.problem.maximum_velocity_curve(&ours.law)?),
        bindings: binding_bars(ours.check.bindings(), factor),
    });
    let limits = ours.problem.limits();
    let torque = limits.torque().map_or(Joints::repeat(f64::INFINITY), |torque| *torque.limits());
    let kinds: [(&str, &str, &'static str, Joints<6>); 3] = [
        (files[1], "joint velocities", "rad/s", *limits.joints().velocity()),
        (files[2], "joint accelerations", "rad/s²", *limits.joints().acceleration()),
        (files[3], "joint torques", "N m", torque),
    ];
    let samples = |planned: &Planned<'_>| -> Result<Vec<Setpoint>, PlanError> {
        planned.problem.setpoints(&planned.law, 1e-3)?.collect()
    };
    let both = [(samples(&ours)?, &ours), (samples(&published)?, &published)];
    for (kind, (file, what, unit, limits)) in kinds.into_iter().enumerate() {
        let lines = |j: usize| -> Vec<Vec<(f64, f64)>> {
            let value = |p: &Setpoint, planned: &Planned<'_>| match kind {
                0 => p.qd[j],
                1 => p.qdd[j],
                _ => planned.problem.torque_at(p).map_or(0.0, |torque| torque[j]),
            };
            both.iter().map(|(points, planned)| points.iter().map(|p| (p.t, value(p, planned))).collect()).collect()
        };
        figures.joints.push(JointFigure {
            file: format!("{file}_{}.svg", what.replace(' ', "_")),
            title: format!("Figure {}: {what}, {name}", file.trim_start_matches("figure_")),
            facts: "setpoints every millisecond; above each panel the peak of our plan and the limit".to_owned(),
            unit,
            names: vec!["interpolated-reachability".to_owned(), "published scan".to_owned()],
            joints: (0..6).map(|j| JointPanel { limit: limits[j], lines: lines(j) }).collect(),
        });
    }
    Ok(())
}
