//! What a controller says about its arm.

use std::fmt::{self, Display, Formatter};

use arcfeed_kinematics::Joints;

/// What the arm does, as far as a session has to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArmMode {
    /// The drives are off.
    Disabled,
    /// The drives hold the arm, and nothing moves it.
    Idle,
    /// The arm follows commands.
    Running,
    /// An alarm is not cleared.
    Alarm,
    /// Anything else, in words. No motion is sent in it.
    Other(&'static str),
}

impl Display for ArmMode {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Disabled => "disabled",
            Self::Idle => "idle",
            Self::Running => "running",
            Self::Alarm => "in alarm",
            Self::Other(words) => words,
        })
    }
}

/// The arm at one time, as its controller states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmState<const N: usize = 6> {
    /// What it does.
    pub mode: ArmMode,
    /// True if the drives are on.
    pub enabled: bool,
    /// True if an alarm is not cleared.
    pub alarm: bool,
    /// The clock of the controller, ms. A state with the same clock as the one before says nothing new.
    pub clock_ms: u64,
    /// The number of the model of the arm; 0 where the controller does not say.
    pub model: u8,
    /// Actual positions, rad.
    pub q: Joints<N>,
    /// Actual velocities, rad/s.
    pub qd: Joints<N>,
    /// The positions that the controller asks of its drives, rad.
    pub q_target: Joints<N>,
}
