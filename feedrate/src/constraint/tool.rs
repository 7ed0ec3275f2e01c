//! Limits of the tool: feed, speed, acceleration and jerk along the path.

use super::interface::{PathConstraint, Place, RowSink, Within};
use crate::error::{FeedError, positive};
use crate::row::{IntervalBound, JerkRow, LimitId, Quantity, Row};

/// A cap on `ds/dt` at every grid point, from whatever source: see [`crate::caps`] for normal
/// acceleration, normal jerk and chord error from the curvature, and divide a limit on angular
/// speed by `|d angle / ds|`.
#[derive(Debug, Clone, Copy)]
pub struct SpeedCap<'a> {
    speeds: &'a [f64],
    on_intervals: Option<&'a [f64]>,
    source: LimitId,
}

impl<'a> SpeedCap<'a> {
    /// Greatest `ds/dt` at each grid point, not negative; infinity means none.
    ///
    /// # Errors
    /// [`FeedError::Empty`], [`FeedError::Negative`] (also for NaN).
    pub fn new(speeds: &'a [f64], quantity: Quantity) -> Result<Self, FeedError> {
        if speeds.is_empty() {
            return Err(FeedError::Empty { what: "speed caps" });
        }
        match speeds.iter().find(|v| v.is_nan() || **v < 0.0) {
            Some(&value) => Err(FeedError::Negative { what: "speed cap", value }),
            None => Ok(Self { speeds, on_intervals: None, source: LimitId::path(quantity) }),
        }
    }

    /// Gives the greatest `ds/dt` on the whole of every interval (one less than there are points).
    /// Without it the lower of both ends is taken, which holds where the cap does not sag between
    /// the points.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`], [`FeedError::Negative`] (also for NaN).
    pub fn with_intervals(mut self, speeds: &'a [f64]) -> Result<Self, FeedError> {
        let (got, expected) = (speeds.len(), self.speeds.len() - 1);
        if got != expected {
            return Err(FeedError::LengthMismatch { what: "speed caps on the intervals", got, expected });
        }
        if let Some(&value) = speeds.iter().find(|v| v.is_nan() || **v < 0.0) {
            return Err(FeedError::Negative { what: "speed cap", value });
        }
        self.on_intervals = Some(speeds);
        Ok(self)
    }
}

impl PathConstraint for SpeedCap<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.speeds.len())
    }

    /// In the middle of an interval the mean of both squares is taken: a cap is what its caller
    /// says it is at the points.
    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let square = |i: usize| self.speeds[i] * self.speeds[i];
        match place {
            Place::Point(i) => out.cap(square(i), self.source),
            Place::Middle { k, .. } => out.cap(0.5 * (square(k) + square(k + 1)), self.source),
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        let most = match self.on_intervals {
            Some(speeds) => speeds[k],
            None => self.speeds[k].min(self.speeds[k + 1]),
        };
        if most.is_finite() {
            out.push(IntervalBound::Speed { most, source: self.source });
        }
    }
}

/// A programmed feed per section of the path; where two sections meet, the lower one counts.
#[derive(Debug, Clone, Copy)]
pub struct Feed<'a> {
    per_interval: &'a [f64],
}

impl<'a> Feed<'a> {
    /// Greatest `ds/dt` in each interval of the grid (one less than there are points), above 0.
    ///
    /// # Errors
    /// [`FeedError::Empty`], [`FeedError::NotPositive`] (also for NaN).
    pub fn new(per_interval: &'a [f64]) -> Result<Self, FeedError> {
        if per_interval.is_empty() {
            return Err(FeedError::Empty { what: "feeds" });
        }
        match per_interval.iter().find(|v| !(**v > 0.0)) {
            Some(&value) => Err(FeedError::NotPositive { what: "feed", value }),
            None => Ok(Self { per_interval }),
        }
    }
}

impl PathConstraint for Feed<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.per_interval.len() + 1)
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let mut cap = |k: Option<&f64>| {
            if let Some(v) = k {
                out.cap(v * v, LimitId::path(Quantity::Feed));
            }
        };
        match place {
            Place::Point(i) => {
                cap(self.per_interval.get(i));
                cap(i.checked_sub(1).and_then(|k| self.per_interval.get(k)));
            }
            Place::Middle { k, .. } => cap(self.per_interval.get(k)),
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        out.push(IntervalBound::Speed { most: self.per_interval[k], source: LimitId::path(Quantity::Feed) });
    }

    fn axis_speeds(&self, k: usize, _h: f64, out: &mut dyn FnMut([f64; 3], f64, LimitId)) {
        out([1.0; 3], self.per_interval[k], LimitId::path(Quantity::Feed));
    }
}

/// `|u| <= a`: tangential acceleration.
#[derive(Debug, Clone, Copy)]
pub struct TangentialAcceleration(f64);

impl TangentialAcceleration {
    /// The limit (m/s²), above 0 and finite.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn new(limit: f64) -> Result<Self, FeedError> {
        positive("tangential acceleration", limit).map(Self)
    }
}

impl PathConstraint for TangentialAcceleration {
    fn points(&self) -> Option<usize> {
        None
    }

    fn rows(&self, _place: Place, out: &mut RowSink<'_>) {
        out.row(Row::symmetric(1.0, 0.0, self.0, LimitId::path(Quantity::TangentialAcceleration)));
    }
}

/// `|w sdot| <= jerk`: tangential jerk.
#[derive(Debug, Clone, Copy)]
pub struct TangentialJerk(f64);

impl TangentialJerk {
    /// The limit (m/s³), above 0 and finite.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn new(limit: f64) -> Result<Self, FeedError> {
        positive("tangential jerk", limit).map(Self)
    }
}

impl PathConstraint for TangentialJerk {
    fn points(&self) -> Option<usize> {
        None
    }

    fn rows(&self, _place: Place, _out: &mut RowSink<'_>) {}

    fn jerk_rows(&self, _k: usize, _h: f64, _within: Within, out: &mut Vec<JerkRow>) {
        let source = LimitId::path(Quantity::TangentialJerk);
        out.push(JerkRow { alpha: 1.0, beta: 0.0, gamma: 0.0, step: 0.0, limit: self.0, source });
    }
}

/// A point at which the motion has to stop, such as a corner of the path.
#[derive(Debug, Clone, Copy)]
pub struct Stop {
    /// Index of the grid point.
    pub at: usize,
}

impl PathConstraint for Stop {
    fn points(&self) -> Option<usize> {
        None
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        if place == Place::Point(self.at) {
            out.cap(0.0, LimitId::path(Quantity::Corner));
        }
    }
}
