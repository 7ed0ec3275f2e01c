//! The last part of the way to a standstill at a known place: one exact plan.

use super::curve::VelocityLimitCurve;
use crate::error::FeedError;
use crate::limits::AxisLimits;
use crate::online::{FeedScheduler, FeedStep};
use crate::state::AxisState;

/// Parts in which an exact plan to an end is held against the caps.
const PARTS: usize = 24;

/// An exact plan to a standstill at a known place.
#[derive(Debug, Clone, Copy)]
pub(super) struct FinalStop {
    scheduler: FeedScheduler,
    /// Position of the start, and `1` or `-1` for the way forward or back.
    pub origin: f64,
    pub direction: f64,
    pub place: f64,
    /// Highest speed that the curve allows all the way.
    cap: f64,
    /// Speed asked for last.
    asked: f64,
}

impl FinalStop {
    /// The plan from position, speed and acceleration to rest at `place`, at the speed `asked` for,
    /// if there is one under the curve.
    pub fn plan(
        curve: &VelocityLimitCurve,
        (s, v, a): (f64, f64, f64),
        place: f64,
        direction: f64,
        asked: f64,
    ) -> Option<Self> {
        let distance = direction * (place - s);
        let cap = curve.lowest_cap(s.min(place), s.max(place));
        // Where the curve falls below the present speed on the way, braking is all there is to do.
        let top = if v <= cap || asked < v { cap.min(asked) } else { v };
        let start = AxisState::new(0.0, v, a);
        let scheduler = FeedScheduler::new(&start, &AxisState::rest(distance), &limits(curve, top).ok()?).ok()?;
        let keeps = direction <= 0.0 || keeps_caps(curve, s, scheduler);
        keeps.then_some(Self { scheduler, origin: s, direction, place, cap, asked: cap.min(asked) })
    }

    /// Moves on by one cycle of `period`, at the speed `wanted` as far as the curve allows it.
    pub fn step(&mut self, curve: &VelocityLimitCurve, wanted: f64, period: f64) -> Result<FeedStep, FeedError> {
        let wanted = wanted.min(self.cap);
        if wanted != self.asked {
            if let Ok(limits) = limits(curve, wanted) {
                // What cannot be done any more before the end is not done: the end is near.
                let _ = self.scheduler.set_limits(&limits);
            }
            self.asked = wanted;
        }
        self.scheduler.step(period)
    }
}

fn limits(curve: &VelocityLimitCurve, v: f64) -> Result<AxisLimits, FeedError> {
    let limits = curve.limits();
    AxisLimits::forward(v, limits.a, limits.j)
}

/// Returns true if a plan from `s` keeps the caps, between its samples too.
fn keeps_caps(curve: &VelocityLimitCurve, s: f64, mut plan: FeedScheduler) -> bool {
    let dt = plan.remaining() / PARTS as f64;
    // By so much at most the speed is above the straight line between two samples.
    let bow = curve.jerk() * dt * dt / 8.0;
    let mut from = plan.state();
    for _ in 0..PARTS {
        let Ok(step) = plan.step(dt) else { return false };
        let to = step.state;
        if from.v.max(to.v) + bow > curve.lowest_cap(s + from.p, s + to.p) {
            return false;
        }
        from = to;
    }
    true
}
