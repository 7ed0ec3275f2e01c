//! Time-optimal motion of one axis from any state to any state.
//!
//! Given the states `(p, v, a)` at both ends and limits on velocity, acceleration and jerk, each sign on its own, the
//! shortest motion between them is
//!
//! ```text
//! minimise T   subject to   p''' = j,  (p, v, a)(0) and (p, v, a)(T) given,
//!                           v_min <= v <= v_max,  a_min <= a <= a_max,  j_min <= j <= j_max.
//! ```
//!
//! Its jerk is at a bound, or zero while acceleration or velocity is at one, with seven phases at most. The solution is
//! exact: a closed form where both halves reach their acceleration limits or the motion cruises, otherwise the root of one smooth
//! function of one variable, by Newton's method inside a bracket. Nothing here is compared with an absolute number, so
//! that the result scales exactly with powers of two in the units of length and time.
//!
//! * A start outside the limits is brought back by the shortest jerk-limited way that does not dip below the limit and return.
//! * A target outside them, or one that cannot be entered without leaving them, is an error.

mod by_duration;
mod cruise;
mod durations;
mod error;
mod extremal;
mod family;
mod limits;
mod outside;
mod problem;
mod profile;
mod scale;
mod solve;
mod velocity;
mod writer;

pub use durations::Durations;
pub use error::StateToStateError;
pub use limits::{AxisLimits, AxisState};
pub use problem::AxisProblem;
pub use profile::{PositionRange, StateToState};
