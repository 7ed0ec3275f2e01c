//! Limits on velocity, acceleration and jerk.

use crate::error::{FeedError, below_zero, not_negative, positive};
use crate::state::AxisState;

/// Bounds `v_min <= v <= v_max`, `a_min <= a <= a_max`, `j_min <= j <= j_max` of a motion on one
/// scalar.
///
/// Every lower bound is below and every upper bound above zero. Limits made by
/// [`AxisLimits::forward`] are the exception: their velocity is within `[0, v_max]`, and
/// `v_max = 0` holds the motion.
///
/// ```
/// use arcfeed_feedrate::AxisLimits;
/// let limits = AxisLimits::new((-0.2, 1.0), (-8.0, 5.0), (-80.0, 50.0))?;
/// assert_eq!(limits.a_min(), -8.0);
/// assert!(AxisLimits::new((0.0, 1.0), (-8.0, 5.0), (-80.0, 50.0)).is_err());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits {
    pub(crate) v: (f64, f64),
    pub(crate) a: (f64, f64),
    pub(crate) j: (f64, f64),
}

impl AxisLimits {
    /// Bounds as `(lower, upper)` on velocity (1/s), acceleration (1/s²) and jerk (1/s³).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`] or [`FeedError::NotBelowZero`] naming
    /// the bound.
    pub fn new(v: (f64, f64), a: (f64, f64), j: (f64, f64)) -> Result<Self, FeedError> {
        Ok(Self {
            v: (below_zero("v_min", v.0)?, positive("v_max", v.1)?),
            a: (below_zero("a_min", a.0)?, positive("a_max", a.1)?),
            j: (below_zero("j_min", j.0)?, positive("j_max", j.1)?),
        })
    }

    /// The same bound in both directions: `|v| <= v_max`, `|a| <= a_max`, `|j| <= j_max`.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] or [`FeedError::NotPositive`] naming the bound.
    ///
    /// ```
    /// use arcfeed_feedrate::AxisLimits;
    /// let limits = AxisLimits::symmetric(0.1, 1.0, 50.0)?;
    /// assert_eq!(limits.a_min(), -1.0);
    /// assert!(AxisLimits::symmetric(0.1, 0.0, 50.0).is_err());
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    pub fn symmetric(v_max: f64, a_max: f64, j_max: f64) -> Result<Self, FeedError> {
        Ok(Self::symmetric_unchecked(positive("v_max", v_max)?, positive("a_max", a_max)?, positive("j_max", j_max)?))
    }

    /// Bounds of a motion that runs forward only: `0 <= v <= v_max`, with `(lower, upper)` bounds
    /// on acceleration and jerk.
    ///
    /// `v_max = 0` holds the motion of a [`FeedScheduler`](crate::FeedScheduler): it stops as soon
    /// as possible and waits.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::Negative`], [`FeedError::NotPositive`] or
    /// [`FeedError::NotBelowZero`] naming the bound.
    ///
    /// ```
    /// use arcfeed_feedrate::AxisLimits;
    /// let full = AxisLimits::forward(0.1, (-2.0, 1.0), (-50.0, 40.0))?;
    /// let half = full.with_v_max(0.05)?;
    /// let hold = full.with_v_max(0.0)?;
    /// assert_eq!((half.v_max(), hold.v_max(), hold.a_min()), (0.05, 0.0, -2.0));
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    pub fn forward(v_max: f64, a: (f64, f64), j: (f64, f64)) -> Result<Self, FeedError> {
        Ok(Self {
            v: (0.0, not_negative("v_max", v_max)?),
            a: (below_zero("a_min", a.0)?, positive("a_max", a.1)?),
            j: (below_zero("j_min", j.0)?, positive("j_max", j.1)?),
        })
    }

    /// Symmetric bounds that the caller has validated.
    pub(crate) const fn symmetric_unchecked(v_max: f64, a_max: f64, j_max: f64) -> Self {
        Self { v: (-v_max, v_max), a: (-a_max, a_max), j: (-j_max, j_max) }
    }

    /// The same limits with another highest velocity (1/s), which may be 0 for a forward motion
    /// only.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::Negative`] or [`FeedError::NotPositive`].
    pub fn with_v_max(self, v_max: f64) -> Result<Self, FeedError> {
        let v_max = not_negative("v_max", v_max)?;
        let v_max = if self.v.0 < 0.0 { positive("v_max", v_max)? } else { v_max };
        Ok(Self { v: (self.v.0, v_max), ..self })
    }

