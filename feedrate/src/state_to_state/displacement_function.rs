//! The extremals of one direction as one function of one number.
//!
//! Going up, jerk is `j_max, [0], j_min, [v_max], j_min, [0], j_max`: a rise to a peak velocity
//! `v_p` and a fall from it, each with its peak acceleration. Extend the first phase back (or on)
//! to zero acceleration, where the velocity is `base`; seen from there the rise covers
//! `x = v_p - base`, and with `k = 1/(2 j_max) + 1/(2 |j_min|)` it has
//!
//! ```text
//! x = k a²,               duration 2 k a,          distance base 2 k a + m a³                     for a <= a_max
//! x = k a_max² + a_max h, duration 2 k a_max + h,  ...                                            beyond
//! ```
//!
//! The fall is the same thing backwards in time. The two differ by the constant
//! `base_end - base_start = x - y`, so that one number fixes both. The number used is the signed
//! peak acceleration `s` of the lower of the two: the distance is then smooth at `s = 0`, and for
//! `s < 0` the very same formulas describe the extremals in which the acceleration never passes
//! through zero (the middle phase ends before it gets there, or starts after).

use crate::scurve::closed_form::{Jerks, Peak};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// A problem in the frame in which it moves up. `d` is the displacement wanted; `a_min` is stored
/// as the positive `fall`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Problem {
    pub d: f64,
    pub v0: f64,
    pub a0: f64,
    pub vf: f64,
    pub af: f64,
    pub v_min: f64,
    pub v_max: f64,
    pub rise: f64,
    pub fall: f64,
    pub j: Jerks,
}

impl Problem {
    pub fn mirrored(&self) -> Self {
        Self {
            d: -self.d,
            v0: -self.v0,
            a0: -self.a0,
            vf: -self.vf,
            af: -self.af,
            v_min: -self.v_max,
            v_max: -self.v_min,
            rise: self.fall,
            fall: self.rise,
            j: self.j.swapped(),
        }
    }
}

/// The free peaks of the lower and the higher ramp, the first one signed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peaks {
    pub small: f64,
    pub large: f64,
}

/// Displacement error over the signed peak acceleration `s`.
#[derive(Debug, Clone, Copy)]
pub(super) struct DisplacementFunction {
    pub(super) k: f64,
    pub(super) m: f64,
    pub(super) q: f64,
    pub(super) offset: f64,
    /// True if `s` belongs to the fall (at the end) and not to the rise.
    pub(super) small_is_fall: bool,
    pub(super) base_small: f64,
    pub(super) base_large: f64,
    pub(super) cap_small: f64,
    pub(super) cap_large: f64,
    /// `a_large² - s²`.
    pub(super) gap: f64,
    /// Excess of the duration over that of the two ramps from and to zero acceleration.
    pub(super) lead_time: f64,
}

impl DisplacementFunction {
    pub fn new(p: &Problem) -> Self {
        let (b0, bf) = Self::bases(p);
        Self::with_small(p, b0, bf, bf >= b0)
    }

    /// With the choice of the ramp that `s` belongs to made by the caller (round-off may contradict
    /// it).
    pub fn forced(p: &Problem, small_is_fall: bool) -> Self {
        let (b0, bf) = Self::bases(p);
        Self::with_small(p, b0, bf, small_is_fall)
    }

    fn bases(p: &Problem) -> (f64, f64) {
        (p.v0 - 0.5 * p.a0 * p.a0 * p.j.inv_up, p.vf - 0.5 * p.af * p.af * p.j.inv_up)
    }

    fn with_small(p: &Problem, b0: f64, bf: f64, small_is_fall: bool) -> Self {
        let u = p.j.inv_up;
        let (t0, tf) = (p.a0 * u, p.af * u);
        let lead_in = t0 * (b0 + p.a0 * t0 / 6.0);
        let lead_out = tf * (bf + p.af * tf / 6.0);
        let (base_small, base_large, cap_small, cap_large) =
            if small_is_fall { (bf, b0, p.fall, p.rise) } else { (b0, bf, p.rise, p.fall) };
        Self {
            k: p.j.k,
            m: p.j.m,
            q: p.j.q,
            offset: lead_out - lead_in - p.d,
            small_is_fall,
            base_small,
            base_large,
            cap_small,
            cap_large,
            gap: ((base_small - base_large) / p.j.k).max(0.0),
            lead_time: tf - t0,
        }
    }

    pub const fn small_is_fall(&self) -> bool {
        self.small_is_fall
    }

    pub const fn gap(&self) -> f64 {
        self.gap
    }

    /// The value of `s` at which the peak velocity is `v`.
    pub fn at_velocity(&self, v: f64) -> f64 {
        ((v - self.base_small) / self.k).max(0.0).sqrt()
    }

    /// The peaks at `s`.
    pub fn at(&self, s: f64) -> Peaks {
        Peaks { small: s, large: (s * s + self.gap).sqrt() }
    }

    /// The size of `s` beyond which the higher ramp holds its limit.
    fn corner_large(&self) -> f64 {
        (self.cap_large * self.cap_large - self.gap).max(0.0).sqrt()
    }

