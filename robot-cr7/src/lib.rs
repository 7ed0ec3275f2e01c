//! The Dobot CR7 on arcfeed: path and job files, plots, reports and the command line.
#![forbid(unsafe_code)]

mod compare;
mod cr7;
mod cr7_error;
mod error;
mod job;
mod job_file;
mod joint_check;
mod joint_run;
mod joint_values;
mod limit_line;
mod limit_lines;
mod model;
mod online_events;
mod online_scenario;
mod path_file;
#[cfg(feature = "plot")]
pub mod plot;
mod report;
pub mod reproduce;
mod robot;
mod sample_paths;
mod samples;
mod scenario;
mod schedule_figure;
mod schedule_file;
mod schedule_run;
mod schedule_way;
mod series;
mod staging;
mod toml_check;
mod trajectory_csv;
mod unit;
mod verdict;
mod whole_file;

pub use compare::{Comparison, Entry, Use, compare};
pub use cr7::{Motion, Task, drawn_segments, trajectory_row};
pub use cr7_error::Cr7Error;
pub use error::InputError;
pub use job::{FeedLimits, Job, Payload, ToolOrientation, TorqueJob};
pub use joint_check::{JointCheck, Rates};
pub use joint_run::{Happening, JointReport};
pub use joint_values::{JointOverrides, JointValues};
pub use limit_line::{LimitLine, LimitUnit};
pub use model::{ACCELERATION, Cr7, JERK, VELOCITY};
pub use online_scenario::{OnlineRun, OnlineScenario, ScenarioError};
pub use path_file::{PathFile, PathGeometry};
pub use report::{Report, SegmentCount};
pub use robot::{Drives, Robot};
pub use sample_paths::{SamplePath, butterfly};
pub use samples::{MOST_CYCLES, MOST_SAMPLES, TooManySamples, few_enough, sample_times};
pub use scenario::{
    Accuracy, Clock, Cycle, DetourLine, EventLine, ExcursionLine, Played, RunReport, Scenario, Stage, StateSpan,
    StepTimes,
};
pub use schedule_figure::{BindingBar, JointFigure, JointPanel, ShareFigure, SharePanel, SpeedFigure};
pub use schedule_file::{ScheduleFile, SchedulePlace, ScheduleWay};
pub use schedule_run::{BindingLine, ScheduleReport, ScheduleRun, run_pose_move, run_way_points};
pub use series::Series;
pub use staging::Staging;
pub use trajectory_csv::{TrajectoryRow, TrajectoryWriter, read_trajectory, trajectory_columns, write_trajectory};
pub use unit::LengthUnit;
pub use verdict::{Exceeded, LimitsHold};
pub use whole_file::interrupt;
