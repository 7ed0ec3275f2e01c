//! Synchronising by projection on the error: a target that may change in any cycle.

mod feasible_set;
mod joints;
mod line;
mod norm_limits;
mod pose;
mod recover;
mod transverse_brake;

pub use joints::{ProjectionStep, ProjectionSync};
pub use norm_limits::PoseLimits;
pub use pose::{PoseProjectionSync, PoseState, PoseStep};

/// Status of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProjectionStatus {
    /// The state is being brought inside the limits, acceleration to zero.
    Recovering,
    /// The velocity across the line to the target is being taken off.
    Turning,
    /// On the straight line to the target.
    Straight,
    /// At the target, at rest.
    Reached {
        /// Part of the last period that was not needed (s).
        unused: f64,
    },
}
