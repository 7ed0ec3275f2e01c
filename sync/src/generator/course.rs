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

/// Part of the limits by which plans exceed them for round-off.
const PLANNED: f64 = 1e-12;

/// A motion of an axis, and what it may take.
#[derive(Debug, Clone, Copy)]
struct Part<'a> {
    motion: &'a StateToState,
    limits: Hull,
    /// The limits, widened to what the motion takes: by round-off, or there is no ramp.
    bounds: Hull,
    /// What the motion takes.
    taken: Hull,
}

impl<'a> Part<'a> {
    /// Counts what the motion takes from `from` (s) to `to` (s).
    fn new(motion: &'a StateToState, (from, to): (f64, f64), l: &AxisLimits) -> Self {
        let limits = [(l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max())];
        let mut taken = EMPTY;
        if from <= to {
            extend(&mut taken, motion, from, to);
        }
        let mut bounds = limits;
        for (bound, taken) in bounds.iter_mut().zip(&taken) {
            *bound = (bound.0.min(taken.0), bound.1.max(taken.1));
        }
        Self { motion, limits, bounds, taken }
    }

    /// Returns true if the motion itself keeps its limits.
    fn keeps_limits(&self) -> bool {
        self.taken == EMPTY || self.taken.iter().zip(&self.limits).all(|(x, limits)| within(x, limits, PLANNED))
    }

    /// The highest constant scale with which the motion keeps its limits.
    fn highest_scale(&self) -> f64 {
        let factor = |i: usize| {
            let ((lo, hi), (l, h)) = (self.taken[i], self.limits[i]);
            let up = if hi > 0.0 { h / hi } else { f64::INFINITY };
            let down = if lo < 0.0 { l / lo } else { f64::INFINITY };
            up.min(down)
        };
        factor(0).min(factor(1).sqrt()).min(factor(2).cbrt()).max(1.0)
    }
}

/// The motion of an axis from a time of its plan on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course<'a> {
    now: f64,
    /// End of the first part, where the second begins (s).
    until: f64,
    /// The motion under way, and the one after it.
    parts: [Part<'a>; 2],
    /// Time of the plan from which on it is not known (s).
    known: f64,
}

/// The motion under way and the one after it, with their limits.
pub(super) type Motions<'a> = [(&'a StateToState, &'a AxisLimits); 2];

impl<'a> Course<'a> {
    /// The first motion from `now` (s) until `until` (s), and the second from there on. If it is
    /// `open`, another one follows that is not known.
    pub fn new([first, second]: Motions<'a>, (now, until): (f64, f64), open: bool) -> Self {
        let after = if until.is_finite() { (0.0, f64::MAX) } else { (0.0, -1.0) };
        let parts = [Part::new(first.0, (now, until.min(f64::MAX)), first.1), Part::new(second.0, after, second.1)];
        let known = if open { until + second.0.duration() } else { f64::INFINITY };
        Self { now, until, parts, known }
    }

    /// The highest constant scale with which the rest of the plan keeps the limits, at most
    /// infinite; 1 if the plan itself does not, or is not known to its end.
    pub fn highest_scale(&self) -> f64 {
        if self.known < f64::INFINITY {
            return 1.0;
        }
        self.parts[0].highest_scale().min(self.parts[1].highest_scale())
    }

    /// Bounds on the first two derivatives of the scale that keep acceleration and jerk at the
    /// highest velocity of the plan, were it constant.
    pub fn scale_rates(&self) -> (f64, f64) {
        let mut rates = (1e12, 1e12);
        for Part { taken, limits, .. } in &self.parts {
            let speed = taken[0].1.max(-taken[0].0);
            let least = |(l, h): (f64, f64)| if speed > 0.0 { (h.min(-l) / speed).min(1e12) } else { 1e12 };
            rates = (f64::min(rates.0, least(limits[1])), f64::min(rates.1, least(limits[2])));
        }
        rates
    }

    /// Returns true if the plan itself keeps its limits: then it does at every constant scale up to 1.
    pub fn keeps_limits(&self) -> bool {
        self.parts.iter().all(Part::keeps_limits)
    }

