//! Shapes written down as phases.

use super::brake_to_limits::Brake;
use super::displacement_function::Problem;
use super::profile::PHASES;
use super::shape::{Shape, times};
use crate::scurve::phase::Phase;
use crate::scurve::phases::Phases;

/// Writes phases into a motion; `side` is -1 while the problem is written in the mirrored frame.
pub(super) struct Writer<'a> {
    out: &'a mut Phases<PHASES>,
    side: f64,
}

impl<'a> Writer<'a> {
    /// Removes the phases that `out` held.
    pub fn new(out: &'a mut Phases<PHASES>) -> Self {
        out.clear();
        Self { out, side: 1.0 }
    }

    /// Duration of the phases written.
    pub fn duration(&self) -> f64 {
        self.out.duration
    }

    #[inline]
    pub fn push(&mut self, dt: f64, p: f64, v: f64, a: f64, j: f64) {
        let side = self.side;
        self.out.push(Phase { t: 0.0, s: side * p, v: side * v, a: side * a, j: side * j }, dt);
    }

    pub fn push_phase(&mut self, dt: f64, phase: &Phase) {
        self.push(dt, phase.s, phase.v, phase.a, phase.j);
    }

    /// Sets the duration of the motion.
    pub fn finish(self, duration: f64) {
        self.out.duration = duration;
    }

    /// Writes the phases of `brake`, which belongs to the frame of the problem or to the mirrored
    /// one, and returns where they end. What follows is written in the frame of `brake`.
    pub fn brake(&mut self, brake: &Brake, mirrored: bool, from: f64) -> f64 {
        let from = if mirrored {
            self.side = -self.side;
            -from
        } else {
            from
        };
        if self.out.len() > 0 && brake.t1 > 0.0 {
            // The acceleration was above its bound: the same phase goes on.
            self.out.extend_last(brake.t1);
        } else {
            self.push(brake.t1, from, brake.v0, brake.a0, -brake.rest.j.down);
        }
        self.push(brake.peak.hold, from + brake.p1, brake.v1, brake.peak.a, 0.0);
        from + brake.p2
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

    /// The first half forward from the start, the second backward from the target: round-off meets
    /// in the middle.
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

        let begins = self.out.len() == 0;
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
        if begins {
            // Also where the first half takes no time: the motion begins in its start, and round-off is at its end.
            self.out.begin_at([from, p.v0, p.a0].map(|x| self.side * x));
        }
    }
}
