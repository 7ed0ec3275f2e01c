//! What can stop a path from becoming a trajectory, and where.

use arcfeed_feedrate::{FeedError, Quantity as RowQuantity, RowSource};
use arcfeed_geometry::{GeometryError, PosePath};
use arcfeed_kinematics::{Joints, KinematicsError};
use thiserror::Error;

use crate::schedule::ScheduleParameter;
use crate::withheld::Cause;

/// Everything that can go wrong between a tool path and a joint trajectory.
///
/// Errors of the lower crates are wrapped with the place on the path where they happened. Joints count from 0 in the
/// fields and from 1 in the texts.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The arm cannot stand at a place of the path: out of reach, outside joint limits, or singular.
    #[error("at s = {s:.6} m (tool at x {:.4}, y {:.4}, z {:.4} m): {source}", position[0], position[1], position[2])]
    Arm {
        /// Arc length of the place, m.
        s: f64,
        /// Tool position there, m, in base.
        position: [f64; 3],
        /// What the arm says.
        source: KinematicsError,
    },
    /// The joints would have to jump to stay on the path.
    #[error("at s = {s:.6} m joint {} would jump by {jump:.4} rad to stay on the path: the inverse changes its branch there; start from another configuration, or move the path", joint + 1)]
    BranchChange {
        /// Arc length of the place, m.
        s: f64,
        /// The joint that jumps most, from 0.
        joint: usize,
        /// How far, rad.
        jump: f64,
        /// Where the joints would have gone on, rad.
        predicted: Vec<f64>,
    },
    /// A joint reaches the end of its range on the path.
    #[error("at s = {s:.6} m joint {} would have to go on to about {value:.4} rad, outside its range [{lower:.4}, {upper:.4}]: start from a configuration with more room, turn the tool about its axis, or move the path", joint + 1)]
    JointRange {
        /// Arc length of the place, m.
        s: f64,
        /// The joint, from 0.
        joint: usize,
        /// Where it would have to be, rad.
        value: f64,
        /// Lower end of its range, rad.
        lower: f64,
        /// Upper end of its range, rad.
        upper: f64,
    },
    /// No starting configuration can follow the whole path.
    #[error(
        "none of the {candidates} configurations that reach the start can follow the path to its end; the best one fails: {best}"
    )]
    NoConfiguration {
        /// How many configurations were tried.
        candidates: usize,
        /// Why the one that came farthest failed.
        best: Box<PlanError>,
    },
    /// A limit is not a finite number above 0.
    #[error("{what} is {value}, but has to be a finite number above 0")]
    Limit {
        /// Which limit.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A motion takes longer than can be verified.
    #[error(
        "the motion takes {duration:.3e} s, more than the {longest:.3e} s that are planned at this control period: raise the limits, lengthen the period, or split the path"
    )]
    TooLong {
        /// Duration, s.
        duration: f64,
        /// Longest duration that is taken at the control period, s.
        longest: f64,
    },
    /// The arm cannot stand at a place of a scheduled motion, or would have to jump there.
    #[error("at s = {s:.6} {} ({parameter}): {source}", parameter.unit())]
    OnPath {
        /// Value of the parameter.
        s: f64,
        /// What the parameter measures.
        parameter: ScheduleParameter,
        /// What the arm says.
        source: KinematicsError,
    },
    /// A limit of a joint is unusable.
    #[error("limits: {0}")]
    JointLimit(KinematicsError),
    /// Something that a schedule needs is not given.
    #[error("{needed} is needed for {purpose}: {remedy}")]
    Missing {
        /// What is missing.
        needed: &'static str,
        /// For what.
        purpose: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// The grid of a schedule is too coarse or too fine.
    #[error("{intervals} intervals: a schedule takes 4 to {most}; 200 to 2000 are usual")]
    Intervals {
        /// Intervals asked for.
        intervals: usize,
        /// The most that are taken.
        most: usize,
    },
    /// A path through joint way-points needs two of them.
    #[error("{count} way-points: a path needs two at least")]
    TooFewWaypoints {
        /// How many there are.
        count: usize,
    },
    /// A joint way-point cannot be used.
    #[error("way-point {} {problem}", index + 1)]
    Waypoint {
        /// Index of the way-point, from 0.
        index: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// The spline through joint way-points leaves the range of a joint.
    #[error("at s = {s:.6} rad, between way-points {} and {}, joint {} goes to {value:.4} rad, outside its range [{lower:.4}, {upper:.4}]: add a way-point there, or move the way-points", after + 1, after + 2, joint + 1)]
    SplineRange {
        /// Value of the parameter.
        s: f64,
        /// Index of the way-point before that place, from 0.
        after: usize,
        /// The joint, from 0.
        joint: usize,
        /// Where it would go, rad.
        value: f64,
        /// Lower end of its range, rad.
        lower: f64,
        /// Upper end of its range, rad.
        upper: f64,
    },
    /// The shape of the path cannot be used.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// No speed along the path keeps the limits at one place of it.
    #[error("{}", infeasible(*s, position, *row, *why, *value, *limit))]
    Infeasible {
        /// Arc length of the place, m.
        s: f64,
        /// Tool position there, m, in base.
        position: [f64; 3],
        /// The limit that is broken, and of which joint.
        row: RowSource,
        /// In which way.
        why: Infeasibility,
        /// The value that cannot be avoided, SI.
        value: f64,
        /// Its limit, SI.
        limit: f64,
    },
    /// The speed asked for at an end of the path cannot be had.
    #[error("{}", end_speed(*at_start, *speed, [*lowest, *highest], *row, *s, position))]
    EndSpeed {
        /// Whether it is the speed at the start.
        at_start: bool,
        /// The speed asked for, m/s.
        speed: f64,
        /// Lowest speed that can be had, m/s.
        lowest: f64,
        /// Highest speed that can be had, m/s.
        highest: f64,
        /// The limit that is in the way; none where it is how the rest of the path has to be run.
        row: Option<RowSource>,
        /// Arc length where the limit is met, m.
        s: f64,
        /// Tool position there, m, in base.
        position: [f64; 3],
    },
    /// A look-ahead window and a speed at the end of the path exclude each other.
    #[error(
        "an end speed of {speed} m/s needs the whole path in view, but a look-ahead window plans as if the path ended at rest at its end: leave out one of the two"
    )]
    WindowEndSpeed {
        /// The speed asked for at the end, m/s.
        speed: f64,
    },
    /// A section with a feed of its own is not a part of the path.
    #[error("feed section {}, {from} to {to} {unit}: {rule}", index + 1)]
    Section {
        /// Which one, from 0.
        index: usize,
        /// Where it begins.
        from: f64,
        /// Where it ends.
        to: f64,
        /// What the two are.
        unit: &'static str,
        /// The rule that is broken.
        rule: &'static str,
    },
    /// Two sections with feeds of their own overlap.
    #[error(
        "feed sections {} and {} overlap at s = {s:.6} m: let one end where the other begins",
        first + 1,
        second + 1
    )]
    SectionsOverlap {
        /// The one that begins first, from 0.
        first: usize,
        /// The other one, from 0.
        second: usize,
        /// Where the overlap begins, m.
        s: f64,
    },
    /// The speed along the path cannot be planned.
    #[error("speed along the path: {0}")]
    Feed(#[from] FeedError),
    /// The arm is close to singular on a stretch of the path, or changes its branch there.
    #[error("between s = {from:.6} and {to:.6} m: {trouble}; {rule}")]
    Singular {
        /// Where the stretch begins, m.
        from: f64,
        /// Where it ends, m.
        to: f64,
        /// What is wrong there, in words.
        trouble: String,
        /// Why that is not gone round, and what to do.
        rule: &'static str,
    },
    /// A motion in both spaces cannot be set up.
    #[error(transparent)]
    Hybrid(#[from] crate::hybrid::HybridError),
    /// The finished trajectory breaks a limit; it must not be executed.
    #[error("the finished trajectory breaks a limit and is withheld: {quantity} reaches {:.4} % of its limit at s = {s:.6} m, t = {t:.4} s; {cause}", 100.0 * ratio)]
    Unverified {
        /// Which limit, in words.
        quantity: String,
        /// Value over limit.
        ratio: f64,
        /// Where, m.
        s: f64,
        /// When, s.
        t: f64,
        /// What is special about the place.
        cause: Cause,
    },
}

/// In which way a limit cannot be kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Infeasibility {
    /// Holding still breaks it already.
    AtRest,
    /// It is broken at every speed at which this other limit is kept.
    Against(RowSource),
    /// The motion comes to rest there and cannot go on.
    Standstill,
}

