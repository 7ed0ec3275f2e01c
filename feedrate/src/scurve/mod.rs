//! Jerk-limited motion under constant limits: the seven-phase S-profile and the change of speed from any state.

pub mod change;
pub mod phases;
pub mod profile;
pub mod solve;
