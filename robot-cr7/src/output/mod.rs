//! Trajectories, reports and pictures.

pub(crate) mod arm_poses;
pub(crate) mod binding_line;
pub(crate) mod bound_report;
pub(crate) mod compiled_report;
pub(crate) mod folder_lock;
pub(crate) mod joint_report;
pub(crate) mod limit_table;
#[cfg(feature = "html")]
pub(crate) mod page;
pub(crate) mod paper_figure;
pub(crate) mod part_report;
pub(crate) mod parts_report;
#[cfg(feature = "plot")]
pub mod plot;
pub(crate) mod program_report;
pub(crate) mod report;
pub(crate) mod report_head;
pub(crate) mod ros;
pub(crate) mod run_report;
pub(crate) mod schedule_figure;
pub(crate) mod schedule_report;
pub(crate) mod series;
pub(crate) mod staging;
pub(crate) mod trajectory_csv;
pub(crate) mod whole_file;
