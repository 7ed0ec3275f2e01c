//! Motions of several axes through way-points.
//!
//! A motion is determined by velocity and acceleration of each axis in each way-point: between them
//! every section is the exact shortest motion in common time ([`Trajectory`](crate::Trajectory)).
//! They come from a program in which every section consists of three parts with constant jerk, and
//! that an interior-point method solves for velocities, accelerations and durations of all axes at
//! once.
//!
//! Sections that have to be straight, and the blends between them, have closed forms of their own.

// Loops over the axes are written by index, so that several axes are computed at once.
#![allow(clippy::needless_range_loop)]

mod bounded;
mod distinct;
mod equations;
mod excess;
mod guess;
mod line_writer;
mod lines;
mod memory;
mod planner;
mod program;
mod route;
mod rows;
mod settle;
mod spline;
mod step;
mod sums;
mod trajectory;

pub use memory::RouteMemory;
pub use planner::WayPointPlanner;
pub use route::{Route, WayPoint};
pub use trajectory::{SectionKind, WayPointTrajectory};

/// Most way-points between start and target.
pub const MOST_WAY_POINTS: usize = 64;

/// One more for a stop before straight lines.
const SECTIONS: usize = MOST_WAY_POINTS + 2;
const NODES: usize = SECTIONS + 1;
