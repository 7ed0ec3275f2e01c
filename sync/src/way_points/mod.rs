//! Motions of several axes through way-points.
//!
//! A motion is determined by velocity and acceleration of each axis in each way-point: between them
//! every section is the exact shortest motion in common time ([`Trajectory`](crate::Trajectory)).
//! They come from a program in which every section consists of three parts with constant jerk, and
//! that an interior-point method solves for velocities, accelerations and durations of all axes at
//! once.

// Loops over the axes are written by index, so that several axes are computed at once.
#![allow(clippy::needless_range_loop)]

mod bounded;
mod equations;
mod excess;
mod generator;
mod guess;
mod planner;
mod program;
mod route;
mod rows;
mod spline;
mod step;
mod sums;
mod trajectory;

pub use generator::{WayPointGenerator, WayPointStep};
pub use planner::WayPointPlanner;
pub use route::{Route, WayPoint};
pub use trajectory::WayPointTrajectory;

/// Most way-points between start and target.
pub const MOST_WAY_POINTS: usize = 64;

const SECTIONS: usize = MOST_WAY_POINTS + 1;
const NODES: usize = SECTIONS + 1;
