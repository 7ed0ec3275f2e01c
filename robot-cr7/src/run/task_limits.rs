//! The limits that a task is planned within.

use arcfeed_interp::{FeedSection, JointTables, LimitError, ToolLimits};
use arcfeed_kinematics::{JointLimits, Joints};

use crate::input::job::TableJob;

/// All limits of a task.
#[derive(Debug, Clone)]
pub(crate) struct TaskLimits<const N: usize> {
    pub joints: JointLimits<N>,
    pub tool: ToolLimits,
    /// N m, where torque is limited.
    pub torque: Option<Joints<N>>,
    /// Limits of joints by speed or position.
    pub tables: JointTables<N>,
    /// Feeds of parts of the path.
    pub sections: Vec<FeedSection>,
}

/// The tables of a job for an arm of `N` joints.
pub(crate) fn tables_of<const N: usize>(tables: &[TableJob]) -> Result<JointTables<N>, LimitError> {
    let mut all = JointTables::new();
    for TableJob { joint, kind, table } in tables {
        let joints = joint.map_or(0..N, |joint| joint..joint + 1);
        for joint in joints {
            all = all.with(*kind, joint, table.clone())?;
        }
    }
    Ok(all)
}
