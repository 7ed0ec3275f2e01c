//! One cycle under the limit curve: as far towards what is asked for as is safe.

use super::curve::SPEED_TOLERANCE;
use super::feed::FeedOverride;
use crate::scurve::change::SpeedChange;
use crate::state::{MotionLaw, MotionState};

/// Samples of a braking that is looked at ahead of time.
const SAMPLES: usize = 12;
/// Halvings with which the place is found where such a braking comes closest to the law.
const CLOSEST_HALVINGS: usize = 5;
/// Parts of a cycle that are looked at where the curve is near.
const SUBSTEPS: usize = 4;
/// Number of smaller steps tried if the request is too large.
const HALVINGS: usize = 5;
/// Number of times the jerk is halved until the first cycle from a standstill fits under the curve.
const START_HALVINGS: usize = 14;
/// Part of the jerk with which the fastest law is approached, and the cycles over which the rest of
/// the way to it is spread.
const APPROACH: (f64, f64) = (0.4, 5.0);

/// The motion over one cycle.
#[derive(Debug, Clone, Copy)]
#[allow(clippy::large_enum_variant, reason = "a few per cycle, none is stored")]
enum Way {
    /// By a change of speed, and at its target speed after it.
    Change(SpeedChange, f64),
    /// With constant jerk.
    Push(f64),
}

