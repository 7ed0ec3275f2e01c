//! Values of a job for the joints of an arm.

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

/// A value for the joints of an arm whose number the job does not know.
#[derive(Debug, Clone, PartialEq)]
pub enum JointValues {
    /// The same for all joints.
    All(f64),
    /// One for each joint.
    Each(Vec<f64>),
}

impl JointValues {
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
