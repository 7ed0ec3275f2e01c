//! Jerk-limited motion under constant limits: the seven-phase S-profile and the change of speed from any state.

pub mod change;
pub(crate) mod closed_form;
pub mod phase;
pub(crate) mod phases;
pub mod profile;
pub mod solve;
