//! Limits on speed, acceleration and jerk.

use crate::error::{FeedError, positive};

/// Symmetric bounds of a motion on one scalar: `|v| <= v_max`, `|a| <= a_max`, `|j| <= j_max`.
///
/// ```
/// use arcfeed_feedrate::MotionLimits;
/// let limits = MotionLimits::new(0.1, 1.0, 50.0)?;
/// assert_eq!(limits.a_max(), 1.0);
/// assert!(MotionLimits::new(0.1, 0.0, 50.0).is_err());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionLimits {
    v_max: f64,
    a_max: f64,
    j_max: f64,
}

impl MotionLimits {
    /// Bounds on speed (m/s), acceleration (m/s²) and jerk (m/s³).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] or [`FeedError::NotPositive`] naming the bound.
    pub fn new(v_max: f64, a_max: f64, j_max: f64) -> Result<Self, FeedError> {
        Ok(Self {
            v_max: positive("v_max", v_max)?,
            a_max: positive("a_max", a_max)?,
            j_max: positive("j_max", j_max)?,
        })
    }

    /// For callers inside the crate that have validated the three numbers already.
    pub(crate) const fn trusted(v_max: f64, a_max: f64, j_max: f64) -> Self {
        Self { v_max, a_max, j_max }
    }

    /// Largest speed (m/s).
    pub const fn v_max(&self) -> f64 {
        self.v_max
    }

    /// Largest acceleration, either sign (m/s²).
    pub const fn a_max(&self) -> f64 {
        self.a_max
    }

    /// Largest jerk, either sign (m/s³).
    pub const fn j_max(&self) -> f64 {
        self.j_max
    }
}
