//! Starts above the velocity limit with more way to go than the shortest change of velocity covers.
//!
//! The velocity is brought down to `v_p` and zero acceleration by the shortest way, without dipping below, and changed
//! from there to the target. `v_p` is the limit itself if the way is long enough: braking as hard as possible until the
//! limit is crossed would end the excess sooner, but undershoot it and come back. Otherwise `v_p` is the
//! velocity with which the displacement comes out exactly, unless braking hard at first turns out to be shorter.

use super::family::{Peak, Problem};
use super::solve::Shape;

/// One ramp below a velocity `top` at zero acceleration: peak, duration, distance.
fn below(top: f64, v: f64, cap: f64, p: &Problem) -> (Peak, f64) {
    let swapped = p.j.swapped();
    let peak = Peak::from_square((top - v) / p.j.k, cap, p.j.k);
    (peak, span(peak, top, -1.0, swapped.k, swapped.m, swapped.q))
}

/// Distance of a ramp with its base at velocity `base`, on the side `side` of it.
fn span(peak: Peak, base: f64, side: f64, k: f64, m: f64, q: f64) -> f64 {
    let Peak { a, hold } = peak;
    base * (2.0 * k * a + hold) + side * (m * a * a * a + hold * (q * a * a + 0.5 * a * hold))
}

/// Velocity and distance (from here to there) at which the line of constant jerk through `(v, a)` has zero acceleration.
fn line(v: f64, a: f64, inv_jerk: f64) -> (f64, f64) {
    let base = v - 0.5 * a * a * inv_jerk;
    let t = a * inv_jerk;
    (base, t * (base + a * t / 6.0))
}

struct Ramps<'a> {
    p: &'a Problem,
    top: f64,
    lead_in: f64,
    /// Second half falling to the target, or rising to it.
    falling: (f64, f64),
    rising: (f64, f64),
    /// The second half falls from velocities above this.
    threshold: f64,
}

impl Ramps<'_> {
    fn eval(&self, v: f64) -> (f64, Peak, Peak, bool) {
        let (p, j) = (self.p, &self.p.j);
        let (first, d1) = below(self.top, v, p.fall, p);
        let (second, d2, up) = if v >= self.threshold {
            let (base, lead) = self.falling;
            let peak = Peak::from_square((v - base) / j.k, p.fall, j.k);
            (Peak { a: -peak.a, hold: peak.hold }, span(peak, base, 1.0, j.k, j.m, j.q) + lead, false)
        } else {
            let (peak, d) = below(self.rising.0, v, p.rise, p);
            (peak, d + self.rising.1, true)
        };
        let d = d1 + d2 - self.lead_in - p.d;
        (d, Peak { a: -first.a, hold: first.hold }, second, up)
    }

    fn shape(&self, v: f64, cruise: f64) -> Shape {
        let (_, first, second, up) = self.eval(v);
        Shape { first, second, cruise, v_peak: v, joined: false, up: (false, up), squeezed: false }
    }
}

pub(super) fn solve(p: &Problem) -> Shape {
    let (top, lead_in) = line(p.v0, p.a0, -p.j.inv_down);
    let falling = line(p.vf, p.af, p.j.inv_up);
    let rising = line(p.vf, p.af, -p.j.inv_down);
    let threshold = if p.af > 0.0 { falling.0 } else { rising.0 };
    let ramps = Ramps { p, top, lead_in, falling, rising, threshold };
    let (f_max, f_min) = (ramps.eval(p.v_max).0, ramps.eval(p.v_min).0);
    if f_max <= 0.0 {
        return ramps.shape(p.v_max, -f_max / p.v_max);
    }
    if f_min >= 0.0 {
        return Shape { squeezed: true, ..ramps.shape(p.v_min, f_min / -p.v_min) };
    }
    // Bisection with secant steps in between: rare enough not to be worth derivatives.
    let (mut lo, mut hi, mut f_lo, mut f_hi) = (p.v_min, p.v_max, f_min, f_max);
    for i in 0..MAX_STEPS {
        let secant = lo - f_lo * (hi - lo) / (f_hi - f_lo);
        let mid = if i % 3 == 2 || !(secant > lo && secant < hi) { 0.5 * (lo + hi) } else { secant };
        if mid <= lo || mid >= hi {
            break;
        }
        let f = ramps.eval(mid).0;
        if f < 0.0 { (lo, f_lo) = (mid, f) } else { (hi, f_hi) = (mid, f) }
    }
    Shape { squeezed: true, ..ramps.shape(if -f_lo < f_hi { lo } else { hi }, 0.0) }
}

/// Acceleration and time at its limit when the velocity is brought down to `v_max` as soon as possible.
pub(super) fn brake_to_limit(p: &Problem) -> Peak {
    let top = line(p.v0, p.a0, -p.j.inv_down).0;
    let peak = (2.0 * p.j.down * (top - p.v_max)).max(0.0).sqrt();
    if peak <= p.fall {
        return Peak { a: -peak, hold: 0.0 };
    }
    let excess = top - 0.5 * p.fall * p.fall * p.j.inv_down - p.v_max;
    Peak { a: -p.fall, hold: (excess / p.fall).max(0.0) }
}

const MAX_STEPS: usize = 200;
