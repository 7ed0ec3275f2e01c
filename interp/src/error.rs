//! What can stop a path from becoming a trajectory, and where.

use arcfeed_feedrate::FeedError;
use arcfeed_geometry::GeometryError;
use arcfeed_kinematics::{Joints, KinematicsError};
use thiserror::Error;

use crate::schedule::ScheduleParameter;

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
        "the motion takes {duration:.3e} s, more than the {longest:.3e} s that can be verified at this control period: raise the limits, lengthen the period, or split the path"
    )]
    TooLong {
        /// Duration, s.
        duration: f64,
        /// Longest duration that is verified at the control period, s.
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
    #[error("the finished trajectory breaks a limit and is withheld: {quantity} reaches {:.4} % of its limit at s = {s:.6} m, t = {t:.4} s; lower the feed or the accelerations, and please report the job", 100.0 * ratio)]
    Unverified {
        /// Which limit, in words.
        quantity: String,
        /// Value over limit.
        ratio: f64,
        /// Where, m.
        s: f64,
        /// When, s.
        t: f64,
    },
}

impl PlanError {
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
