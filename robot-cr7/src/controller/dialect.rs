//! The two versions of the text protocol of Dobot's controllers for six joints.
//!
//! Facts from the maker's manuals "TCP/IP remote control interface" for version 3 (controllers 3.5.5 and later) and version 4
//! (4.6.0 and later). Angles are degrees there.

use std::fmt::{self, Display, Formatter, Write};

use super::arm_state::ArmMode;
use super::channel::Channel;
use super::stream::Order;

/// A version of the protocol.
///
/// ```
/// use robot_cr7::controller::{Channel, Dialect, Order};
/// let mut text = String::new();
/// let channel = Dialect::V4.write(&Order::Stop, &mut text);
/// assert_eq!((channel, text.as_str()), (Channel::Dashboard, "Stop()"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// Version 3: setpoints go to the motion port and are not answered; `ResetRobot()` stops.
    V3,
    /// Version 4: all commands go to the dashboard port and are answered; `Stop()` stops.
    V4,
}

impl Dialect {
    /// The connections that it takes.
    pub fn channels(self) -> &'static [Channel] {
        match self {
            Self::V3 => &[Channel::Dashboard, Channel::Motion, Channel::Feedback],
            Self::V4 => &[Channel::Dashboard, Channel::Feedback],
        }
    }

    /// The least time between two setpoints that the maker states, s.
    pub fn least_period(self) -> f64 {
        match self {
            Self::V3 => 0.02,
            Self::V4 => 0.004,
        }
    }

    /// Appends an order in the words of this version, and says where it goes. A command ends with its bracket.
    pub fn write(self, order: &Order<6>, text: &mut String) -> Channel {
        match order {
            Order::AskErrors => text.push_str("GetErrorID()"),
            Order::Enable => text.push_str("EnableRobot()"),
            Order::Stop => text.push_str(match self {
                Self::V3 => "ResetRobot()",
                Self::V4 => "Stop()",
            }),
            Order::Setpoint { q, period } => {
                text.push_str("ServoJ(");
                for q in q.iter() {
                    // Writing to a string does not fail.
                    let _ = write!(text, "{:.6},", q.to_degrees());
                }
                let _ = write!(text, "t={period:.3})");
                return if self == Self::V3 { Channel::Motion } else { Channel::Dashboard };
            }
        }
        Channel::Dashboard
    }

    /// The mode of a number in the feedback.
    pub fn mode(self, number: u64) -> ArmMode {
        match (number, self) {
            (1, _) => ArmMode::Other("starting up"),
            (2, _) => ArmMode::Other("without a brake on some joint"),
            (3, _) => ArmMode::Other("without power"),
            (4, _) => ArmMode::Disabled,
            (5, _) => ArmMode::Idle,
            (6, _) => ArmMode::Other("dragged by hand"),
            (7, _) => ArmMode::Running,
            (8, Self::V3) => ArmMode::Other("recording a trajectory"),
            (8, Self::V4) => ArmMode::Other("in a single move"),
            (9, _) => ArmMode::Alarm,
            (10, _) => ArmMode::Other("paused"),
            (11, Self::V3) => ArmMode::Other("jogging"),
            (11, Self::V4) => ArmMode::Other("stopped by a collision"),
            _ => ArmMode::Other("in a mode that the manual does not list"),
        }
    }
}

impl Display for Dialect {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::V3 => "version 3",
            Self::V4 => "version 4",
        })
    }
}

#[cfg(test)]
mod tests {
    use arcfeed_kinematics::Joints;

    use super::*;

    #[test]
    fn setpoints_are_degrees_and_go_where_the_version_says() {
        let q = Joints::<6>::from([0.0, -0.5, 1.0, std::f64::consts::FRAC_PI_2, -1e-9, 3.0]);
        let mut text = String::new();
        let channel = Dialect::V4.write(&Order::Setpoint { q, period: 0.03 }, &mut text);
        let expected = "ServoJ(0.000000,-28.647890,57.295780,90.000000,-0.000000,171.887339,t=0.030)";
        assert_eq!((channel, text.as_str()), (Channel::Dashboard, expected));
        text.clear();
        let channel = Dialect::V3.write(&Order::Setpoint { q, period: 0.03 }, &mut text);
        assert_eq!((channel, text.as_str()), (Channel::Motion, expected));
    }

    #[test]
    fn every_other_order_goes_to_the_dashboard() {
        let orders: [(Order<6>, [&str; 2]); 3] = [
            (Order::AskErrors, ["GetErrorID()"; 2]),
            (Order::Enable, ["EnableRobot()"; 2]),
            (Order::Stop, ["ResetRobot()", "Stop()"]),
        ];
        for (order, words) in orders {
            for (dialect, words) in [Dialect::V3, Dialect::V4].into_iter().zip(words) {
                let mut text = String::new();
                assert_eq!((dialect.write(&order, &mut text), text.as_str()), (Channel::Dashboard, words));
            }
        }
    }
}
