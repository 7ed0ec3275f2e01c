//! The extremals of one direction as one function of one number.
//!
//! Going up, jerk is `j_max, [0], j_min, [v_max], j_min, [0], j_max`: a rise to a peak velocity `v_p` and a fall from it,
//! each with its peak acceleration. Extend the first phase back (or on) to zero acceleration, where the velocity is
//! `base`; seen from there the rise covers `x = v_p - base`, and with `k = 1/(2 j_max) + 1/(2 |j_min|)` it has
//!
//! ```text
//! x = k a²,               duration 2 k a,          distance base 2 k a + m a³                     for a <= a_max
//! x = k a_max² + a_max h, duration 2 k a_max + h,  ...                                            beyond
//! ```
//!
//! The fall is the same thing backwards in time. The two differ by the constant `base_end - base_start = x - y`, so that one
//! number fixes both. The number used is the signed peak acceleration `s` of the lower of the two: the distance
//! is then smooth at `s = 0`, and for `s < 0` the very same formulas describe the extremals in which the
//! acceleration never passes through zero (the middle phase ends before it gets there, or starts after).

/// Jerk limits of a frame, as positive numbers, and what follows from them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jerks {
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

/// A problem in the frame in which it moves up. `d` is the displacement wanted; `a_min` is stored as the positive `fall`.
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

/// Peak acceleration and time at it, of a ramp over `x = k peak_free²` with acceleration limit `cap`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peak {
    pub a: f64,
    pub hold: f64,
}

impl Peak {
    /// From the square of the peak acceleration a ramp would have without a limit on it.
    pub fn from_square(sq: f64, cap: f64, k: f64) -> Self {
        if sq <= cap * cap {
            Self { a: sq.max(0.0).sqrt(), hold: 0.0 }
        } else {
            Self { a: cap, hold: k * (sq - cap * cap) / cap }
        }
    }
}

/// Displacement error over the signed peak acceleration `s`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Family {
    k: f64,
    m: f64,
    q: f64,
    offset: f64,
    /// Whether `s` belongs to the fall (at the end) and not to the rise.
    small_is_fall: bool,
    base_small: f64,
    base_large: f64,
    cap_small: f64,
    cap_large: f64,
    /// `a_large² - s²`.
    gap: f64,
}

impl Family {
    pub fn new(p: &Problem) -> Self {
        let (b0, bf) = Self::bases(p);
        Self::with_small(p, b0, bf, bf >= b0)
    }

    /// With the choice of the ramp that `s` belongs to made by the caller (round-off may contradict it).
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

    /// The values of `s` at which the two ramps reach their acceleration limits, in ascending order.
    fn corners(&self) -> (f64, f64) {
        let large = (self.cap_large * self.cap_large - self.gap).max(0.0).sqrt();
        (self.cap_small.min(large), self.cap_small.max(large))
    }

    /// Distance of a ramp beyond `base * duration`, its duration, and the derivatives of both by the free peak `a`.
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

    /// Peaks of rise and fall for `s`; the second is negative, or positive where the fall ends before zero acceleration.
    pub fn peaks(&self, s: f64) -> (Peak, Peak) {
        let small = if s > 0.0 { Peak::from_square(s * s, self.cap_small, self.k) } else { Peak { a: s, hold: 0.0 } };
        let small = if s > 0.0 && small.hold == 0.0 { Peak { a: s, hold: 0.0 } } else { small };
        let large = Peak::from_square(s * s + self.gap, self.cap_large, self.k);
        let (rise, fall) = if self.small_is_fall { (large, small) } else { (small, large) };
        (rise, Peak { a: -fall.a, hold: fall.hold })
    }

