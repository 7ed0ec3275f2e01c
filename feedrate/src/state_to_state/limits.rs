//! Limits of one axis, each sign on its own, and the state of the axis.

use super::error::{StateToStateError, finite};
use crate::limits::MotionLimits;

/// Position, velocity and acceleration of one axis at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisState {
    /// Position (m or rad).
    pub p: f64,
    /// Velocity (1/s).
    pub v: f64,
    /// Acceleration (1/s²).
    pub a: f64,
}

impl AxisState {
    /// A state of motion.
    pub const fn new(p: f64, v: f64, a: f64) -> Self {
        Self { p, v, a }
    }

    /// At rest at a position.
    pub const fn rest(p: f64) -> Self {
        Self { p, v: 0.0, a: 0.0 }
    }
}

/// Bounds `v_min <= v <= v_max`, `a_min <= a <= a_max`, `j_min <= j <= j_max` with every lower bound below and every upper
/// bound above zero.
///
/// ```
/// use arcfeed_feedrate::AxisLimits;
/// let limits = AxisLimits::new((-0.2, 1.0), (-8.0, 5.0), (-80.0, 50.0))?;
/// assert_eq!(limits.a_min(), -8.0);
/// assert!(AxisLimits::new((0.0, 1.0), (-8.0, 5.0), (-80.0, 50.0)).is_err());
/// # Ok::<(), arcfeed_feedrate::StateToStateError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits {
    pub(super) v: (f64, f64),
    pub(super) a: (f64, f64),
    pub(super) j: (f64, f64),
}

impl AxisLimits {
    /// Bounds as `(lower, upper)` on velocity (1/s), acceleration (1/s²) and jerk (1/s³).
    ///
    /// # Errors
    /// [`StateToStateError::NotFinite`] or [`StateToStateError::LimitSign`] naming the bound.
    pub fn new(v: (f64, f64), a: (f64, f64), j: (f64, f64)) -> Result<Self, StateToStateError> {
        let below = |what, x| match finite(what, x)? {
            x if x < 0.0 => Ok(x),
            value => Err(StateToStateError::LimitSign { what, value }),
        };
        let above = |what, x| match finite(what, x)? {
            x if x > 0.0 => Ok(x),
            value => Err(StateToStateError::LimitSign { what, value }),
        };
        Ok(Self {
            v: (below("v_min", v.0)?, above("v_max", v.1)?),
            a: (below("a_min", a.0)?, above("a_max", a.1)?),
            j: (below("j_min", j.0)?, above("j_max", j.1)?),
        })
    }

    /// The same bound in both directions.
    ///
    /// # Errors
    /// As [`AxisLimits::new`].
    pub fn symmetric(v_max: f64, a_max: f64, j_max: f64) -> Result<Self, StateToStateError> {
        Self::new((-v_max, v_max), (-a_max, a_max), (-j_max, j_max)).map_err(|e| match e {
            // The caller gave upper bounds only: name those.
            StateToStateError::NotFinite { what, value } => {
                StateToStateError::NotFinite { what: upper(what), value: -value }
            }
            StateToStateError::LimitSign { what, value } => {
                StateToStateError::LimitSign { what: upper(what), value: -value }
            }
            other => other,
        })
    }

    /// Whether velocity and acceleration of a state are inside, but for round-off, and will stay inside: the velocity, too, with
    /// which the acceleration can be zero at the soonest.
    pub fn contain(&self, s: &AxisState) -> bool {
        self.contain_now(s) && inside(self.velocity_after(s), self.v)
    }

    /// Whether a motion that has arrived in `target` can go on within its velocity limits: at the soonest the acceleration is zero
    /// at another velocity.
    ///
    /// # Errors
    /// [`StateToStateError::TargetOvershoots`] with that velocity.
    ///
    /// ```
    /// use arcfeed_feedrate::{AxisLimits, AxisState};
    /// let limits = AxisLimits::symmetric(1.0, 5.0, 50.0)?;
    /// assert!(limits.check_leaving(&AxisState::new(0.0, 0.9, 2.0)).is_ok());
    /// // With jerk -50 the velocity rises to 0.9 + 4² / 100 = 1.06 before the acceleration is zero.
    /// assert!(limits.check_leaving(&AxisState::new(0.0, 0.9, 4.0)).is_err());
    /// # Ok::<(), arcfeed_feedrate::StateToStateError>(())
    /// ```
    pub fn check_leaving(&self, target: &AxisState) -> Result<(), StateToStateError> {
        let after = self.velocity_after(target);
        if inside(after, self.v) {
            return Ok(());
        }
        let limit = if after > 0.0 { self.v.1 } else { self.v.0 };
        Err(StateToStateError::TargetOvershoots { v: target.v, a: target.a, after, limit })
    }

    /// The velocity with which the acceleration of `s` can be zero at the soonest.
    pub fn velocity_after(&self, s: &AxisState) -> f64 {
        let jerk = if s.a > 0.0 { -self.j.0 } else { -self.j.1 };
        s.v + 0.5 * s.a * s.a / jerk
    }

    /// Whether velocity and acceleration of a state are inside, but for round-off.
    pub fn contain_now(&self, s: &AxisState) -> bool {
        inside(s.v, self.v) && inside(s.a, self.a)
    }

    /// Lowest velocity, below 0 (1/s).
    pub const fn v_min(&self) -> f64 {
        self.v.0
    }
    /// Highest velocity, above 0 (1/s).
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

fn inside(x: f64, (lower, upper): (f64, f64)) -> bool {
    let slack = SLACK * upper.max(-lower);
    x >= lower - slack && x <= upper + slack
}

/// How far beyond a limit, relative to the larger of the two, a state still counts as inside: round-off in the caller's
/// arithmetic must not change the answer.
pub(super) const SLACK: f64 = 1e-13;

fn upper(what: &'static str) -> &'static str {
    match what {
        "v_min" => "v_max",
        "a_min" => "a_max",
        "j_min" => "j_max",
        other => other,
    }
}

impl From<MotionLimits> for AxisLimits {
    fn from(l: MotionLimits) -> Self {
        Self { v: (-l.v_max(), l.v_max()), a: (-l.a_max(), l.a_max()), j: (-l.j_max(), l.j_max()) }
    }
}
