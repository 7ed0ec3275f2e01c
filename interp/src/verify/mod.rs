//! The independent check of a motion.

mod check;
mod requirement;
mod sample;
mod tally;
mod verification;
mod worst;

pub use check::{Binding, Check, Verification};
pub use requirement::Requirement;
pub use verification::verify;
