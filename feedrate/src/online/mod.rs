//! Speed along a path whose limits change while it runs (Liu et al. 2024, section 3, corrected).
//!
//! [`FeedScheduler`] takes one scalar `s` to the end `S` of a path, to arrive there with a given speed and acceleration. Once a
//! cycle [`FeedScheduler::step`] yields the state; between two cycles every limit may change, a live override or a
//! hold (`v_max = 0`) included.
//!
//! # Where this departs from print
//! The paper chooses the jerk of every cycle by tests on the current state (eqs. 3 to 13), sums it up (eq. 2) and takes
//! off the error of the sum at the end. As printed this runs away; with eqs. 3 to 16 corrected it ends up to 0.040 mm
//! beside the end at a cycle of 1 ms, and the correction at the end is a jump. Here the same motion, largest jerk to the speed limit,
//! cruise, and the braking or accelerating polynomial to the end (eqs. 6 to 16), is one exact plan that is kept for as long as it is
//! valid and sampled once a cycle, so that
//!
//! * `s`, `v` and `a` at the end are exactly the ones asked for, whatever the cycle;
//! * jerk never leaves its bounds, not in the cycle in which a limit changes and not at the end;
//! * a limit lowered under the current state is returned to with bounded jerk, without passing the limit and coming back;
//! * the choice between braking and accelerating at the end (in print by `max(Sdec, Sacc)`, which can be imaginary) follows
//!   from the sign of the change of speed.

mod plan;
mod scheduler;

pub use scheduler::{Adoption, FeedScheduler, FeedStatus, FeedStep};
