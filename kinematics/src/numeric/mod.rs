//! Inverse kinematics of any arm by damped least squares.
//!
//! Each step solves `min |J dq - e|^2 + mu |dq|^2` for the pose error e with damping mu = |e|^2 / 2
//! (Sugihara 2011, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method"):
//! far from the target and at singular poses it cannot blow up, near the target it becomes Newton's
//! method. A joint at a limit that the step would push outwards is taken out and the step solved
//! again, so that the others make up for it.
//!
//! The tolerances say when a target counts as reached. From there on the steps continue until
//! rounding ends them: Newton's method needs one or two, and solutions along a path are then as
//! smooth as those of a closed form.

mod arm;
mod descent;
mod search;

pub(crate) use arm::size;
pub use arm::{NullSpace, NumericArm, NumericSettings};
pub use search::NumericSolution;
