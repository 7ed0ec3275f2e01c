//! Jerk-limited motion on one scalar: S-curves and speed along a path.
#![forbid(unsafe_code)]

pub mod caps;
pub mod error;
pub mod limits;
pub mod plan;
pub mod scan;
pub mod scurve;
pub mod state;

pub use error::FeedError;
pub use limits::MotionLimits;
pub use plan::{Cursor, SpeedPlan};
pub use scan::joined::plan_joined;
pub use scan::segment::{boundary_speeds, plan_per_segment, plan_windowed};
pub use scan::{Segment, boundaries};
pub use scurve::change::SpeedChange;
pub use scurve::phases::Phase;
pub use scurve::profile::{Adjust, Adjusted, SProfile};
pub use scurve::solve::{distance_for_change, highest_speed_over, lowest_speed_over};
pub use state::{MotionLaw, MotionState};
