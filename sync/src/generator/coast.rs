//! The motion of an axis without a target: at constant velocity, and to a stop before its range
//! ends.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, MotionLaw, PositionLimits, StateToState};

/// The motion of an axis that has no target to go to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Coast {
    pub motion: StateToState,
    /// The velocity with which it goes on, until its range ends (1/s).
    pub velocity: f64,
    /// It goes back to that velocity, of which the scale of time, or a hold, had left another one.
    pub returns: bool,
    /// Its limits permit less than that velocity, which it has again once they do.
    pub limited: bool,
    /// Time at which it begins to brake because its range ends (s).
    pub brakes_from: f64,
}

impl Coast {
    /// From `s` the acceleration is brought to zero, and the velocity inside its limits; then it
    /// stays what it is. Where the range ends ahead, the axis brakes so that it stands at that end.
    pub fn new(s: &AxisState, l: &AxisLimits, range: &PositionLimits) -> Result<Self, FeedError> {
        Self::to_velocity(s, l.velocity_after(s).clamp(l.v_min(), l.v_max()), l, range)
    }

    /// From `s` to the velocity `v`, which then stays; as [`Coast::new`] where the range ends.
    pub fn to_velocity(s: &AxisState, v: f64, l: &AxisLimits, range: &PositionLimits) -> Result<Self, FeedError> {
        let end = if v > 0.0 { range.upper() } else { range.lower() };
        if v == 0.0 || !end.is_finite() {
            let motion = StateToState::to_velocity(s, v, 0.0, l)?;
            return Ok(Self { motion, velocity: v, returns: false, limited: false, brakes_from: f64::INFINITY });
        }
        // The shortest way to a standstill there, no faster than the axis goes anyway.
        let velocity = if v > 0.0 { (l.v_min(), v) } else { (v, l.v_max()) };
        let limits = AxisLimits::new(velocity, (l.a_min(), l.a_max()), (l.j_min(), l.j_max()))?;
        let motion = StateToState::new(s, &AxisState::rest(end), &limits)?;
        let brakes_from = last_turn(&motion, v.signum());
        Ok(Self { motion, velocity: v, returns: false, limited: false, brakes_from })
    }

    /// A motion that goes on with another one, or rests.
    pub fn none(motion: StateToState) -> Self {
        Self { motion, velocity: 0.0, returns: false, limited: false, brakes_from: f64::INFINITY }
    }

    /// Returns true if the axis has another velocity at time `t` (s) than the one it goes on with, and may have that again: on the
    /// way back to it, slower within its limits, or while it brakes because its range ends.
    pub fn deviates_at(&self, t: f64) -> bool {
        if t < self.motion.duration() {
            self.returns || self.limited || t >= self.brakes_from
        } else {
            // Where its range ended it stands.
            self.limited && self.brakes_from == f64::INFINITY
        }
    }

    /// Returns true if the range makes the axis brake at some time between `from` and `to` (s).
    pub fn brakes_between(&self, from: f64, to: f64) -> bool {
        self.brakes_from < to && from < self.motion.duration()
    }
}

/// The last time at which the acceleration turns against the direction `sign` (s); the begin if it does not.
fn last_turn(motion: &StateToState, sign: f64) -> f64 {
    let (mut turn, mut against) = (0.0, false);
    for (phase, dt) in motion.phases() {
        let (a, j) = (sign * phase.a, sign * phase.j);
        let after = match (a < 0.0, j < 0.0) {
            (true, _) => 0.0,
            (false, true) => -a / j,
            (false, false) => f64::INFINITY,
        };
        if after < dt && !against {
            turn = phase.t + after;
        }
        against = after < dt && a + j * dt < 0.0;
    }
    turn
}
