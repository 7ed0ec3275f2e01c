//! Verified motions on a real controller: orders out, states back, and a stop on any doubt.
//!
//! A [`Session`] decides what is sent and when. It is a state machine that reads no clock: events and times are handed in, so that an
//! hour of motion can be tried in seconds. Its setpoints come from a [`SetpointSource`]: a [`VerifiedMotion`], or [`LiveSetpoints`] of a
//! scenario that is planned while the arm moves. Each is held against the limits before it is sent. A [`JointStream`] carries its
//! orders to one kind of controller. [`DobotLink`] is the one for the CR series of Dobot, which speaks one of two [`Dialect`]s over a
//! [`Wire`]; [`TcpWire`] is the wire of the real controller. [`drive`] joins session and stream.

mod arm_state;
mod channel;
mod deadlines;
mod dialect;
mod drive;
mod fault;
mod feedback;
mod guard;
mod lead_in;
mod link;
mod live;
mod live_record;
mod log;
mod outcome;
mod recent;
mod reply;
mod session;
#[cfg(test)]
mod session_tests;
mod setpoints;
mod settings;
mod stream;
mod tcp;
mod verified_motion;

pub use arm_state::{ArmMode, ArmState};
pub use channel::Channel;
pub use deadlines::Deadlines;
pub use dialect::Dialect;
pub use drive::{Survey, drive, survey};
pub use fault::Fault;
pub use feedback::{FEEDBACK_BYTES, FEEDBACK_PERIOD, FeedbackReader, decode_feedback};
pub use lead_in::lead_in;
pub use link::{DobotLink, Wire};
pub use live::LiveSetpoints;
pub use log::{SendLog, SendRow};
pub use outcome::Outcome;
pub use reply::{CommandName, Reply, ReplyReader};
pub use session::Session;
pub use setpoints::{NextSetpoint, SetpointSource};
pub use settings::{SendSettings, SettingsError};
pub use stream::{Event, JointStream, LinkError, Order};
pub use tcp::{Ports, TcpWire};
pub use verified_motion::{NotSendable, VerifiedMotion};
