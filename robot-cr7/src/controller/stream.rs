//! The seam between a session and a kind of controller.

use std::io;

use arcfeed_kinematics::Joints;
use thiserror::Error;

use super::arm_state::ArmState;
use super::channel::Channel;

/// What a session asks of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order<const N: usize = 6> {
    /// Say which errors are not cleared. Answered by [`Event::Errors`].
    AskErrors,
    /// Switch the drives on.
    Enable,
    /// Be at these positions a period after now.
    Setpoint {
        /// Positions, rad.
        q: Joints<N>,
        /// The time between two setpoints, s.
        period: f64,
    },
    /// Bring the arm to rest and forget all setpoints.
    Stop,
}

/// What comes back from a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<const N: usize = 6> {
    /// The state of the arm.
    State(ArmState<N>),
    /// The errors that are not cleared.
    Errors {
        /// Their number.
        count: usize,
        /// The first of them.
        first: i64,
    },
    /// An order is refused.
    Refused {
        /// Name of the order in the language of the controller.
        order: &'static str,
        /// The code that the controller gives as the reason.
        code: i32,
    },
}

/// A way to a controller that follows joint setpoints.
///
/// The clock is that of the stream, so that a simulated controller can be as fast as it likes.
pub trait JointStream<const N: usize = 6> {
    /// The time, s. It never goes back.
    fn now(&self) -> f64;

    /// Hands an order on.
    ///
    /// # Errors
    /// [`LinkError::AfterStop`] for a setpoint after a stop, else the fault of the link.
    fn send(&mut self, order: &Order<N>) -> Result<(), LinkError>;

    /// The next event; `None` if there is none until the time `until` (s).
    ///
    /// # Errors
    /// The fault of the link, or what cannot be read. A fault that lasts is told at the time `until`, so that those who ask again do not
    /// keep the processor busy.
    fn receive(&mut self, until: f64) -> Result<Option<Event<N>>, LinkError>;
}

/// Why nothing can be said to or heard from a controller.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The controller has closed a connection.
    #[error("the controller has closed the {0} connection: check that no other program is connected, and the network")]
    Closed(Channel),
    /// The operating system reports a fault.
    #[error(
        "the {channel} connection: {source}; check the address, the network and that the controller is in TCP/IP mode"
    )]
    Io {
        /// The connection.
        channel: Channel,
        /// The fault.
        source: io::Error,
    },
    /// The controller answers with something else than the protocol says.
    #[error(
        "the controller answers \"{0}\": check that it is in TCP/IP mode, and the version of its protocol (--dialect)"
    )]
    Unreadable(String),
    /// A number in the feedback is none.
    #[error("the feedback has a {value} as {what} of joint {}: the controller is not to be trusted", joint + 1)]
    NotANumber {
        /// The quantity.
        what: &'static str,
        /// The joint, from 0.
        joint: usize,
        /// The value.
        value: f64,
    },
    /// A setpoint was to be sent after a stop.
    #[error("no setpoint is sent after a stop: begin a new session")]
    AfterStop,
}
