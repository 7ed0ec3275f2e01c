//! Where a hybrid motion is, and what it refuses.

use arcfeed_feedrate::FeedError;
use arcfeed_sync::SyncError;
use thiserror::Error;

use crate::trajectory::Setpoint;

/// Where the motion is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum HybridState {
    /// On the tool path: moving, holding or stepping back.
    TaskPath,
    /// An event has come: braking on the path, or on the way from it to the first point.
    Leaving,
    /// In joint space, on the way to the point of this number, from 0.
    JointMove(usize),
    /// At the goal of the excursion, until told to return.
    Waiting,
    /// On the way back to where the path was left.
    Returning,
    /// On the way round a stretch of the path that the arm cannot follow.
    GoingRound,
    /// At the end of the path.
    Done,
    /// Told to stop, and braking.
    Stopping,
    /// Told to stop, and at rest.
    Stopped,
}

impl HybridState {
    /// Name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::TaskPath => "task path",
            Self::Leaving => "leaving",
            Self::JointMove(_) => "joint move",
            Self::Waiting => "waiting",
            Self::Returning => "returning",
            Self::GoingRound => "going round",
            Self::Done => "done",
            Self::Stopping => "stopping",
            Self::Stopped => "stopped",
        }
    }
}

/// What one cycle brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HybridStep<const N: usize = 6> {
    /// What to command at the end of the cycle. Off the path `s` is where it was left, and `acceleration` 0.
    pub setpoint: Setpoint<N>,
    /// Where the motion is.
    pub state: HybridState,
    /// Whether the tool is on the path.
    pub on_path: bool,
    /// Whether it was told to hold, and stands.
    pub holding: bool,
    /// Why the command of this cycle was not followed, or not to the letter. The motion goes on without it.
    pub refused: Option<HybridError>,
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
        /// When it is possible.
        rule: &'static str,
    },
    /// An excursion has no point, or too many.
    #[error("an excursion has {count} points; give 1 to {}", super::MAX_POINTS)]
    Points {
        /// How many were given.
        count: usize,
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
        /// Where it would get, rad.
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