/// What a person can change about a limit.
fn way_out(row: RowSource) -> &'static str {
    match row.quantity {
        RowQuantity::JointTorque => {
            "raise the torque limit, carry less, move the path to where the arm reaches out less, or start from another configuration"
        }
        RowQuantity::JointVelocity | RowQuantity::JointAcceleration | RowQuantity::JointJerk => {
            "raise the joint's limit, or move the path away from singular poses"
        }
        RowQuantity::Corner => "round the corner off, or let the tool stop there",
        _ => "raise that limit",
    }
}

fn unit(row: RowSource) -> &'static str {
    match row.quantity {
        RowQuantity::JointTorque => "N m",
        RowQuantity::JointVelocity | RowQuantity::AngularSpeed => "rad/s",
        RowQuantity::JointAcceleration => "rad/s^2",
        RowQuantity::JointJerk => "rad/s^3",
        RowQuantity::TangentialAcceleration | RowQuantity::NormalAcceleration => "m/s^2",
        RowQuantity::TangentialJerk | RowQuantity::NormalJerk => "m/s^3",
        _ => "m/s",
    }
}

fn infeasible(s: f64, at: &[f64; 3], row: RowSource, why: Infeasibility, value: f64, limit: f64) -> String {
    let place = format!("at s = {s:.6} m (tool at x {:.4}, y {:.4}, z {:.4} m)", at[0], at[1], at[2]);
    let (unit, way_out) = (unit(row), way_out(row));
    let (size, most) = (value.abs(), limit.abs());
    let over = format!("{:.4} {unit} over its limit of {most:.4} {unit}", size - most);
    match why {
        Infeasibility::AtRest => {
            format!("{place} holding still needs a {row} of {size:.4} {unit}, {over}: {way_out}")
        }
        Infeasibility::Against(other) => {
            format!(
                "{place} no speed keeps {row} together with {other}: the least is {size:.4} {unit}, {over}: {way_out}"
            )
        }
        Infeasibility::Standstill => format!("{place} {row} holds the motion at rest: {way_out}"),
    }
}

