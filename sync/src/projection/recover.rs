//! Back inside the limits, and to zero acceleration, one coordinate at a time.

use arcfeed_feedrate::{AxisLimits, MotionLaw, MotionState, SpeedChange};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// A change of velocity to zero acceleration, by the largest jerk; the velocity goes on from there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Recovery {
    /// `None` if its numbers leave the range of `f64`.
    change: Option<SpeedChange>,
    side: f64,
}

impl Recovery {
    /// From velocity `v` and acceleration `a` within `limits`, which are the same in both
    /// directions.
    ///
    /// Inside, the acceleration is just taken off. A velocity outside, or bound to get there, is
    /// braked as hard as possible until it is at its limit, the earliest moment from which every
    /// limit can be kept.
    pub fn new(v: f64, a: f64, limits: &AxisLimits) -> Self {
        let (v_max, a_max, j_max) = (limits.v_max(), limits.a_max(), limits.j_max());
        let released = v + 0.5 * a * (a.abs() / j_max);
        let outward = if v.abs() > v_max { v } else { released };
        let side = if outward < 0.0 { -1.0 } else { 1.0 };
        let (v1, a1, released) = (side * v, side * a, side * released);
        let mut target = released;
        if v1 > v_max || released > v_max {
            let top = v1 + 0.5 * a1 * (a1 / j_max);
            let peak = (2.0 * j_max * (top - v_max)).sqrt().min(a_max);
            target = (v_max - 0.5 * peak * (peak / j_max)).max(-v_max);
        }
        // The change runs towards a velocity that is not negative.
        let (side, flip) = if target < 0.0 { (-side, -1.0) } else { (side, 1.0) };
        let target = (flip * target).max(0.0);
        let change = AxisLimits::symmetric(target.max(v_max), a_max, j_max)
            .and_then(|limits| SpeedChange::new(flip * v1, flip * a1, target, &limits));
        Self { change: change.ok(), side }
    }

    /// Infinite if it is not representable.
    pub fn duration(&self) -> f64 {
        self.change.as_ref().map_or(f64::INFINITY, SpeedChange::duration)
    }

    /// Displacement and its derivatives.
    pub fn at(&self, t: f64) -> MotionState {
        let Some(change) = &self.change else { return MotionState::default() };
        let s = change.at(t);
        let coasting = (t - change.duration()).max(0.0);
        let k = self.side;
        MotionState { p: k * (s.p + s.v * coasting), v: k * s.v, a: k * s.a, j: k * s.j }
    }
}
