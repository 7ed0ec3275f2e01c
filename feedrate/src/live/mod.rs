//! Speed along a path that an operator may change in any cycle: feed, override, hold, resume, a step back.
//!
//! # The idea
//! A [`VelocityLimitCurve`] is a limit curve `V(s)` to which every limit of the path holds **whatever the motion does** within constant bounds
//! `|a| <= A` and `|j| <= J`: who builds it puts the worst case of both into `V`. From it the fastest law `n(s)` is planned once. Then
//!
//! > from any state with `v <= n(s)` and `a <= n'(s)` braking as hard as `A` and `J` allow stays under `n` until it stands.
//!
//! *Proof.* With `y = v^2 / 2`: `dy/ds = a` and `da/ds = j / v`. While braking builds up, `da/ds = -J / v <= -J / v_n <= da_n/ds`, as
//! `v <= v_n`; so `a <= a_n` stays true, and with it `v <= v_n`. At `a = -A <= a_n` the same. While it is released, `v = a^2 / (2 J)`; if
//! `n` came down to that state with less acceleration it could not stand still without running backwards, which it does not. ∎
//!
//! So each cycle of a [`FeedOverride`] may do what the operator asks, if from the state that this leads to a braking is known that gets
//! under `n`; else it does a little less, and braking itself is always possible. Nothing is planned anew while the motion runs, and a cycle takes
//! a bounded number of operations.

mod curve;
mod cycle;
mod feed;
mod follow;
mod landing;
mod sections;

pub use curve::VelocityLimitCurve;
pub use feed::{FeedOverride, LiveStatus, LiveStep};
pub use sections::{LiveSection, MAX_SECTIONS};
