//! Limits that may change while the motion runs.

use crate::error::{FeedError, below_zero, not_negative, positive};
use crate::state_to_state::{AxisLimits, AxisState};

/// Bounds `v <= v_max`, `a_min <= a <= a_max`, `j_min <= j <= j_max` of a motion that runs forward only.
///
/// `v_max = 0` holds the motion: it stops as soon as possible and waits.
///
/// ```
/// use arcfeed_feedrate::FeedLimits;
/// let full = FeedLimits::new(0.1, (-2.0, 1.0), (-50.0, 40.0))?;
/// let half = full.with_v_max(0.05)?;
/// let hold = full.with_v_max(0.0)?;
/// assert_eq!((half.v_max(), hold.a_min()), (0.05, -2.0));
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedLimits {
    pub(super) v_max: f64,
    pub(super) a: (f64, f64),
    pub(super) j: (f64, f64),
}

impl FeedLimits {
    /// Highest speed (m/s), and `(lower, upper)` bounds of acceleration (m/s²) and jerk (m/s³).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::Negative`], [`FeedError::NotPositive`] or [`FeedError::NotBelowZero`]
    /// naming the bound.
    pub fn new(v_max: f64, a: (f64, f64), j: (f64, f64)) -> Result<Self, FeedError> {
        Ok(Self {
            v_max: not_negative("v_max", v_max)?,
            a: (below_zero("a_min", a.0)?, positive("a_max", a.1)?),
            j: (below_zero("j_min", j.0)?, positive("j_max", j.1)?),
        })
    }

    /// The same limits with another highest speed (m/s).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] or [`FeedError::Negative`].
    pub fn with_v_max(self, v_max: f64) -> Result<Self, FeedError> {
        Ok(Self { v_max: not_negative("v_max", v_max)?, ..self })
    }

    /// Highest speed, 0 for a hold (m/s).
    pub const fn v_max(&self) -> f64 {
        self.v_max
    }
    /// Lowest acceleration, below 0 (m/s²).
    pub const fn a_min(&self) -> f64 {
        self.a.0
    }
    /// Highest acceleration, above 0 (m/s²).
    pub const fn a_max(&self) -> f64 {
        self.a.1
    }
    /// Lowest jerk, below 0 (m/s³).
    pub const fn j_min(&self) -> f64 {
        self.j.0
    }
    /// Highest jerk, above 0 (m/s³).
    pub const fn j_max(&self) -> f64 {
        self.j.1
    }

    /// The wider of both in acceleration and jerk, with the speed of `self`.
    pub(super) fn widened_by(&self, other: &Self) -> Self {
        let union = |x: (f64, f64), y: (f64, f64)| (x.0.min(y.0), x.1.max(y.1));
        Self { v_max: self.v_max, a: union(self.a, other.a), j: union(self.j, other.j) }
    }

    /// For the solver, which wants a lower bound of the speed: what reaches it is refused afterwards.
    pub(super) fn as_axis(&self) -> Result<AxisLimits, crate::StateToStateError> {
        AxisLimits::new((-self.v_max, self.v_max), self.a, self.j)
    }

    /// The end speed and acceleration must be possible at all: inside the acceleration limits, and neither entered nor left from
    /// below zero.
    pub(super) fn check_end(&self, end: &AxisState) -> Result<(), FeedError> {
        not_negative("end.v", end.v)?;
        if end.a > self.a.1 {
            return Err(FeedError::AboveLimit { what: "end.a", value: end.a, limit: self.a.1 });
        }
        if end.a < self.a.0 {
            return Err(FeedError::BelowLimit { what: "end.a", value: end.a, limit: self.a.0 });
        }
        let gained = 0.5 * end.a.max(0.0) * (end.a / self.j.1);
        if gained > end.v * (1.0 + 1e-13) {
            return Err(FeedError::BelowLimit { what: "end.v", value: end.v, limit: gained });
        }
        Ok(())
    }

    /// Highest speed that arriving in `end` takes.
    pub(super) fn entry_speed(&self, end: &AxisState) -> f64 {
        end.v + 0.5 * end.a.min(0.0) * (end.a / -self.j.0)
    }
}
