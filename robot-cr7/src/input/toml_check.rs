//! Checks of TOML files: every message names file, line, key, value, rule and the way out.

use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::de::DeserializeOwned;

use super::error::{InputError, line_column};
use super::job_file::{RawFrame, RawJoints, RawSampling};
use super::joint_values::{JointOverrides, JointValues, PER_JOINT};
use crate::text::clip;

/// Degrees per radian.
const PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// Longest tool and farthest workpiece that can be meant with an arm that reaches less than a metre, in metres.
const FARTHEST: f64 = 100.0;

/// Largest joint value, rad or m: a hundred turns.
const FARTHEST_JOINT: f64 = 100.0 * std::f64::consts::TAU;

const FINITE: (&str, &str) = ("it has to be a finite number", "write a plain number");

/// Reads `text` as TOML; `example` is the file that shows every key.
pub(crate) fn read_toml<T: DeserializeOwned>(text: &str, file: &Path, example: &str) -> Result<T, InputError> {
    toml::from_str(text).map_err(|e| {
        let (line, column) = e.span().map_or((1, 1), |span| line_column(text, span.start));
        let mut message = e.message().replace('\n', ": ");
        // An untagged value is not told by the parser.
        if let Some(given) = e.span().and_then(|span| text.get(span)).filter(|_| message == PER_JOINT) {
            message += &format!(", not {}", clip(given, 40));
        }
        let hint = if message.contains("unknown field") {
            format!("; remove the key, or correct its spelling ({example} shows all)")
        } else if message.contains("unknown variant") {
            "; choose one of those".to_owned()
        } else {
            format!("; {example} shows every key with its form")
        };
        InputError::Syntax { file: file.to_owned(), line, column, message, hint }
    })
}

/// The checks of one file, with what a message needs.
pub(crate) struct Check<'a> {
    pub text: &'a str,
    pub file: &'a Path,
    pub warnings: Vec<String>,
}

impl<'a> Check<'a> {
    pub fn new(text: &'a str, file: &'a Path) -> Self {
        Self { text, file, warnings: Vec::new() }
    }

    /// Line, from 1, of the value under a dotted key such as `feed.feed_mm_s` or `change[2].at_s`.
    ///
    /// Reads the file once more, which only happens for a message: the types stay free of places.
    pub fn line_of(&self, key: &str) -> Option<usize> {
        let document = toml::de::DeTable::parse(self.text).ok()?;
        let mut value: Option<&toml::Spanned<toml::de::DeValue<'_>>> = None;
        for part in key.split('.') {
            let (name, index) = part.split_once('[').unwrap_or((part, ""));
            let table = match value {
                None => document.get_ref(),
                Some(v) => v.get_ref().as_table()?,
            };
            value = Some(table.get(name)?);
            // Of a list of numbers the line of the list is good enough; of a list of tables the table is wanted.
            let item = index.trim_end_matches(']').parse::<usize>().ok().zip(value?.get_ref().as_array());
            if let Some(table) = item.and_then(|(i, list)| list.get(i)).filter(|v| v.get_ref().as_table().is_some()) {
                value = Some(table);
            }
        }
        value.map(|v| line_column(self.text, v.span().start).0)
    }

    pub fn wrong(&self, key: &str, value: impl ToString, rule: &'static str, remedy: &'static str) -> InputError {
        InputError::Value {
            file: self.file.to_owned(),
            line: self.line_of(key),
            key: key.to_owned(),
            value: value.to_string(),
            rule,
            remedy,
        }
    }

    pub fn warn(&mut self, key: &str, value: f64, hint: &str) {
        let line = self.line_of(key).map(|l| format!(":{l}")).unwrap_or_default();
        self.warnings.push(format!("{}{line}: {key} = {value} {hint}", self.file.display()));
    }

