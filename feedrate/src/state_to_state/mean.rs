//! The mean of the farthest and the least far motion of one duration.
//!
//! Both keep the limits, and so does every mean of them because the motions that keep the limits
//! form a convex set. The mean whose weights are as the excesses of the two goes as far as wanted.

use super::displacement_function::Problem;
use super::phase_writer::Writer;
use super::profile::PHASES;
use super::shape::Shape;
use crate::scurve::phase::Phase;
use crate::scurve::phases::Phases;

/// Largest difference between the time that the phases take and the duration they were made for,
/// relative. More means numbers too far apart to work with.
const ROUND_OFF: f64 = 1e-6;

/// Two phases that should end together may do so this far apart, relative to the duration.
const SHORT_PHASE: f64 = 1e-9;

/// Two motions of the same duration and the weight of the first.
pub(super) struct Mean {
    far: Phases<PHASES>,
    near: Phases<PHASES>,
    weight: f64,
    duration: f64,
}

impl Mean {
    /// The mean of the farthest and the least far motion of duration `t`, each with how much it
    /// goes beyond `to` or falls short of it. `None` if round-off leaves no such motions.
    pub fn new(
        p: &Problem,
        t: f64,
        (up, down): (&(f64, Shape), &(f64, Shape)),
        (from, to): (f64, f64),
    ) -> Option<Self> {
        let (more, less) = (up.0.max(0.0), down.0.max(0.0));
        let all = more + less;
        let weight = if all > 0.0 { less / all } else { 0.5 };
        let (mut far, mut near) = (Phases::default(), Phases::default());
        Writer::new(&mut far).write(p, &up.1, false, from, to + up.0);
        Writer::new(&mut near).write(p, &down.1, true, from, to - down.0);
        let takes_t = |w: &Phases<PHASES>| (w.duration - t).abs() <= ROUND_OFF * t;
        (takes_t(&far) && takes_t(&near)).then_some(Self { far, near, weight, duration: t })
    }

    /// Writes the phases forward from the start and backward from the end: round-off meets in the
    /// longest phase of the least jerk.
    pub fn write(&self, out: &mut Writer<'_>) {
        let pivot = self.pivot();
        let mut merge = Merge::default();
        let mut start = 0.0;
        let middle = loop {
            let (i, k) = (merge.i.min(PHASES - 1), merge.k.min(PHASES - 1));
            let phase = self.state((i, merge.since_i), (k, merge.since_k));
            match merge.next(&self.far, &self.near) {
                Some((dt, ..)) if start + dt <= pivot => {
                    out.push_phase(dt, &phase);
                    start += dt;
                }
                _ => break phase,
            }
        };
        let mut later = [(0.0, Phase::default()); PHASES];
        let (mut count, mut back) = (0, 0.0);
        let mut merge = Merge { backwards: true, ..Merge::default() };
        while let Some((dt, i, k)) = merge.next(&self.far, &self.near) {
            if back + dt > self.duration - pivot || count == PHASES {
                break;
            }
            // What has not been passed of the two phases, seen from their starts.
            let since = |motion: &Phases<PHASES>, n: usize, next: usize, passed: f64| {
                if n + next + 1 > motion.len() { 0.0 } else { (motion.get(n).1 - passed).max(0.0) }
            };
            let since_i = since(&self.far, i, merge.i, merge.since_i);
            let since_k = since(&self.near, k, merge.k, merge.since_k);
            later[count] = (dt, self.state((i, since_i), (k, since_k)));
            (count, back) = (count + 1, back + dt);
        }
        out.push_phase(self.duration - start - back, &middle);
        for (dt, phase) in later[..count].iter().rev() {
            out.push_phase(*dt, phase);
        }
    }

    /// The mean of a state in phase `i` of one motion and a state in phase `k` of the other.
    fn state(&self, (i, since_i): (usize, f64), (k, since_k): (usize, f64)) -> Phase {
        let (x, y) = (self.far.get(i).0.after(since_i), self.near.get(k).0.after(since_k));
        let mean = |x, y| self.mean(x, y);
        Phase { t: 0.0, s: mean(x.p, y.p), v: mean(x.v, y.v), a: mean(x.a, y.a), j: mean(x.j, y.j) }
    }

    fn mean(&self, x: f64, y: f64) -> f64 {
        // Not beyond either of the two by cancellation.
        if x == y { x } else { self.weight * x + (1.0 - self.weight) * y }
    }

    /// The middle of the longest phase without jerk, or else of the longest one against its jerk.
    fn pivot(&self) -> f64 {
        let t = self.duration;
        let (mut pivot, mut best) = (0.5 * t, (false, 0.0));
        let mut merge = Merge::default();
        let mut now = 0.0;
        while let Some((dt, i, k)) = merge.next(&self.far, &self.near) {
            let j = self.mean(self.far.get(i).0.j, self.near.get(k).0.j).abs();
            let score = if j == 0.0 { (true, dt) } else { (false, dt / j) };
            if score > best && dt > SHORT_PHASE * t {
                (pivot, best) = (now + 0.5 * dt, score);
            }
            now += dt;
        }
        pivot
    }
}

/// Walks through the phases of two motions at once, from the start or from the end.
#[derive(Default)]
struct Merge {
    backwards: bool,
    /// Numbers of the present phases in the order of the walk, and how much of them has been
    /// passed.
    i: usize,
    k: usize,
    since_i: f64,
    since_k: f64,
}

impl Merge {
    /// The time in which neither changes its phase, and the indices of the phases.
    fn next(&mut self, far: &Phases<PHASES>, near: &Phases<PHASES>) -> Option<(f64, usize, usize)> {
        if self.i >= far.len() || self.k >= near.len() {
            return None;
        }
        let index = |n: usize, len: usize| if self.backwards { len - 1 - n } else { n };
        let (i, k) = (index(self.i, far.len()), index(self.k, near.len()));
        let (left_i, left_k) = (far.get(i).1 - self.since_i, near.get(k).1 - self.since_k);
        let dt = left_i.min(left_k);
        (self.since_i, self.since_k) = (self.since_i + dt, self.since_k + dt);
        if left_i <= left_k {
            (self.i, self.since_i) = (self.i + 1, 0.0);
        }
        if left_k <= left_i {
            (self.k, self.since_k) = (self.k + 1, 0.0);
        }
        Some((dt, i, k))
    }
}
