//! Targets without a position: a velocity as soon as possible, a stop, a stop that stays inside a
//! range of positions.

use super::problem::{AxisProblem, check_target};
use super::profile::StateToState;
use crate::error::{FeedError, finite, not_negative};
use crate::limits::AxisLimits;
use crate::scurve::phase::Phase;
use crate::state::AxisState;

/// Doublings and halvings of the distance at which a stop is looked for.
const HALVINGS: usize = 64;

/// Difference of positions that counts as round-off, relative to their size.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

impl StateToState {
    /// The shortest motion to velocity `v` (m/s) and acceleration `a` (m/s²), wherever it ends.
    ///
    /// A start outside the limits is brought back on the way: no other motion is there earlier.
    ///
    /// ```
    /// use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
    /// let limits = AxisLimits::symmetric(2.0, 4.0, 40.0)?;
    /// let motion = StateToState::to_velocity(&AxisState::rest(0.0), 1.0, 0.0, &limits)?;
    /// assert!((motion.duration() - (1.0 / 4.0 + 4.0 / 40.0)).abs() < 1e-15);
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    ///
    /// # Errors
    /// As [`StateToState::new`].
    pub fn to_velocity(start: &AxisState, v: f64, a: f64, limits: &AxisLimits) -> Result<Self, FeedError> {
        for (what, value) in
            [("start.p", start.p), ("start.v", start.v), ("start.a", start.a), ("target.v", v), ("target.a", a)]
        {
            finite(what, value)?;
        }
        let target = AxisState::new(start.p, v, a);
        check_target(&target, limits)?;
        AxisProblem::direct(start, &target, limits)
    }

