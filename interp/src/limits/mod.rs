//! The limits of a motion.

mod all;
mod sections;
mod tool;
mod torque;

pub use all::Limits;
pub use sections::{Extent, FeedSection, Section};
pub(crate) use sections::{Feeds, resolve, snap};
pub use tool::ToolLimits;
pub use torque::TorqueLimits;
