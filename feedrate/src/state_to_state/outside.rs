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

impl<'a> Ramps<'a> {
    fn new(p: &'a Problem) -> Self {
        let (top, lead_in) = line(p.v0, p.a0, -p.j.inv_down);
        let falling = line(p.vf, p.af, p.j.inv_up);
        let rising = line(p.vf, p.af, -p.j.inv_down);
        let threshold = if p.af > 0.0 { falling.0 } else { rising.0 };
        Self { p, top, lead_in, falling, rising, threshold }
    }

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
    let ramps = Ramps::new(p);
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

/// Settling at the limit, cruising there, and changing to the target: the shape without a cruise, its duration, and how much
/// farther than wanted it goes. No motion that does not rise above the settling one goes farther.
pub(super) fn settled(p: &Problem) -> (Shape, f64, f64) {
    let ramps = Ramps::new(p);
    let (excess, first, second, up) = ramps.eval(p.v_max);
    let (u, d) = (p.j.inv_up, p.j.inv_down);
    let settling = (p.a0 - first.a) * d + first.hold - first.a * u;
    let change =
        second.hold + if up { second.a * u + (second.a - p.af) * d } else { (p.af - second.a) * u - second.a * d };
    (ramps.shape(p.v_max, 0.0), settling + change, excess)
}

/// The hardest way to bring a velocity above `v_max` down to it.
pub(super) struct Brake {
    pub v0: f64,
    pub a0: f64,
    /// Time until the acceleration is that of `peak`.
    pub t1: f64,
    pub peak: Peak,
    /// Velocity and distance after `t1`.
    pub v1: f64,
    pub p1: f64,
    /// Distance at the end.
    pub p2: f64,
    /// What is left from there, inside the limits.
    pub rest: Problem,
}

impl Brake {
    /// `None` if the acceleration it ends with forces the velocity out of the other limit.
    pub fn new(p: &Problem) -> Option<Self> {
        let peak = brake_to_limit(p);
        if p.v_max - 0.5 * peak.a * peak.a * p.j.inv_up < p.v_min {
            return None;
        }
        let t1 = ((p.a0 - peak.a) * p.j.inv_down).max(0.0);
        let v1 = p.v_max - peak.a * peak.hold;
        let p1 = t1 * (p.v0 + t1 * (2.0 * p.a0 + peak.a) / 6.0);
        let p2 = p1 + 0.5 * peak.hold * (v1 + p.v_max);
        let rest = Problem { d: p.d - p2, v0: p.v_max, a0: peak.a, ..*p };
        Some(Self { v0: p.v0, a0: p.a0, t1, peak, v1, p1, p2, rest })
    }

    pub fn duration(&self) -> f64 {
        self.t1 + self.peak.hold
    }
}

/// Acceleration and time at its limit when the velocity is brought down to `v_max` as soon as possible.
fn brake_to_limit(p: &Problem) -> Peak {
    let top = line(p.v0, p.a0, -p.j.inv_down).0;
    let peak = (2.0 * p.j.down * (top - p.v_max)).max(0.0).sqrt();
    if peak <= p.fall {
        return Peak { a: -peak, hold: 0.0 };
    }
    let excess = top - 0.5 * p.fall * p.fall * p.j.inv_down - p.v_max;
    Peak { a: -p.fall, hold: (excess / p.fall).max(0.0) }
}

const MAX_STEPS: usize = 200;
