//! The job file as it is written: TOML, unknown keys refused.

use serde::Deserialize;

use super::joint_values::JointValues;

/// The whole file. Absent keys are `None`; defaults belong to [`crate::Job`].
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawJob {
    pub path: RawPath,
    pub start: RawStart,
    pub workpiece: RawFrame,
    pub tool: RawFrame,
    pub orientation: RawOrientation,
    pub feed: RawFeed,
    pub joints: RawJoints,
    pub torque: RawTorque,
    pub sections: Vec<RawSection>,
    pub tables: Vec<RawTable>,
    pub vibration: Vec<RawVibration>,
    pub tolerance: RawTolerance,
    pub sampling: RawSampling,
    pub plan: RawPlan,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawStart {
    pub near_deg: Option<JointValues>,
    pub configuration: Option<String>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawPath {
    pub file: Option<String>,
    pub csv_unit: Option<String>,
    pub fit_tolerance_mm: Option<f64>,
    pub through: RawThrough,
    pub bulge_mm: Option<f64>,
    pub smooth_mm: Option<f64>,
    pub blend_mm: Option<f64>,
    pub blend_deg: Option<f64>,
    pub layers: Option<Vec<String>>,
    pub lift_mm: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum RawThrough {
    #[default]
    Spline,
    Polyline,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawFrame {
    pub position_mm: Option<[f64; 3]>,
    pub rotation_rpy_deg: Option<[f64; 3]>,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum RawMode {
    #[default]
    Constant,
    Slerp,
    Tangent,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawOrientation {
    pub mode: RawMode,
    pub rpy_deg: Option<[f64; 3]>,
    pub from_rpy_deg: Option<[f64; 3]>,
    pub to_rpy_deg: Option<[f64; 3]>,
    pub axis: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawFeed {
    pub feed_mm_s: Option<f64>,
    pub tangential_acceleration_mm_s2: Option<f64>,
    pub tangential_jerk_mm_s3: Option<f64>,
    pub normal_acceleration_mm_s2: Option<f64>,
    pub normal_jerk_mm_s3: Option<f64>,
    pub tool_acceleration_mm_s2: Option<f64>,
    pub tool_jerk_mm_s3: Option<f64>,
    pub angular_speed_deg_s: Option<f64>,
    pub start_mm_s: Option<f64>,
    pub end_mm_s: Option<f64>,
    pub rapid: RawRapid,
    pub rapid_mm_s: Option<f64>,
    pub rapid_blend_mm: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum RawRapid {
    #[default]
    Line,
    Joints,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawTorque {
    pub limited: Option<bool>,
    pub limit_nm: Option<JointValues>,
    pub rated_nm: Option<JointValues>,
    pub payload_kg: Option<f64>,
    pub payload_centre_mm: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawSection {
    pub feed_mm_s: Option<f64>,
    pub from_mm: Option<f64>,
    pub to_mm: Option<f64>,
    pub from_u: Option<f64>,
    pub to_u: Option<f64>,
    pub from_segment: Option<i64>,
    pub to_segment: Option<i64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawTable {
    pub joint: Option<i64>,
    pub speed_deg_s: Option<Vec<f64>>,
    pub position_deg: Option<Vec<f64>>,
    pub payload_kg: Option<Vec<f64>>,
    pub acceleration_deg_s2: Option<RawColumns>,
    pub jerk_deg_s3: Option<RawColumns>,
    pub torque_nm: Option<RawColumns>,
}

/// Limits of a table: a list, or one for each payload.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "a list of limits, or a list with such a list for each payload")]
pub(crate) enum RawColumns {
    One(Vec<f64>),
    PerPayload(Vec<Vec<f64>>),
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawVibration {
    pub joint: Option<i64>,
    pub frequency_hz: Option<f64>,
    pub damping: Option<f64>,
    pub residual_limit_deg: Option<f64>,
    pub residual_limit_mm: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawJoints {
    pub velocity_deg_s: Option<JointValues>,
    pub acceleration_deg_s2: Option<JointValues>,
    pub jerk_deg_s3: Option<JointValues>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawTolerance {
    pub chord_mm: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawSampling {
    pub period_ms: Option<f64>,
    pub whole_cycles: Option<bool>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawPlan {
    pub planner: Option<String>,
    pub lookahead: Option<i64>,
}
