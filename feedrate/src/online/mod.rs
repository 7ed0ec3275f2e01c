//! Speed along a path whose limits change, or whose segments arrive, while it runs.

mod plan;
mod scheduler;
mod stream;
mod window;

pub use scheduler::{Adoption, FeedScheduler, FeedStatus, FeedStep};
pub use stream::{SegmentStream, StreamStatus, StreamStep};
