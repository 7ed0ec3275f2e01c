//! The scenario file as it is written: TOML, unknown keys refused.

use serde::Deserialize;

use crate::input::job_file::{RawFeed, RawFrame, RawOrientation, RawSampling, RawTolerance};
use crate::input::joint_values::JointValues;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScenario {
    pub path: RawScenarioPath,
    #[serde(default)]
    pub workpiece: Option<RawFrame>,
    #[serde(default)]
    pub tool: RawFrame,
    #[serde(default)]
    pub orientation: Option<RawOrientation>,
    pub run: RawRun,
    #[serde(default)]
    pub feed: RawFeed,
    #[serde(default)]
    pub joints: RawScenarioJoints,
    #[serde(default)]
    pub tolerance: RawTolerance,
    #[serde(default)]
    pub sampling: RawSampling,
    #[serde(default)]
    pub event: Vec<RawEvent>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScenarioPath {
    pub file: Option<String>,
    pub csv_unit: Option<String>,
    pub fit_tolerance_mm: Option<f64>,
    pub built_in: Option<String>,
    pub line: Option<Vec<RawPlace>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRun {
    pub feed_mm_s: f64,
    pub drive_time_constant_ms: Option<JointValues>,
    pub longest_s: Option<f64>,
    pub start: Option<RawPlace>,
    pub singularities: Option<RawSingularities>,
    pub stall_percent: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum RawSingularities {
    SlowDown,
    GoRound,
    Refuse,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawScenarioJoints {
    pub velocity_deg_s: Option<JointValues>,
    pub acceleration_deg_s2: Option<JointValues>,
    pub jerk_deg_s3: Option<JointValues>,
    pub velocity_rad_s: Option<JointValues>,
    pub acceleration_rad_s2: Option<JointValues>,
    pub jerk_rad_s3: Option<JointValues>,
    pub zero_deg: Option<JointValues>,
}

/// A place of the arm: joint values, or a pose of the tool.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawPlace {
    pub deg: Option<JointValues>,
    pub rad: Option<JointValues>,
    pub position_mm: Option<[f64; 3]>,
    pub rpy_deg: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum RawAction {
    Feed,
    Override,
    Section,
    ClearSections,
    Hold,
    Resume,
    StepBack,
    Leave,
    Return,
    Stop,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum RawLeave {
    Braking,
    AtOnce,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum RawJointMoves {
    LeastTime,
    Projection,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEvent {
    #[serde(rename = "do")]
    pub action: RawAction,
    pub at_s: Option<f64>,
    pub at_cycle: Option<i64>,
    pub at_mm: Option<f64>,
    pub wait_s: Option<f64>,
    pub feed_mm_s: Option<f64>,
    pub percent: Option<f64>,
    pub from_mm: Option<f64>,
    pub to_mm: Option<f64>,
    pub by_mm: Option<f64>,
    pub leave: Option<RawLeave>,
    pub points: Option<Vec<RawPlace>>,
    pub pass_within_deg: Option<f64>,
    pub joint_moves: Option<RawJointMoves>,
}
