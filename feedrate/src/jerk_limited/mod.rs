//! Third order: the fastest speed law under limits on velocity, acceleration, torque and jerk.
//!
//! # Formulation
//! The unknown is `x(s) = sdot^2`, a quadratic B-spline on the grid, so that `u = x' / 2` is
//! continuous and `w = u'` constant on every interval. The duration `integral of x^(-1/2) ds` is
//! minimised directly; it is convex. Rows on velocity, acceleration and torque are linear in the
//! coefficients of the spline. A jerk row
//!
//! ```text
//! |alpha w + beta u + gamma x| <= J x^(-1/2)
//! ```
//!
//! has a convex right side, whose tangent at the current iterate is below it: every step of the
//! interior-point method (module `interior_point`) stays inside the true bound, and no sequence of
//! convex programs is needed. The Newton matrix has two diagonals beside the main one.
//!
//! From and to rest the first and last interval have constant jerk, `x = (4.5 j s^2)^(2/3)`, which
//! no quadratic spline can follow; the spline continues their speed and acceleration. Where that
//! interval is longer than the acceleration takes to build up, it is split there (module `refine`).
//!
//! # Between the grid points
//! On an interval of a piecewise cubic path a joint's acceleration is a cubic in `s` and `|q'|^2 x`
//! a polynomial of degree six; their inner Bernstein coefficients are rows too (module
//! `barrier_problem`). Jerk is kept by margins that follow the iterate. At the end everything is
//! checked between the points in closed form, and what is left, of the order of 1e-5, is taken off
//! the speed (module `check`). On other paths (inverse kinematics, torque) the same holds for the
//! rows as interpolated through both ends and the middle of each interval.
//!
//! # Optimality
//! The multipliers of the rows bound the duration of all motions on the grid from below (modules
//! `relaxed` and `lower_bound`).
// Knots, values, coefficients and rows run in step.
#![allow(clippy::needless_range_loop, reason = "rows of several arrays are read side by side")]
mod band;
mod barrier_problem;
mod barrier_sides;
mod between;
mod check;
#[cfg(feature = "clarabel")]
pub(crate) mod conic;
mod derivatives;
mod drop_distant;
mod end_speed;
mod grid_cost;
mod interior_point;
mod lower_bound;
mod outcome;
mod parts;
mod passes;
mod planner;
mod polish;
mod refine;
mod relaxed;
mod side;
mod solution;
mod spline;
mod start;
mod windowed;

pub use lower_bound::LowerBound;
pub use planner::JerkLimited;
pub use solution::{JerkLimitedDraft, JerkLimitedPlan};
pub use windowed::{WindowedJerkLimited, WindowedPlan};
