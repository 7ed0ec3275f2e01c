//! The part that both kinds of scenario for `cr7 online` have.

use std::path::{Path, PathBuf};

use super::error::InputError;
use super::job_file::{RawJoints, RawSampling};
use super::joint_values::JointOverrides;
use super::toml_check::Check;

/// Control period, length and limits of the joints of an online scenario, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct OnlineSettings {
    /// The file and its text, for messages.
    pub(crate) file: PathBuf,
    pub(crate) text: String,
    /// Control period, s.
    pub period: f64,
    /// Longest motion that is simulated, s.
    pub longest: f64,
    /// Limits that replace those of the arm's model.
    pub joints: JointOverrides,
}

impl OnlineSettings {
    /// Checks `[sampling]`, `run.longest_s` and `[joints]`.
    ///
    /// # Errors
    /// Fails when a value breaks its rule.
    pub(super) fn new(
        check: &Check<'_>,
        sampling: &RawSampling,
        longest: Option<f64>,
        joints: &RawJoints,
    ) -> Result<Self, InputError> {
        check.no_whole_cycles(sampling)?;
        Ok(Self {
            file: check.file.to_owned(),
            text: check.text.to_owned(),
            period: check.period(sampling.period_ms)?.unwrap_or(1e-3),
            longest: check.limit("run.longest_s", longest, 1.0)?.unwrap_or(60.0),
            joints: check.overrides("joints", joints)?,
        })
    }

    /// The checks of the file, for a value that turns out wrong later.
    pub(crate) fn check(&self) -> Check<'_> {
        Check::new(&self.text, Path::new(&self.file))
    }
}
