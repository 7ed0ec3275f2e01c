//! Limits of the tool along a path; those of the joints come from the kinematics crate.

use crate::error::{LimitError, positive};

/// Limits of the tool's motion along the path; each that is not set leaves the matter to the joints.
///
/// ```
/// use arcfeed_interp::ToolLimits;
/// let tool = ToolLimits::new().with_feed(0.1)?.with_normal_acceleration(1.0)?;
/// assert_eq!((tool.feed(), tool.angular_speed()), (Some(0.1), None));
/// assert!(tool.with_tangential_jerk(-1.0).is_err());
/// # Ok::<(), arcfeed_interp::LimitError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ToolLimits {
    feed: Option<f64>,
    tangential_acceleration: Option<f64>,
    tangential_jerk: Option<f64>,
    normal_acceleration: Option<f64>,
    normal_jerk: Option<f64>,
    angular_speed: Option<f64>,
    acceleration: Option<f64>,
    jerk: Option<f64>,
}

impl ToolLimits {
    /// No limits yet.
    pub const fn new() -> Self {
        Self {
            feed: None,
            tangential_acceleration: None,
            tangential_jerk: None,
            normal_acceleration: None,
            normal_jerk: None,
            angular_speed: None,
            acceleration: None,
            jerk: None,
        }
    }

    /// With a programmed feed, m/s: the highest speed of the tool point.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_feed(self, feed: f64) -> Result<Self, LimitError> {
        Ok(Self { feed: Some(positive("feed rate", feed)?), ..self })
    }

    /// With a highest tangential acceleration, either sign, m/s^2.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_tangential_acceleration(self, limit: f64) -> Result<Self, LimitError> {
        Ok(Self { tangential_acceleration: Some(positive("tangential acceleration", limit)?), ..self })
    }

    /// With a highest tangential jerk, either sign, m/s^3.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_tangential_jerk(self, limit: f64) -> Result<Self, LimitError> {
        Ok(Self { tangential_jerk: Some(positive("tangential jerk", limit)?), ..self })
    }

    /// With a highest normal (centripetal) acceleration, m/s^2.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_normal_acceleration(self, limit: f64) -> Result<Self, LimitError> {
        Ok(Self { normal_acceleration: Some(positive("normal acceleration", limit)?), ..self })
    }

    /// With a highest jerk that the curvature causes at constant speed, kappa^2 v^3, m/s^3.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_normal_jerk(self, limit: f64) -> Result<Self, LimitError> {
        Ok(Self { normal_jerk: Some(positive("normal jerk", limit)?), ..self })
    }

    /// With a highest angular speed of the tool, rad/s.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_angular_speed(self, limit: f64) -> Result<Self, LimitError> {
        Ok(Self { angular_speed: Some(positive("angular speed", limit)?), ..self })
    }

    /// With a highest magnitude of the acceleration vector of the tool point, along and across the path together, m/s^2.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_acceleration(self, limit: f64) -> Result<Self, LimitError> {
        Ok(Self { acceleration: Some(positive("acceleration of the tool", limit)?), ..self })
    }

    /// With a highest magnitude of the jerk vector of the tool point, m/s^3.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_jerk(self, limit: f64) -> Result<Self, LimitError> {
        Ok(Self { jerk: Some(positive("jerk of the tool", limit)?), ..self })
    }

    /// Programmed feed, m/s.
    pub const fn feed(&self) -> Option<f64> {
        self.feed
    }

    /// Highest tangential acceleration, m/s^2.
    pub const fn tangential_acceleration(&self) -> Option<f64> {
        self.tangential_acceleration
    }

    /// Highest tangential jerk, m/s^3.
    pub const fn tangential_jerk(&self) -> Option<f64> {
        self.tangential_jerk
    }

    /// Highest normal acceleration, m/s^2.
    pub const fn normal_acceleration(&self) -> Option<f64> {
        self.normal_acceleration
    }

    /// Highest jerk by curvature at constant speed, m/s^3.
    pub const fn normal_jerk(&self) -> Option<f64> {
        self.normal_jerk
    }

    /// Highest angular speed of the tool, rad/s.
    pub const fn angular_speed(&self) -> Option<f64> {
        self.angular_speed
    }

    /// Highest magnitude of the acceleration vector, m/s^2.
    pub const fn acceleration(&self) -> Option<f64> {
        self.acceleration
    }

    /// Highest magnitude of the jerk vector, m/s^3.
    pub const fn jerk(&self) -> Option<f64> {
        self.jerk
    }
}
