//! Errors of a live motion.

use arcfeed_feedrate::FeedError;
use arcfeed_sync::SyncError;
use thiserror::Error;

use crate::error::{LimitError, PathError, PlanError, SpeedError};

/// At most so many points on the way of an excursion: no cycle allocates.
pub const MAX_POINTS: usize = 8;

/// Why a path cannot be made ready for a live motion, or a live motion cannot begin.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LiveError {
    /// The path cannot be run under the limits.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The part in joint space cannot be set up.
    #[error(transparent)]
    Hybrid(#[from] HybridError),
}

impl From<PathError> for LiveError {
    fn from(error: PathError) -> Self {
        Self::Plan(error.into())
    }
}

impl From<LimitError> for LiveError {
    fn from(error: LimitError) -> Self {
        Self::Plan(error.into())
    }
}

impl From<SpeedError> for LiveError {
    fn from(error: SpeedError) -> Self {
        Self::Plan(error.into())
    }
}

/// Why a command was not followed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum HybridError {
    /// The command does not belong to the present state.
    #[error("{command} is not possible in the state \"{state}\": {rule}")]
    NotNow {
        /// The command.
        command: &'static str,
        /// The state, in words.
        state: &'static str,
        /// The condition under which it is possible.
        rule: &'static str,
    },
    /// An excursion has no point, or too many.
    #[error("an excursion has {count} points; give 1 to {}", MAX_POINTS)]
    Points {
        /// The number given.
        count: usize,
    },
    /// The distance at which points are passed is no distance.
    #[error("points are to be passed within {value} rad: give a finite number of 0 or more")]
    Within {
        /// The number given, rad.
        value: f64,
    },
    /// A point is outside the range of a joint.
    #[error(
        "point {} of the excursion has joint {} at {value} rad, outside its range [{lower}, {upper}]: choose a point inside", point + 1, joint + 1
    )]
    OutsideRange {
        /// The point, from 0.
        point: usize,
        /// The joint, from 0.
        joint: usize,
        /// Its value, rad.
        value: f64,
        /// Lower end of its range, rad.
        lower: f64,
        /// Upper end, rad.
        upper: f64,
    },
    /// Leaving at once would carry a joint past the end of its range: the motion brakes on the path first.
    #[error("leaving at once would carry joint {} to {value} rad, past the end of its range at {limit}: it brakes on the path first", joint + 1)]
    BrakesFirst {
        /// The joint, from 0.
        joint: usize,
        /// The value that it would reach, rad.
        value: f64,
        /// The end of its range, rad.
        limit: f64,
    },
    /// A number of the command breaks a rule.
    #[error(transparent)]
    Feed(#[from] FeedError),
    /// A joint move cannot be planned.
    #[error(transparent)]
    Joints(#[from] SyncError),
}
