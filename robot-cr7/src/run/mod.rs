//! Checked input becomes verified motion.

pub(crate) mod compare;
pub(crate) mod cr7;
pub(crate) mod dense_lines;
pub(crate) mod error;
pub(crate) mod limit_line;
pub(crate) mod limit_lines;
pub(crate) mod measure;
pub(crate) mod online_events;
pub(crate) mod online_run;
pub(crate) mod outline;
pub(crate) mod placed_path;
pub(crate) mod play;
pub(crate) mod pose_way;
pub(crate) mod programmed;
pub(crate) mod robot;
pub(crate) mod samples;
pub(crate) mod speed_task;
pub(crate) mod stage;
pub(crate) mod stand_in;
pub(crate) mod stream;
pub(crate) mod task;
pub(crate) mod tool_check;
pub(crate) mod tool_run;
pub(crate) mod trajectory_row;
pub(crate) mod verdict;
