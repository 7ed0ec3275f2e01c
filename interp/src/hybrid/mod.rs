//! Motion in both spaces: along a tool path, off it into joint space on an event, and back (Liu et al. 2024, section 5.3).
//!
//! | room | holds |
//! |---|---|
//! | `command` | what an operator or a cell controller says: [`Command`], [`Excursion`] |
//! | `state` | where the motion is: [`HybridState`], [`HybridStep`], [`HybridError`] |
//! | `joints` | the part in joint space |
//! | `motion` | [`HybridMotion`]: one step a cycle |
//!
//! ```text
//!             Leave                    at rest / first point        last point
//! TaskPath ----------> Leaving ----------> JointMove ----------> Waiting
//!    ^  | end of path                                                | Return
//!    |  +-----> Done       Stop, from anywhere ---> Stopping ---> Stopped
//!    +------------------------- Returning <--------------------------+
//! ```

mod command;
mod joints;
mod motion;
mod state;

pub(crate) use joints::axis_limits;

pub use command::{Command, Excursion, LeaveBy, MAX_POINTS};
pub use motion::HybridMotion;
pub use state::{HybridError, HybridState, HybridStep};
