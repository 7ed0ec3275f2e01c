//! The state of a hybrid motion.

use super::error::HybridError;
use crate::setpoint::Setpoint;

/// The state of the motion.
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

/// The result of one cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HybridStep<const N: usize = 6> {
    /// The setpoint at the end of the cycle. Off the path `s` is where it was left, and `acceleration` 0.
    pub setpoint: Setpoint<N>,
    /// The state of the motion.
    pub state: HybridState,
    /// True while the tool is on the path.
    pub on_path: bool,
    /// True while it was told to hold, and stands.
    pub holding: bool,
    /// Why the command of this cycle was not followed, or not to the letter. The motion goes on without it.
    pub refused: Option<HybridError>,
}
