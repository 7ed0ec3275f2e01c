//! The last part of the way to a standstill at a known place: one exact plan.

use super::feed::{Intent, LiveFeed, LiveStatus};
use crate::error::FeedError;
use crate::online::{FeedLimits, FeedScheduler, FeedStatus};
use crate::scurve::change::SpeedChange;
use crate::state_to_state::AxisState;

/// Parts in which an exact plan to an end is held against the caps.
const PARTS: usize = 24;
/// The way to an end is left to one exact plan from so many cycles before the last place to brake.
const EARLY: f64 = 4.0;

/// An exact plan to a standstill at a known place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Landing {
    scheduler: FeedScheduler,
    /// Where it started, and `1` or `-1` for the way forward or back.
    origin: f64,
    direction: f64,
    place: f64,
    /// Highest speed that the curve allows all the way.
    cap: f64,
    /// Speed asked for last.
    asked: f64,
}

impl LiveFeed<'_> {
    /// Prepares an exact plan from the present state to rest at `place`, if there is one under the curve.
    pub(super) fn land(&mut self, place: f64, direction: f64) {
        let distance = direction * (place - self.s);
        let cap = self.curve.lowest_cap(self.s.min(place), self.s.max(place));
        let asked = if direction > 0.0 { self.asked() } else { self.feeds.base() * self.factor };
        // Where the curve falls below the present speed on the way, braking is all there is to do.
        let top = if self.v <= cap || asked < self.v { cap.min(asked) } else { self.v };
        let start = AxisState::new(0.0, self.v, self.a);
        let Ok(limits) = self.limits(top) else { return };
        let Ok(scheduler) = FeedScheduler::new(&start, &AxisState::rest(distance), &limits) else { return };
        if direction > 0.0 && !self.keeps_caps(scheduler) {
            return;
        }
        self.landing = Some(Landing { scheduler, origin: self.s, direction, place, cap, asked: cap.min(asked) });
    }

    fn limits(&self, v: f64) -> Result<FeedLimits, FeedError> {
        let (a, j) = (self.curve.acceleration(), self.curve.jerk());
        FeedLimits::new(v, (-a, a), (-j, j))
    }

    /// Whether a plan from here keeps the caps, between its samples too.
    fn keeps_caps(&self, mut plan: FeedScheduler) -> bool {
        let dt = plan.remaining() / PARTS as f64;
        // By so much at most the speed is above the straight line between two samples.
        let bow = self.curve.jerk() * dt * dt / 8.0;
        let mut from = plan.state();
        for _ in 0..PARTS {
            let Ok(step) = plan.step(dt) else { return false };
            let to = step.state;
            if from.v.max(to.v) + bow > self.curve.lowest_cap(self.s + from.p, self.s + to.p) {
                return false;
            }
            from = to;
        }
        true
    }

    pub(super) fn follow_landing(&mut self, mut landing: Landing) -> LiveStatus {
        let forward = landing.direction > 0.0;
        let wanted = match (forward, self.intent) {
            (true, Intent::Run) => self.asked(),
            (false, Intent::Back(place)) if place == landing.place => self.feeds.base() * self.factor,
            _ => 0.0,
        };
        let wanted = wanted.min(landing.cap);
        if wanted != landing.asked {
            if let Ok(limits) = self.limits(wanted) {
                // What cannot be done any more before the end is not done: the end is near.
                let _ = landing.scheduler.set_limits(&limits);
            }
            landing.asked = wanted;
        }
        let Ok(step) = landing.scheduler.step(self.period) else { return LiveStatus::Holding };
        self.s = landing.origin + landing.direction * step.state.p;
        self.v = landing.direction * step.state.v;
        self.a = landing.direction * step.state.a;
        self.landing = Some(landing);
        match step.status {
            FeedStatus::Moving if forward => LiveStatus::Moving,
            FeedStatus::Moving => LiveStatus::SteppingBack,
            FeedStatus::Holding => {
                (self.v, self.a) = (0.0, 0.0);
                self.landing = None;
                self.next = self.stops_passed();
                LiveStatus::Holding
            }
            FeedStatus::Reached { .. } => {
                (self.s, self.v, self.a) = (landing.place, 0.0, 0.0);
                self.landing = None;
                self.next = self.stops_passed();
                if self.next == self.curve.stops().len() {
                    return LiveStatus::Finished;
                }
                if forward {
                    return LiveStatus::Moving;
                }
                if self.intent == Intent::Back(landing.place) {
                    self.intent = Intent::Hold;
                }
                LiveStatus::Holding
            }
        }
    }

    /// Leaves the last part of the way to the next stop to an exact plan, from shortly before the last place to brake.
    pub(super) fn begin_landing(&mut self) {
        let Some(&stop) = self.curve.stops().get(self.next) else { return };
        let braking = SpeedChange::build(self.v, self.a, 0.0, self.curve.acceleration(), self.curve.jerk()).length();
        if self.intent == Intent::Run && self.v > 0.0 && stop - self.s - braking < EARLY * self.v * self.period {
            self.land(stop, 1.0);
        }
    }
}
