//! The scale of time at which a plan is played, and the ramps by which it changes.
//!
//! A plan `q(u)` is played at `u(t)`. With the scale `s = u'` the axes have
//!
//! ```text
//! velocity       q' s
//! acceleration   q'' s² + q' s'
//! jerk           q''' s³ + 3 q'' s s' + q' s''
//! ```
//!
//! so that the geometric curve of the plan is never left. A ramp is the shortest change of the scale
//! within bounds on `s'` and `s''`. It is followed only if the limits of all axes hold on all of it
//! ([`Course::keeps`]); while no ramp is possible the scale stays what it is. Every cycle tries a
//! few ramps that are better than the one that is followed.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, MotionState, StateToState};
#[cfg(not(feature = "std"))]
use num_traits::Float;

use super::course::Course;

/// Highest scale that may be asked for.
pub(super) const HIGHEST: f64 = 1.5;

/// The parts of the way to the scale asked for that a ramp may cover, best first.
const PARTS: [f64; 4] = [1.0, 0.5, 0.2, 0.05];

/// Ramps with that part of the way, each with half the bounds of the one before.
const LEVELS: usize = 6;

/// Ramps tried in one cycle.
const TRIES: usize = 4;

/// How far a plan is played in one cycle, and how fast at its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pace {
    /// Time of the plan that passes (s).
    pub elapsed: f64,
    /// The scale and its first two derivatives at the end of the cycle.
    pub scale: f64,
    pub rate: f64,
    pub jerk: f64,
}

impl Pace {
    /// Cycles of the plan that pass.
    pub fn cycles(&self, cycle: f64) -> f64 {
        if self.elapsed == cycle { 1.0 } else { self.elapsed / cycle }
    }

    /// The state of an axis that is in state `s` of its plan.
    pub fn apply(&self, s: &MotionState) -> MotionState {
        let Self { scale, rate, jerk, .. } = *self;
        if (scale, rate, jerk) == (1.0, 0.0, 0.0) {
            return *s;
        }
        MotionState {
            p: s.p,
            v: s.v * scale,
            a: s.a * scale * scale + s.v * rate,
            j: s.j * scale.powi(3) + 3.0 * s.a * scale * rate + s.v * jerk,
        }
    }
}

/// A change of the scale that is followed.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    /// Position is the time of the plan, velocity the scale.
    motion: StateToState,
    /// Time since it began (s).
    t: f64,
    /// Its place in the order of ramps, best first.
    rank: usize,
}

/// The scale of time.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeScale {
    /// The scale set, and whether the motion is held all the same.
    pub wanted: f64,
    pub held: bool,
    /// The scale where no ramp is followed.
    scale: f64,
    ramp: Option<Ramp>,
    /// The rank that is tried next.
    next: usize,
}

impl Default for TimeScale {
    fn default() -> Self {
        Self { wanted: 1.0, held: false, scale: 1.0, ramp: None, next: 0 }
    }
}

impl TimeScale {
    /// The scale to go to.
    pub fn goal(&self) -> f64 {
        if self.held { 0.0 } else { self.wanted }
    }

    /// The scale now, and its rate.
    pub fn now(&self) -> (f64, f64) {
        self.ramp.map_or((self.scale, 0.0), |r| {
            let s = r.motion.at(r.t);
            (s.v, s.a)
        })
    }

    /// The scale, if it does not change at present.
    pub fn steady(&self) -> Option<f64> {
        self.ramp.is_none().then_some(self.scale)
    }

    /// Jumps to a scale: for axes that stand, or plans that begin in the state commanded last.
    pub fn jump(&mut self, scale: f64) {
        (self.scale, self.ramp, self.next) = (scale, None, 0);
    }

    /// Another scale was asked for: ramps that lead elsewhere count no more.
    pub fn retarget(&mut self) {
        self.next = 0;
        if let Some(ramp) = &mut self.ramp {
            ramp.rank = PARTS.len() * LEVELS;
        }
    }

