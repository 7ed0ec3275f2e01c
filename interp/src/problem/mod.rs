//! A path with its limits on a grid: what planners of speed take.

mod bounds;
mod concave;
mod fractions;
mod grid;
mod joint_tables;
mod jumps;
mod needs;
mod path_grid;
mod path_problem;
mod resolution;
mod rows;
mod settings;
mod tool_speed;
mod tool_vector;
mod torque;

pub(crate) use fractions::LimitFractions;
pub use needs::RowsNeeded;
pub(crate) use path_grid::PathGrid;
pub use path_problem::PathProblem;
pub(crate) use path_problem::{Held, suits};
pub(crate) use resolution::{parts_by_cost, resolved};
pub(crate) use settings::{MOST_INTERVALS, Settings};
