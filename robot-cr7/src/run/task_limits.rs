//! The limits that a task is planned within.

use arcfeed_interp::{FeedSection, ToolLimits};
use arcfeed_kinematics::{JointLimits, Joints};

/// All limits of a task.
#[derive(Debug, Clone)]
pub(crate) struct TaskLimits<const N: usize> {
    pub joints: JointLimits<N>,
    pub tool: ToolLimits,
    /// N m, where torque is limited.
    pub torque: Option<Joints<N>>,
    /// Feeds of parts of the path.
    pub sections: Vec<FeedSection>,
}
