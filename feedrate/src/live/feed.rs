//! The motion along a live curve, cycle by cycle.

use super::curve::{LiveCurve, ROOM};
use super::sections::{Feeds, LiveSection};
use crate::error::{FeedError, finite, not_negative, positive};
use crate::online::{FeedLimits, FeedScheduler, FeedStatus};
use crate::scurve::change::SpeedChange;
use crate::state::{MotionLaw, MotionState};
use crate::state_to_state::AxisState;

/// Samples of a braking that is looked at ahead of time.
const SAMPLES: usize = 12;
/// Parts in which an exact plan to an end is held against the caps.
const PARTS: usize = 24;
/// Halvings with which the place is found where such a braking comes closest to the law.
const CLOSEST: usize = 5;
/// Parts of a cycle that are looked at where the curve is near.
const WITHIN: usize = 4;
/// How often less is tried where what is asked for is too much.
const HALVINGS: usize = 5;
/// How often the jerk is halved until the first cycle from a standstill fits under the curve.
const STARTS: usize = 14;
/// The way to an end is left to one exact plan from so many cycles before the last place to brake.
const EARLY: f64 = 4.0;
/// Part of the jerk with which the fastest law is approached, and the cycles over which the rest of the way to it is spread.
const APPROACH: (f64, f64) = (0.4, 5.0);

/// What the operator wants.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Intent {
    Run,
    Hold,
    Back(f64),
}

/// What the motion is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LiveStatus {
    /// On the way forward, or braking.
    Moving,
    /// At rest, and told to hold.
    Holding,
    /// On the way back.
    SteppingBack,
    /// At the end of the path, at rest.
    Finished,
}

/// State and status after a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveStep {
    /// Position, speed (negative on the way back), acceleration, and the mean jerk of the cycle.
    pub state: MotionState,
    /// What the motion is doing.
    pub status: LiveStatus,
}

/// How to go on for a cycle.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// By a change of speed, and at its target speed after it.
    Change(SpeedChange, f64),
    /// With constant jerk.
    Push(f64),
}

/// An exact plan to a standstill at a known place.
#[derive(Debug, Clone, Copy)]
struct Landing {
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

/// A motion along a [`LiveCurve`] whose feed may change in any cycle; see the [module](crate::live).
///
/// **Guarantees**, whatever is asked for and whenever: `|a| <= A`, `|j| <= J`, the speed is under the curve, and every end (corner, end of
/// path, place to step back to) is reached exactly and at rest. A lower feed is met as soon as `A` and `J` allow, that of a section
/// ahead before it begins, if it was asked for in time. No call allocates; a cycle takes a bounded number of operations.
///
/// ```
/// use arcfeed_feedrate::{LiveCurve, LiveFeed, LiveStatus};
/// let grid: Vec<f64> = (0..=30).map(|i| 0.01 * f64::from(i)).collect();
/// let curve = LiveCurve::new(&grid, &[0.1; 30], &[], 1.0, 20.0)?;
/// let mut feed = LiveFeed::new(&curve, 1e-3, 0.08)?;
/// let mut cycle = 0;
/// let end = loop {
///     match cycle {
///         500 => feed.set_override(0.5)?,
///         900 => feed.hold(),
///         1200 => feed.step_back(0.02)?,
///         2500 => feed.resume(),
///         _ => {}
///     }
///     let step = feed.step();
///     if step.status == LiveStatus::Finished {
///         break step.state;
///     }
///     cycle += 1;
/// };
/// assert_eq!((end.p, end.v, end.a), (curve.end(), 0.0, 0.0));
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LiveFeed<'a> {
    curve: &'a LiveCurve,
    period: f64,
    feeds: Feeds,
    factor: f64,
    intent: Intent,
    s: f64,
    v: f64,
    a: f64,
    /// Number of the next place to stand at.
    next: usize,
    landing: Option<Landing>,
    /// Start of the section ahead for which the motion brakes, and the feed on it.
    braking_for: Option<(f64, f64)>,
}

