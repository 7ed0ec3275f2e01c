//! Limits on the position, and the states from which they can be kept.

use super::problem::AxisProblem;
use super::profile::StateToState;
use crate::error::FeedError;
use crate::limits::AxisLimits;
use crate::state::{AxisState, MotionLaw};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Relative difference of positions that counts as round-off.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// The positions an axis may take, `lower <= p <= upper` (m or rad); an end may be infinite.
///
/// ```
/// use arcfeed_feedrate::{AxisLimits, AxisState, PositionLimits};
/// let limits = AxisLimits::symmetric(1.0, 5.0, 50.0)?;
/// let positions = PositionLimits::new(-1.0, 1.0)?;
/// // At full speed 0.148 before the end. The shortest stop takes 0.15, the hardest braking 0.1479.
/// assert!(positions.can_stay(&AxisState::new(0.852, 1.0, 0.0), &limits));
/// assert!(!positions.can_stay(&AxisState::new(0.853, 1.0, 0.0), &limits));
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionLimits {
    lower: f64,
    upper: f64,
}

impl PositionLimits {
    /// All positions.
    pub const ALL: Self = Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY };

    /// From the lower to the upper end.
    ///
    /// # Errors
    /// [`FeedError::EmptyRange`] unless the lower end is below the upper one.
    pub fn new(lower: f64, upper: f64) -> Result<Self, FeedError> {
        if lower < upper { Ok(Self { lower, upper }) } else { Err(FeedError::EmptyRange { lower, upper }) }
    }

    /// The lower end.
    pub const fn lower(&self) -> f64 {
        self.lower
    }

    /// The upper end.
    pub const fn upper(&self) -> f64 {
        self.upper
    }

    /// Returns true if a position is inside.
    pub fn contain(&self, position: f64) -> bool {
        self.lower <= position && position <= self.upper
    }

    /// The nearest position inside.
    pub const fn nearest(&self, position: f64) -> f64 {
        position.max(self.lower).min(self.upper)
    }

    /// Returns true if a motion stays inside but for round-off.
    pub fn contain_all_of(&self, motion: &StateToState) -> bool {
        self.check(motion).is_ok()
    }

    /// How far a motion leaves the range (m), 0 if it does not but for round-off.
    pub(super) fn overshoot(&self, motion: &StateToState) -> f64 {
        match self.check(motion) {
            Err(FeedError::LeavesPositions { position, limit, .. }) => (position - limit).abs(),
            _ => 0.0,
        }
    }

    /// As [`PositionLimits::contain_all_of`].
    ///
    /// # Errors
    /// [`FeedError::LeavesPositions`] with the farthest position and when it is there.
    pub fn check(&self, motion: &StateToState) -> Result<(), FeedError> {
        let way = motion.position_range();
        let ends = [self.lower, self.upper].into_iter().filter(|x| x.is_finite());
        let slack = ROUND_OFF * (ends.fold(0.0, |m: f64, x| m.max(x.abs())) + way.max - way.min);
        if way.max > self.upper + slack {
            Err(FeedError::LeavesPositions { position: way.max, time: way.t_max, limit: self.upper })
        } else if way.min < self.lower - slack {
            Err(FeedError::LeavesPositions { position: way.min, time: way.t_min, limit: self.lower })
        } else {
            Ok(())
        }
    }

    /// Returns true if braking from `s` stays inside, by a closed form.
    ///
    /// The shortest stop, or the hardest braking with the swing back that follows it, must stay
    /// inside. From any other state no motion stays inside, unless the range is narrower than that
    /// swing.
    pub fn can_stay(&self, s: &AxisState, limits: &AxisLimits) -> bool {
        let Ok(stop) = StateToState::stop(s, limits) else { return false };
        if self.contain_all_of(&stop) {
            return true;
        }
        // The end the axis moves to is the first one it meets.
        let upwards = s.v > 0.0 || s.v == 0.0 && s.a > 0.0;
        let (state, l, lower, upper) = if upwards {
            (*s, *limits, self.lower, self.upper)
        } else {
            (mirrored(s), mirrored_limits(limits), -self.upper, -self.lower)
        };
        let turn = hardest_turn(&state, &l);
        let slack = ROUND_OFF * (s.p.abs() + self.width_or_zero());
        turn.p <= upper + slack && turn.p - turn.swing(&l) >= lower - slack
    }

    fn width_or_zero(&self) -> f64 {
        let width = self.upper - self.lower;
        if width.is_finite() { width } else { 0.0 }
    }
}

/// Where a motion turns that brakes upwards motion as hard as possible.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    pub p: f64,
    /// Acceleration there, not above 0.
    pub a: f64,
}

impl Turn {
    /// How far the axis goes back after the turn until it can rest.
    fn swing(&self, l: &AxisLimits) -> f64 {
        let from = AxisState::new(0.0, 0.0, self.a);
        let target = AxisState::rest(0.0);
        AxisProblem::direct(&from, &target, l).map_or(f64::INFINITY, |m| -m.at(m.duration()).p)
    }
}

/// The lowest acceleration with which an axis may turn downwards: no lower than its limit, and such
/// that the velocity does not have to exceed its limit afterwards.
pub(super) fn lowest_at_turn(l: &AxisLimits) -> f64 {
    l.a_min().max(-(2.0 * l.j_max() * -l.v_min()).sqrt())
}

/// The turn of the hardest braking from `s`, whose numbers are finite.
pub(super) fn hardest_turn(s: &AxisState, l: &AxisLimits) -> Turn {
    let square = s.a * s.a - 2.0 * l.j_min() * s.v;
    if s.v < 0.0 && s.a <= 0.0 || square < 0.0 || s.v == 0.0 && s.a <= 0.0 {
        return Turn { p: s.p, a: s.a.min(0.0) };
    }
    let lowest = lowest_at_turn(l);
    // One phase with this jerk. As a change of velocity it could be either of two, by round-off.
    let at_once = |jerk: f64| {
        let a = -(s.a * s.a - 2.0 * jerk * s.v).max(0.0).sqrt();
        let t = ((a - s.a) / jerk).max(0.0);
        let p = s.p + t * (s.v + t * (0.5 * s.a + t * jerk / 6.0));
        Turn { p: p.max(s.p), a }
    };
    if -square.sqrt() >= lowest {
        return at_once(l.j_min());
    }
    let target = AxisState::new(s.p, 0.0, lowest);
    let rising = s.a * s.a - 2.0 * l.j_max() * s.v;
    // The acceleration has to rise from now on for the velocity to keep its limit. Within round-off of that it may rise at once or
    // later: the turn that is nearer counts.
    if s.a <= lowest && rising >= lowest * lowest * (1.0 - 1e-9) {
        let at_once = at_once(l.j_max());
        if rising >= lowest * lowest {
            return at_once;
        }
        let farthest = |m: StateToState| m.position_range().max;
        let later = AxisProblem::direct(s, &target, l).map_or(f64::INFINITY, farthest);
        return if later < at_once.p { Turn { p: later.max(s.p), a: lowest } } else { at_once };
    }
    let p = AxisProblem::direct(s, &target, l).map_or(f64::INFINITY, |m| m.at(m.duration()).p);
    Turn { p: p.max(s.p), a: lowest }
}

pub(super) const fn mirrored(s: &AxisState) -> AxisState {
    AxisState::new(-s.p, -s.v, -s.a)
}

pub(super) const fn mirrored_limits(l: &AxisLimits) -> AxisLimits {
    AxisLimits { v: (-l.v.1, -l.v.0), a: (-l.a.1, -l.a.0), j: (-l.j.1, -l.j.0) }
}
