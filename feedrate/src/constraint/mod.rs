//! Limits on joints and tool, each turned into rows along a path.
//!
//! A constraint states its limit once and answers for every use of it. It yields rows at every
//! place of the grid: at the grid points, in the middle between two, and (jerk) at both ends of
//! every interval, where the third derivatives of a spline jump; and it yields bounds that hold on
//! a whole interval ([`IntervalBound`](crate::IntervalBound)). [`crate::FeedProblem`] collects
//! them; nothing past that knows which constraint a row came from but by its
//! [`LimitId`](crate::LimitId).

mod interface;
mod joint;
mod path;
mod tool;
mod torque;

pub use interface::{PathConstraint, Place, RowSink, Within};
pub use joint::{JointAcceleration, JointJerk, JointVelocity};
pub use path::PathDerivatives;
pub use tool::{Feed, SpeedCap, Stop, TangentialAcceleration, TangentialJerk};
pub use torque::JointTorque;