    /// Returns an error unless all bounds are the same in both directions.
    ///
    /// # Errors
    /// [`FeedError::NotSymmetric`] naming the quantity.
    pub fn check_symmetric(&self) -> Result<(), FeedError> {
        symmetric("v", self.v)?;
        self.check_symmetric_acceleration()
    }

    /// As [`AxisLimits::check_symmetric`], for acceleration and jerk only.
    pub(crate) fn check_symmetric_acceleration(&self) -> Result<(), FeedError> {
        symmetric("a", self.a)?;
        symmetric("j", self.j)
    }

    /// Returns an error unless the velocity may have either sign.
    pub(crate) fn check_both_directions(&self) -> Result<(), FeedError> {
        below_zero("v_min", self.v.0)?;
        positive("v_max", self.v.1).map(|_| ())
    }

    /// Returns true if velocity and acceleration of a state are inside, but for round-off, and can
    /// stay inside: the velocity, too, with which the acceleration can be zero at the soonest.
    pub fn contain(&self, s: &AxisState) -> bool {
        self.contain_now(s) && inside(self.velocity_after(s), self.v)
    }

    /// Returns an error if a motion that has arrived in `target` cannot go on within its velocity
    /// limits: at the soonest the acceleration is zero at another velocity.
    ///
    /// # Errors
    /// [`FeedError::TargetOvershoots`] with that velocity.
    ///
    /// ```
    /// use arcfeed_feedrate::{AxisLimits, AxisState};
    /// let limits = AxisLimits::symmetric(1.0, 5.0, 50.0)?;
    /// assert!(limits.check_leaving(&AxisState::new(0.0, 0.9, 2.0)).is_ok());
    /// // With jerk -50 the velocity rises to 0.9 + 4² / 100 = 1.06 before the acceleration is zero.
    /// assert!(limits.check_leaving(&AxisState::new(0.0, 0.9, 4.0)).is_err());
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    pub fn check_leaving(&self, target: &AxisState) -> Result<(), FeedError> {
        let after = self.velocity_after(target);
        if inside(after, self.v) {
            return Ok(());
        }
        let limit = if after > 0.0 { self.v.1 } else { self.v.0 };
        Err(FeedError::TargetOvershoots { v: target.v, a: target.a, after, limit })
    }

    /// The velocity with which the acceleration of `s` can be zero at the soonest.
    pub fn velocity_after(&self, s: &AxisState) -> f64 {
        let jerk = if s.a > 0.0 { -self.j.0 } else { -self.j.1 };
        s.v + 0.5 * s.a * s.a / jerk
    }

    /// Returns true if velocity and acceleration of a state are inside, but for round-off.
    pub fn contain_now(&self, s: &AxisState) -> bool {
        inside(s.v, self.v) && inside(s.a, self.a)
    }

    /// Lowest velocity, below 0, or 0 for a forward motion (1/s).
    pub const fn v_min(&self) -> f64 {
        self.v.0
    }
    /// Highest velocity, above 0, or 0 for a hold (1/s).
    pub const fn v_max(&self) -> f64 {
        self.v.1
    }
    /// Lowest acceleration, below 0 (1/s²).
    pub const fn a_min(&self) -> f64 {
        self.a.0
    }
    /// Highest acceleration, above 0 (1/s²).
    pub const fn a_max(&self) -> f64 {
        self.a.1
    }
    /// Lowest jerk, below 0 (1/s³).
    pub const fn j_min(&self) -> f64 {
        self.j.0
    }
    /// Highest jerk, above 0 (1/s³).
    pub const fn j_max(&self) -> f64 {
        self.j.1
    }
}

fn symmetric(what: &'static str, (lower, upper): (f64, f64)) -> Result<(), FeedError> {
    if lower == -upper { Ok(()) } else { Err(FeedError::NotSymmetric { what, lower, upper }) }
}

fn inside(x: f64, (lower, upper): (f64, f64)) -> bool {
    let slack = SLACK * upper.max(-lower);
    x >= lower - slack && x <= upper + slack
}

/// Excess over a limit, relative to the larger of the two, that counts as round-off in the caller's
/// arithmetic.
pub(crate) const SLACK: f64 = 1e-13;
