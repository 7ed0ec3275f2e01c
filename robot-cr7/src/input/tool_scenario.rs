//! Scenarios of tool poses that change while the arm moves, as TOML.

use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde::Deserialize;

use super::error::InputError;
use super::job_file::{RawFrame, RawJoints, RawSampling};
use super::joint_values::JointValues;
use super::online_settings::OnlineSettings;
use super::toml_check::{Check, read_toml};
use super::unit::DEGREE;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScenario {
    #[serde(default)]
    sampling: RawSampling,
    run: RawRun,
    #[serde(default)]
    joints: RawJoints,
    #[serde(default)]
    tool: RawFrame,
    #[serde(default)]
    limits: RawLimits,
    start: RawStart,
    target: RawFrame,
    #[serde(default)]
    change: Vec<RawChange>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRun {
    /// Chose this kind of file.
    #[serde(rename = "mode")]
    _mode: String,
    longest_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStart {
    q_deg: JointValues,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawLimits {
    linear_mm_s: Option<f64>,
    linear_mm_s2: Option<f64>,
    linear_mm_s3: Option<f64>,
    angular_deg_s: Option<f64>,
    angular_deg_s2: Option<f64>,
    angular_deg_s3: Option<f64>,
}

/// The keys of a pose and of limits stand beside one another; `flatten` would let unknown ones pass.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChange {
    at_s: f64,
    position_mm: Option<[f64; 3]>,
    rotation_rpy_deg: Option<[f64; 3]>,
    linear_mm_s: Option<f64>,
    linear_mm_s2: Option<f64>,
    linear_mm_s3: Option<f64>,
    angular_deg_s: Option<f64>,
    angular_deg_s2: Option<f64>,
    angular_deg_s3: Option<f64>,
}

impl RawChange {
    const fn pose(&self) -> RawFrame {
        RawFrame { position_mm: self.position_mm, rotation_rpy_deg: self.rotation_rpy_deg }
    }

    const fn limits(&self) -> RawLimits {
        RawLimits {
            linear_mm_s: self.linear_mm_s,
            linear_mm_s2: self.linear_mm_s2,
            linear_mm_s3: self.linear_mm_s3,
            angular_deg_s: self.angular_deg_s,
            angular_deg_s2: self.angular_deg_s2,
            angular_deg_s3: self.angular_deg_s3,
        }
    }
}

/// Keys of the limits of a tool: velocity, acceleration, jerk of its tip, then of its rotation.
const LIMITS: [&str; 6] =
    ["linear_mm_s", "linear_mm_s2", "linear_mm_s3", "angular_deg_s", "angular_deg_s2", "angular_deg_s3"];

/// A pose of which parts may be given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PartialPose {
    position: Option<Translation3<f64>>,
    rotation: Option<UnitQuaternion<f64>>,
}

impl PartialPose {
    /// The pose, with the parts of `before` that are not given.
    pub(crate) fn after(&self, before: &Isometry3<f64>) -> Isometry3<f64> {
        Isometry3::from_parts(self.position.unwrap_or(before.translation), self.rotation.unwrap_or(before.rotation))
    }
}

/// Limits of a tool that are given, in the order of the keys.
pub(crate) type ToolLimitChanges = [Option<f64>; 6];

/// What changes at one time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ToolChange {
    pub(crate) at: f64,
    pub(crate) pose: PartialPose,
    pub(crate) limits: ToolLimitChanges,
    /// The keys that are given.
    pub(crate) keys: Vec<&'static str>,
}

/// A checked scenario of tool targets, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolScenario {
    /// Control period, length and limits of the joints.
    pub settings: OnlineSettings,
    /// Tool tip in the flange frame.
    pub tool: Isometry3<f64>,
    /// Velocity, acceleration and jerk of the tool tip (m), then of its rotation (rad).
    pub limits: [f64; 6],
    /// Values that are allowed but look like a slip of the unit.
    pub warnings: Vec<String>,
    pub(crate) start: JointValues,
    pub(crate) target: PartialPose,
    pub(crate) changes: Vec<ToolChange>,
}

