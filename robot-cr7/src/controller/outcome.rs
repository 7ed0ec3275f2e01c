//! What became of a session.

use std::fmt::{self, Display, Formatter};

use super::deadlines::Deadlines;
use super::fault::Fault;

/// What became of a session. As text it says how the motion ended and what is known of the arm.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outcome {
    /// The doubt that ended it; `None` if the arm is at the end of the motion, or where an order has stopped the motion.
    pub fault: Option<Fault>,
    /// True if an order has stopped the motion on the way, within the limits.
    pub stopped_by_order: bool,
    /// Number of setpoints sent.
    pub sent: usize,
    /// Number of setpoints of the motion, as far as it was known before it began.
    pub setpoints: usize,
    /// When they were sent.
    pub deadlines: Deadlines,
    /// True if the drives were switched on or a setpoint was sent.
    pub touched: bool,
    /// The time at which the first stop was sent, s; `None` if the arm was not touched or the link was down.
    pub stopped_at: Option<f64>,
    /// The time from which on the arm was seen at rest after it, s; `None` if that is not known.
    pub rests_at: Option<f64>,
    /// The largest following error: joint from 0, rad.
    pub off: (usize, f64),
}

impl Outcome {
    /// How the motion ended.
    pub fn end(&self) -> String {
        match &self.fault {
            Some(fault) => fault.to_string(),
            None if self.stopped_by_order => "the motion was stopped by order, and is not at its end".to_owned(),
            None => "the motion is done".to_owned(),
        }
    }

    /// What is known of the arm at the end.
    pub fn arm(&self) -> String {
        match (self.stopped_at, self.rests_at) {
            (Some(stop), Some(rest)) => {
                format!("the stop was sent, and the arm rests {:.0} ms later", 1e3 * (rest - stop).max(0.0))
            }
            (Some(_), None) => "the stop was sent, BUT THE ARM WAS NOT SEEN AT REST: look at it".to_owned(),
            (None, _) if self.touched => {
                "THE STOP COULD NOT BE SENT: look at the arm, and stop it by its own switch".to_owned()
            }
            (None, _) => "the arm was not touched, and no stop was sent".to_owned(),
        }
    }
}

impl Display for Outcome {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let begin = if self.fault.is_some() { "the motion was ended: " } else { "" };
        write!(f, "{begin}{}; {}", self.end(), self.arm())
    }
}
