//! What all reports have in common, as JSON.

use serde::Serialize;

use crate::run::robot::Robot;
use crate::text::json;

/// The keys with which every report begins in its JSON form.
///
/// [`ReportHead::SCHEMA`] says what every key means: those that all reports have mean the same everywhere, others what their command says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReportHead {
    /// Name and version of the format.
    format: &'static str,
    /// The command, as `plan`.
    command: &'static str,
    /// Name of the robot.
    robot: String,
    /// Names of its joints, in their order.
    joint_names: Vec<String>,
}

/// A report with its head.
#[derive(Serialize)]
struct Whole<'a, R> {
    #[serde(flatten)]
    head: &'a ReportHead,
    #[serde(flatten)]
    report: &'a R,
}

impl ReportHead {
    /// The JSON schema (draft 2020-12) of the reports of all commands.
    pub const SCHEMA: &'static str = include_str!("../../data/report.schema.json");

    /// The head of the reports of `command` about `robot`.
    pub fn new(command: &'static str, robot: &Robot) -> Self {
        let (robot, joint_names) = (robot.description().name.clone(), robot.any().joint_names().to_vec());
        Self { format: "report/1", command, robot, joint_names }
    }

    /// The whole report as one JSON object on one line. Numbers that are not finite become `null`.
    pub fn json(&self, report: &impl Serialize) -> String {
        json(&Whole { head: self, report })
    }
}
