//! State to state of one axis: reference durations, exact ends, limits, symmetries, scales, refusals.
use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState, StateToStateError};
use proptest::prelude::*;

mod common;
use common::Rng;

/// One problem.
#[derive(Debug, Clone, Copy)]
struct Case {
    start: AxisState,
    target: AxisState,
    v: (f64, f64),
    a: (f64, f64),
    j: (f64, f64),
}

impl Case {
    fn limits(&self) -> AxisLimits {
        AxisLimits::new(self.v, self.a, self.j).unwrap()
    }

    fn solve(&self) -> Result<StateToState, StateToStateError> {
        StateToState::new(&self.start, &self.target, &self.limits())
    }

    fn mirrored(&self) -> Self {
        let flip = |s: AxisState| AxisState::new(-s.p, -s.v, -s.a);
        let swap = |l: (f64, f64)| (-l.1, -l.0);
        Self {
            start: flip(self.start),
            target: flip(self.target),
            v: swap(self.v),
            a: swap(self.a),
            j: swap(self.j),
        }
    }

    /// Backwards in time: position mirrored too, so that velocities keep their sign; accelerations change it.
    fn reversed(&self) -> Self {
        let back = |s: AxisState| AxisState::new(-s.p, s.v, -s.a);
        Self { start: back(self.target), target: back(self.start), a: (-self.a.1, -self.a.0), ..*self }
    }

    fn scaled(&self, length: f64, time: f64) -> Self {
        let (v, a, j) = (length / time, length / time / time, length / time / time / time);
        let state = |s: AxisState| AxisState::new(s.p * length, s.v * v, s.a * a);
        let pair = |l: (f64, f64), k: f64| (l.0 * k, l.1 * k);
        Self {
            start: state(self.start),
            target: state(self.target),
            v: pair(self.v, v),
            a: pair(self.a, a),
            j: pair(self.j, j),
        }
    }

    fn start_inside(&self) -> bool {
        let s = self.start;
        let stop = s.v + 0.5 * s.a * s.a / if s.a > 0.0 { -self.j.0 } else { -self.j.1 };
        let within = |x: f64, l: (f64, f64)| l.0 <= x && x <= l.1;
        within(s.a, self.a) && within(s.v, self.v) && within(stop, self.v)
    }
}

/// Follows the phases by itself and returns what is wrong with them, if anything.
fn fault(case: &Case, motion: &StateToState) -> Option<String> {
    let t_end = motion.duration();
    let phases = motion.phases();
    let span = |l: (f64, f64)| l.1 - l.0;
    let (mut p, mut v, mut a) = (case.start.p, case.start.v, case.start.a);
    // Round-off is relative to the largest numbers on the way.
    let mut scale = (p.abs() + case.target.p.abs(), span(case.v) + v.abs(), span(case.a) + a.abs());
    let inside = case.start_inside();
    if !(t_end >= 0.0) {
        return Some(format!("duration {t_end}"));
    }
    for (i, phase) in phases.iter().enumerate() {
        let dt = phases.get(i + 1).map_or(t_end, |n| n.t) - phase.t;
        if dt < 0.0 || (i == 0 && phase.t != 0.0) {
            return Some(format!("phase {i} lasts {dt}"));
        }
        scale.0 = scale.0.max(p.abs()).max(scale.1 * t_end);
        let gap = ((phase.s - p).abs() / scale.0)
            .max((phase.v - v).abs() / scale.1)
            .max((phase.a - a).abs() / scale.2);
        if gap > 1e-9 {
            return Some(format!("phase {i} of {phases:?} starts {gap:e} away from where the one before ended: {p} {v} {a}"));
        }
        let eps = 1e-12;
        if phase.j < case.j.0 * (1.0 + eps) || phase.j > case.j.1 * (1.0 + eps) {
            return Some(format!("jerk {} in phase {i}", phase.j));
        }
        let mut times = vec![0.0, dt];
        let top = -phase.a / phase.j;
        if top > 0.0 && top < dt {
            times.push(top);
        }
        for t in times {
            let (vt, at) = (phase.v + t * (phase.a + 0.5 * t * phase.j), phase.a + t * phase.j);
            let over = |x: f64, l: (f64, f64)| (x - l.1).max(l.0 - x) / span(l);
            if inside && over(vt, case.v).max(over(at, case.a)) > eps {
                return Some(format!("v {vt} or a {at} breaks its limit in phase {i} of {phases:?}"));
            }
        }
        p = phase.s + dt * (phase.v + dt * (0.5 * phase.a + dt * phase.j / 6.0));
        v = phase.v + dt * (phase.a + 0.5 * dt * phase.j);
        a = phase.a + dt * phase.j;
    }
    let end = case.target;
    let miss = ((p - end.p).abs() / scale.0).max((v - end.v).abs() / scale.1).max((a - end.a).abs() / scale.2);
    if miss > 1e-9 {
        return Some(format!("ends {miss:e} away from the target: {p} {v} {a} after {phases:?}"));
    }
    let last = motion.at(t_end);
    if (last.p, last.v, last.a, last.j) != (end.p, end.v, end.a, 0.0) {
        return Some(format!("at(duration) is {last:?}"));
    }
    None
}