    /// Distance of a ramp beyond `base * duration`, its duration, and the derivatives of both by
    /// the free peak `a`.
    #[inline]
    fn ramp(&self, a: f64, sq: f64, cap: f64, base: f64) -> (f64, f64) {
        if a <= cap {
            (a * (2.0 * self.k * base + self.m * sq), 2.0 * self.k * base + 3.0 * self.m * sq)
        } else {
            let cap2 = cap * cap;
            let hold = self.k * (sq - cap2) / cap;
            let tail = base + self.q * cap2;
            (
                cap * (2.0 * self.k * base + self.m * cap2) + hold * (tail + 0.5 * cap * hold),
                2.0 * self.k * (a / cap) * (tail + cap * hold),
            )
        }
    }

    /// Displacement minus the one wanted, and its derivative by `s`.
    #[inline]
    pub fn eval(&self, s: f64) -> (f64, f64) {
        let sq = s * s;
        let (d_small, g_small) = self.ramp(s, sq, self.cap_small, self.base_small);
        let sq_large = sq + self.gap;
        let large = sq_large.sqrt();
        let (d_large, g_large) = self.ramp(large, sq_large, self.cap_large, self.base_large);
        let ratio = if large > 0.0 { s / large } else { 1.0 };
        (self.offset + d_small + d_large, g_small + ratio * g_large)
    }

    /// Rise and fall; the peak of the second is negative, or positive where it ends before zero
    /// acceleration.
    pub fn ramps(&self, peaks: Peaks) -> (Peak, Peak) {
        let small = Peak::from_free(peaks.small, self.cap_small, self.k);
        let large = Peak::from_free(peaks.large, self.cap_large, self.k);
        let (rise, fall) = if self.small_is_fall { (large, small) } else { (small, large) };
        (rise, Peak { a: -fall.a, hold: fall.hold })
    }

    /// The root in `[lo, hi]`, where the displacement is too small at `lo` and large enough at
    /// `hi`.
    pub fn root(&self, lo: f64, f_lo: f64, hi: f64, f_hi: f64) -> Peaks {
        let (mut lo, mut f_lo, mut hi, mut f_hi) = (lo, f_lo, hi, f_hi);
        let large = self.corner_large();
        for corner in [self.cap_small, large, -large] {
            if corner > lo && corner < hi {
                let f = self.eval(corner).0;
                if f < 0.0 { (lo, f_lo) = (corner, f) } else { (hi, f_hi) = (corner, f) }
            }
        }
        let inside = 0.5 * (lo + hi);
        match (inside > self.cap_small, inside.abs() > large) {
            (false, false) => self.root_free(lo, f_lo, hi, f_hi),
            (true, true) => self.root_both_held(lo, hi),
            (false, true) => {
                let held = OneHeld::new(self, self.base_small, self.base_large, self.cap_large);
                self.at(bracketed(lo, f_lo, hi, f_hi, |r| held.eval(r)))
            }
            (true, false) => {
                let held = OneHeld::new(self, self.base_large, self.base_small, self.cap_small);
                let large = bracketed(self.at(lo).large, f_lo, self.at(hi).large, f_hi, |r| held.eval(r));
                Peaks { small: (large * large - self.gap).max(0.0).sqrt(), large }
            }
        }
    }

    /// No ramp holds its limit. In `w = small + large`, to which the duration is proportional, the
    /// displacement is `c + alpha w + beta w³ + gamma / w`.
    fn root_free(&self, lo: f64, f_lo: f64, hi: f64, f_hi: f64) -> Peaks {
        let w = |s: f64| {
            let large = self.at(s).large;
            if s < 0.0 { self.gap / (large - s) } else { large + s }
        };
        let (alpha, beta, gamma) = self.free_terms();
        let root = bracketed(w(lo), f_lo, w(hi), f_hi, |w| {
            let (inv, sq) = (1.0 / w, w * w);
            (self.offset + w * (alpha + beta * sq) + gamma * inv, alpha + 3.0 * beta * sq - gamma * inv * inv)
        });
        let other = if self.gap > 0.0 { self.gap / root } else { 0.0 };
        Peaks { small: 0.5 * (root - other), large: 0.5 * (root + other) }
    }

    pub(super) fn free_terms(&self) -> (f64, f64, f64) {
        let gamma = self.gap * self.gap * (0.75 * self.m - self.k * self.k);
        (self.k * (self.base_small + self.base_large), 0.25 * self.m, gamma)
    }

    /// Both ramps hold their limits: the displacement is `c0 + c1 z + c2 z²` in `z = k s²`.
    pub(super) fn both_held_terms(&self) -> (f64, f64, f64) {
        let k = self.k;
        let part = |cap: f64, base: f64, shift: f64| {
            // The ramp holds its limit for (z + shift) / cap.
            let (inv, tail) = (1.0 / cap, base + self.q * cap * cap);
            let w = shift * inv;
            (
                cap * (2.0 * k * base + self.m * cap * cap) + w * (tail + 0.5 * cap * w),
                inv * (tail + cap * w),
                0.5 * inv,
            )
        };
        let (cs, cl) = (self.cap_small, self.cap_large);
        let a = part(cs, self.base_small, -k * cs * cs);
        let b = part(cl, self.base_large, k * (self.gap - cl * cl));
        (self.offset + a.0 + b.0, a.1 + b.1, a.2 + b.2)
    }

