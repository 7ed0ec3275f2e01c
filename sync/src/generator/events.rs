//! The events of a cycle.

use crate::joint_state::JointState;

/// The result of one cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<const N: usize> {
    /// The state to command at the end of this cycle.
    pub state: JointState<N>,
    /// The events.
    pub events: Events<N>,
}

/// The events of a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Events<const N: usize> {
    /// The last axis that was under way arrived in this cycle: every axis has been in its target.
    /// With [`Synchronisation::None`](crate::Synchronisation::None) axes that arrived in an earlier
    /// cycle with a velocity have gone on since.
    pub reached: bool,
    /// The axes that arrived in this cycle: each is in its target exactly, or past it where a route or a scale of time ends
    /// between two cycles and the target moves.
    pub arrived: [bool; N],
    /// Number of way-points of the route that were passed in this cycle. A point with a blend is passed
    /// where the blend ends.
    pub passed: usize,
    /// A new plan took effect.
    pub replanned: bool,
    /// Limits were set below the state of an axis: it is brought back inside, with its jerk
    /// limited, while this holds.
    pub outside_limits: bool,
    /// The axes that go on after their target and brake because their range ends.
    pub range_ends: [bool; N],
}

impl<const N: usize> Default for Events<N> {
    fn default() -> Self {
        Self {
            reached: false,
            arrived: [false; N],
            passed: 0,
            replanned: false,
            outside_limits: false,
            range_ends: [false; N],
        }
    }
}
