//! The Dobot CR7 on arcfeed: path and job files, plots, reports and the command line.
//!
//! Checked files (`input`) become verified motions (`run`), and these become trajectories, reports and
//! pictures (`output`). The command line (`cli`) joins the three. [`reproduce`] sets the figures of the papers beside ours.
#![forbid(unsafe_code)]

#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "controller")]
pub mod controller;
mod input;
mod output;
pub mod reproduce;
mod run;
mod text;

#[cfg(feature = "cli")]
pub use cli::command_line;
pub use input::drawing::{DrawingOptions, read_drawing};
pub use input::error::InputError;
pub use input::gcode::{
    GcodeFault, GcodeMarker, GcodeMove, GcodeOptions, GcodeProgram, MarkerKind, MoveKind, MoveShape, PathControl,
};
pub use input::job::{FeedLimits, Job, Payload, TableJob, ToolOrientation, TorqueJob, VibrationJob};
pub use input::joint_values::{JointOverrides, JointValues};
#[cfg(feature = "html")]
pub use input::meshes::{LinkMesh, MeshFault, read_meshes};
pub use input::named_column::NamedColumn;
pub use input::online_file::OnlineFile;
pub use input::online_scenario::OnlineScenario;
pub use input::online_settings::OnlineSettings;
pub use input::path_file::{PathFile, PathGeometry, PointTools};
pub use input::rapid_moves::{RapidKind, RapidMoves};
pub use input::recorded_rows::{RecordedRounding, RecordedRow, RecordedRows};
pub use input::sample_paths::{SamplePath, butterfly};
pub use input::scenario::Scenario;
pub use input::schedule_file::{ScheduleFile, SchedulePlace, ScheduleWay};
pub use input::tool_scenario::ToolScenario;
pub use input::unit::LengthUnit;
pub use output::arm_poses::{ArmPoses, Pose};
pub use output::binding_line::BindingLine;
pub use output::bound_report::BoundReport;
pub use output::compiled_report::{CertifiedRatio, CertifiedToolRatio, CompiledReport};
pub use output::joint_report::JointReport;
#[cfg(feature = "html")]
pub use output::page::{MotionPage, PageFacts, SpeedCeiling};
pub use output::part_report::{JointMoveReport, PartReport};
#[cfg(feature = "plot")]
pub use output::plot;
pub use output::program_report::{LineTime, ProgramReport, StopLine, line_times};
pub use output::report::{Report, SegmentCount};
pub use output::report_head::ReportHead;
#[cfg(feature = "mcap")]
pub use output::ros::RosRecording;
pub use output::ros::{RosError, RosTrajectory};
pub use output::run_report::{Accuracy, DetourLine, EventLine, ExcursionLine, RunReport, StateSpan};
pub use output::schedule_figure::{BindingBar, JointFigure, JointPanel, ShareFigure, SharePanel, SpeedFigure};
pub use output::schedule_report::{ScheduleReport, ScheduleRun};
pub use output::series::Series;
pub use output::staging::Staging;
pub use output::trajectory_csv::{TrajectoryWriter, read_trajectory, trajectory_columns, write_trajectory};
pub use output::whole_file::interrupt;
pub use run::advice::{Advice, IdleLimit, LimitCost};
pub use run::batch::{BatchItem, BatchResult};
pub use run::compare::{Comparison, Entry, compare};
pub use run::cr7::{ACCELERATION, Cr7, JERK, VELOCITY};
pub use run::error::Cr7Error;
pub use run::joint_move::{JointMove, Leaves, Passed};
pub use run::limit_line::{LimitLine, LimitUnit};
pub use run::limit_lines::limit_lines;
pub use run::motion::{Motion, drawn_segments};
pub use run::on_robot::{OnProgram, OnToolPath};
pub use run::online_events::Happening;
pub use run::online_run::{OnlineRun, ScenarioError};
pub use run::outline::{MarkerLine, Outline, Smoothed};
pub use run::placed_path::PointFit;
pub use run::placement::{Placement, PlacementSearch, Placements};
pub use run::play::{Clock, Cycle, Played, StepTimes};
pub use run::program_check::ProgramCheck;
pub use run::program_motion::ProgramMotion;
pub use run::program_part::{PartMotion, ProgramPart};
pub use run::program_plan::CompiledProgram;
pub use run::program_samples::{ProgramSample, ProgramSamples};
pub use run::program_task::ProgramTask;
pub use run::recorded_check::{RecordedCheck, RecordedLimits};
pub use run::robot::{Drives, Robot};
pub use run::samples::{MOST_CYCLES, MOST_SAMPLES, TooManySamples, few_enough, sample_times};
pub use run::side_effects::{ThermalLine, VibrationLine};
pub use run::speed_task::SpeedTask;
pub use run::stage::Stage;
pub use run::stream::StreamReport;
pub use run::task::Task;
pub use run::tool_check::tool_lines;
pub use run::tool_run::ToolRun;
pub use run::trajectory_row::TrajectoryRow;
pub use run::verdict::{Exceeded, LimitsHold};
