//! Shape, speed and arm together: from a tool path to a verified, sampled joint trajectory.
#![forbid(unsafe_code)]

mod constraints;
mod error;
mod grid;
mod joint_path;
mod limits;
pub mod parameter;
mod planner;
mod sampler;
mod trajectory;
mod verify;

pub use constraints::Shares;
pub use error::PlanError;
pub use joint_path::{JointJet, JointPath, MIN_SINGULAR_VALUE, best_start, joint_jet};
pub use limits::{AXES, ToolLimits};
pub use planner::{Plan, Planner, Scan, Timings};
pub use sampler::Sampler;
pub use trajectory::Setpoint;
pub use verify::{Check, Quantity, Requirement, Verification, verify};
