//! Speed along a path given as a list of segments, each with its own limits.

mod ceiling;
pub(crate) mod continuous_acceleration;
pub(crate) mod fallback;
mod feasible_pairs;
pub(crate) mod forward_backward;
mod forward_pass;
pub(crate) mod interpolated;
pub(crate) mod on_problem;
mod pass;
pub(crate) mod per_segment;
pub(crate) mod reachability;
mod segment;
pub(crate) mod streamed;

pub use segment::{Segment, boundaries};
