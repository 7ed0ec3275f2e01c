//! Paths of the joints by one parameter: what a motion follows.

mod configuration;
mod follow;
mod inverse;
mod jet;
mod joint_lines;
mod joint_spline;
mod known_joints;
mod locked;
mod motion_path;
mod passage;
mod pose_move;
mod tool_path;
mod way_points;

pub use follow::JointPath;
pub use jet::JointJet;
pub use joint_lines::JointLines;
pub use joint_spline::JointSpline;
pub(crate) use known_joints::KnownJoints;
pub use locked::LockedArm;
pub use motion_path::MotionPath;
pub use pose_move::PoseMove;
pub use tool_path::ToolPath;
