//! Closed-form inverse kinematics.

mod parallel_axis;
mod solutions;

pub(crate) use parallel_axis::ParallelAxisSolver;
pub use solutions::Solutions;
