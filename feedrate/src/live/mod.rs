//! Speed along a path that an operator may change in any cycle: feed, override, hold, resume, a
//! step back.

mod curve;
mod cycle;
mod feed;
mod final_stop;
mod follow;
mod sections;

pub use curve::VelocityLimitCurve;
pub use feed::{FeedOverride, LiveStatus, LiveStep};
pub use sections::{LiveSection, MAX_SECTIONS};
