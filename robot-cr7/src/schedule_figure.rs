//! What is drawn of a scheduled motion, as plain numbers in the units of the labels.

use arcfeed_feedrate::RowSource;
use arcfeed_interp::{LimitPoint, Schedule, ScheduleCheck, ScheduleParameter, SchedulePath};

/// Speed along a motion, under the curves that limit it, with what binds below.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedFigure {
    /// Name of its file.
    pub file: String,
    /// What it shows.
    pub title: String,
    /// Conditions and results in words.
    pub facts: String,
    /// The parameter and its unit.
    pub x_label: String,
    /// The speed and its unit.
    pub y_label: String,
    /// Planned speeds with their names, the first of them the one that binds.
    pub speeds: Vec<(String, Vec<(f64, f64)>)>,
    /// The initial velocity limit: what could be kept at constant speed.
    pub initial: Vec<(f64, f64)>,
    /// The maximum velocity curve: above it nothing can be kept.
    pub ceiling: Vec<(f64, f64)>,
    /// Which limit binds where.
    pub bindings: Vec<BindingBar>,
}

/// Where one limit binds.
#[derive(Debug, Clone, PartialEq)]
pub struct BindingBar {
    /// Name of the limit.
    pub name: String,
    /// Its joint, from 0.
    pub joint: Option<usize>,
    /// From where to where.
    pub intervals: Vec<(f64, f64)>,
}

/// Joint curves over time in units of their limits, quantity by quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct ShareFigure {
    /// Name of its file.
    pub file: String,
    /// What it shows.
    pub title: String,
    /// Conditions and results in words.
    pub facts: String,
    /// One panel a quantity.
    pub panels: Vec<SharePanel>,
}

/// One quantity of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct SharePanel {
    /// The quantity.
    pub label: String,
    /// For every joint: time in s, value over limit.
    pub joints: Vec<Vec<(f64, f64)>>,
}

/// One quantity, a panel for every joint with its limit on both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFigure {
    /// Name of its file.
    pub file: String,
    /// What it shows.
    pub title: String,
    /// Conditions and results in words.
    pub facts: String,
    /// Unit of the values.
    pub unit: &'static str,
    /// Names of the lines that every panel has.
    pub names: Vec<String>,
    /// One panel a joint.
    pub joints: Vec<JointPanel>,
}

/// One joint in a [`JointFigure`].
#[derive(Debug, Clone, PartialEq)]
pub struct JointPanel {
    /// Its limit, for both signs.
    pub limit: f64,
    /// The points of each line: time in s, value.
    pub lines: Vec<Vec<(f64, f64)>>,
}

/// Factor and unit in which people read the parameter.
fn shown(parameter: ScheduleParameter) -> (f64, &'static str) {
    match parameter {
        ScheduleParameter::ArcLength => (1e3, "mm"),
        _ => (1f64.to_degrees(), "deg"),
    }
}

pub(crate) fn speed_figure<P: SchedulePath<N>, const N: usize>(
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
    let curve = |points: &mut dyn Iterator<Item = LimitPoint>| {
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
