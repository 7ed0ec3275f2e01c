//! Synchronisation of the axes of one motion.

use crate::error::SyncError;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Synchronisation of the axes of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Synchronisation {
    /// Nothing: every axis moves as fast as it can and arrives on its own.
    None,
    /// The end: all axes arrive at the same time, the earliest that is possible.
    #[default]
    Time,
    /// The line, wherever both states lie on one: all axes move in proportion, exactly straight, as
    /// fast as that allows. Otherwise as [`Synchronisation::Time`].
    StraightLine,
    /// The line or nothing: a motion that cannot be straight is refused.
    ForcedStraight,
}

/// Choices for a motion between two states.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionOptions {
    synchronisation: Synchronisation,
    least_duration: f64,
    cycle: Option<f64>,
}

impl MotionOptions {
    /// As fast as possible, with the axes together as told.
    pub const fn new(synchronisation: Synchronisation) -> Self {
        Self { synchronisation, least_duration: 0.0, cycle: None }
    }

    /// The motion takes at least this long (s): exactly, unless that duration is impossible.
    ///
    /// # Errors
    /// [`SyncError::Duration`] if it is not finite or negative.
    pub fn with_least_duration(self, least_duration: f64) -> Result<Self, SyncError> {
        if !(least_duration.is_finite() && least_duration >= 0.0) {
            return Err(SyncError::Duration { value: least_duration });
        }
        Ok(Self { least_duration, ..self })
    }

    /// The duration is a multiple of the control cycle (s), the shortest that is possible.
    ///
    /// # Errors
    /// [`SyncError::Cycle`] if the cycle is not finite or not above 0.
    pub fn with_cycle(self, cycle: f64) -> Result<Self, SyncError> {
        if !(cycle.is_finite() && cycle > 0.0) {
            return Err(SyncError::Cycle { value: cycle });
        }
        Ok(Self { cycle: Some(cycle), ..self })
    }

    /// The synchronisation of the axes.
    pub const fn synchronisation(&self) -> Synchronisation {
        self.synchronisation
    }

    /// The least duration (s).
    pub const fn least_duration(&self) -> f64 {
        self.least_duration
    }

    /// The control cycle (s) of which the duration is a multiple.
    pub const fn cycle(&self) -> Option<f64> {
        self.cycle
    }

    /// The first duration allowed by these choices from `t` on, never below `t`. Numbers of 2^53 cycles and more are farther
    /// apart than a cycle: each of them counts as a multiple.
    pub(crate) fn round_up(&self, t: f64) -> f64 {
        let t = t.max(self.least_duration);
        let Some(cycle) = self.cycle else { return t };
        let n = (t / cycle).ceil();
        if n >= COUNTABLE {
            return t;
        }
        let rounded = n * cycle;
        if rounded < t { (n + 1.0) * cycle } else { rounded }
    }
}

/// Integers from here on have no neighbours: adding 1 changes nothing.
const COUNTABLE: f64 = (1_u64 << 53) as f64;
