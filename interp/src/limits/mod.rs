//! What a motion has to keep.

mod all;
mod sections;
mod tool;
mod torque;

pub use all::Limits;
pub(crate) use sections::{Feeds, resolve, snap};
pub use sections::{Extent, FeedSection, Section};
pub use tool::ToolLimits;
pub use torque::TorqueLimits;
