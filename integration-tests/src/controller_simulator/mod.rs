//! A simulated controller of a Dobot CR: what the manuals of its protocol say, and an arm that lags behind.
//!
//! It shares no code with the sender: packets, commands and replies are written here from the maker's manuals, and a client of others
//! (`controller/independent_client.py`) checks them. How the arm follows setpoints is made up, as the maker does not publish it:
//!
//! * Setpoints are played two periods after they come, on straight lines, which a mean over one period rounds off. A stream whose
//!   second differences keep an acceleration limit moves the arm within it.
//! * Each drive follows with a lag of first order.
//! * Where setpoints stay out while the arm moves, or one of them asks for more acceleration than the arm has, it brakes within its limits
//!   and raises an alarm. `Stop` brakes it in the same way.

mod arm;
mod case;
mod command;
mod controller;
mod disturbance;
mod in_process;
mod judge;
mod live_case;
mod over_tcp;
mod packet;
mod play;

pub use arm::{ArmLimits, Excess, SimulatedArm};
pub use case::{Case, cr7_limits, long_motion, random_motion};
pub use controller::{Record, SimulatedController, Version};
pub use disturbance::Disturbance;
pub use in_process::InProcess;
pub use judge::Judged;
pub use live_case::{Operator, SCENARIOS, on_stage};
pub use over_tcp::{Served, serve};
