//! Arbitrary inputs for every reader and every planner: [`TARGETS`], each fed bytes that belong to a seed.
//!
//! Readers get the sample files of the repository, mutated with regard to their structure: lines, words, numbers, pieces of other files.
//! Planners get bytes that [`Numbers`] turns into finite numbers. An input is accepted or refused; everything else is a defect:
//! a panic, a motion that jumps or exceeds a limit, more than the time or the memory of the target.
//!
//! The example `fuzz` runs them by the million in a process of their own; the test `fuzz` runs some of each, and all of `corpus/`.

mod corpus;
mod judge;
#[cfg(feature = "html")]
mod meshes;
mod mutation;
mod numbers;
mod planners;
mod readers;
mod target;
mod verdict;
mod watchdog;

pub use numbers::Numbers;
pub use target::{Found, Inputs, Judged, TARGETS, Target, target};
pub use verdict::Verdict;
pub use watchdog::{MOST_BYTES, Watchdog};