    fn root_both_held(&self, lo: f64, hi: f64) -> Peaks {
        let k = self.k;
        let (c0, c1, c2) = self.both_held_terms();
        // The larger root: the displacement increases there.
        let r = (c1 * c1 - 4.0 * c2 * c0).max(0.0).sqrt();
        let z = if c1 > 0.0 { -2.0 * c0 / (c1 + r) } else { 0.5 * (r - c1) / c2 };
        let s = (z / k).max(0.0).sqrt();
        // One Newton step takes off what cancellation left.
        let (f, g) = self.eval(s);
        let better = s - f / g;
        self.at(if better.is_finite() { better.clamp(lo, hi) } else { s.clamp(lo, hi) })
    }

    /// The first local maximum of the displacement in `(lo, hi)`, `hi <= 0`. Over the duration it
    /// is concave first and convex then, so that there is one at most.
    pub fn summit(&self, lo: f64, hi: f64) -> Option<f64> {
        let corner = -self.corner_large();
        let inside = |s: &f64| *s > lo && *s < hi;
        if lo < corner {
            // While the higher ramp holds its limit, d(displacement)/d(duration) is quadratic in s:
            // see `OneHeld`.
            let half = 0.5 * (self.q - self.k) * self.cap_large;
            let root = (half * half - self.k * self.base_small).sqrt();
            let s = -(half + root) / self.k;
            if s <= corner && inside(&s) {
                return Some(s);
            }
        }
        // alpha + 3 beta w² - gamma / w² = 0: the smaller root; NaN and negative numbers where
        // there is none.
        let (alpha, beta, gamma) = self.free_terms();
        let root = (alpha * alpha + 12.0 * beta * gamma).sqrt();
        let w = (2.0 * gamma / (alpha - root)).sqrt();
        Some(0.5 * (w - self.gap / w)).filter(|s| *s >= corner).filter(inside)
    }
}

/// One ramp holds its limit, the other one has the free peak `r`.
struct OneHeld {
    k: f64,
    m: f64,
    constant: f64,
    base: f64,
    held_base: f64,
    inv_cap: f64,
    slope: f64,
    shift: f64,
    qc2: f64,
}

impl OneHeld {
    fn new(f: &DisplacementFunction, base: f64, held_base: f64, cap: f64) -> Self {
        let fixed = cap * (2.0 * f.k * held_base + f.m * cap * cap);
        Self {
            k: f.k,
            m: f.m,
            constant: f.offset + fixed,
            base,
            held_base,
            inv_cap: 1.0 / cap,
            slope: (f.q - f.k) * cap,
            shift: base - held_base - f.k * cap * cap,
            qc2: f.q * cap * cap,
        }
    }

    /// Displacement error and derivative; the latter is `d(duration)/dr` times
    /// `base + k r² + (q - k) cap r`.
    #[inline]
    fn eval(&self, r: f64) -> (f64, f64) {
        let sq = r * r;
        let gained = self.k * sq + self.shift;
        let hold = gained * self.inv_cap;
        let f = self.constant
            + r * (2.0 * self.k * self.base + self.m * sq)
            + hold * (self.held_base + self.qc2 + 0.5 * gained);
        let g = 2.0 * self.k * (1.0 + r * self.inv_cap) * (self.base + self.k * sq + self.slope * r);
        (f, g)
    }
}

/// Root of `f` by Newton's method kept inside a bracket with `f(lo) < 0 <= f(hi)`.
#[inline]
fn bracketed(lo: f64, f_lo: f64, hi: f64, f_hi: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut lo, mut hi) = (lo, hi);
    let mut before = hi - lo;
    // The displacement bends upwards almost everywhere: start right of the chord's root.
    let mut x = lo + before * (f_lo / (f_lo - f_hi)).sqrt().clamp(0.02, 0.98);
    for _ in 0..MAX_STEPS {
        let (value, slope) = f(x);
        if value < 0.0 {
            lo = x
        } else {
            hi = x
        }
        let newton = x - value / slope;
        if (newton - x).abs() <= f64::EPSILON * x.abs() {
            // Not strictly inside any more: `x` is an end of the bracket.
            return x;
        }
        let inside = newton > lo && newton < hi && (newton - x).abs() < 0.8 * before;
        let next = if inside { newton } else { 0.5 * (lo + hi) };
        let step = (next - x).abs();
        // Newton's steps square the error, by a factor seen from the last two: stop when what is to
        // come is round-off.
        let ratio = step / before;
        let converged = step * ratio * ratio <= 0.25 * f64::EPSILON * next.abs();
        if inside && converged || hi - lo <= f64::EPSILON * hi.abs() {
            return next;
        }
        before = step;
        x = next;
    }
    x
}

/// Bisection alone needs this many steps to exhaust `f64` within a bracket of moderate ratio.
pub(super) const MAX_STEPS: usize = 100;
