//! The input of a speed planner: a grid on the path, rows at its points, caps on the speed, speeds
//! at both ends.

mod bound_table;
mod error_place;
mod feed_problem;
mod inside;
mod intervals;
mod lowered;
mod part;
mod row_table;
mod thinned;

pub use feed_problem::{FeedPlanner, FeedProblem};
pub(crate) use inside::{InnerRow, inner_row, matching, quadratic};
pub use intervals::{LimitPartition, live_speed};
