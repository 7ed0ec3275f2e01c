//! One piece of a speed law, by its state at the start and what stays constant on it.

use crate::scurve::phase::Phase;
use crate::state::MotionState;

/// The quantity that is constant on a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// The jerk `j` (m/s³).
    Jerk(f64),
    /// The slope `w = da/ds` of the acceleration over the path: `x = v^2` is quadratic in `s`. With
    /// `w = 0` the acceleration is constant.
    Slope(f64),
}

/// The motion from one knot of a law to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    /// Start time (s).
    pub t: f64,
    /// Position at the start (m).
    pub s: f64,
    /// Speed at the start (m/s).
    pub v: f64,
    /// Acceleration at the start (m/s²).
    pub a: f64,
    pub shape: Shape,
}

impl Piece {
    /// The state `dt` seconds after the start of the piece.
    #[inline]
    pub fn after(&self, dt: f64) -> MotionState {
        let Self { t, s, v, a, shape } = *self;
        match shape {
            Shape::Jerk(j) => Phase { t, s, v, a, j }.after(dt),
            Shape::Slope(w) => {
                let (c, sh, d) = hyperbolic(w * dt * dt);
                let speed = v * c + a * dt * sh;
                MotionState { p: s + dt * (v * sh + a * dt * d), v: speed, a: a * c + w * v * dt * sh, j: w * speed }
            }
        }
    }

    /// The piece by its state at the end, where time `t` is better reached from there: on the second half of a piece on which the
    /// speed decays exponentially. From its start the terms cancel, and the position would run back by their round-off.
    #[inline]
    pub fn reversed(&self, [s, t_end, v]: [f64; 3], t: f64) -> Option<Self> {
        let Shape::Slope(w) = self.shape else { return None };
        let (passed, left) = (t - self.t, t_end - t);
        let decays = w > 0.0 && self.a < 0.0 && passed > left && w * (passed + left) * (passed + left) > 1.0;
        decays.then_some(Self { t: t_end, s, v, a: self.a + w * (s - self.s), shape: self.shape })
    }

    /// The state after a distance `ds` within the piece, which lasts `duration`.
    pub fn after_distance(&self, ds: f64, duration: f64) -> MotionState {
        let Self { t, s, v, a, shape } = *self;
        let p = s + ds;
        match shape {
            Shape::Slope(w) => {
                let speed = (v * v + ds * (2.0 * a + w * ds)).max(0.0).sqrt();
                MotionState { p, v: speed, a: a + w * ds, j: w * speed }
            }
            Shape::Jerk(j) => {
                let phase = Phase { t, s, v, a, j };
                let dt = time_from_or_to_rest(&phase, ds).unwrap_or_else(|| phase.time_to_cover(ds, duration));
                let state = phase.after(dt);
                MotionState { p, v: state.v.max(0.0), ..state }
            }
        }
    }

    /// Returns true if all states on the piece, which ends at speed `v_end`, are finite, and no acceleration is so small that its
    /// digits are lost.
    pub fn is_in_range(&self, v_end: f64) -> bool {
        let jerk = match self.shape {
            Shape::Jerk(j) => j,
            Shape::Slope(w) => w * self.v.max(v_end).max(1.0),
        };
        (self.t + self.s + self.v + v_end + self.a + jerk).is_finite() && !self.a.is_subnormal()
    }
}

/// The time to cover `ds` in closed form, for a phase that starts at rest with zero acceleration or
/// ends so.
///
/// At a standstill the distance is a cubic of the time with a triple root there, at which no
/// iteration converges.
fn time_from_or_to_rest(phase: &Phase, ds: f64) -> Option<f64> {
    let Phase { v, a, j, .. } = *phase;
    if v == 0.0 && a == 0.0 {
        // s = j t^3 / 6.
        return Some((6.0 * ds / j).max(0.0).cbrt());
    }
    if a * j < 0.0 && (2.0 * v * j - a * a).abs() <= 8.0 * f64::EPSILON * a * a {
        // The same, backwards from the end.
        let total = -a / j;
        let left = v * total / 3.0 - ds;
        return Some(total - (6.0 * left / j).max(0.0).cbrt());
    }
    None
}

/// `cosh(r)`, `sinh(r) / r` and `(cosh(r) - 1) / r^2` for `r^2 = z`, of either sign of `z`.
fn hyperbolic(z: f64) -> (f64, f64, f64) {
    if z.abs() < 0.25 {
        // Taylor's series; the first term left out is below 1e-16.
        let sum = |f: [f64; 7]| f.iter().rev().fold(0.0, |sum, c| sum * z + c);
        let c = sum([1.0, 0.5, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40_320.0, 1.0 / 3_628_800.0, 1.0 / 479_001_600.0]);
        let s = sum([1.0, 1.0 / 6.0, 1.0 / 120.0, 1.0 / 5040.0, 1.0 / 362_880.0, 1.0 / 39_916_800.0, 0.0]);
        let d = sum([0.5, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40_320.0, 1.0 / 3_628_800.0, 1.0 / 479_001_600.0, 0.0]);
        return (c, s, d);
    }
    let r = z.abs().sqrt();
    let (c, s) = if z > 0.0 { (r.cosh(), r.sinh()) } else { (r.cos(), r.sin()) };
    (c, s / r, (c - 1.0) / z)
}