/// After the limits hold for the first time they hold for good. Returns the worst excess after that.
fn leaves_again(case: &Case, motion: &StateToState) -> f64 {
    let over = |x: f64, l: (f64, f64)| (x - l.1).max(l.0 - x) / (l.1 - l.0);
    let mut been_inside = false;
    let mut worst: f64 = 0.0;
    for i in 0..=4000 {
        let s = motion.at(motion.duration() * f64::from(i) / 4000.0);
        let excess = over(s.v, case.v).max(over(s.a, case.a));
        // Acceleration may still force the velocity out.
        let stop = s.v + 0.5 * s.a * s.a / if s.a > 0.0 { -case.j.0 } else { -case.j.1 };
        been_inside |= excess <= 0.0 && over(stop, case.v) <= 0.0;
        if been_inside {
            worst = worst.max(excess);
        }
    }
    worst
}

struct Reference {
    case: Case,
    family: &'static str,
    outside: bool,
    duration: f64,
    range: (f64, f64),
}

fn references() -> Vec<Reference> {
    let mut family = "";
    let mut outside = false;
    let mut all = Vec::new();
    for line in include_str!("fixtures/state_to_state.txt").lines().filter(|l| !l.starts_with('#')) {
        if let Some(head) = line.strip_prefix("> ") {
            family = head.split(' ').next().unwrap();
            outside = head.ends_with(" outside");
            continue;
        }
        let words: Vec<&str> = line.split(' ').collect();
        let x = |i: usize| words[i].parse::<f64>().unwrap();
        let lower = |i: usize| if words[i] == "-" { -x(i - 1) } else { x(i) };
        let duration = x(11);
        let range = if words.len() > 12 { (x(12), x(13)) } else { (duration, duration) };
        let case = Case {
            start: AxisState::new(x(0), x(1), x(2)),
            target: AxisState::new(x(3), x(4), x(5)),
            v: (lower(7), x(6)),
            a: (lower(9), x(8)),
            j: (-x(10), x(10)),
        };
        all.push(Reference { case, family, outside, duration, range });
    }
    assert_eq!(all.len(), 3000);
    all
}

#[test]
fn reference_durations() {
    let mut counts = std::collections::BTreeMap::<&str, (usize, usize, usize)>::new();
    let mut failures = Vec::new();
    for r in references() {
        let entry = counts.entry(r.family).or_default();
        entry.1 += 1;
        let motion = match r.case.solve() {
            Ok(m) => m,
            Err(e) => {
                failures.push(format!("{}: {e}: {:?}", r.family, r.case));
                continue;
            }
        };
        let tolerance = 1e-9 + 1e-7 * r.duration;
        let (lo, hi) = (r.range.0 - tolerance, r.range.1 + tolerance);
        let t = motion.duration();
        let shorter = r.outside && t < lo;
        entry.2 += usize::from(shorter);
        if let Some(text) = fault(&r.case, &motion) {
            failures.push(format!("{}: {text}: {:?}", r.family, r.case));
        } else if !shorter && !(lo <= t && t <= hi) {
            failures.push(format!("{}: {t} instead of {}: {:?}", r.family, r.duration, r.case));
        } else if r.outside && leaves_again(&r.case, &motion) > 1e-12 {
            failures.push(format!("{}: leaves the limits again: {:?}", r.family, r.case));
        } else {
            entry.0 += 1;
        }
    }
    println!("family: (passed, of, shorter than the reference) {counts:#?}");
    assert!(failures.is_empty(), "{} failures, the first ones: {:#?}", failures.len(), &failures[..failures.len().min(6)]);
}
