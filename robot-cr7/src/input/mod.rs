//! Files that people write: jobs, paths, schedules and scenarios, read and checked.

pub(crate) mod csv_points;
pub(crate) mod drawing;
pub(crate) mod error;
pub(crate) mod gcode;
pub(crate) mod job;
pub(crate) mod job_file;
pub(crate) mod job_reader;
pub(crate) mod joint_values;
#[cfg(feature = "html")]
pub(crate) mod meshes;
pub(crate) mod named_column;
pub(crate) mod online_file;
pub(crate) mod online_scenario;
pub(crate) mod online_settings;
pub(crate) mod path_file;
pub(crate) mod rapid_moves;
pub(crate) mod recorded_rows;
pub(crate) mod sample_paths;
pub(crate) mod scenario;
pub(crate) mod schedule_file;
pub(crate) mod table_reader;
pub(crate) mod toml_check;
pub(crate) mod tool_scenario;
pub(crate) mod torque_reader;
pub(crate) mod unit;
