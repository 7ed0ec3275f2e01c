//! Ranges of positions that are set, and what they change of the motion under way.

use arcfeed_feedrate::{AxisState, PositionLimits};

use super::OnlineGenerator;
use super::command::Command;
use super::following::Following;
use crate::error::SyncError;
use crate::way_points::RouteMemory;

impl<const N: usize, R: RouteMemory<N>> OnlineGenerator<N, R> {
    /// The range of positions of each axis, lower and upper end; infinite for none.
    ///
    /// Where the scale of time is neither 1 nor 0 and cannot go on so with what has to follow the target now,
    /// the motion is planned anew from the state commanded last, at scale 1; a stop on the path becomes a
    /// shortest stop, and the last section of a route a motion to its target. After
    /// [`OnlineGenerator::hold`] the axes may become faster once more before they rest.
    ///
    /// # Errors
    /// [`SyncError::Range`]; [`SyncError::OutsideRange`] if a start or target is outside;
    /// [`SyncError::CannotStop`] and [`SyncError::LeavesRange`] if what is under way leaves it.
    ///
    /// ```
    /// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
    /// use arcfeed_sync::{OnlineGenerator, SyncError, Synchronisation};
    /// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?];
    /// let generator = OnlineGenerator::new([AxisState::rest(0.0)], limits, 1e-3, Synchronisation::Time)?;
    /// let mut generator = generator.with_ranges([(-2.0, 2.0)])?;
    /// assert!(matches!(generator.set_target([AxisState::rest(2.5)]), Err(SyncError::OutsideRange { axis: 0, .. })));
    /// // Goes on with 0.5 / s after the target, and stops where the range ends.
    /// generator.set_target([AxisState::new(1.0, 0.5, 0.0)])?;
    /// for _ in 0..10_000 {
    ///     generator.step();
    /// }
    /// assert_eq!(generator.state()[0], AxisState::rest(2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_ranges(mut self, ranges: [(f64, f64); N]) -> Result<Self, SyncError> {
        for (axis, (lower, upper)) in ranges.into_iter().enumerate() {
            self.ranges[axis] =
                PositionLimits::new(lower, upper).map_err(|_| SyncError::Range { axis, lower, upper })?;
        }
        self.check_inside("start", &self.planned)?;
        self.check_inside("target", &self.target)?;
        if matches!(self.command, Command::PathStop { .. }) && !self.is_underway() {
            // Behind the end of the path there is none to stop on, and the scale of time does not know the new ends.
            self.stop()?;
            return Ok(self);
        }
        if let Command::Jog { velocity, left } = self.command {
            self.begin_jog(velocity, left, self.limits)?;
            return Ok(self);
        }
        let next = self.following_within_ranges()?;
        if self.fits_next(&next) {
            self.following = next;
        } else if matches!(self.command, Command::PathStop { .. }) {
            self.stop()?;
        } else {
            let (target, limits) = (self.target, self.limits);
            self.plan_from_commanded(&target, &limits)?;
        }
        Ok(self)
    }

    /// What is under way, with what follows it inside the ranges.
    fn following_within_ranges(&self) -> Result<Following<N>, SyncError> {
        let mut next = self.following;
        if next.section.is_some() {
            return self.route_within_ranges(next);
        }
        for k in 0..N {
            let (limits, range, axis) = (&self.limits[k], &self.ranges[k], self.following.axes[k]);
            if axis.underway {
                next.lead(k, axis.planned, &self.target[k], limits, range)?;
                next.axes[k].steps = axis.steps;
            } else {
                next.coast(k, (&self.planned[k], &self.planned[k]), (limits, range), self.cycle)?;
            }
        }
        Ok(next)
    }

    /// Returns true if the scale of time can go on as it does with what follows now. What it was judged by
    /// before and has not changed is not judged again: the judge of ramps refuses some that keep the limits.
    fn fits_next(&self, next: &Following<N>) -> bool {
        let limits = match &self.command {
            Command::PathStop { limits } => limits,
            _ => &self.limits,
        };
        next.goes_on_as(&self.following) || self.scale_fits(next, self.route.motion(), limits)
    }

    pub(super) fn check_inside(&self, what: &'static str, states: &[AxisState; N]) -> Result<(), SyncError> {
        for (axis, (range, s)) in self.ranges.iter().zip(states).enumerate() {
            let (lower, upper) = (range.lower(), range.upper());
            // The planner says what is not a number.
            if !range.contain(s.p) && !s.p.is_nan() {
                return Err(SyncError::OutsideRange { axis, what, position: s.p, lower, upper });
            }
        }
        Ok(())
    }
}