fn end_speed(
    at_start: bool,
    speed: f64,
    [lowest, highest]: [f64; 2],
    row: Option<RowSource>,
    s: f64,
    at: &[f64; 3],
) -> String {
    let end = if at_start { "start" } else { "end" };
    let because = match row.filter(|row| row.quantity != RowQuantity::Ahead) {
        Some(row) => row.to_string(),
        None if at_start => "what the path ahead leaves room for".to_owned(),
        None => "what the path before leaves room for".to_owned(),
    };
    format!(
        "{end} speed {speed} m/s cannot be had: {lowest:.6} to {highest:.6} m/s is possible, because of {because} at s = {s:.6} m \
         (tool at x {:.4}, y {:.4}, z {:.4} m): ask for a speed in between, or raise the limits there",
        at[0], at[1], at[2]
    )
}

impl PlanError {
    /// What a planner of the feedrate crate says, with the place on `path` it speaks of; `grid` are the arc lengths it
    /// planned on.
    pub(crate) fn explained(error: FeedError, path: &PosePath, grid: impl Fn(usize) -> f64) -> Self {
        let place = |s: f64| path.curve().point(s).into();
        match error {
            FeedError::StaticallyInfeasible { s, row, value, limit, .. } => {
                Self::Infeasible { s, position: place(s), row, why: Infeasibility::AtRest, value, limit }
            }
            FeedError::Infeasible { s, row, against, excess, limit, .. } => {
                let value = limit + excess.copysign(limit);
                Self::Infeasible { s, position: place(s), row, why: Infeasibility::Against(against), value, limit }
            }
            FeedError::Standstill { s, row, .. } => {
                let why = Infeasibility::Standstill;
                Self::Infeasible { s, position: place(s), row, why, value: 0.0, limit: 0.0 }
            }
            FeedError::SpeedOutOfReach { what, speed, lowest, highest, row, s } => {
                let at_start = what == "start speed";
                Self::EndSpeed { at_start, speed, lowest, highest, row: Some(row), s, position: place(s) }
            }
            FeedError::StartTooFast { speed, segment, highest_start, .. } => {
                let (s, highest) = (grid(segment), highest_start);
                Self::EndSpeed { at_start: true, speed, lowest: 0.0, highest, row: None, s, position: place(s) }
            }
            FeedError::EndTooFast { speed, highest } => {
                let s = path.length();
                Self::EndSpeed { at_start: false, speed, lowest: 0.0, highest, row: None, s, position: place(s) }
            }
            FeedError::WindowEndSpeed { speed } => Self::WindowEndSpeed { speed },
            // The scans check the speeds at the ends against the boxes there before anything else.
            FeedError::AboveLimit { what: "v_end", value: speed, limit: highest } => {
                let s = path.length();
                Self::EndSpeed { at_start: false, speed, lowest: 0.0, highest, row: None, s, position: place(s) }
            }
            error => Self::Feed(error),
        }
    }

    /// A joint that has used up its range shows as a jump to another turn or branch: says so, where the limits are known.
    pub(crate) fn within<const N: usize>(self, lower: &Joints<N>, upper: &Joints<N>) -> Self {
        if let Self::BranchChange { s, predicted, .. } = &self {
            for (joint, &value) in predicted.iter().enumerate() {
                if !(lower[joint]..=upper[joint]).contains(&value) {
                    return Self::JointRange { s: *s, joint, value, lower: lower[joint], upper: upper[joint] };
                }
            }
        }
        self
    }
}