    /// The velocity of `start` becomes that of `target` in two phases of opposite jerk that last half
    /// of `duration` (s) each. With `d` the change of velocity and `T` the duration the jerk is
    /// `4 d / T²`, the largest acceleration `2 d / T`, and the way `T (v0 + v1) / 2`, so that
    /// `target.p` must be there but for round-off. The accelerations of `start` and `target` must be 0. A blend of no
    /// duration leads from a state to the same one, whose acceleration is free.
    ///
    /// Axes that do so together leave a corner between two lines: the first half stays within
    /// `T |d| / 12` of the first line and the second half of the second one.
    ///
    /// ```
    /// use arcfeed_feedrate::{AxisState, MotionLaw, StateToState};
    /// let motion = StateToState::blend(&AxisState::new(0.0, 1.0, 0.0), &AxisState::new(0.3, 0.5, 0.0), 0.4)?;
    /// let middle = motion.at(0.2);
    /// // Without the blend it would be at 0.2.
    /// assert!((middle.p - (0.2 - 0.4 * 0.5 / 12.0)).abs() < 1e-15 && (middle.a + 2.5).abs() < 1e-12);
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::Negative`], [`FeedError::NoBlend`] for a target that no such motion leads to,
    /// [`FeedError::OutOfRange`].
    pub fn blend(start: &AxisState, target: &AxisState, duration: f64) -> Result<Self, FeedError> {
        check_blend(start, target, duration)?;
        let half = 0.5 * duration;
        let begin = Phase { t: 0.0, s: start.p, v: start.v, a: 0.0, j: (target.v - start.v) / half / half };
        let middle = begin.after(half);
        let mut motion = Self::standing(target.p);
        if duration > 0.0 {
            motion.phases.push(begin, half);
            motion.phases.push(Phase { t: half, s: middle.p, v: middle.v, a: middle.a, j: -begin.j }, half);
        }
        motion.set_target(target, (0.0, 0.0));
        motion.check_sound()?;
        Ok(motion)
    }

    /// The shortest way to a standstill.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::OutOfRange`].
    pub fn stop(start: &AxisState, limits: &AxisLimits) -> Result<Self, FeedError> {
        Self::to_velocity(start, 0.0, 0.0, limits)
    }

    /// A stop that stays within `positions` (m), lower and upper bound, either of them infinite for
    /// none.
    ///
    /// The shortest stop, if that one stays inside. Otherwise it brakes harder, turns at the bound
    /// and comes back a little. That one is searched for: up to 128 calculations.
    ///
    /// # Errors
    /// As [`StateToState::stop`]; [`FeedError::LeavesPositions`] if the hardest braking does not
    /// stay inside either, with the place and time that the shortest stop gets to.
    pub fn stop_within(start: &AxisState, limits: &AxisLimits, positions: (f64, f64)) -> Result<Self, FeedError> {
        let shortest = Self::stop(start, limits)?;
        let Err(error) = shortest.check_within(positions) else {
            return Ok(shortest);
        };
        let FeedError::LeavesPositions { position, limit, .. } = error else { return Err(error) };
        // The farther back it rests, the longer it brakes and the earlier it turns.
        let resting = |back: f64| {
            let p = (limit - back).max(positions.0).min(positions.1);
            Self::new(start, &AxisState::rest(p), limits).ok().filter(|m| m.check_within(positions).is_ok())
        };
        let (mut near, mut far, mut best) = (0.0, position - limit, None);
        for _ in 0..HALVINGS {
            best = resting(far);
            if best.is_some() {
                break;
            }
            (near, far) = (far, 2.0 * far);
        }
        let mut best = best.ok_or(error)?;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            match resting(middle) {
                Some(motion) => (far, best) = (middle, motion),
                None => near = middle,
            }
        }
        Ok(best)
    }

    /// Returns true if the motion stays within `positions` (m), lower and upper bound.
    ///
    /// # Errors
    /// [`FeedError::LeavesPositions`] with the farthest position and when it is there.
    ///
    /// ```
    /// use arcfeed_feedrate::{AxisLimits, AxisState, StateToState, FeedError};
    /// let limits = AxisLimits::symmetric(1.0, 1.0, 10.0)?;
    /// let motion = StateToState::new(&AxisState::new(0.0, 0.9, 0.0), &AxisState::rest(0.1), &limits)?;
    /// let error = motion.check_within((-1.0, 0.2)).unwrap_err();
    /// assert!(matches!(error, FeedError::LeavesPositions { limit: 0.2, .. }));
    /// # Ok::<(), FeedError>(())
    /// ```
    pub fn check_within(&self, positions: (f64, f64)) -> Result<(), FeedError> {
        for (what, value) in [("p_min", positions.0), ("p_max", positions.1)] {
            if value.is_nan() {
                return Err(FeedError::NotFinite { what, value });
            }
        }
        let range = self.position_range();
        let over = (range.max - positions.1).max(0.0);
        let under = (positions.0 - range.min).max(0.0);
        if over == 0.0 && under == 0.0 {
            return Ok(());
        }
        let (position, time, limit) =
            if over >= under { (range.max, range.t_max, positions.1) } else { (range.min, range.t_min, positions.0) };
        Err(FeedError::LeavesPositions { position, time, limit })
    }
}

/// Returns an error unless a blend of this duration leads from `start` to `target`.
fn check_blend(start: &AxisState, target: &AxisState, duration: f64) -> Result<(), FeedError> {
    not_negative("duration", duration)?;
    for (what, value) in [("start.p", start.p), ("start.v", start.v), ("start.a", start.a)] {
        finite(what, value)?;
    }
    for (what, value) in [("target.p", target.p), ("target.v", target.v), ("target.a", target.a)] {
        finite(what, value)?;
    }
    let exactly = if duration > 0.0 {
        [("start.a", start.a, 0.0), ("target.a", target.a, 0.0)]
    } else {
        [("target.v", target.v, start.v), ("target.a", target.a, start.a)]
    };
    for (what, value, needed) in exactly {
        if value != needed {
            return Err(FeedError::NoBlend { what, value, needed });
        }
    }
    let way = 0.5 * duration * (start.v + target.v);
    let (value, needed) = (target.p, start.p + way);
    let slack = ROUND_OFF * (start.p.abs() + target.p.abs() + 0.5 * duration * (start.v.abs() + target.v.abs()));
    if (value - needed).abs() <= slack { Ok(()) } else { Err(FeedError::NoBlend { what: "target.p", value, needed }) }
}