impl ToolScenario {
    /// A scenario with every key and what it means.
    pub const EXAMPLE: &'static str = include_str!("../../scenarios/tool.toml");

    /// Checks the text of a scenario; `file` is the name used in messages.
    ///
    /// # Errors
    /// Fails when the text is not TOML, has an unknown key, or a value breaks its rule.
    pub fn parse(text: &str, file: &Path) -> Result<Self, InputError> {
        let raw: RawScenario = read_toml(text, file, "scenarios/tool.toml")?;
        let mut check = Check::new(text, file);
        if raw.target.position_mm.is_none() && raw.target.rotation_rpy_deg.is_none() {
            let rule = "a target has a position or a rotation";
            return Err(check.wrong("target", "empty", rule, "add position_mm or rotation_rpy_deg"));
        }
        let mut changes: Vec<ToolChange> = Vec::with_capacity(raw.change.len());
        for (i, raw) in raw.change.iter().enumerate() {
            let at = check.time_of_change(i, raw.at_s, changes.last().map(|before| before.at))?;
            changes.push(change(&mut check, i, at, raw)?);
        }
        let given = limits(&check, "limits", &raw.limits)?;
        let defaults = [0.25, 1.0, 10.0, 1.0, 4.0, 40.0];
        Ok(Self {
            settings: OnlineSettings::new(&check, &raw.sampling, raw.run.longest_s, &raw.joints)?,
            tool: check.frame("tool", &raw.tool, Isometry3::identity())?,
            limits: std::array::from_fn(|k| given[k].unwrap_or(defaults[k])),
            start: check.places("start.q_deg", &raw.start.q_deg, DEGREE)?,
            target: pose(&mut check, "target", &raw.target)?,
            changes,
            warnings: std::mem::take(&mut check.warnings),
        })
    }
}

impl ToolChange {
    pub(crate) fn words(&self) -> String {
        format!("new {} of the tool", self.keys.join(", "))
    }
}

fn change(check: &mut Check<'_>, i: usize, at: f64, raw: &RawChange) -> Result<ToolChange, InputError> {
    let section = format!("change[{i}]");
    let limits = limits(check, &section, &raw.limits())?;
    let of_pose = [("position_mm", raw.position_mm.is_some()), ("rotation_rpy_deg", raw.rotation_rpy_deg.is_some())];
    let of_limits = LIMITS.into_iter().zip(&limits).map(|(key, value)| (key, value.is_some()));
    let keys: Vec<_> = of_pose.into_iter().chain(of_limits).filter_map(|(key, given)| given.then_some(key)).collect();
    if keys.is_empty() {
        let rule = "a change has to change something";
        return Err(check.wrong(&section, "empty", rule, "add position_mm, linear_mm_s or another key"));
    }
    Ok(ToolChange { at, pose: pose(check, &section, &raw.pose())?, limits, keys })
}

fn pose(check: &mut Check<'_>, section: &str, raw: &RawFrame) -> Result<PartialPose, InputError> {
    let frame = check.frame(section, raw, Isometry3::identity())?;
    Ok(PartialPose {
        position: raw.position_mm.map(|_| frame.translation),
        rotation: raw.rotation_rpy_deg.map(|_| frame.rotation),
    })
}

fn limits(check: &Check<'_>, section: &str, raw: &RawLimits) -> Result<ToolLimitChanges, InputError> {
    let given = [
        raw.linear_mm_s,
        raw.linear_mm_s2,
        raw.linear_mm_s3,
        raw.angular_deg_s,
        raw.angular_deg_s2,
        raw.angular_deg_s3,
    ];
    let mut limits = [None; 6];
    for (k, slot) in limits.iter_mut().enumerate() {
        let per_si = if k < 3 { 1e3 } else { 1.0 / DEGREE };
        *slot = check.limit(&format!("{section}.{}", LIMITS[k]), given[k], per_si)?;
    }
    Ok(limits)
}