    /// The root in `[lo, hi]`, where the displacement is too small at `lo` and large enough at `hi`, `0 <= lo`.
    pub fn root_above(&self, lo: f64, f_lo: f64, hi: f64, f_hi: f64) -> f64 {
        let (mut lo, mut f_lo, mut hi, mut f_hi) = (lo, f_lo, hi, f_hi);
        let (first, last) = self.corners();
        if last > lo && last < hi {
            let f = self.eval(last).0;
            if f < 0.0 { (lo, f_lo) = (last, f) } else { (hi, f_hi) = (last, f) }
        }
        if lo >= last {
            return self.root_both_held(lo, hi);
        }
        if first > lo && first < hi {
            let f = self.eval(first).0;
            if f < 0.0 { (lo, f_lo) = (first, f) } else { (hi, f_hi) = (first, f) }
        }
        self.root(lo, f_lo, hi, f_hi)
    }

    /// Both ramps hold their limits: the displacement is quadratic in the peak velocity.
    fn root_both_held(&self, lo: f64, hi: f64) -> f64 {
        // f = c0 + c1 z + c2 z² with z = k s².
        let part = |cap: f64, base: f64, shift: f64| {
            let inv = 1.0 / cap;
            let fixed = cap * (2.0 * self.k * base + self.m * cap * cap);
            let tail = base + self.q * cap * cap;
            // hold = (z + shift) / cap
            let w = shift * inv;
            (fixed + w * (tail + 0.5 * cap * w), inv * (tail + cap * w), 0.5 * inv)
        };
        let (k, cs, cl) = (self.k, self.cap_small, self.cap_large);
        let a = part(cs, self.base_small, -k * cs * cs);
        let b = part(cl, self.base_large, k * (self.gap - cl * cl));
        let (c0, c1, c2) = (self.offset + a.0 + b.0, a.1 + b.1, a.2 + b.2);
        // The larger root: the displacement increases there.
        let r = (c1 * c1 - 4.0 * c2 * c0).max(0.0).sqrt();
        let z = if c1 > 0.0 { -2.0 * c0 / (c1 + r) } else { 0.5 * (r - c1) / c2 };
        let s = (z / k).max(0.0).sqrt();
        // One Newton step takes off what cancellation left.
        let (f, g) = self.eval(s);
        let better = s - f / g;
        if better.is_finite() { better.clamp(lo, hi) } else { s.clamp(lo, hi) }
    }

    /// The root in `[lo, hi]` by Newton's method kept inside the bracket; `f(lo) < 0 <= f(hi)`.
    pub fn root(&self, lo: f64, f_lo: f64, hi: f64, f_hi: f64) -> f64 {
        let (mut lo, mut hi) = (lo, hi);
        let width = hi - lo;
        let mut s = lo + width * (f_lo / (f_lo - f_hi)).clamp(0.05, 1.0).sqrt().min(0.98);
        let mut before = width;
        for _ in 0..MAX_STEPS {
            let (f, g) = self.eval(s);
            if f < 0.0 { lo = s } else { hi = s }
            let newton = s - f / g;
            let inside = newton > lo && newton < hi;
            let next = if inside && (newton - s).abs() < 0.7 * before { newton } else { 0.5 * (lo + hi) };
            let step = (next - s).abs();
            // Newton's steps square the error with a constant seen from the last two: stop when the next one is round-off.
            let coming = step * (step / before).powi(2);
            if inside && coming <= 0.5 * f64::EPSILON * next.abs() || hi - lo <= f64::EPSILON * hi.abs().max(lo.abs()) {
                return next;
            }
            before = step;
            s = next;
        }
        s
    }

    /// Where the displacement is largest inside `[lo, hi]`, given that it grows at `lo` and shrinks at `hi`.
    pub fn summit(&self, lo: f64, hi: f64) -> f64 {
        let (mut lo, mut hi) = (lo, hi);
        for _ in 0..MAX_STEPS {
            let mid = 0.5 * (lo + hi);
            if mid <= lo || mid >= hi {
                break;
            }
            if self.eval(mid).1 > 0.0 { lo = mid } else { hi = mid }
        }
        0.5 * (lo + hi)
    }
}

/// Bisection alone needs this many steps to exhaust `f64` within a bracket of moderate ratio.
const MAX_STEPS: usize = 100;
