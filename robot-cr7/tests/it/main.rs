//! Tests of the program `cr7` and its library, in one binary.

mod advise;
mod bad_jobs;
mod bad_path_files;
#[cfg(feature = "cli")]
mod batch;
mod command_line;
mod common;
mod compare;
mod csv_tools;
mod dense_gcode;
mod determinism;
mod docs;
mod drawing_contours;
mod drawing_dxf;
mod drawing_hostile;
#[cfg(feature = "cli")]
mod drawing_plan;
mod drawing_refusals;
mod drawing_round_trip;
mod drawing_svg;
mod drawing_texts;
#[cfg(feature = "cli")]
mod dwells;
mod faults;
mod gcode_hostile;
mod gcode_plan;
mod gcode_refusals;
mod gcode_round_trip;
mod gcode_rules;
mod gcode_samples;
mod gcode_texts;
mod gcode_writer;
mod hostile_numbers;
#[cfg(feature = "cli")]
mod joint_space;
#[cfg(feature = "cli")]
mod limit_jobs;
mod limits_and_files;
mod page;
mod papers;
#[cfg(feature = "plot")]
mod pictures;
mod pinned;
#[cfg(feature = "cli")]
mod place;
mod png;
#[cfg(feature = "cli")]
mod program_case;
#[cfg(feature = "cli")]
mod random_jobs;
#[cfg(feature = "cli")]
mod rapid_moves;
#[cfg(feature = "cli")]
mod reproduce;
#[cfg(feature = "cli")]
mod robots;
#[cfg(feature = "cli")]
mod run;
mod sabotage;
mod scenarios;
#[cfg(feature = "cli")]
mod schedule;
#[cfg(feature = "cli")]
mod schema;
#[cfg(all(feature = "cli", feature = "controller"))]
mod send_command;
mod tool_targets;
mod trajectory_csv;
#[cfg(feature = "cli")]
mod verify_command;
#[cfg(feature = "cli")]
mod whole_cycles;
mod windows_files;

#[cfg(feature = "cli")]
#[path = "common/keeps.rs"]
mod keeps;
