//! Jerk-limited motion under constant limits: the seven-phase S-profile and the change of speed
//! from any state.

pub(crate) mod change;
pub(crate) mod closed_form;
pub(crate) mod phase;
pub(crate) mod phases;
pub(crate) mod profile;
pub(crate) mod solve;
