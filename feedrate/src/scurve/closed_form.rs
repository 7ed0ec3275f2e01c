//! The shortest change of velocity and acceleration in closed form.
//!
//! Largest jerk to a peak acceleration, which is held if it is at its bound, and largest jerk to
//! the final acceleration. With `u`, `d` the inverse jerk limits up and down and `k = (u + d) / 2`,
//! a change that rises from `(v0, a0)` to `(vf, af)` has
//!
//! ```text
//! k peak² = vf - v0 + u a0² / 2 + d af² / 2        without a bound on the acceleration,
//! hold    = k (peak² - bound²) / bound             with peak = bound where that is lower.
//! ```
//!
//! (Liu et al. 2023, eqs. 14 to 18, and Liu et al. 2024, eqs. 6, 7, 10 and 11, corrected, for any
//! signs.) A change that falls is the mirror image.

#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Jerk limits of a frame, as positive numbers, and what follows from them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jerks {
    pub up: f64,
    pub down: f64,
    pub inv_up: f64,
    pub inv_down: f64,
    pub k: f64,
    /// Distance above the lower end of a ramp: `m a³`.
    pub m: f64,
    /// Distance gained per hold time: `q a²`.
    pub q: f64,
}

impl Jerks {
    pub fn new(up: f64, down: f64) -> Self {
        Self::from_parts(up, down, 1.0 / up, 1.0 / down)
    }

    fn from_parts(up: f64, down: f64, u: f64, d: f64) -> Self {
        Self {
            up,
            down,
            inv_up: u,
            inv_down: d,
            k: 0.5 * (u + d),
            m: u * u / 6.0 + 0.5 * u * d + d * d / 3.0,
            q: 0.5 * u + d,
        }
    }

    pub fn swapped(&self) -> Self {
        Self::from_parts(self.down, self.up, self.inv_down, self.inv_up)
    }
}

/// Peak acceleration and time at it, of a ramp over `x = k peak_free²` with acceleration limit
/// `cap`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peak {
    pub a: f64,
    pub hold: f64,
}

impl Peak {
    /// From the square of the peak acceleration a ramp would have without a limit on it.
    #[inline]
    pub fn from_square(sq: f64, cap: f64, k: f64) -> Self {
        Self::from_free(sq.max(0.0).sqrt(), cap, k)
    }

    /// From the peak acceleration a ramp would have without a limit on it.
    #[inline]
    pub fn from_free(a: f64, cap: f64, k: f64) -> Self {
        if a <= cap { Self { a, hold: 0.0 } } else { Self { a: cap, hold: k * (a - cap) * (a + cap) / cap } }
    }
}

/// The shortest change from `(v0, a0)`, `a0` within its bounds, to `(vf, af)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    /// Jerk up, hold, jerk down; the other way round if false.
    pub up: bool,
    /// The peak acceleration, negative where the change falls.
    pub peak: Peak,
    /// Durations of the first and the last phase.
    pub t1: f64,
    pub t3: f64,
    /// Velocity at the start of the last phase.
    pub v2: f64,
    /// Displacement from the start of the hold to the start of the last phase, and over the last
    /// phase.
    pub d2: f64,
    pub d3: f64,
}

impl Change {
    /// With acceleration limits `rise` up and `fall` down, both positive.
    #[inline]
    pub fn new((v0, a0): (f64, f64), (vf, af): (f64, f64), (rise, fall): (f64, f64), j: &Jerks) -> Self {
        let (u, d) = (j.inv_up, j.inv_down);
        let (s0, sf, dv) = (0.5 * a0 * a0, 0.5 * af * af, vf - v0);
        let single = (sf - s0) * if af >= a0 { u } else { -d };
        // A change by one phase is both; the peak of the right one has the sign of the
        // accelerations.
        let up = if dv == single { a0 + af >= 0.0 } else { dv > single };
        let (square, cap, sign) =
            if up { (dv + s0 * u + sf * d, rise, 1.0) } else { (-dv + s0 * d + sf * u, fall, -1.0) };
        let peak = Peak::from_square(square / j.k, cap, j.k);
        let (j1, j3) = if up { (u, d) } else { (d, u) };
        // A change going down is the mirror image: same numbers, other signs.
        let (a0, af) = (sign * a0, sign * af);
        let (t1, t3) = (((peak.a - a0) * j1).max(0.0), ((peak.a - af) * j3).max(0.0));
        let peak = Peak { a: sign * peak.a, hold: peak.hold };
        let af = sign * af;
        let d3 = t3 * (vf - t3 * (2.0 * af + peak.a) / 6.0);
        let v2 = vf - 0.5 * t3 * (peak.a + af);
        let d2 = peak.hold * (v2 - 0.5 * peak.a * peak.hold);
        Self { up, peak, t1, t3, v2, d2, d3 }
    }
}
