//! Errors in a path, with their place.

use arcfeed_geometry::GeometryError;
use arcfeed_kinematics::{Joints, KinematicsError, Posture};
use thiserror::Error;

use crate::place::PathPlace;

/// Why an arm cannot follow a path. The way out is another path or another configuration.
///
/// Joints count from 0 in the fields and from 1 in the texts.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PathError {
    /// The arm cannot stand at a place of the path: out of reach, outside joint limits, or singular.
    #[error("at {place}: {source}")]
    Arm {
        /// The place.
        place: PathPlace,
        /// The error of the arm.
        source: KinematicsError,
    },
    /// The joints would have to jump to stay on the path.
    #[error("at {place} joint {} would jump by {jump:.4} rad to stay on the path: the inverse changes its branch there; start from another configuration, or move the path", joint + 1)]
    BranchChange {
        /// The place.
        place: PathPlace,
        /// The joint that jumps most, from 0.
        joint: usize,
        /// The distance, rad.
        jump: f64,
        /// The joint values that continue the motion, rad.
        predicted: Vec<f64>,
    },
    /// A joint reaches the end of its range on the path.
    #[error("at {place} joint {} would have to go on to about {value:.4} rad, outside its range [{lower:.4}, {upper:.4}]: start from a configuration with more room, turn the tool about its axis, or move the path", joint + 1)]
    JointRange {
        /// The place.
        place: PathPlace,
        /// The joint, from 0.
        joint: usize,
        /// The value that the path asks for, rad.
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
        /// The number of configurations tried.
        candidates: usize,
        /// Why the one that came farthest failed.
        best: Box<PathError>,
    },
    /// No solution at the start of the path stands in the posture asked for.
    #[error("no solution at the start stands \"{wanted}\"{}", of_those(there))]
    NoPosture {
        /// The posture.
        wanted: Posture,
        /// Those of the solutions there; none for an arm whose solutions have no names.
        there: Vec<Posture>,
    },
    /// A path through joint way-points needs two of them.
    #[error("{count} way-points: a path needs two at least")]
    TooFewWaypoints {
        /// The number there are.
        count: usize,
    },
    /// A joint way-point cannot be used.
    #[error("way-point {} {problem}", index + 1)]
    Waypoint {
        /// Index of the way-point, from 0.
        index: usize,
        /// The fault.
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
        /// The value that it would reach, rad.
        value: f64,
        /// Lower end of its range, rad.
        lower: f64,
        /// Upper end of its range, rad.
        upper: f64,
    },
    /// The shape of the path cannot be used.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The arm is close to singular on an interval of the path, or changes its branch there.
    #[error("between s = {from:.6} and {to:.6} m: {trouble}; {rule}")]
    Singular {
        /// The start of the interval, m.
        from: f64,
        /// The end, m.
        to: f64,
        /// The fault there, in words.
        trouble: String,
        /// Why that is not gone round, and what to do.
        rule: &'static str,
    },
}

/// The postures to choose from, in words.
fn of_those(postures: &[Posture]) -> String {
    if postures.is_empty() {
        return ": the solutions of this arm have no names; start near given joints instead".to_owned();
    }
    let names: Vec<String> = postures.iter().map(|posture| format!("\"{posture}\"")).collect();
    format!(": choose one of {}", names.join(", "))
}

impl PathError {
    /// The place on the path at which the arm cannot follow, where it is one place; that of the best configuration where all fail.
    pub fn place(&self) -> Option<&PathPlace> {
        match self {
            Self::Arm { place, .. } | Self::BranchChange { place, .. } | Self::JointRange { place, .. } => Some(place),
            Self::NoConfiguration { best, .. } => best.place(),
            _ => None,
        }
    }

    /// A joint that has used up its range shows as a jump to another turn or branch: says so, where the limits are known.
    pub(crate) fn within<const N: usize>(self, lower: &Joints<N>, upper: &Joints<N>) -> Self {
        if let Self::BranchChange { place, predicted, .. } = &self {
            for (joint, &value) in predicted.iter().enumerate() {
                if !(lower[joint]..=upper[joint]).contains(&value) {
                    return Self::JointRange { place: *place, joint, value, lower: lower[joint], upper: upper[joint] };
                }
            }
        }
        self
    }
}
