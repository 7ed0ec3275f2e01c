//! All limits of a motion in one value.

use arcfeed_kinematics::{Dynamics, JointLimits, Joints};

use super::table::JointTables;
use super::tool::ToolLimits;
use super::torque::TorqueLimits;
use crate::error::LimitError;

/// The limits of a motion: those of the joints, and where they are set those of the tool and of the drives.
///
/// ```
/// use arcfeed_interp::{Limits, ToolLimits};
/// use arcfeed_kinematics::{Joints, models};
///
/// let robot = models::description("ur5e").ok_or("built in")?.build::<6>()?;
/// let joints = robot.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
/// let (dynamics, torque) = (robot.dynamics().ok_or("known")?, robot.drive_limits().torque.ok_or("known")?);
/// let limits = Limits::new(joints).with_tool(ToolLimits::new().with_feed(0.1)?).with_torque(dynamics, torque)?;
/// assert_eq!(limits.tool().feed(), Some(0.1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Limits<'a, const N: usize = 6> {
    joints: JointLimits<N>,
    tool: ToolLimits,
    torque: Option<TorqueLimits<'a, N>>,
    tables: Option<&'a JointTables<N>>,
}

impl<'a, const N: usize> Limits<'a, N> {
    /// Limits of the joints alone.
    pub const fn new(joints: JointLimits<N>) -> Self {
        Self { joints, tool: ToolLimits::new(), torque: None, tables: None }
    }

    /// With limits of the tool.
    pub fn with_tool(self, tool: ToolLimits) -> Self {
        Self { tool, ..self }
    }

    /// With limits of the drives: at most `torque` (N m, either sign; infinite means no limit) of an arm with `dynamics`, payload and
    /// friction included.
    ///
    /// # Errors
    /// [`LimitError::Joint`] for a torque that is not above 0.
    pub fn with_torque(self, dynamics: &'a (dyn Dynamics<N> + Sync), torque: Joints<N>) -> Result<Self, LimitError> {
        Ok(Self { torque: Some(TorqueLimits::new(dynamics, torque)?), ..self })
    }

    /// With limits of the joints as tables, beside the constant ones: the least counts.
    pub fn with_tables(self, tables: &'a JointTables<N>) -> Self {
        Self { tables: Some(tables), ..self }
    }

    /// Limits of the joints.
    pub const fn joints(&self) -> &JointLimits<N> {
        &self.joints
    }

    /// Limits of the tool.
    pub const fn tool(&self) -> &ToolLimits {
        &self.tool
    }

    /// Limits of the drives.
    pub const fn torque(&self) -> Option<&TorqueLimits<'a, N>> {
        self.torque.as_ref()
    }

    /// Limits of the joints as tables.
    pub const fn tables(&self) -> Option<&'a JointTables<N>> {
        self.tables
    }
}
