//! What an axis has before it, and whether it keeps its limits when time is scaled.

use arcfeed_feedrate::{AxisLimits, MotionLaw, Phase, StateToState};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Bounds of velocity, acceleration and jerk, in this order.
type Hull = [(f64, f64); 3];

/// Parts of a ramp examined at most for one axis.
const BUDGET: usize = 192;

/// Halvings of a phase of a ramp at most.
const DEPTH: u32 = 7;

/// Relative difference that counts as round-off.
const ROUND_OFF: f64 = 1e-13;

/// The motion of an axis from a time of its plan on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course<'a> {
    motion: &'a StateToState,
    now: f64,
    /// End of `motion`, where `after` begins (s).
    until: f64,
    after: &'a StateToState,
    /// The limits, widened to what the plan itself takes while it is outside of them.
    bounds: Hull,
    /// What the plan takes.
    taken: Hull,
    limits: Hull,
}

impl<'a> Course<'a> {
    /// `motion` from `now` (s) until `until` (s), and `after` from there on.
    pub fn new(motion: &'a StateToState, now: f64, until: f64, after: &'a StateToState, l: &AxisLimits) -> Self {
        let limits = [(l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max())];
        let mut course = Self { motion, now, until, after, bounds: limits, taken: [(0.0, 0.0); 3], limits };
        course.taken = course.hull(0.0, f64::MAX);
        for (bound, taken) in course.bounds.iter_mut().zip(&course.taken) {
            *bound = (bound.0.min(taken.0), bound.1.max(taken.1));
        }
        course
    }

    /// The highest constant scale with which the rest of the plan keeps the limits, at most
    /// infinite; 1 if the plan itself does not.
    pub fn highest_scale(&self) -> f64 {
        let factor = |i: usize| {
            let ((lo, hi), (l, h)) = (self.taken[i], self.limits[i]);
            let up = if hi > 0.0 { h / hi } else { f64::INFINITY };
            let down = if lo < 0.0 { l / lo } else { f64::INFINITY };
            up.min(down)
        };
        factor(0).min(factor(1).sqrt()).min(factor(2).cbrt()).max(1.0)
    }

    /// Bounds on the first two derivatives of the scale that keep acceleration and jerk at the
    /// highest velocity of the plan, were it constant.
    pub fn scale_rates(&self) -> (f64, f64) {
        let speed = self.taken[0].1.max(-self.taken[0].0);
        let least = |(l, h): (f64, f64)| if speed > 0.0 { (h.min(-l) / speed).min(1e12) } else { 1e12 };
        (least(self.limits[1]), least(self.limits[2]))
    }

    /// Returns true if the limits hold for certain at all times of a ramp from `from` (s) on, whose
    /// position is the time of the plan and whose velocity is the scale.
    pub fn keeps(&self, ramp: &StateToState, from: f64) -> bool {
        let passed = ramp.at(from).p;
        let mut budget = BUDGET;
        ramp.phases().all(|(phase, dt)| {
            let begin = (from - phase.t).max(0.0);
            begin >= dt || self.keeps_part(&Phase { s: phase.s - passed, ..phase }, (begin, dt), DEPTH, &mut budget)
        })
    }

    fn keeps_part(&self, phase: &Phase, (x0, x1): (f64, f64), depth: u32, budget: &mut usize) -> bool {
        if *budget == 0 {
            return false;
        }
        *budget -= 1;
        let (from, to) = (phase.after(x0), phase.after(x1));
        let [v, a, j] = self.hull(from.p.max(0.0), to.p.max(0.0));
        let mut scale = ordered(from.v, to.v);
        if let Some(t) = phase.turn(x1).filter(|&t| t > x0) {
            let v = phase.after(t).v;
            scale = (scale.0.min(v), scale.1.max(v));
        }
        let scale = (scale.0.max(0.0), scale.1.max(0.0));
        let rate = ordered(from.a, to.a);
        let square = (scale.0 * scale.0, scale.1 * scale.1);
        let cube = (square.0 * scale.0, square.1 * scale.1);
        let cross = times(scale, rate);
        let all = [
            times(v, scale),
            sum(times(a, square), times(v, rate)),
            sum(sum(times(j, cube), times(a, (3.0 * cross.0, 3.0 * cross.1))), ordered(v.0 * phase.j, v.1 * phase.j)),
        ];
        if all.iter().zip(&self.bounds).all(|(x, bound)| within(x, bound)) {
            return true;
        }
        let middle = 0.5 * (x0 + x1);
        depth > 0
            && self.keeps_at(phase, middle)
            && self.keeps_part(phase, (x0, middle), depth - 1, budget)
            && self.keeps_part(phase, (middle, x1), depth - 1, budget)
    }

    /// Returns false if the limits do not hold at one time of a ramp; where the jerk of the plan jumps,
    /// one of both is examined.
    fn keeps_at(&self, phase: &Phase, x: f64) -> bool {
        let s = phase.after(x);
        let [v, a, j] = self.hull(s.p.max(0.0), s.p.max(0.0)).map(|h| h.0);
        let all = [v * s.v, a * s.v * s.v + v * s.a, j * s.v.powi(3) + 3.0 * a * s.v * s.a + v * phase.j];
        all.iter().zip(&self.bounds).all(|(&x, bound)| within(&(x, x), bound))
    }

    /// Bounds of the plan between two times from now on (s).
    fn hull(&self, from: f64, to: f64) -> Hull {
        let (from, to) = (self.now + from, self.now + to);
        let mut hull = [(f64::INFINITY, f64::NEG_INFINITY); 3];
        if from <= self.until {
            extend(&mut hull, self.motion, from, to.min(self.until));
        }
        if to > self.until {
            extend(&mut hull, self.after, (from - self.until).max(0.0), to - self.until);
        }
        hull
    }
}

/// Widens bounds to a motion between two times (s); beyond its end it goes on at constant velocity.
fn extend(hull: &mut Hull, motion: &StateToState, from: f64, to: f64) {
    let mut add = |i: usize, x: f64| hull[i] = (hull[i].0.min(x), hull[i].1.max(x));
    for (phase, dt) in motion.phases() {
        if phase.t > to || phase.t + dt < from {
            continue;
        }
        let (x0, x1) = ((from - phase.t).max(0.0), (to - phase.t).min(dt));
        add(2, phase.j);
        for x in [Some(x0), Some(x1), phase.turn(x1).filter(|&t| t > x0)].into_iter().flatten() {
            let s = phase.after(x);
            add(0, s.v);
            add(1, s.a);
        }
    }
    if to >= motion.duration() {
        let s = motion.at_or_after(motion.duration());
        add(0, s.v);
        add(1, s.a);
        add(2, 0.0);
    }
}

fn ordered(x: f64, y: f64) -> (f64, f64) {
    (x.min(y), x.max(y))
}

fn sum(x: (f64, f64), y: (f64, f64)) -> (f64, f64) {
    (x.0 + y.0, x.1 + y.1)
}

/// The product of two intervals.
fn times(x: (f64, f64), y: (f64, f64)) -> (f64, f64) {
    let (p, q) = (ordered(x.0 * y.0, x.0 * y.1), ordered(x.1 * y.0, x.1 * y.1));
    (p.0.min(q.0), p.1.max(q.1))
}

fn within(x: &(f64, f64), bound: &(f64, f64)) -> bool {
    let slack = ROUND_OFF * (bound.1 - bound.0);
    x.0 >= bound.0 - slack && x.1 <= bound.1 + slack
}
