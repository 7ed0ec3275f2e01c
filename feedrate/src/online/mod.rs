//! Speed along a path whose limits change while it runs.

mod plan;
mod scheduler;

pub use scheduler::{Adoption, FeedScheduler, FeedStatus, FeedStep};
