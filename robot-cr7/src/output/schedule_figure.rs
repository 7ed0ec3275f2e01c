//! The figures of a scheduled motion, as plain numbers in the units of the labels.

use arcfeed_interp::{Binding, LimitId, LimitPoint, PathParameter, SpeedError, Trajectory};

/// Speed along a motion, under the curves that limit it, with what binds below.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedFigure {
    /// Name of its file.
    pub file: String,
    /// The title.
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

/// The intervals in which one limit binds.
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
    /// The title.
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
    /// The title.
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
fn shown(parameter: PathParameter) -> (f64, &'static str) {
    match parameter {
        PathParameter::ArcLength => (1e3, "mm"),
        _ => (1f64.to_degrees(), "deg"),
    }
}

pub(crate) fn speed_figure<const N: usize>(
    trajectory: &Trajectory<'_, N>,
    name: &str,
    facts: &str,
) -> Result<SpeedFigure, SpeedError> {
    let parameter = trajectory.path().parameter();
    let (factor, unit) = shown(parameter);
    let end = trajectory.path().length();
    let points = 2000;
    let speed = (0..=points).map(|i| {
        let s = end * f64::from(i) / f64::from(points);
        (s * factor, trajectory.law().at_position(s).v * factor)
    });
    let curve = |points: Vec<LimitPoint>| points.iter().map(|p| (p.s * factor, p.speed * factor)).collect();
    Ok(SpeedFigure {
        file: "speed.svg".to_owned(),
        title: name.to_owned(),
        facts: facts.to_owned(),
        x_label: format!("{parameter} s [{unit}]"),
        y_label: format!("speed [{unit}/s]"),
        speeds: vec![("speed".to_owned(), speed.collect())],
        initial: curve(trajectory.initial_velocity_limit()?),
        ceiling: curve(trajectory.maximum_velocity_curve()?),
        bindings: binding_bars(trajectory.verification().bindings(), factor),
    })
}

/// The limits that bind, as bars along the motion.
pub(crate) fn binding_bars(bindings: &[Binding], factor: f64) -> Vec<BindingBar> {
    let bar = |b: &Binding| BindingBar {
        name: short(b.id),
        joint: b.id.joint.map(usize::from),
        intervals: b.intervals.iter().map(|&(from, to)| (from * factor, to * factor)).collect(),
    };
    bindings.iter().map(bar).collect()
}

/// "J3 torque".
fn short(id: LimitId) -> String {
    match id.joint {
        Some(joint) => format!("J{} {}", joint + 1, id.quantity.name().trim_start_matches("joint ")),
        None => id.quantity.to_string(),
    }
}
