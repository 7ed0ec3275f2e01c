//! Files for ROS 2: trajectory_msgs/JointTrajectory as YAML and JSON, and a recording that Foxglove and `ros2 bag` read.

#[cfg(feature = "mcap")]
mod cdr;
mod joint_trajectory;
#[cfg(feature = "mcap")]
mod recording;

pub use joint_trajectory::{RosError, RosTrajectory};
#[cfg(feature = "mcap")]
pub use recording::RosRecording;
