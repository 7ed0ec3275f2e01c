//! Shapes and blends written down as phases.

use super::family::Problem;
use super::outside::Brake;
use super::profile::{PHASES, StateToState};
use super::shape::{Shape, times};
use crate::scurve::phases::Phase;

/// Writes phases into a motion; `side` is -1 while the problem is written in the mirrored frame.
pub(super) struct Writer<'a> {
    out: &'a mut StateToState,
    pub t: f64,
    side: f64,
}

impl<'a> Writer<'a> {
    /// What `out` held is lost.
    pub fn new(out: &'a mut StateToState) -> Self {
        out.count = 0;
        Self { out, t: 0.0, side: 1.0 }
    }

    #[inline]
    pub fn push(&mut self, dt: f64, p: f64, v: f64, a: f64, j: f64) {
        let i = self.out.count;
        if dt > 0.0 && i < PHASES {
            let side = self.side;
            self.out.lasting[i] = dt;
            self.out.phases[i] = Phase { t: self.t, s: side * p, v: side * v, a: side * a, j: side * j };
            self.out.count = i + 1;
            self.t += dt;
        }
    }

    /// The motion lasts `duration`; its target is still to be set.
    pub fn finish(self, duration: f64) {
        self.out.duration = duration;
    }

    /// Writes the phases of `brake`, which belongs to the frame of the problem or to the mirrored one, and returns where they
    /// end. What follows is written in the frame of `brake`.
    pub fn brake(&mut self, brake: &Brake, mirrored: bool, from: f64) -> f64 {
        let from = if mirrored {
            self.side = -self.side;
            -from
        } else {
            from
        };
        if self.out.count > 0 && brake.t1 > 0.0 {
            // The acceleration was above its bound: the same phase goes on.
            self.out.lasting[self.out.count - 1] += brake.t1;
            self.t += brake.t1;
        } else {
            self.push(brake.t1, from, brake.v0, brake.a0, -brake.rest.j.down);
        }
        self.push(brake.peak.hold, from + brake.p1, brake.v1, brake.peak.a, 0.0);
        from + brake.p2
    }

    /// Writes the motion between the farthest and the least far one of duration `t` that ends `to`.
    ///
    /// The two keep the limits, and so does every mean of them because the motions that keep the limits form a convex set; the
    /// one whose weights are as the excesses of the two goes as far as wanted. False if round-off leaves none.
    pub fn between(
        &mut self,
        p: &Problem,
        t: f64,
        (up, down): (&(f64, Shape), &(f64, Shape)),
        (from, to): (f64, f64),
    ) -> bool {
        let (more, less) = (up.0.max(0.0), down.0.max(0.0));
        let all = more + less;
        let weight = if all > 0.0 { less / all } else { 0.5 };
        let (mut far, mut near) = (StateToState::default(), StateToState::default());
        let (mut far_writer, mut near_writer) = (Writer::new(&mut far), Writer::new(&mut near));
        far_writer.write(p, &up.1, false, from, to + up.0);
        near_writer.write(p, &down.1, true, from, to - down.0);
        let lasts = |w: &Writer<'_>| (w.t - t).abs() <= ROUND_OFF * t;
        if !(lasts(&far_writer) && lasts(&near_writer)) {
            return false;
        }
        // Not beyond either of the two by cancellation.
        let mean = |x: f64, y: f64| if x == y { x } else { weight * x + (1.0 - weight) * y };
        let state = |(i, since_i): (usize, f64), (k, since_k): (usize, f64)| {
            let (x, y) = (far.phases[i].after(since_i), near.phases[k].after(since_k));
            (mean(x.p, y.p), mean(x.v, y.v), mean(x.a, y.a), mean(x.j, y.j))
        };
        // Forward from the start and backward from the end: round-off meets in the longest stretch of the least jerk.
        let (mut pivot, mut best) = (0.5 * t, (false, 0.0));
        let mut merge = Merge::default();
        let mut now = 0.0;
        while let Some((dt, i, k)) = merge.next(&far, &near) {
            let j = mean(far.phases[i].j, near.phases[k].j).abs();
            let score = if j == 0.0 { (true, dt) } else { (false, dt / j) };
            if score > best && dt > SHORT * t {
                (pivot, best) = (now + 0.5 * dt, score);
            }
            now += dt;
        }
        let mut merge = Merge::default();
        let mut start = 0.0;
        let middle = loop {
            let (i, k) = (merge.i.min(PHASES - 1), merge.k.min(PHASES - 1));
            let (p, v, a, j) = state((i, merge.since_i), (k, merge.since_k));
            match merge.next(&far, &near) {
                Some((dt, ..)) if start + dt <= pivot => {
                    self.push(dt, p, v, a, j);
                    start += dt;
                }
                _ => break (p, v, a, j),
            }
        };
        let mut later = [(0.0, (0.0, 0.0, 0.0, 0.0)); PHASES];
        let (mut count, mut back) = (0, 0.0);
        let (far_back, near_back) = (backwards(&far), backwards(&near));
        let mut merge = Merge::default();
        while let Some((dt, i, k)) = merge.next(&far_back, &near_back) {
            if back + dt > t - pivot || count == PHASES {
                break;
            }
            // What has not been passed of the two phases, seen from their starts.
            let since = |motion: &StateToState, n: usize, next: usize, passed: f64| {
                if next > n { 0.0 } else { (motion.lasting[n] - passed).max(0.0) }
            };
            let since_i = since(&far_back, i, merge.i, merge.since_i);
            let since_k = since(&near_back, k, merge.k, merge.since_k);
            later[count] = (dt, state((far.count - 1 - i, since_i), (near.count - 1 - k, since_k)));
            (count, back) = (count + 1, back + dt);
        }
        let (p, v, a, j) = middle;
        self.push(t - start - back, p, v, a, j);
        for &(dt, (p, v, a, j)) in later[..count].iter().rev() {
            self.push(dt, p, v, a, j);
        }
        true
    }

