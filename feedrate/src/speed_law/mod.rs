//! The motion law of a path, `s(t)`: the result of every planner.

mod builder;
mod constructors;
mod cursor;
mod law;
mod piece;

pub(crate) use builder::Builder;
pub use cursor::Cursor;
pub use law::SpeedLaw;
