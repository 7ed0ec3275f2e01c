//! Results on stdout and in files.
//!
//! A reader may stop reading stdout (`cr7 robots | head -1`): that ends the program and is no failure.

use std::fmt::Display;
use std::io::Write;
use std::path::PathBuf;

use crate::{JointReport, LimitLine, LimitsHold, Report, ReportHead, RunReport, ScheduleReport, Staging};
use serde::Serialize;

use crate::cli::Failure;

/// Writes to stdout; ends the program quietly when nobody reads any more.
pub fn write(text: std::fmt::Arguments<'_>) {
    if let Err(error) = std::io::stdout().lock().write_fmt(text) {
        let code = if error.kind() == std::io::ErrorKind::BrokenPipe { 0 } else { 2 };
        if code != 0 {
            eprintln!("cr7: stdout: {error}");
        }
        std::process::exit(code);
    }
}

/// As `println!`.
macro_rules! say {
    ($($part:tt)*) => { $crate::cli::output::write(format_args!("{}\n", format_args!($($part)*))) };
}
/// As `print!`.
macro_rules! say_as_is {
    ($($part:tt)*) => { $crate::cli::output::write(format_args!($($part)*)) };
}
pub(crate) use {say, say_as_is};

/// A text or a JSON object on stdout.
pub fn show(text: &impl Display, json: Option<String>) {
    match json {
        Some(json) => say!("{json}"),
        None => say_as_is!("{text}"),
    }
}

/// The report of a motion.
pub trait MotionReport: Display + Serialize {
    /// Every limit with its worst place.
    fn limits(&self) -> &[LimitLine];
    /// The files of the motion.
    fn files(&mut self) -> &mut Vec<PathBuf>;
}

macro_rules! motion_report {
    ($($report:ty),*) => {$(
        impl MotionReport for $report {
            fn limits(&self) -> &[LimitLine] {
                &self.limits
            }
            fn files(&mut self) -> &mut Vec<PathBuf> {
                &mut self.files
            }
        }
    )*};
}
motion_report!(Report, ScheduleReport, JointReport, RunReport);

/// Names of the report files that every motion has.
pub const REPORTS: [&str; 2] = ["report.json", "report.txt"];

/// Prints the report, and publishes the files and the report if every limit holds.
pub fn conclude(
    head: &ReportHead,
    mut report: impl MotionReport,
    mut staging: Staging,
    json: bool,
    remedy: &str,
) -> Result<(), Failure> {
    let held = LimitsHold::of(report.limits());
    if let Ok(hold) = &held {
        *report.files() = staging.files_with(&REPORTS);
        staging.write(REPORTS[0], &(head.json(&report) + "\n"))?;
        staging.write(REPORTS[1], &report.to_string())?;
        staging.publish(hold)?;
    }
    show(&report, json.then(|| head.json(&report)));
    held.map(drop).map_err(|error| Failure::exceeded(&error, remedy))
}
