//! Errors, split by what a caller can do about them.

mod cause;
mod limit;
mod path;
mod plan;
mod speed;

pub use cause::Cause;
pub use limit::LimitError;
pub(crate) use limit::positive;
pub use path::PathError;
pub use plan::PlanError;
pub use speed::{Infeasibility, SpeedError};

pub use arcfeed_feedrate::PathEnd;
