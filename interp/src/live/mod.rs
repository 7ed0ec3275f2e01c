//! Motion in both spaces: along a path of the tool, off it into joint space on an event, and back (Liu et al. 2024, section 5.3).
//!
//! | file | holds |
//! |---|---|
//! | `live_path` | a path under a limit curve that holds whatever an operator does: [`LivePath`] |
//! | `singular` | intervals of a path near singular poses, and ways round: [`LiveRoute`] |
//! | `command` | what an operator or a cell controller says: [`Command`], [`Excursion`] |
//! | `state`, `error` | where the motion is: [`HybridState`], [`HybridStep`]; what is refused: [`HybridError`] |
//! | `joints` | the part in joint space |
//! | `motion` | [`HybridMotion`]: one step a cycle |
//! | `orders` | what a command means in each state of it |
//! | `live_tool` | poses of the tool as targets, straight through task space: [`LiveTool`] |
//! | `drive` | simulated drives behind their setpoints: [`DriveLag`] |
//!
//! ```text
//!             Leave                    at rest / first point        last point
//! TaskPath ----------> Leaving ----------> JointMove ----------> Waiting
//!    ^  | end of path                                                | Return
//!    |  +-----> Done       Stop, from anywhere ---> Stopping ---> Stopped
//!    +------------------------- Returning <--------------------------+
//! ```

mod command;
mod drive;
mod error;
mod joints;
mod live_path;
mod live_tool;
mod motion;
mod orders;
mod recorded;
mod singular;
mod state;

pub use command::{Command, Excursion, JointMoveBy, LeaveBy};
pub use drive::DriveLag;
pub use error::{HybridError, LiveError, MAX_POINTS};
pub use live_path::LivePath;
pub use live_tool::{LiveTool, LiveToolStep, MAX_CYCLES, ToolTargetError};
pub use motion::HybridMotion;
pub use singular::{Detour, LiveRoute, SingularInterval, SingularityKind, SingularityPolicy};
pub use state::{HybridState, HybridStep};
