//! Why a session ended before its time.

use thiserror::Error;

use super::arm_state::ArmMode;

/// The doubt that ended a session.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// The operator asked for it.
    #[error("interrupted")]
    Interrupted,
    /// The link does not work.
    #[error("{0}")]
    Link(String),
    /// No new state of the arm comes.
    #[error("no new state of the arm for {:.0} ms: check the network and the load of this computer", 1e3 * silence)]
    Silence {
        /// The time since the last new state, s.
        silence: f64,
    },
    /// A state is older than the one before.
    #[error("the clock of the controller went back by {back_ms} ms: what it says of the arm may be old; start it anew")]
    Clock {
        /// By how much, ms.
        back_ms: u64,
    },
    /// The controller does not answer an order.
    #[error("no answer to {order} within {:.1} s: check that no other program is connected", waited)]
    NoAnswer {
        /// The order.
        order: &'static str,
        /// The time waited, s.
        waited: f64,
    },
    /// The controller has errors that are not cleared.
    #[error(
        "the controller reports {count} errors, the first of them {first}: look them up, remove the cause and clear them on the pendant"
    )]
    Errors {
        /// Their number.
        count: usize,
        /// The first of them.
        first: i64,
    },
    /// The arm is in a mode in which it is not led.
    #[error("the arm is {mode}: it is led only when it is idle or runs for this program")]
    Mode {
        /// The mode.
        mode: ArmMode,
    },
    /// The drives are off.
    #[error("the drives are off: switch them on at the pendant, or let this program do so with --enable")]
    Disabled,
    /// The drives do not come on.
    #[error("the drives are not on {:.1} s after the order", waited)]
    NotEnabled {
        /// The time waited, s.
        waited: f64,
    },
    /// The arm is another model.
    #[error("the controller leads an arm of model {found}, and the motion is for {expected:?}: check the address")]
    Model {
        /// The number of the model.
        found: u8,
        /// The numbers of the models that the motion is for.
        expected: &'static [u8],
    },
    /// The arm stands elsewhere.
    #[error("joint {} is at {:.3} deg, and the motion starts at {:.3} deg: bring it there, or let this program do so with --approach", joint + 1, actual.to_degrees(), start.to_degrees())]
    Elsewhere {
        /// The joint, from 0.
        joint: usize,
        /// Its position, rad.
        actual: f64,
        /// The position at the start of the motion, rad.
        start: f64,
    },
    /// The arm moves before the motion begins.
    #[error("joint {} moves with {:.3} deg/s before the motion begins: wait until the arm rests", joint + 1, velocity.to_degrees())]
    Moving {
        /// The joint, from 0.
        joint: usize,
        /// Its velocity, rad/s.
        velocity: f64,
    },
    /// A setpoint could not be sent in time.
    #[error("setpoint {index} is {:.1} ms late{}: use a computer with less load, or a longer --period-ms", 1e3 * late, planned(*planning, *late))]
    Late {
        /// The setpoint, from 0.
        index: usize,
        /// How late it is, s.
        late: f64,
        /// The time that passed while it was planned, s.
        planning: f64,
    },
    /// A setpoint would exceed a limit.
    #[error("setpoint {index} is not sent: the {what} of joint {} up to it would be {value:.6}, beyond {limit:.6} (rad, s); this is an error of the planner, please report it", joint + 1)]
    Unsafe {
        /// The setpoint, from 0.
        index: usize,
        /// The quantity.
        what: &'static str,
        /// The joint, from 0.
        joint: usize,
        /// Its value, in rad and s.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// A scenario does not go on.
    #[error("{0}")]
    Scenario(String),
    /// The arm does not follow.
    #[error("joint {} is {:.2} deg off what was asked of it within the lag: look for an obstacle, payload and speed limits of the controller", joint + 1, off.to_degrees())]
    Following {
        /// The joint, from 0.
        joint: usize,
        /// The distance, rad.
        off: f64,
    },
    /// The controller refuses an order.
    #[error("the controller refuses {order} with code {code}{}", meaning(*code))]
    Refused {
        /// The order.
        order: &'static str,
        /// The code of the controller.
        code: i32,
    },
    /// The arm has not arrived.
    #[error("joint {} is {:.3} deg from the end of the motion {:.1} s after it", joint + 1, off.to_degrees(), waited)]
    NotArrived {
        /// The joint that is furthest, from 0.
        joint: usize,
        /// Its distance, rad.
        off: f64,
        /// The time waited, s.
        waited: f64,
    },
    /// The arm was at its end and was stopped, but it is not seen at rest.
    #[error("the motion is done, but the arm is not seen at rest {:.1} s after the stop: look at it", waited)]
    NotResting {
        /// The time waited, s.
        waited: f64,
    },
}

/// Names the planner where a setpoint is late because of it.
fn planned(planning: f64, late: f64) -> String {
    // Without its time the setpoint would have been in time.
    if planning >= late { format!(", and planning it took {:.1} ms", 1e3 * planning) } else { String::new() }
}

/// The meaning of the codes that the maker lists.
fn meaning(code: i32) -> &'static str {
    match code {
        -1 => ": it could not be carried out",
        -2 => ": the arm is in alarm",
        -3 => ": an emergency stop is pressed",
        -4 => ": the arm has no power",
        -5 | -7 => ": a script runs or is paused",
        -10000 => ": it does not know it; check --dialect",
        -49999..=-20000 => ": it does not take its arguments; check --dialect and --period-ms",
        _ => "",
    }
}
