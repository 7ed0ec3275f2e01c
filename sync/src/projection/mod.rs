//! Synchronising by projection on the error: a target that may change in any cycle (Liu et al. 2024, section 4.2, corrected).
//!
//! The paper lays a frame on the present error (its first axis along it, the others by Gram-Schmidt), plans each axis of that frame
//! on its own with projected limits (eq. 17), and turns the result back (eq. 18), every cycle anew. What it is after: the joints run
//! to the target on a straight line, motion across the line is taken off meanwhile, and a target may change at any
//! time. As printed it does not move, or blows up; corrected, it breaks the joint limits it is meant to keep (100 of 100 random starts,
//! acceleration up to 3.2 times its limit): boxes on the rotated axes do not fit into the box of the joints, and the frame is
//! singular where the error vanishes.
//!
//! [`ProjectionSync`] does the same with guarantees. When the target changes, velocity and acceleration are divided
//! once into their projection on the error and the rest. The rest needs no axes of its own: it brakes to a halt
//! joint by joint. What that leaves of every joint's limits bounds the one scalar along the line to the target (its limits are
//! projected as in eq. 17, corrected), which is planned time-optimally. Both are latched until the target changes again, so that nothing
//! is singular at the end. If a state cannot be divided within the limits, accelerations are taken off first.
//!
//! # When to prefer it
//! Against the time-optimal motion of the slowest joint alone, over 4000 random problems of six joints: from rest 1.000 (median) to 1.17
//! (worst) times as long, from random states of motion 1.05 to 1.39, from random states close to the target 1.09 to 1.67. The
//! time-optimal synchronised motion ([`Trajectory`](crate::Trajectory), [`OnlineGenerator`](crate::OnlineGenerator)) is on that
//! bound more often, but runs through joint space on curves that depend on the limits. Prefer the projection
//! where the path matters (a straight line in joint space, or of the tool) and where the target moves all the
//! time: a new target costs some 10 microseconds (a pose some 40) and keeps the part of the motion that already points there.
//!
//! # Orientation
//! Position and rotation of a tool ([`PoseProjectionSync`]) share one scalar. Where the paper adds quaternions (eq. 20), rotations are composed of exact
//! exponentials ([`so3`](crate::so3)), the error is taken on the shorter arc (eq. 19 lacks the factor and the choice of sign), and limits are
//! balls, so that the frame of the error, Gram-Schmidt's, does fit there. Products of angular rates (velocities that turn each other) are
//! part of the budget. A start with an angular acceleration across its velocity often has it taken off first, which takes at most
//! acceleration limit over jerk limit.

mod balls;
mod fade;
mod joints;
mod line;
mod pose;
mod recover;
mod room;

pub use balls::PoseLimits;
pub use joints::{ProjectionStep, ProjectionSync};
pub use pose::{PoseProjectionSync, PoseState, PoseStep};

/// What the motion is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProjectionStatus {
    /// The state is being brought inside the limits, acceleration to zero.
    Recovering,
    /// Velocity across the line to the target is fading.
    Turning,
    /// On the straight line to the target.
    Straight,
    /// At the target, at rest.
    Reached {
        /// Part of the last period that was not needed (s).
        unused: f64,
    },
}
