//! Speed along a path whose limits change, or whose segments arrive, while it runs; one axis that
//! follows a moving target.

mod plan;
mod scheduler;
#[cfg(feature = "std")]
mod stream;
mod tracker;
#[cfg(feature = "std")]
mod window;

pub use scheduler::{Adoption, FeedScheduler, FeedStatus, FeedStep};
#[cfg(feature = "std")]
pub use stream::{SegmentStream, StreamStatus, StreamStep};
pub use tracker::{TargetTracker, TrackStatus, TrackStep};
