//! One cycle of the motion: along the curve, on the last part of the way to a standstill, or at
//! rest.

use super::feed::{FeedOverride, Intent, LiveStatus, LiveStep};
use super::final_stop::FinalStop;
use crate::online::FeedStatus;
use crate::scurve::change::SpeedChange;
use crate::state::MotionState;

/// The way to an end is left to one exact plan from so many cycles before the last place to brake.
const STOP_LEAD_CYCLES: f64 = 4.0;

impl FeedOverride<'_> {
    /// Moves on by one cycle.
    #[inline]
    pub fn step(&mut self) -> LiveStep {
        let before = self.a;
        let status = self.advance();
        let state = MotionState { p: self.s, v: self.v, a: self.a, j: (self.a - before) / self.period };
        LiveStep { state, status }
    }

    fn advance(&mut self) -> LiveStatus {
        if self.final_stop.is_none() && self.is_at_rest() {
            match self.intent {
                Intent::Back(place) if place < self.s => self.plan_final_stop(place, -1.0),
                Intent::Back(_) => self.intent = Intent::Hold,
                _ => {}
            }
            if self.intent == Intent::Hold || self.asked() == 0.0 && self.final_stop.is_none() {
                return LiveStatus::Holding;
            }
            let Some(&stop) = self.curve.stops().get(self.next) else { return LiveStatus::Finished };
            // So close that it is there within a few cycles: the curve says nothing there.
            if self.final_stop.is_none() && stop - self.s < 64.0 * self.curve.jerk() * self.period.powi(3) {
                self.plan_final_stop(stop, 1.0);
            }
        }
        match self.final_stop {
            Some(final_stop) => self.follow_final_stop(final_stop),
            None => {
                self.follow_curve();
                self.begin_final_stop();
                LiveStatus::Moving
            }
        }
    }

    /// Prepares an exact plan from the present state to rest at `place`, if there is one under the
    /// curve.
    fn plan_final_stop(&mut self, place: f64, direction: f64) {
        let asked = if direction > 0.0 { self.asked() } else { self.feeds.base() * self.factor };
        let now = (self.s, self.v, self.a);
        if let Some(final_stop) = FinalStop::plan(self.curve, now, place, direction, asked) {
            self.final_stop = Some(final_stop);
        }
    }

    fn follow_final_stop(&mut self, mut final_stop: FinalStop) -> LiveStatus {
        let forward = final_stop.direction > 0.0;
        let wanted = match (forward, self.intent) {
            (true, Intent::Run) => self.asked(),
            (false, Intent::Back(place)) if place == final_stop.place => self.feeds.base() * self.factor,
            _ => 0.0,
        };
        let Ok(step) = final_stop.step(self.curve, wanted, self.period) else { return LiveStatus::Holding };
        self.s = final_stop.origin + final_stop.direction * step.state.p;
        self.v = final_stop.direction * step.state.v;
        self.a = final_stop.direction * step.state.a;
        self.final_stop = Some(final_stop);
        match step.status {
            FeedStatus::Moving if forward => LiveStatus::Moving,
            FeedStatus::Moving => LiveStatus::SteppingBack,
            FeedStatus::Holding => {
                (self.v, self.a) = (0.0, 0.0);
                self.final_stop = None;
                self.next = self.stops_passed();
                LiveStatus::Holding
            }
            FeedStatus::Reached { .. } => {
                (self.s, self.v, self.a) = (final_stop.place, 0.0, 0.0);
                self.final_stop = None;
                self.next = self.stops_passed();
                if self.next == self.curve.stops().len() {
                    return LiveStatus::Finished;
                }
                if forward {
                    return LiveStatus::Moving;
                }
                if self.intent == Intent::Back(final_stop.place) {
                    self.intent = Intent::Hold;
                }
                LiveStatus::Holding
            }
        }
    }

    /// Leaves the last part of the way to the next stop to an exact plan, from shortly before the
    /// last place to brake.
    fn begin_final_stop(&mut self) {
        let Some(&stop) = self.curve.stops().get(self.next) else { return };
        let braking = SpeedChange::between((self.v, self.a), (0.0, 0.0), &self.curve.limits()).length();
        if self.intent == Intent::Run
            && self.v > 0.0
            && stop - self.s - braking < STOP_LEAD_CYCLES * self.v * self.period
        {
            self.plan_final_stop(stop, 1.0);
        }
    }
}
