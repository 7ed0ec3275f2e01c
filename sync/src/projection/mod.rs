//! Synchronising by projection on the error: a target that may change in any cycle.

mod balls;
mod fade;
mod joints;
mod line;
mod pose;
mod recover;
mod room;

pub use balls::PoseLimits;
pub use joints::{ProjectionStep, ProjectionSync};
pub use pose::{PoseProjectionSync, PoseState, PoseStep};

/// What the motion is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProjectionStatus {
    /// The state is being brought inside the limits, acceleration to zero.
    Recovering,
    /// Velocity across the line to the target is fading.
    Turning,
    /// On the straight line to the target.
    Straight,
    /// At the target, at rest.
    Reached {
        /// Part of the last period that was not needed (s).
        unused: f64,
    },
}
