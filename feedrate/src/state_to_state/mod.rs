//! Time-optimal motion of one axis from any state to any state.
//!
//! Given the states `(p, v, a)` at both ends and limits on velocity, acceleration and jerk, each
//! sign on its own, the shortest motion between them is
//!
//! ```text
//! minimise T   subject to   p''' = j,  (p, v, a)(0) and (p, v, a)(T) given,
//!                           v_min <= v <= v_max,  a_min <= a <= a_max,  j_min <= j <= j_max.
//! ```
//!
//! Its jerk is at a bound, or zero while acceleration or velocity is at one, with seven phases at
//! most. The solution is exact: a closed form where both halves reach their acceleration limits or
//! the motion cruises, otherwise the root of one smooth function of one variable, by Newton's
//! method inside a bracket. Nothing here is compared with an absolute number, so that the result
//! scales exactly with powers of two in the units of length and time.
//!
//! Answers: the shortest motion ([`StateToState`]), the durations that are possible and a motion in
//! any of them ([`AxisProblem`], [`Durations`]; Liu et al. 2024, section 4.1, corrected), a
//! velocity or a standstill as soon as possible ([`StateToState::to_velocity`],
//! [`StateToState::stop`], [`StateToState::stop_within`]).
//!
//! * A start outside the limits is brought back with bounded jerk. An acceleration beyond its bound
//!   is taken back with the largest jerk first: nothing is inside earlier. A velocity above its
//!   bound (or bound to get there) is then either settled at a velocity inside without
//!   undershooting that, or braked as hard as possible until it is at the bound and continued in
//!   the shortest way from there; the shorter of the two is taken. With way enough to settle at the
//!   bound itself that is always done: to brake on would only dip below and come back. A
//!   third way can be shorter and inside sooner where the start has an acceleration or the target
//!   moves: braking hard for a while, then less. A search at 16 places of the hardest braking found
//!   one in 34 of 40000 random starts above the limit, the worst with 0.23 s instead of 111 s. From no
//!   acceleration to rest it found none in 300000.
//! * A target outside them, or one that cannot be entered without leaving them, is an error.
//! * Positions are not limited while planning; [`StateToState::check_within`] says where a motion
//!   leaves a range, and [`BoundedProblem`] finds the shortest motion that does not.
//!
//! # Source
//! Liu et al. 2024: online trajectory generation for robots in hybrid space (task and joint space),
//! section 4.1.

mod bounded;
mod brake_to_limits;
mod by_duration;
mod cruise;
mod displacement_function;
mod durations;
mod entry;
mod extremal;
mod leg;
mod mean;
mod phase_writer;
mod positions;
mod problem;
mod profile;
mod scale;
mod search;
mod shape;
mod solve;
mod touches;
mod velocity;

pub use bounded::BoundedProblem;
pub use durations::Durations;
pub use positions::PositionLimits;
pub use problem::AxisProblem;
pub use profile::{PositionRange, StateToState};
