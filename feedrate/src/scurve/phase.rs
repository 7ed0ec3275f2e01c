//! One stretch of constant jerk: the brick every motion in this crate is built of.

use crate::state::MotionState;

/// A stretch of motion with constant jerk, from its start time until the next one starts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Phase {
    /// Start time (s).
    pub t: f64,
    /// Position at the start (m).
    pub s: f64,
    /// Speed at the start (m/s).
    pub v: f64,
    /// Acceleration at the start (m/s²).
    pub a: f64,
    /// Jerk during the phase (m/s³).
    pub j: f64,
}

/// A division takes several times as long.
const SIXTH: f64 = 1.0 / 6.0;

impl Phase {
    /// The state `dt` seconds after the start of the phase.
    #[inline]
    pub fn after(&self, dt: f64) -> MotionState {
        MotionState {
            p: self.s + self.advance(dt),
            v: self.v + dt * (self.a + 0.5 * dt * self.j),
            a: self.a + dt * self.j,
            j: self.j,
        }
    }

    /// Time after the start, inside a phase of duration `dt`, at which the acceleration is zero and
    /// the velocity extremal.
    #[inline]
    pub fn turn(&self, dt: f64) -> Option<f64> {
        let t = -self.a / self.j;
        (t > 0.0 && t < dt).then_some(t)
    }

    /// Distance covered in the first `dt` seconds (m).
    #[inline]
    pub(crate) fn advance(&self, dt: f64) -> f64 {
        dt * (self.v + dt * (0.5 * self.a + dt * self.j * SIXTH))
    }

    /// Time after the start at which `ds` has been covered, for a phase of the given duration in
    /// which the speed does not go below 0. Newton's method, kept inside a shrinking bracket.
    pub(crate) fn time_to_cover(&self, ds: f64, duration: f64) -> f64 {
        let (mut lo, mut hi) = (0.0, duration);
        if ds <= 0.0 {
            return 0.0;
        }
        if ds >= self.advance(duration) {
            return duration;
        }
        let mut t = if self.v > 0.0 { (ds / self.v).min(0.5 * duration) } else { 0.5 * duration };
        for _ in 0..60 {
            let f = self.advance(t) - ds;
            if f > 0.0 {
                hi = t;
            } else {
                lo = t;
            }
            let v = self.v + t * (self.a + 0.5 * t * self.j);
            let newton = t - f / v;
            let next = if newton > lo && newton < hi { newton } else { 0.5 * (lo + hi) };
            if (next - t).abs() <= 4.0 * f64::EPSILON * next {
                return next;
            }
            t = next;
        }
        t
    }
}