    /// Returns true if the limits hold for certain at all times of a ramp from `from` (s) on, whose
    /// position is the time of the plan and whose velocity is the scale, and after it. No ramp does
    /// before the plan itself is inside its limits.
    pub fn keeps(&self, ramp: &StateToState, from: f64) -> bool {
        if !self.keeps_limits() {
            return false;
        }
        let (passed, end) = (ramp.at(from).p, ramp.at(ramp.duration()));
        if self.now + (end.p - passed) > self.known || (end.v > 1.0 && end.v > self.highest_scale()) {
            return false;
        }
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
        let mut hulls = self.hulls(from.p.max(0.0), to.p.max(0.0)).into_iter().zip(&self.parts);
        let certain = hulls.all(|([v, a, j], part)| {
            v == EMPTY[0] || {
                let jerk = sum(times(j, cube), times(a, (3.0 * cross.0, 3.0 * cross.1)));
                let jerk = sum(jerk, ordered(v.0 * phase.j, v.1 * phase.j));
                let all = [times(v, scale), sum(times(a, square), times(v, rate)), jerk];
                all.iter().zip(&part.bounds).all(|(x, bound)| within(x, bound, ROUND_OFF))
            }
        });
        if certain {
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
        let mut hulls = self.hulls(s.p.max(0.0), s.p.max(0.0)).into_iter().zip(&self.parts);
        hulls.all(|(hull, part)| {
            let [v, a, j] = hull.map(|h| h.0);
            let all = [v * s.v, a * s.v * s.v + v * s.a, j * s.v.powi(3) + 3.0 * a * s.v * s.a + v * phase.j];
            hull == EMPTY || all.iter().zip(&part.bounds).all(|(&x, bound)| within(&(x, x), bound, ROUND_OFF))
        })
    }

    /// Bounds of both parts between two times from now on (s); empty for one that is not under way
    /// then.
    fn hulls(&self, from: f64, to: f64) -> [Hull; 2] {
        let (from, to) = (self.now + from, self.now + to);
        let mut hulls = [EMPTY; 2];
        if from <= self.until {
            extend(&mut hulls[0], self.parts[0].motion, from, to.min(self.until));
        }
        if to > self.until {
            extend(&mut hulls[1], self.parts[1].motion, (from - self.until).max(0.0), to - self.until);
        }
        hulls
    }
}

/// The bounds of nothing.
const EMPTY: Hull = [(f64::INFINITY, f64::NEG_INFINITY); 3];

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

fn within(x: &(f64, f64), bound: &(f64, f64), part: f64) -> bool {
    let slack = part * (bound.1 - bound.0);
    x.0 >= bound.0 - slack && x.1 <= bound.1 + slack
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcfeed_feedrate::AxisState;
    use arcfeed_testing::Random;

    /// By how much the motion takes more than its limits at most, in parts of them, at 400 moments of a ramp.
    fn worst(motions: Motions<'_>, until: f64, ramp: &StateToState) -> f64 {
        let mut worst = 0.0_f64;
        for i in 0..=400 {
            let scale = ramp.at(ramp.duration() * f64::from(i) / 400.0);
            let (motion, limits, t) = if scale.p < until {
                (motions[0].0, motions[0].1, scale.p)
            } else {
                (motions[1].0, motions[1].1, scale.p - until)
            };
            let (plan, s) = (motion.at_or_after(t), scale.v);
            let jerk = plan.j * s.powi(3) + 3.0 * plan.a * s * scale.a + plan.v * scale.j;
            let rates = [plan.v * s, plan.a * s * s + plan.v * scale.a, jerk];
            for (x, limit) in rates.into_iter().zip([limits.v_max(), limits.a_max(), limits.j_max()]) {
                worst = worst.max(x.abs() / limit);
            }
        }
        worst
    }

    /// Ramps of the scale along random plans that leave something of their limits. None that counts as safe breaks a limit, and of those
    /// that keep them with a tenth to spare none is refused.
    #[test]
    fn what_counts_as_safe_keeps_the_limits_and_nothing_with_room_is_refused() {
        let mut rng = Random::new(5);
        let (mut safe, mut refused, mut above) = (0, 0, 0);
        for case in 0..4000 {
            let limits =
                AxisLimits::symmetric(rng.log(0.3, 3.0), rng.log(1.0, 10.0), rng.log(5.0, 200.0)).expect("limits");
            let part = [1.0, 0.8, 0.5, 0.3][case % 4];
            let [v, a, j] = [limits.v_max() * part, limits.a_max() * part * part, limits.j_max() * part.powi(3)];
            let planned = AxisLimits::symmetric(v, a, j).expect("limits");
            let states = [0.0, rng.sign() * rng.log(0.01, 2.0), rng.unit()].map(|p| AxisState::new(p, 0.0, 0.0));
            let plans =
                [0, 1].map(|i| StateToState::new(&states[i], &states[i + 1], &planned).expect("from rest to rest"));
            let motions = [(&plans[0], &limits), (&plans[1], &limits)];
            let until = if rng.unit() < 0.5 { plans[0].duration() } else { f64::INFINITY };
            let course = Course::new(motions, (0.0, until), false);
            let rates = course.scale_rates();
            let level = rng.log(1e-2, 1.0);
            let rates = AxisLimits::symmetric(100.0, rates.0 * level, rates.1 * level).expect("limits");
            let (from, to) = (1.2 * rng.unit(), (1.5 * rng.unit()).min(course.highest_scale()));
            let begin = AxisState::new(0.0, from.min(course.highest_scale()), 0.0);
            let ramp = StateToState::to_velocity(&begin, to, 0.0, &rates).expect("a ramp");
            let worst = worst(motions, until, &ramp);
            if course.keeps(&ramp, 0.0) {
                safe += 1;
                above += usize::from(to > 1.0 || from > 1.0);
                assert!(worst <= 1.0 + 1e-9, "case {case}: {worst}");
            } else {
                refused += usize::from(worst < 0.9);
            }
        }
        assert!(safe > 2000 && above > 500 && refused == 0, "{safe} {above} {refused}");
    }

    /// A plan that leaves nothing of its limits, slowed down: it is known to keep them after five parts.
    #[test]
    fn no_more_parts_are_looked_at_than_the_budget_has() {
        let limits = AxisLimits::symmetric(1.0, 4.0, 40.0).expect("limits");
        let [begin, end] = [0.0, 2.0].map(|p| AxisState::new(p, 0.0, 0.0));
        let plan = StateToState::new(&begin, &end, &limits).expect("from rest to rest");
        let course = Course::new([(&plan, &limits); 2], (0.0, f64::INFINITY), false);
        // The scale falls from 1 to a half in 1 s.
        let phase = Phase { v: 1.0, a: -0.5, ..Phase::default() };
        for most in [1, 2, 4] {
            let mut budget = most;
            assert!(!course.keeps_part(&phase, (0.0, 1.0), DEPTH, &mut budget) && budget == 0, "{budget} of {most}");
        }
        let mut budget = BUDGET;
        assert!(course.keeps_part(&phase, (0.0, 1.0), DEPTH, &mut budget));
        assert_eq!(budget, BUDGET - 5);
    }
}
