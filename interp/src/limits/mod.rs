//! The limits of a motion.

mod all;
mod sections;
mod table;
mod tool;
mod torque;

pub use all::Limits;
pub use sections::{Extent, FeedSection, Section};
pub(crate) use sections::{Feeds, resolve, snap};
pub use table::{JointTables, LimitTable, PayloadTable, TableKind};
pub use tool::ToolLimits;
pub use torque::TorqueLimits;
