//! The independent check of a motion.

mod check;
mod joint_check;
mod joints;
mod requirement;
mod sample;
mod tables;
mod tally;
mod verification;
mod worst;

pub(crate) use check::Excess;
pub use check::{Binding, Check, Verification};
pub use joint_check::JointCheck;
pub use joints::{JointRates, JointSample};
pub use requirement::Requirement;
pub(crate) use sample::Sample;
pub(crate) use tally::Tally;
pub use verification::verify;
