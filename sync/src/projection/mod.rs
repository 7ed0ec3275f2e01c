//! Synchronising by projection on the error: a target that may change in any cycle.

mod feasible_set;
mod joints;
mod line;
mod norm_limits;
mod pose;
mod recover;
mod status;
mod transverse_brake;

pub use joints::{ProjectionStep, ProjectionSync};
pub use norm_limits::PoseLimits;
pub use pose::{PoseProjectionSync, PoseState, PoseStep};
pub use status::ProjectionStatus;
