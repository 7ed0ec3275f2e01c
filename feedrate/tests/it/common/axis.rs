//! Problems of one axis and an independent judge of their motions.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, MotionLaw, StateToState};

use arcfeed_testing::{Phase, Random, Wanted};

/// One problem.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub start: AxisState,
    pub target: AxisState,
    pub v: (f64, f64),
    pub a: (f64, f64),
    pub j: (f64, f64),
}

impl Case {
    pub fn limits(&self) -> AxisLimits {
        AxisLimits::new(self.v, self.a, self.j).unwrap()
    }

    pub fn solve(&self) -> Result<StateToState, FeedError> {
        StateToState::new(&self.start, &self.target, &self.limits())
    }

    pub fn mirrored(&self) -> Self {
        let flip = |s: AxisState| AxisState::new(-s.p, -s.v, -s.a);
        let swap = |l: (f64, f64)| (-l.1, -l.0);
        Self { start: flip(self.start), target: flip(self.target), v: swap(self.v), a: swap(self.a), j: swap(self.j) }
    }

    /// Backwards in time: position mirrored too, so that velocities keep their sign; accelerations change it.
    pub fn reversed(&self) -> Self {
        let back = |s: AxisState| AxisState::new(-s.p, s.v, -s.a);
        Self { start: back(self.target), target: back(self.start), a: (-self.a.1, -self.a.0), ..*self }
    }

    pub fn scaled(&self, length: f64, time: f64) -> Self {
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

    pub fn start_inside(&self) -> bool {
        self.wanted().starts_inside(0.0)
    }

    fn wanted(&self) -> Wanted {
        let of = |s: AxisState| [s.p, s.v, s.a];
        Wanted { start: of(self.start), target: of(self.target), limits: [self.v, self.a, self.j] }
    }
}

/// Follows the phases by itself and returns what is wrong with them, if anything.
pub fn fault(case: &Case, motion: &StateToState) -> Option<String> {
    let t_end = motion.duration();
    let phases: Vec<_> = motion.phases().collect();
    if !(t_end >= 0.0) {
        return Some(format!("duration {t_end}"));
    }
    // Of the time in which the slower jerk reaches the accelerations of the ends.
    let round_off = 8.0 * f64::EPSILON * (case.start.a.abs() + case.target.a.abs()) / case.j.1.min(-case.j.0);
    for (i, &(phase, dt)) in phases.iter().enumerate() {
        let next = phases.get(i + 1).map_or(t_end, |n| n.0.t);
        if !(dt > 0.0) || (i == 0 && phase.t != 0.0) || (next - phase.t - dt).abs() > 1e-14 * t_end + round_off {
            return Some(format!("phase {i} lasts {dt}"));
        }
    }
    let followed: Vec<Phase> =
        phases.iter().map(|&(phase, time)| Phase { state: [phase.s, phase.v, phase.a], jerk: phase.j, time }).collect();
    if let Some(fault) = case.wanted().fault(&followed, case.start_inside()) {
        return Some(format!("{fault} in {phases:?}"));
    }
    let end = case.target;
    let last = motion.at(t_end);
    if (last.p, last.v, last.a, last.j) != (end.p, end.v, end.a, 0.0) {
        return Some(format!("at(duration) is {last:?}"));
    }
    None
}

/// Random problems of every kind: resting, moving, short and long, limits far from symmetric.
pub fn random_case(rng: &mut Random, outside: bool) -> Case {
    let pair = |rng: &mut Random, lo: f64, hi: f64| (-rng.log(lo, hi), rng.log(lo, hi));
    let (v, a, j) = (pair(rng, 0.1, 10.0), pair(rng, 0.1, 30.0), pair(rng, 0.3, 300.0));
    // Sometimes exactly zero or exactly at a limit.
    let within = |rng: &mut Random, l: (f64, f64), over: f64| match (rng.unit() * 8.0) as u32 {
        0 | 1 => 0.0,
        2 => {
            if rng.unit() < 0.5 {
                l.0
            } else {
                l.1
            }
        }
        _ => over * (l.0 + (l.1 - l.0) * rng.unit()),
    };
    let admissible = |rng: &mut Random| {
        let x = within(rng, a, 1.0);
        let (lo, hi) = (v.0 + 0.5 * x.max(0.0).powi(2) / j.1, v.1 - 0.5 * x.min(0.0).powi(2) / -j.0);
        if lo > hi { (0.0, 0.0) } else { (lo + (hi - lo) * within(rng, (0.0, 1.0), 1.0), x) }
    };
    let (vf, af) = admissible(rng);
    let vf = vf.clamp(v.0, v.1);
    let (v0, a0) = if outside {
        (within(rng, v, 2.5), within(rng, a, 2.5))
    } else {
        // A state that can be left is one that can be entered, backwards in time.
        let x = within(rng, a, 1.0);
        let (lo, hi) = (v.0 + 0.5 * x.min(0.0).powi(2) / j.1, v.1 - 0.5 * x.max(0.0).powi(2) / -j.0);
        if lo > hi { (0.0, 0.0) } else { ((lo + (hi - lo) * within(rng, (0.0, 1.0), 1.0)).clamp(v.0, v.1), x) }
    };
    let reach = rng.log(1e-6, 30.0) * if rng.unit() < 0.5 { -1.0 } else { 1.0 };
    let p0 = if rng.unit() < 0.5 { 0.0 } else { 4.0 * rng.unit() - 2.0 };
    Case { start: AxisState::new(p0, v0, a0), target: AxisState::new(p0 + reach, vf, af), v, a, j }
}
