//! The shortest motion between two states, also where only its start makes the target possible.
//!
//! A target that brakes harder than a motion inside the limits can is refused by [`AxisProblem`]:
//! its velocity would have been outside before. Right after a start that brakes as hard it can be
//! reached all the same. Backwards in time it is the start, which may be any state, so that the
//! motion is computed that way.

use super::problem::AxisProblem;
use super::profile::StateToState;
use crate::error::FeedError;
use crate::limits::AxisLimits;
use crate::state::AxisState;

/// The motion from one state to another.
pub(super) struct Leg {
    /// From the second state to the first, backwards in time, if `backwards`.
    problem: AxisProblem,
    backwards: bool,
    from: AxisState,
    to: AxisState,
    limits: AxisLimits,
}

/// Factor of round-off of a velocity at its limit.
const ROUND_OFF: f64 = 1.0 + 1e-14;

impl Leg {
    /// `None` if no motion inside the limits connects the two.
    pub fn new(from: &AxisState, to: &AxisState, limits: &AxisLimits) -> Option<Self> {
        let (problem, is_backwards) = match AxisProblem::new(from, to, limits) {
            Err(FeedError::TargetUnreachable { .. }) if brakes(from) => {
                (AxisProblem::new(&backwards(to), &backwards(from), &backwards_limits(limits)).ok()?, true)
            }
            other => (other.ok()?, false),
        };
        Some(Self { problem, backwards: is_backwards, from: *from, to: *to, limits: *limits })
    }

    /// Duration of the shortest motion (s).
    pub const fn shortest_duration(&self) -> f64 {
        self.problem.shortest_duration()
    }

    /// The shortest motion.
    pub fn shortest(&self) -> StateToState {
        self.forwards(self.problem.shortest())
    }

    /// A motion of this duration (s), if there is one.
    pub fn with_duration(&self, duration: f64) -> Option<StateToState> {
        self.problem.with_duration(duration).ok().map(|motion| self.forwards(motion))
    }

    fn forwards(&self, motion: StateToState) -> StateToState {
        if self.backwards { motion.backwards(&self.from, &self.to, self.limits.j) } else { motion }
    }

    /// The state it begins in.
    pub const fn start(&self) -> &AxisState {
        &self.from
    }

    /// Returns true if only its start makes its target possible.
    pub const fn is_backwards(&self) -> bool {
        self.backwards
    }

    /// Returns true if the velocity of a motion of this leg keeps its limits.
    pub fn keeps_velocity(&self, motion: &StateToState) -> bool {
        let l = &self.limits;
        let inside = |v: f64| v >= l.v_min() * ROUND_OFF && v <= l.v_max() * ROUND_OFF;
        let from_inside = || !self.backwards && inside(l.velocity_after(&self.from));
        from_inside() || motion.phases().all(|(phase, dt)| inside(phase.after(phase.turn(dt).unwrap_or(dt)).v))
    }

    /// How far the shortest change of velocity and acceleration goes, if there is one inside the
    /// limits.
    pub fn direct_displacement(from: &AxisState, to: &AxisState, limits: &AxisLimits) -> Option<f64> {
        match AxisProblem::direct_displacement(from, to, limits) {
            Err(FeedError::TargetUnreachable { .. }) if brakes(from) => {
                let (start, end) = (backwards(to), backwards(from));
                AxisProblem::direct_displacement(&start, &end, &backwards_limits(limits)).ok().map(|d| -d)
            }
            other => other.ok(),
        }
    }
}

/// Returns true if a state loses speed: from others a target that cannot be entered from inside is
/// out of reach.
pub(super) fn brakes(s: &AxisState) -> bool {
    // Not by the product, which can be zero for small numbers.
    s.v > 0.0 && s.a < 0.0 || s.v < 0.0 && s.a > 0.0
}

/// A state as it is when time runs backwards.
pub(super) const fn backwards(s: &AxisState) -> AxisState {
    AxisState::new(s.p, -s.v, s.a)
}

/// The limits that hold when time runs backwards.
pub(super) const fn backwards_limits(l: &AxisLimits) -> AxisLimits {
    AxisLimits { v: (-l.v.1, -l.v.0), a: l.a, j: (-l.j.1, -l.j.0) }
}