    /// A number above 0, divided by `per_si`.
    pub fn limit(&self, key: &str, value: Option<f64>, per_si: f64) -> Result<Option<f64>, InputError> {
        let Some(value) = value else { return Ok(None) };
        let si = value / per_si;
        // A denormal number is no limit, and its quotient would be 0.
        if value.is_finite() && si >= f64::MIN_POSITIVE {
            return Ok(Some(si));
        }
        let rule = "it has to be a finite number above 0";
        Err(self.wrong(key, value, rule, "raise it, or remove the key to use the default"))
    }

    /// The same, `default` where there is no number.
    pub fn limit_or(&self, key: &str, value: Option<f64>, per_si: f64, default: f64) -> Result<f64, InputError> {
        Ok(self.limit(key, value, per_si)?.unwrap_or(default))
    }

    /// Numbers above 0 for the joints, divided by `per_si`.
    pub fn limits(&self, key: &str, values: &JointValues, per_si: f64) -> Result<JointValues, InputError> {
        values.try_map(key, |key, v| self.limit_or(key, Some(v), per_si, v))
    }

    /// Joint limits in degrees of `section`.
    pub fn overrides(&self, section: &str, raw: &RawJoints) -> Result<JointOverrides, InputError> {
        let limits = |name: &str, values: &Option<JointValues>| {
            values.as_ref().map(|values| self.limits(&format!("{section}.{name}"), values, PER_RADIAN)).transpose()
        };
        Ok(JointOverrides {
            velocity: limits("velocity_deg_s", &raw.velocity_deg_s)?,
            acceleration: limits("acceleration_deg_s2", &raw.acceleration_deg_s2)?,
            jerk: limits("jerk_deg_s3", &raw.jerk_deg_s3)?,
        })
    }

    /// The values for an arm of `N` joints.
    pub fn of<const N: usize>(&self, key: &str, values: &JointValues) -> Result<[f64; N], InputError> {
        values.of::<N>().map_err(|given| {
            let rule = "a list has one number for each joint of the arm";
            let value = format!("a list of {given} for {N} joints");
            self.wrong(key, value, rule, "write one number for all, or one for each")
        })
    }

    /// Finite numbers of any sign, times `si`.
    pub fn values(&self, key: &str, values: &JointValues, si: f64) -> Result<JointValues, InputError> {
        values.try_map(key, |key, v| match v.is_finite() {
            true => Ok(v * si),
            false => Err(self.wrong(key, v, FINITE.0, FINITE.1)),
        })
    }

    /// Joint values within a hundred turns (or 628 m of a slide), times `si`: beyond, the unit is wrong, and sine and
    /// cosine lose their digits.
    pub fn places(&self, key: &str, values: &JointValues, si: f64) -> Result<JointValues, InputError> {
        self.values(key, values, si)?.try_map(key, |key, v| match v.abs() > FARTHEST_JOINT {
            true => Err(self.wrong(key, v / si, "a joint value lies within a hundred turns", "check its unit")),
            false => Ok(v),
        })
    }

    pub fn period(&self, ms: Option<f64>) -> Result<Option<f64>, InputError> {
        let key = "sampling.period_ms";
        let period = self.limit(key, ms, 1e3)?;
        if let (Some(ms), Some(_)) = (ms, period.filter(|p| !(1e-5..=1.0).contains(p))) {
            let rule = "a control period lies between 0.01 and 1000 ms";
            return Err(self.wrong(key, ms, rule, "did you mean seconds or microseconds? Write 1.0 for a millisecond"));
        }
        Ok(period)
    }

    /// Whether the motion lasts a whole number of control periods, for one whose speeds at both ends are these.
    pub fn whole_cycles(&self, raw: &RawSampling, ends: [f64; 2]) -> Result<bool, InputError> {
        let whole = raw.whole_cycles.unwrap_or(false);
        if whole && ends != [0.0; 2] {
            let rule = "a motion is slowed down to whole cycles, which would change its speeds at start and end";
            let remedy = "begin and end at rest, or remove the key";
            return Err(self.wrong("sampling.whole_cycles", whole, rule, remedy));
        }
        Ok(whole)
    }