    /// Returns true if the ramp followed, or the scale, keeps the limits of other courses, too. At a steady
    /// scale of 1 the axes are in the state of their plan, and at one of 0 they rest: all courses fit.
    pub fn fits<'a, const N: usize>(&self, courses: impl FnOnce() -> [Course<'a>; N]) -> bool {
        match &self.ramp {
            Some(r) => courses().iter().all(|c| c.keeps(&r.motion, r.t)),
            None if self.scale == 1.0 || self.scale == 0.0 => true,
            None if self.scale < 1.0 => courses().iter().all(Course::keeps_limits),
            None => courses().iter().all(|c| c.highest_scale() >= self.scale),
        }
    }

    /// Tries better ramps to the scale asked for than the one that is followed.
    pub fn improve(&mut self, goal: f64, courses: &[Course<'_>]) {
        let headroom = courses.iter().fold(HIGHEST, |m: f64, c| m.min(c.highest_scale()));
        let goal = goal.min(headroom);
        let (scale, rate) = self.now();
        if self.steady() == Some(goal) {
            return;
        }
        let best = self.ramp.map_or(PARTS.len() * LEVELS, |r| r.rank);
        let (a, j) = courses.iter().fold((f64::MAX, f64::MAX), |(a, j), c| {
            let rates = c.scale_rates();
            (a.min(rates.0), j.min(rates.1))
        });
        for _ in 0..TRIES.min(best) {
            let rank = self.next % best;
            self.next = rank + 1;
            let (part, level) = (PARTS[rank / LEVELS], 0.5_f64.powi((rank % LEVELS) as i32));
            let end = if part == 1.0 { goal } else { scale + part * (goal - scale) };
            let Some(motion) = ramp((scale, rate), end, (a * level, j * level)) else { continue };
            if courses.iter().all(|c| c.keeps(&motion, 0.0)) {
                self.ramp = Some(Ramp { motion, t: 0.0, rank });
                self.next = 0;
                return;
            }
        }
    }

    /// Moves on by one cycle (s).
    pub fn advance(&mut self, cycle: f64) -> Pace {
        let Some(ramp) = &mut self.ramp else {
            return Pace { elapsed: self.scale * cycle, scale: self.scale, rate: 0.0, jerk: 0.0 };
        };
        let elapsed = passed(&ramp.motion, ramp.t, cycle);
        ramp.t += cycle;
        let s = ramp.motion.at_or_after(ramp.t);
        let pace = Pace { elapsed: elapsed.max(0.0), scale: s.v, rate: s.a, jerk: s.j };
        if ramp.t >= ramp.motion.duration() {
            self.jump(s.v);
        }
        pace
    }
}

/// Time of the plan that passes from `t` of a ramp on in one cycle (s), phase by phase from the scale there. A difference of two
/// positions of the ramp would carry the round-off of all the time that passes on it.
fn passed(ramp: &StateToState, t: f64, cycle: f64) -> f64 {
    let (mut t, mut left, mut passed) = (t, cycle, 0.0);
    for (phase, dt) in ramp.phases() {
        let since = t - phase.t;
        let part = left.min(dt - since);
        if part > 0.0 {
            let s = phase.after(since);
            passed += part * (s.v + part * (0.5 * s.a + part * s.j / 6.0));
            (t, left) = (t + part, left - part);
        }
    }
    passed + left * ramp.at(ramp.duration()).v
}

/// The shortest change of the scale within bounds on its first two derivatives; `None` where it
/// would run backward.
fn ramp((scale, rate): (f64, f64), end: f64, (a, j): (f64, f64)) -> Option<StateToState> {
    let limits = AxisLimits::symmetric(2.0 * HIGHEST, a, j).ok()?;
    let motion = StateToState::to_velocity(&AxisState::new(0.0, scale, rate), end, 0.0, &limits).ok()?;
    let forward = motion.phases().all(|(p, dt)| p.v >= 0.0 && p.turn(dt).is_none_or(|t| p.after(t).v >= 0.0));
    forward.then_some(motion)
}