impl<'a> LiveFeed<'a> {
    /// At rest at the start of the path, with a control `period` (s) and a programmed `feed` (m/s).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn new(curve: &'a LiveCurve, period: f64, feed: f64) -> Result<Self, FeedError> {
        Ok(Self {
            curve,
            period: positive("control period", period)?,
            feeds: Feeds::new(feed)?,
            factor: 1.0,
            intent: Intent::Run,
            s: curve.start(),
            v: 0.0,
            a: 0.0,
            next: 0,
            landing: None,
            braking_for: None,
        })
    }

    /// Sets the programmed feed (m/s).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn set_feed(&mut self, feed: f64) -> Result<(), FeedError> {
        self.feeds.set_base(feed)
    }

    /// Sets the feeds of up to [`MAX_SECTIONS`](super::MAX_SECTIONS) stretches; where they overlap the lowest counts.
    ///
    /// # Errors
    /// [`FeedError::AboveLimit`] for too many, [`FeedError::NotFinite`], [`FeedError::NotPositive`], [`FeedError::BelowLimit`].
    pub fn set_sections(&mut self, sections: &[LiveSection]) -> Result<(), FeedError> {
        self.braking_for = None;
        self.feeds.set_sections(sections)
    }

    /// Multiplies every feed, from 0 (hold) to what the curve allows.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::Negative`].
    pub fn set_override(&mut self, factor: f64) -> Result<(), FeedError> {
        self.factor = not_negative("override", finite("override", factor)?)?;
        Ok(())
    }

    /// Brakes as hard as allowed and stays where that ends.
    pub fn hold(&mut self) {
        self.intent = Intent::Hold;
    }

    /// Goes on forward.
    pub fn resume(&mut self) {
        self.intent = Intent::Run;
    }

    /// Brakes, runs back to `place` (m), and holds there.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`]; [`FeedError::AboveLimit`] or [`FeedError::BelowLimit`] for a place that does not lie between the start of the
    /// path and the present place.
    pub fn step_back(&mut self, place: f64) -> Result<(), FeedError> {
        finite("place to step back to", place)?;
        if place > self.s {
            return Err(FeedError::AboveLimit { what: "place to step back to", value: place, limit: self.s });
        }
        if place < self.curve.start() {
            let limit = self.curve.start();
            return Err(FeedError::BelowLimit { what: "place to step back to", value: place, limit });
        }
        self.intent = Intent::Back(place);
        Ok(())
    }

    /// Takes the motion as standing where it is: something else has taken it over, and brings it back here.
    pub fn stand(&mut self) {
        (self.v, self.a) = (0.0, 0.0);
        (self.landing, self.braking_for) = (None, None);
        self.intent = Intent::Hold;
        self.next = self.stops_passed();
    }

    /// The same feed, override and sections at the start of another curve.
    pub fn moved_to<'b>(&self, curve: &'b LiveCurve) -> LiveFeed<'b> {
        let (s, intent) = (curve.start(), self.intent);
        let (period, feeds, factor) = (self.period, self.feeds, self.factor);
        LiveFeed { curve, period, feeds, factor, intent, s, v: 0.0, a: 0.0, next: 0, landing: None, braking_for: None }
    }

    /// The curve it runs under.
    pub fn curve(&self) -> &'a LiveCurve {
        self.curve
    }

    /// Where it is (m).
    pub fn position(&self) -> f64 {
        self.s
    }

    /// Whether it stands.
    pub fn is_at_rest(&self) -> bool {
        self.v == 0.0 && self.a == 0.0
    }

    /// The programmed feed outside of sections, without the override (m/s).
    pub fn feed(&self) -> f64 {
        self.feeds.base()
    }

    /// The override.
    pub fn override_factor(&self) -> f64 {
        self.factor
    }

    /// Moves on by one cycle.
    #[inline]
    pub fn step(&mut self) -> LiveStep {
        let before = self.a;
        let status = self.advance();
        let state = MotionState { p: self.s, v: self.v, a: self.a, j: (self.a - before) / self.period };
        LiveStep { state, status }
    }

    fn advance(&mut self) -> LiveStatus {
        if self.landing.is_none() && self.is_at_rest() {
            match self.intent {
                Intent::Back(place) if place < self.s => self.land(place, -1.0),
                Intent::Back(_) => self.intent = Intent::Hold,
                _ => {}
            }
            if self.intent == Intent::Hold || self.asked() == 0.0 && self.landing.is_none() {
                return LiveStatus::Holding;
            }
            let Some(&stop) = self.curve.stops().get(self.next) else { return LiveStatus::Finished };
            // So close that it is there within a few cycles: the curve says nothing there.
            if self.landing.is_none() && stop - self.s < 64.0 * self.curve.jerk() * self.period.powi(3) {
                self.land(stop, 1.0);
            }
        }
        match self.landing {
            Some(landing) => self.follow_landing(landing),
            None => {
                self.follow_curve();
                LiveStatus::Moving
            }
        }
    }

    /// The feed asked for here, 0 where the motion is to stand (m/s).
    fn asked(&self) -> f64 {
        match self.intent {
            Intent::Run => self.feeds.at(self.s) * self.factor,
            Intent::Hold | Intent::Back(_) => 0.0,
        }
    }

    /// Prepares an exact plan from the present state to rest at `place`, if there is one under the curve.
    fn land(&mut self, place: f64, direction: f64) {
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

    fn follow_landing(&mut self, mut landing: Landing) -> LiveStatus {
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

    fn stops_passed(&self) -> usize {
        self.curve.stops().partition_point(|&stop| stop <= self.s)
    }

    /// One cycle under the curve.
    fn follow_curve(&mut self) {
        let feed = self.asked();
        let brake = self.change_to(0.0);
        let way = if feed == 0.0 {
            brake
        } else if self.is_at_rest() {
            self.start(feed)
        } else {
            self.towards(feed, brake)
        };
        (self.s, self.v, self.a) = self.after(&way, self.period);
        self.begin_landing();
    }

    /// Leaves the last part of the way to the next stop to an exact plan, from shortly before the last place to brake.
    fn begin_landing(&mut self) {
        let Some(&stop) = self.curve.stops().get(self.next) else { return };
        let braking = SpeedChange::build(self.v, self.a, 0.0, self.curve.acceleration(), self.curve.jerk()).length();
        if self.intent == Intent::Run && self.v > 0.0 && stop - self.s - braking < EARLY * self.v * self.period {
            self.land(stop, 1.0);
        }
    }

    /// The fastest change to speed `target`.
    fn change_to(&self, target: f64) -> Way {
        Way::Change(SpeedChange::build(self.v, self.a, target, self.curve.acceleration(), self.curve.jerk()), target)
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
        for _ in 0..STARTS {
            j *= 0.5;
            let way = Way::Push(j);
            if self.after(&way, self.period).1 <= feed && self.is_safe(&way) {
                return way;
            }
        }
        Way::Push(0.0)
    }

    /// As far towards `feed` as is safe.
    fn towards(&mut self, feed: f64, brake: Way) -> Way {
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

    /// The feed of a section ahead for which the motion has to brake now, if after `next` it would be too late.
    fn for_sections(&mut self, next: &(f64, f64, f64)) -> Option<f64> {
        if let Some((from, feed)) = self.braking_for {
            if self.s < from {
                return Some(feed);
            }
            self.braking_for = None;
        }
        let (a, j) = (self.curve.acceleration(), self.curve.jerk());
        let too_late = |&(from, feed): &(f64, f64)| {
            let feed = feed * self.factor;
            next.1 + 0.5 * next.2 * next.2.abs() / j > feed
                && SpeedChange::build(next.1, next.2, feed, a, j).length() > from - next.0
        };
        let ahead = self.feeds.ahead(self.s).chain(self.feeds.ends_ahead(self.s));
        let slowest = ahead.filter(too_late).min_by(|x, y| x.1.total_cmp(&y.1));
        self.braking_for = slowest.map(|(from, feed)| (from, feed * self.factor));
        self.braking_for.map(|(_, feed)| feed)
    }

    /// The jerk that leads to the fastest law: onto it from below with a part of what is allowed, and along it.
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

    /// Whether a cycle stays under the curve, and from where it ends braking gets under the fastest law for good.
    fn is_safe(&self, way: &Way) -> bool {
        let (a_max, j_max) = (self.curve.acceleration(), self.curve.jerk());
        let Some(&stop) = self.curve.stops().get(self.next) else { return false };
        let (s, v, a) = self.after(way, self.period);
        // Speed and acceleration of the law that braking has to get under: the fastest one, or the same run slower so that it has
        // the speed `v`.
        let law = |s: f64, v: f64| {
            let law = if s < stop { self.curve.fastest(s) } else { MotionState::default() };
            let (v_law, a_law) = (ROOM * law.v, ROOM * ROOM * law.a);
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
            for i in 1..WITHIN {
                let (s, v, _) = self.after(way, self.period * i as f64 / WITHIN as f64);
                if v > law(s, v).0 {
                    return false;
                }
            }
        }
        if a <= a_law {
            return true;
        }
        let brake = SpeedChange::build(v, a, 0.0, a_max, j_max);
        let hardest = brake.phases()[1].t;
        // How far the braking is under the law at a time, in speed and in acceleration.
        let under = |t: f64| {
            let at = brake.at(t);
            let (v_law, a_law) = law(s + at.p, at.v);
            (v_law - at.v, a_law - at.a)
        };
        // First while the braking builds up; if it is released before it is as hard as the law's, to its end.
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
                    for _ in 0..CLOSEST {
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