    /// Writes a shape given in the frame of the problem, or in the mirrored one.
    pub fn write(&mut self, problem: &Problem, shape: &Shape, mirrored: bool, from: f64, to: f64) {
        if mirrored {
            self.side = -self.side;
            self.write_halves(&problem.mirrored(), shape, -from, -to);
        } else {
            self.write_halves(problem, shape, from, to);
        }
    }

    /// The first half forward from the start, the second backward from the target: round-off meets in the middle.
    fn write_halves(&mut self, p: &Problem, shape: &Shape, from: f64, to: f64) {
        let Shape { first, second, v_peak, joined, up, .. } = *shape;
        let [t1, t2, t3, t4, t5, t6, t7] = times(p, shape);
        let jerk = |up: bool| if up { p.j.up } else { -p.j.down };
        let (a1, a2) = (first.a, second.a);

        let v1 = p.v0 + 0.5 * t1 * (p.a0 + a1);
        let p1 = from + t1 * (p.v0 + t1 * (2.0 * p.a0 + a1) / 6.0);
        let v2 = v1 + a1 * t2;
        let p2 = p1 + 0.5 * t2 * (v1 + v2);

        let v7 = p.vf - 0.5 * t7 * (p.af + a2);
        let p7 = to - t7 * (p.vf - t7 * (2.0 * p.af + a2) / 6.0);
        let v6 = v7 - a2 * t6;
        let p6 = p7 - 0.5 * t6 * (v6 + v7);

        self.push(t1, from, p.v0, p.a0, jerk(up.0));
        self.push(t2, p1, v1, a1, 0.0);
        if joined {
            self.push(t3, p2, v2, a1, jerk(up.1));
        } else {
            self.push(t3, p2, v2, a1, jerk(!up.0));
            self.push(t4, p2 + t3 * (v2 + t3 * a1 / 3.0), v_peak, 0.0, 0.0);
            self.push(t5, p6 - t5 * (v_peak + t5 * a2 / 6.0), v_peak, 0.0, jerk(up.1));
        }
        self.push(t6, p6, v6, a2, 0.0);
        self.push(t7, p7, v7, a2, jerk(!up.1));
    }
}

/// Walks through the phases of two motions at once.
#[derive(Default)]
struct Merge {
    i: usize,
    k: usize,
    since_i: f64,
    since_k: f64,
}

impl Merge {
    /// How long neither changes its phase, and the phases.
    fn next(&mut self, far: &StateToState, near: &StateToState) -> Option<(f64, usize, usize)> {
        let (i, k) = (self.i, self.k);
        if i >= far.count || k >= near.count {
            return None;
        }
        let (left_i, left_k) = (far.lasting[i] - self.since_i, near.lasting[k] - self.since_k);
        let dt = left_i.min(left_k);
        (self.since_i, self.since_k) = (self.since_i + dt, self.since_k + dt);
        if left_i <= left_k {
            (self.i, self.since_i) = (i + 1, 0.0);
        }
        if left_k <= left_i {
            (self.k, self.since_k) = (k + 1, 0.0);
        }
        Some((dt, i, k))
    }
}

/// How long the phases last, the last one first.
fn backwards(motion: &StateToState) -> StateToState {
    let mut other = *motion;
    other.lasting[..motion.count].reverse();
    other
}

/// Of the time that the phases take, relative to the one they were made for. More means numbers too far apart to work with.
const ROUND_OFF: f64 = 1e-6;

/// Two phases that should end together may do so this far apart, relative to the duration.
const SHORT: f64 = 1e-9;
