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
            return Ok(Self { motion, velocity: v, returns: false, brakes_from: f64::INFINITY });
        }
        // The shortest way to a standstill there, no faster than the axis goes anyway.
        let velocity = if v > 0.0 { (l.v_min(), v) } else { (v, l.v_max()) };
        let limits = AxisLimits::new(velocity, (l.a_min(), l.a_max()), (l.j_min(), l.j_max()))?;
        let motion = StateToState::new(s, &AxisState::rest(end), &limits)?;
        let brakes_from =
            motion.phases().find(|(phase, _)| phase.a == 0.0 && phase.j == 0.0).map_or(0.0, |(phase, dt)| phase.t + dt);
        Ok(Self { motion, velocity: v, returns: false, brakes_from })
    }

    /// A motion that goes on with another one, or rests.
    pub fn none(motion: StateToState) -> Self {
        Self { motion, velocity: 0.0, returns: false, brakes_from: f64::INFINITY }
    }

    /// Returns true if the axis has another velocity at time `t` (s) than the one it goes on with, and may have that again: on the
    /// way back to it, or while it brakes because its range ends.
    pub fn deviates_at(&self, t: f64) -> bool {
        t < self.motion.duration() && (self.returns || t >= self.brakes_from)
    }

    /// Returns true if the range makes the axis brake at some time between `from` and `to` (s).
    pub fn brakes_between(&self, from: f64, to: f64) -> bool {
        self.brakes_from < to && from < self.motion.duration()
    }
}
