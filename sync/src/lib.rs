//! Several axes moving together.
//!
//! [`Trajectory::rest_to_rest`] moves `N` axes from rest to rest on an exactly straight line in
//! joint space, as fast as the limits of each axis on velocity, acceleration and jerk allow. All
//! axes start and stop together.
//!
//! [`ProjectionSync`] takes them, and [`PoseProjectionSync`] a tool, from any state of motion to
//! rest at a target that may change in any cycle, on a straight line as soon as the state permits.
//!
//! [`Trajectory`] moves them from any state of motion to any other: together in the shortest common
//! time, each on its own, or on a straight line ([`Synchronisation`]). [`OnlineGenerator`] does so
//! cycle by cycle, while targets, limits and routes change.
//!
//! [`WayPointPlanner`] moves them through way-points without stopping, from any state to any other.
//!
//! [`TrackingGenerator`] follows a moving target with all axes.
//!
//! [`NormLimits`] bounds speed and acceleration of a point whose coordinates are axes.
//!
//! Positions are in radians and times in seconds; prismatic axes in metres work just as well, axis
//! by axis.
//!
//! Without the feature `std`, which is on by default, the crate needs neither standard library nor
//! heap, and everything is there all the same.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

// Without the standard library `std::` is what `core` has of it.
#[cfg(not(feature = "std"))]
extern crate core as std;

mod bounded;
mod error;
mod generator;
mod joint_state;
mod limits;
mod mode;
mod norm;
mod projection;
mod sampler;
pub mod so3;
mod state_to_state;
mod straight;
mod tracking;
mod way_points;

pub use arcfeed_feedrate as feedrate;
pub use error::SyncError;
pub use generator::{Events, OnlineGenerator, Step};
pub use joint_state::JointState;
pub use limits::symmetric_limits;
pub use mode::{MotionOptions, Synchronisation};
pub use nalgebra;
pub use norm::NormLimits;
pub use projection::{
    PoseLimits, PoseProjectionSync, PoseState, PoseStep, ProjectionStatus, ProjectionStep, ProjectionSync,
};
pub use sampler::Sampler;
pub use state_to_state::Trajectory;
pub use tracking::{TrackingGenerator, TrackingStep};
pub use way_points::{MOST_WAY_POINTS, Route, RouteMemory, SectionKind, WayPoint, WayPointPlanner, WayPointTrajectory};
