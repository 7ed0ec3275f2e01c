//! Values of a file for the joints of an arm.

use serde::Deserialize;

/// Joint limits that replace those of the arm's model, all above 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointOverrides {
    /// Velocity in rad/s.
    pub velocity: Option<JointValues>,
    /// Acceleration in rad/s^2.
    pub acceleration: Option<JointValues>,
    /// Jerk in rad/s^3.
    pub jerk: Option<JointValues>,
}

/// The form of [`JointValues`] in a file, for messages.
pub(crate) const PER_JOINT: &str = "one number for all joints or a list with one for each";

/// A value for the joints of an arm whose number the file does not know.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "one number for all joints or a list with one for each")]
pub enum JointValues {
    /// The same for all joints.
    All(f64),
    /// One for each joint.
    Each(Vec<f64>),
}

impl JointValues {
    /// Each value changed by `change`, which is told the key of the value.
    pub(crate) fn try_map<E>(&self, key: &str, mut change: impl FnMut(&str, f64) -> Result<f64, E>) -> Result<Self, E> {
        Ok(match self {
            Self::All(value) => Self::All(change(key, *value)?),
            Self::Each(list) => {
                let each = list.iter().enumerate().map(|(i, &value)| change(&format!("{key}[{i}]"), value));
                Self::Each(each.collect::<Result<_, E>>()?)
            }
        })
    }

    /// The values for an arm of `N` joints.
    ///
    /// # Errors
    /// The number there are, when that is another one.
    pub fn of<const N: usize>(&self) -> Result<[f64; N], usize> {
        match self {
            Self::All(value) => Ok([*value; N]),
            Self::Each(values) => <[f64; N]>::try_from(values.as_slice()).map_err(|_| values.len()),
        }
    }
}
