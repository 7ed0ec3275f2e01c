//! Scenarios of targets and limits that change while the arm moves, as TOML.

use std::path::Path;

use arcfeed_sync::Synchronisation;
use serde::Deserialize;

use super::error::InputError;
use super::job_file::{RawJoints, RawSampling};
use super::joint_values::JointValues;
use super::online_settings::OnlineSettings;
use super::toml_check::{Check, read_toml};
use super::unit::DEGREE;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScenario {
    #[serde(default)]
    sampling: RawSampling,
    #[serde(default)]
    run: RawRun,
    #[serde(default)]
    joints: RawJoints,
    start: RawState,
    target: RawState,
    #[serde(default)]
    change: Vec<RawChange>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawRun {
    mode: RawMode,
    longest_s: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawMode {
    #[default]
    Time,
    Line,
    None,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawState {
    q_deg: JointValues,
    qd_deg_s: Option<JointValues>,
    qdd_deg_s2: Option<JointValues>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChange {
    at_s: f64,
    joint: Option<i64>,
    q_deg: Option<JointValues>,
    qd_deg_s: Option<JointValues>,
    qdd_deg_s2: Option<JointValues>,
    velocity_deg_s: Option<JointValues>,
    acceleration_deg_s2: Option<JointValues>,
    jerk_deg_s3: Option<JointValues>,
}

/// A checked scenario, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct OnlineScenario {
    /// Control period, length and limits of the joints.
    pub settings: OnlineSettings,
    /// The synchronisation of the joints.
    pub synchronisation: Synchronisation,
    pub(crate) start: [JointValues; 3],
    pub(crate) target: [JointValues; 3],
    pub(crate) changes: Vec<Change>,
}

/// The changes at one time. The values are those of position, velocity, acceleration of the target, then of the limits
/// of velocity, acceleration and jerk.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Change {
    pub(crate) at: f64,
    pub(crate) joint: Option<usize>,
    pub(crate) values: [Option<JointValues>; 6],
}

/// Keys of a change, in the order of `Change::values`.
pub(crate) const KEYS: [&str; 6] =
    ["q_deg", "qd_deg_s", "qdd_deg_s2", "velocity_deg_s", "acceleration_deg_s2", "jerk_deg_s3"];

impl OnlineScenario {
    /// A scenario with every key and what it means.
    pub const EXAMPLE: &'static str = include_str!("../../scenarios/online.toml");

    /// Checks the text of a scenario; `file` is the name used in messages.
    ///
    /// # Errors
    /// Fails when the text is not TOML, has an unknown key, or a value breaks its rule.
    pub fn parse(text: &str, file: &Path) -> Result<Self, InputError> {
        let raw: RawScenario = read_toml(text, file, "scenarios/online.toml")?;
        let check = Check::new(text, file);
        let state = |section: &str, raw: &RawState| -> Result<[JointValues; 3], InputError> {
            let or_zero = |key, value: &Option<JointValues>| {
                Ok(match value {
                    None => JointValues::All(0.0),
                    Some(value) => check.values(&format!("{section}.{key}"), value, DEGREE)?,
                })
            };
            Ok([
                check.places(&format!("{section}.q_deg"), &raw.q_deg, DEGREE)?,
                or_zero("qd_deg_s", &raw.qd_deg_s)?,
                or_zero("qdd_deg_s2", &raw.qdd_deg_s2)?,
            ])
        };
        let mut changes: Vec<Change> = Vec::with_capacity(raw.change.len());
        for (i, raw) in raw.change.iter().enumerate() {
            let at = check.time_of_change(i, raw.at_s, changes.last().map(|before| before.at))?;
            changes.push(Self::change(&check, i, at, raw)?);
        }
        Ok(Self {
            settings: OnlineSettings::new(&check, &raw.sampling, raw.run.longest_s, &raw.joints)?,
            synchronisation: match raw.run.mode {
                RawMode::Time => Synchronisation::Time,
                RawMode::Line => Synchronisation::StraightLine,
                RawMode::None => Synchronisation::None,
            },
            start: state("start", &raw.start)?,
            target: state("target", &raw.target)?,
            changes,
        })
    }

    fn change(check: &Check<'_>, i: usize, at: f64, raw: &RawChange) -> Result<Change, InputError> {
        let key = |name: &str| format!("change[{i}].{name}");
        let joint = match raw.joint {
            None => None,
            Some(joint) => Some(usize::try_from(joint).ok().and_then(|j| j.checked_sub(1)).ok_or_else(|| {
                check.wrong(&key("joint"), joint, "joints count from 1", "remove the key to change all joints")
            })?),
        };
        let given = [
            &raw.q_deg,
            &raw.qd_deg_s,
            &raw.qdd_deg_s2,
            &raw.velocity_deg_s,
            &raw.acceleration_deg_s2,
            &raw.jerk_deg_s3,
        ];
        let mut values: [Option<JointValues>; 6] = Default::default();
        for (k, (slot, given)) in values.iter_mut().zip(given).enumerate() {
            let Some(given) = given else { continue };
            if let (Some(_), JointValues::Each(list)) = (joint, given) {
                let rule = "with `joint` it is about that one";
                let value = format!("a list of {}", list.len());
                return Err(check.wrong(&key(KEYS[k]), value, rule, "write one number"));
            }
            *slot = match k {
                0 => Some(check.places(&key(KEYS[k]), given, DEGREE)?),
                1..=2 => Some(check.values(&key(KEYS[k]), given, DEGREE)?),
                _ => Some(check.limits(&key(KEYS[k]), given, 1.0 / DEGREE)?),
            };
        }
        if values.iter().all(Option::is_none) {
            let rule = "a change has to change something";
            return Err(check.wrong(
                &format!("change[{i}]"),
                "empty",
                rule,
                "add q_deg, velocity_deg_s or another key",
            ));
        }
        Ok(Change { at, joint, values })
    }
}

impl Change {
    pub(crate) fn words(&self) -> String {
        let given: Vec<&str> =
            KEYS.into_iter().zip(&self.values).filter_map(|(key, value)| value.is_some().then_some(key)).collect();
        let whose = self.joint.map_or("all joints".to_owned(), |j| format!("joint {}", j + 1));
        format!("new {} of {whose}", given.join(", "))
    }
}