impl FeedOverride<'_> {
    /// One cycle under the curve.
    pub(super) fn follow_curve(&mut self) {
        let feed = self.asked();
        let way = if feed == 0.0 {
            self.change_to(0.0)
        } else if self.is_at_rest() {
            self.start(feed)
        } else {
            self.towards(feed)
        };
        (self.s, self.v, self.a) = self.after(&way, self.period);
    }

    /// The fastest change to speed `target`.
    fn change_to(&self, target: f64) -> Way {
        Way::Change(SpeedChange::between((self.v, self.a), (target, 0.0), &self.curve.limits()), target)
    }

    /// Position, speed and acceleration at time `t` of a way to go on.
    #[inline]
    fn after(&self, way: &Way, t: f64) -> (f64, f64, f64) {
        match way {
            Way::Change(change, target) => {
                let state = change.at(t);
                let coast = (t - change.duration()).max(0.0) * target;
                (self.s + state.p + coast, state.v.max(0.0), state.a)
            }
            Way::Push(j) => {
                let (v, a) = (self.v, self.a);
                (self.s + t * (v + t * (0.5 * a + t * j / 6.0)), v + t * (a + 0.5 * t * j), a + t * j)
            }
        }
    }

    /// The first cycle from a standstill: as much jerk as fits under the curve.
    fn start(&self, feed: f64) -> Way {
        let full = self.change_to(feed);
        if self.is_safe(&full) {
            return full;
        }
        let mut j = self.curve.jerk();
        for _ in 0..START_HALVINGS {
            j *= 0.5;
            let way = Way::Push(j);
            if self.after(&way, self.period).1 <= feed && self.is_safe(&way) {
                return way;
            }
        }
        Way::Push(0.0)
    }

    /// As far towards `feed` as is safe.
    fn towards(&mut self, feed: f64) -> Way {
        let mut way = self.change_to(feed);
        let mut next = self.after(&way, self.period);
        if let Some(slower) = self.for_sections(&next) {
            way = self.change_to(slower.min(feed));
            next = self.after(&way, self.period);
        }
        let near = self.approach();
        if self.a + near * self.period < next.2 {
            way = Way::Push(near);
            next = self.after(&way, self.period);
        }
        if self.is_safe(&way) {
            return way;
        }
        // Between braking, which is safe, and what was asked for.
        let brake = self.change_to(0.0);
        let jerk_to = |a: f64| (a - self.a) / self.period;
        let (mut low, mut high) = (jerk_to(self.after(&brake, self.period).2), jerk_to(next.2));
        let mut best = brake;
        for _ in 0..HALVINGS {
            let j = 0.5 * (low + high);
            let middle = Way::Push(j);
            if self.is_safe(&middle) {
                (low, best) = (j, middle);
            } else {
                high = j;
            }
        }
        best
    }

    /// The feed of a section ahead for which the motion has to brake now, if after `next` it would
    /// be too late.
    fn for_sections(&mut self, next: &(f64, f64, f64)) -> Option<f64> {
        if let Some((from, feed)) = self.braking_for {
            if self.s < from {
                return Some(feed);
            }
            self.braking_for = None;
        }
        let (limits, j) = (self.curve.limits(), self.curve.jerk());
        let too_late = |&(from, feed): &(f64, f64)| {
            let feed = feed * self.factor;
            next.1 + 0.5 * next.2 * next.2.abs() / j > feed
                && SpeedChange::between((next.1, next.2), (feed, 0.0), &limits).length() > from - next.0
        };
        let ahead = self.feeds.ahead(self.s).chain(self.feeds.ends_ahead(self.s));
        let slowest = ahead.filter(too_late).min_by(|x, y| x.1.total_cmp(&y.1));
        self.braking_for = slowest.map(|(from, feed)| (from, feed * self.factor));
        self.braking_for.map(|(_, feed)| feed)
    }

    /// The jerk that leads to the fastest law: onto it from below with a part of what is allowed,
    /// and along it.
    fn approach(&self) -> f64 {
        let t = self.period;
        let (a_max, j_max) = (self.curve.acceleration(), self.curve.jerk());
        let law = self.curve.fastest(self.s + t * (self.v + 0.5 * t * self.a));
        let v = self.v + t * self.a;
        let gap = law.v - v;
        let (part, cycles) = APPROACH;
        let closing = gap / (cycles * t);
        let closing = if gap > 0.0 { closing.min((2.0 * part * j_max * gap).sqrt()) } else { closing };
        // The law as it passes by at the present speed.
        let passing = if law.v > 0.0 { law.a * v / law.v } else { 0.0 };
        let a = (passing + closing).max(-a_max).min(a_max);
        ((a - self.a) / t).max(-j_max).min(j_max)
    }

    /// Returns true if a cycle stays under the curve, and from where it ends braking gets under the
    /// fastest law for good.
    fn is_safe(&self, way: &Way) -> bool {
        let (a_max, j_max) = (self.curve.acceleration(), self.curve.jerk());
        let Some(&stop) = self.curve.stops().get(self.next) else { return false };
        let (s, v, a) = self.after(way, self.period);
        // Speed and acceleration of the law that braking has to get under: the fastest one, or the
        // same run slower so that it has the speed `v`.
        let law = |s: f64, v: f64| {
            let law = if s < stop { self.curve.fastest(s) } else { MotionState::default() };
            let (v_law, a_law) = (SPEED_TOLERANCE * law.v, SPEED_TOLERANCE * SPEED_TOLERANCE * law.a);
            let slower = (v / v_law).min(1.0);
            (v_law, if a_law < 0.0 && slower > 0.0 { a_law * slower * slower } else { a_law })
        };
        let (v_law, a_law) = law(s, v);
        if !(v >= 0.0 && v <= v_law && a.abs() <= a_max * (1.0 + 1e-12)) {
            return false;
        }
        // Braking that is too strong to be taken off before the motion would turn back.
        if a < 0.0 && v < 0.5 * a * a / j_max * (1.0 - 1e-9) {
            return false;
        }
        // A dip of the curve that the cycle would jump over.
        let bow = j_max * self.period * self.period / 8.0;
        if self.v.max(v) + bow > self.curve.lowest_cap(self.s, s) {
            for i in 1..SUBSTEPS {
                let (s, v, _) = self.after(way, self.period * i as f64 / SUBSTEPS as f64);
                if v > law(s, v).0 {
                    return false;
                }
            }
        }
        if a <= a_law {
            return true;
        }
        let brake = SpeedChange::between((v, a), (0.0, 0.0), &self.curve.limits());
        let hardest = brake.peak_time;
        // How far the braking is under the law at a time, in speed and in acceleration.
        let under = |t: f64| {
            let at = brake.at(t);
            let (v_law, a_law) = law(s + at.p, at.v);
            (v_law - at.v, a_law - at.a)
        };
        // First while the braking builds up; if it is released before it is as hard as the law's,
        // to its end.
        for (from, to) in [(0.0, hardest), (hardest, brake.duration())] {
            let mut before = from;
            for i in 1..=SAMPLES {
                let t = from + (to - from) * i as f64 / SAMPLES as f64;
                let (speed, acceleration) = under(t);
                if speed < 0.0 {
                    return false;
                }
                if acceleration >= 0.0 {
                    // It came closest to the law where both accelerations were the same.
                    let (mut above, mut below) = (before, t);
                    for _ in 0..CLOSEST_HALVINGS {
                        let middle = 0.5 * (above + below);
                        let (speed, acceleration) = under(middle);
                        if speed < 0.0 {
                            return false;
                        }
                        *(if acceleration >= 0.0 { &mut below } else { &mut above }) = middle;
                    }
                    return true;
                }
                before = t;
            }
        }
        s + brake.length() < stop
    }
}
