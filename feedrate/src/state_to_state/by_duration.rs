//! The extremals of one direction by their duration: both ways between the two, and where the
//! displacement turns.

use super::displacement_function::{DisplacementFunction, MAX_STEPS};
#[cfg(not(feature = "std"))]
use num_traits::Float;

impl DisplacementFunction {
    /// Duration of the extremal at `s`.
    pub fn duration(&self, s: f64) -> f64 {
        let held = |sq: f64, cap: f64| self.k * (cap + sq / cap);
        let sq = s * s;
        let large = (sq + self.gap).sqrt();
        let small = if s <= self.cap_small { 2.0 * self.k * s } else { held(sq, self.cap_small) };
        let large = if large <= self.cap_large { 2.0 * self.k * large } else { held(sq + self.gap, self.cap_large) };
        small + large + self.lead_time
    }

    /// The value of `s` at which the extremal lasts `t`: the inverse of
    /// [`DisplacementFunction::duration`], in closed form.
    pub fn at_duration(&self, t: f64) -> f64 {
        let s = self.near_duration(t);
        // One Newton step takes off what cancellation left.
        let large = (s * s + self.gap).sqrt();
        let small_rate = if s <= self.cap_small { 1.0 } else { s / self.cap_small };
        let large_rate = if large <= self.cap_large { s / large } else { s / self.cap_large };
        let better = s - (self.duration(s) - t) / (2.0 * self.k * (small_rate + large_rate));
        if better.is_finite() { better } else { s }
    }

    fn near_duration(&self, t: f64) -> f64 {
        let (cs, cl, gap) = (self.cap_small, self.cap_large, self.gap);
        let per_k = ((t - self.lead_time) / self.k).max(0.0);
        let w = 0.5 * per_k;
        let other = if gap > 0.0 { gap / w } else { 0.0 };
        let (s, large) = (0.5 * (w - other), 0.5 * (w + other));
        if s <= cs && large <= cl {
            return s;
        }
        // A ramp that holds its limit takes longer for the same peak, so that both peaks are lower
        // than without limits.
        if large > cl {
            let s = (per_k * cl - gap).max(0.0).sqrt() - cl;
            if s <= cs {
                return s;
            }
        }
        let r = (per_k * cs + gap).sqrt() - cs;
        if r <= cl {
            return (r * r - gap).max(0.0).sqrt();
        }
        ((per_k - cs - cl - gap / cl) * cs * cl / (cs + cl)).max(0.0).sqrt()
    }

    /// The values of `s` at which the displacement is stationary over the duration, in the order of
    /// `s`; NaN for none.
    pub fn stationary(&self) -> [f64; 7] {
        let (cs, cl, gap, k) = (self.cap_small, self.cap_large, self.gap, self.k);
        let large = |s: f64| (s * s + gap).sqrt();
        let only = |s: f64, yes: bool| if yes { s } else { f64::NAN };
        // No ramp held: alpha + 3 beta w² - gamma / w² = 0.
        let (alpha, beta, gamma) = self.free_terms();
        let root = (alpha * alpha + 12.0 * beta * gamma).sqrt();
        let free = [(-alpha - root) / (6.0 * beta), (-alpha + root) / (6.0 * beta)].map(|sq| {
            let w = sq.sqrt();
            let s = 0.5 * (w - if gap > 0.0 { gap / w } else { 0.0 });
            only(s, s <= cs && large(s) <= cl)
        });
        // One ramp held: base + k r² + (q - k) cap r = 0 for the free peak r.
        let held = |base: f64, cap: f64| {
            let half = 0.5 * (self.q - k) * cap;
            let root = (half * half - k * base).sqrt();
            [(-half - root) / k, (root - half) / k]
        };
        let large_held = held(self.base_small, cl).map(|s| only(s, s <= cs && large(s) > cl));
        let small_held = held(self.base_large, cs).map(|r| {
            let s = (r * r - gap).sqrt();
            only(s, r > 0.0 && s > cs && r <= cl)
        });
        let (_, c1, c2) = self.both_held_terms();
        let s = (-0.5 * c1 / (c2 * k)).sqrt();
        let both = only(s, s > cs && large(s) > cl);
        let mut all = [free[0], free[1], large_held[0], large_held[1], small_held[0], small_held[1], both];
        all.sort_unstable_by(f64::total_cmp);
        all
    }

    /// The value at which the displacement passes the required one between `a` and `b`, at whose
    /// ends it lies on different sides of it.
    pub fn crossing(&self, a: f64, b: f64) -> f64 {
        let rises = self.eval(b).0 >= 0.0;
        let (mut lo, mut hi) = (a, b);
        let mut x = 0.5 * (a + b);
        for _ in 0..MAX_STEPS {
            let (f, g) = self.eval(x);
            if (f >= 0.0) == rises {
                hi = x
            } else {
                lo = x
            }
            let newton = x - f / g;
            let inside = newton > lo && newton < hi;
            let next = if inside { newton } else { 0.5 * (lo + hi) };
            if next == x || hi - lo <= f64::EPSILON * lo.abs().max(hi.abs()) {
                return next;
            }
            // A step that does not even halve the bracket is followed by one that does.
            x = if inside && (newton - x).abs() > 0.5 * (hi - lo) { 0.5 * (lo + hi) } else { next };
        }
        x
    }
}