    /// Refuses whole cycles for a motion that is made cycle by cycle.
    pub fn no_whole_cycles(&self, raw: &RawSampling) -> Result<(), InputError> {
        let Some(whole) = raw.whole_cycles else { return Ok(()) };
        let rule = "a motion that is made cycle by cycle lasts whole cycles anyway";
        Err(self.wrong("sampling.whole_cycles", whole, rule, "remove the key"))
    }

    /// The time of change `i` (s), not before that of the change `before` it.
    pub fn time_of_change(&self, i: usize, at: f64, before: Option<f64>) -> Result<f64, InputError> {
        let key = format!("change[{i}].at_s");
        if !(at.is_finite() && at >= 0.0) {
            let rule = "a change happens at a time from 0 s on";
            return Err(self.wrong(&key, at, rule, "count the time from the start of the motion"));
        }
        match before.filter(|&before| before > at) {
            None => Ok(at),
            Some(before) => {
                let rule = "changes stand in the order of their times";
                Err(self.wrong(&key, format!("{at} after {before}"), rule, "sort them"))
            }
        }
    }

    pub fn finite(&self, key: &str, values: [f64; 3]) -> Result<Vector3<f64>, InputError> {
        match values.iter().position(|v| !v.is_finite()) {
            Some(i) => Err(self.wrong(&format!("{key}[{i}]"), values[i], FINITE.0, FINITE.1)),
            None => Ok(Vector3::from(values)),
        }
    }

    pub fn angles(&self, key: &str, degrees: [f64; 3]) -> Result<UnitQuaternion<f64>, InputError> {
        self.finite(key, degrees)?;
        if let Some(i) = degrees.iter().position(|v| v.abs() > 36_000.0) {
            let rule = "an angle in degrees lies within a hundred turns";
            return Err(self.wrong(&format!("{key}[{i}]"), degrees[i], rule, "give the angle within +-180 degrees"));
        }
        Ok(rotation(degrees))
    }

    pub fn frame(
        &mut self,
        section: &str,
        raw: &RawFrame,
        default: Isometry3<f64>,
    ) -> Result<Isometry3<f64>, InputError> {
        let mut frame = default;
        if let Some(mm) = raw.position_mm {
            let key = format!("{section}.position_mm");
            let position = self.finite(&key, mm)? / 1e3;
            if let Some(i) = position.iter().position(|v| v.abs() > FARTHEST) {
                let rule = "the arm reaches less than 1000 mm, and a frame more than 100 m away cannot be meant";
                return Err(self.wrong(
                    &format!("{key}[{i}]"),
                    mm[i],
                    rule,
                    "check the unit: the numbers are millimetres",
                ));
            }
            let largest = position.amax();
            if largest > 0.0 && largest < 1e-3 {
                self.warn(
                    &key,
                    largest * 1e3,
                    "is below 1 mm in every direction: did you mean metres? Write 400 for 0.4 m",
                );
            } else if largest > 2.0 {
                self.warn(
                    &key,
                    largest * 1e3,
                    "mm is far beyond the reach of the arm (less than 1000 mm): check the unit",
                );
            }
            frame.translation = Translation3::from(position);
        }
        if let Some(degrees) = raw.rotation_rpy_deg {
            frame.rotation = self.angles(&format!("{section}.rotation_rpy_deg"), degrees)?;
        }
        Ok(frame)
    }
}

/// Roll, pitch and yaw in degrees about the fixed x, y and z axes.
pub(crate) fn rotation(degrees: [f64; 3]) -> UnitQuaternion<f64> {
    let [roll, pitch, yaw] = degrees.map(f64::to_radians);
    UnitQuaternion::from_euler_angles(roll, pitch, yaw)
}
