//! Limits of the tool along a path; those of the joints come from the kinematics crate.

use crate::error::PlanError;

/// Limits of the tool's motion along the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolLimits {
    /// Programmed feed rate, m/s: the highest speed of the tool point.
    pub feed: f64,
    /// Highest tangential acceleration, either sign, m/s^2.
    pub tangential_acceleration: f64,
    /// Highest tangential jerk, either sign, m/s^3.
    pub tangential_jerk: f64,
    /// Highest normal (centripetal) acceleration, m/s^2.
    pub normal_acceleration: f64,
    /// Highest jerk that the curvature causes at constant speed, kappa^2 v^3, m/s^3; `None` leaves it to the joints.
    pub normal_jerk: Option<f64>,
    /// Highest angular speed of the tool, rad/s; `None` leaves it to the joints.
    pub angular_speed: Option<f64>,
}

impl ToolLimits {
    /// Checks that every limit is a finite number above 0.
    ///
    /// # Errors
    /// [`PlanError::Limit`] naming the first that is not.
    pub fn check(&self) -> Result<(), PlanError> {
        for (what, value) in [
            ("feed rate", self.feed),
            ("tangential acceleration", self.tangential_acceleration),
            ("tangential jerk", self.tangential_jerk),
            ("normal acceleration", self.normal_acceleration),
            ("normal jerk", self.normal_jerk.unwrap_or(1.0)),
            ("angular speed", self.angular_speed.unwrap_or(1.0)),
        ] {
            positive(what, value)?;
        }
        Ok(())
    }
}

impl ToolLimits {
    /// The same limits at another feed.
    pub(crate) fn at_feed(self, feed: f64) -> Self {
        Self { feed, ..self }
    }
}

pub(crate) fn positive(what: &'static str, value: f64) -> Result<(), PlanError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(PlanError::Limit { what, value }) }
}
