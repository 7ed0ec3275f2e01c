//! A motion of a given duration by one number: the velocity it cruises at.
//!
//! The shortest change to velocity `v` and zero acceleration, cruise, the shortest change to the
//! target (Liu et al. 2024, section 4.1, whose five cases are the places of `v` relative to both
//! ends; `v` ranges over all velocities here, not only over those between the mean one and the
//! nearer end). At a fixed duration the displacement grows with `v`:
//!
//! ```text
//! D(v) = d_1(v) + v (T - t_1(v) - t_3(v)) + d_3(v),     D'(v) = (T - t_1 - t_3) + e_1 + e_3 > 0,
//! e = d' - v t' = (q - k) min(a, a_max)  with the peak acceleration a of a change,
//! ```
//!
//! so that Newton's method has one root to find. Where the two changes take longer than `T` there
//! is no such motion.

use super::displacement_function::Problem;
use super::shape::Shape;
use crate::scurve::closed_form::{Jerks, Peak};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Shortest changes of one direction from a fixed state to a velocity without acceleration, in the
/// frame in which they rise.
#[derive(Clone, Copy)]
struct Ramp {
    base: f64,
    lead_time: f64,
    lead: f64,
    cap: f64,
    k: f64,
    m: f64,
    q: f64,
}

impl Ramp {
    fn new(v: f64, a: f64, cap: f64, j: &Jerks) -> Self {
        let lead_time = a * j.inv_up;
        let base = v - 0.5 * a * lead_time;
        let lead = lead_time * (base + a * lead_time / 6.0);
        Self { base, lead_time, lead, cap, k: j.k, m: j.m, q: j.q }
    }

    /// Peak, duration, displacement and `e` of the change to `v`.
    #[inline]
    fn to(&self, v: f64) -> (Peak, f64, f64, f64) {
        let Self { base, cap, k, m, q, .. } = *self;
        let x = (v - base).max(0.0);
        let sq = x / k;
        let free = sq.sqrt();
        let (peak, t, d) = if free <= cap {
            (Peak { a: free, hold: 0.0 }, 2.0 * k * free, free * (2.0 * k * base + m * sq))
        } else {
            let hold = (x - k * cap * cap) / cap;
            let t = 2.0 * k * cap + hold;
            let d = base * t + cap * (m * cap * cap + hold * (q * cap + 0.5 * hold));
            (Peak { a: cap, hold }, t, d)
        };
        (peak, t - self.lead_time, d - self.lead, (q - k) * peak.a)
    }
}

/// Changes from one end of the motion to a velocity: rising above a threshold, falling below.
struct End {
    up: Ramp,
    down: Ramp,
    threshold: f64,
}

impl End {
    fn new(v: f64, a: f64, rise: f64, fall: f64, j: &Jerks, swapped: &Jerks) -> Self {
        let threshold = v + 0.5 * a * a.abs() * if a > 0.0 { j.inv_down } else { j.inv_up };
        Self { up: Ramp::new(v, a, rise, j), down: Ramp::new(-v, -a, fall, swapped), threshold }
    }

    /// As [`Ramp::to`], and whether it rises.
    #[inline]
    fn to(&self, v: f64) -> (Peak, f64, f64, f64, bool) {
        if v >= self.threshold {
            let (peak, t, d, e) = self.up.to(v);
            (peak, t, d, e, true)
        } else {
            let (peak, t, d, e) = self.down.to(-v);
            (peak, t, -d, e, false)
        }
    }
}

/// The changes from the start to a velocity and from there to the target.
pub(super) struct Changes {
    first: End,
    second: End,
}

/// Both of them for one velocity.
pub(super) struct Pair {
    pub v: f64,
    pub duration: f64,
    pub displacement: f64,
    /// Sum of both `e`.
    pub e: f64,
    first: (Peak, bool),
    second: (Peak, bool),
}

impl Changes {
    pub fn new(p: &Problem) -> Self {
        let swapped = p.j.swapped();
        Self {
            first: End::new(p.v0, p.a0, p.rise, p.fall, &p.j, &swapped),
            // Backwards in time the second change is one from the target: its acceleration and
            // limits on it have other signs.
            second: End::new(p.vf, -p.af, p.fall, p.rise, &p.j, &swapped),
        }
    }

    #[inline]
    pub fn at(&self, v: f64) -> Pair {
        let (peak1, t1, d1, e1, up1) = self.first.to(v);
        let (peak3, t3, d3, e3, up3) = self.second.to(v);
        Pair { v, duration: t1 + t3, displacement: d1 + d3, e: e1 + e3, first: (peak1, up1), second: (peak3, up3) }
    }
}

impl Pair {
    /// Derivative of the displacement by the velocity, without a cruise.
    pub fn slope(&self) -> f64 {
        let rate = |(peak, up): (Peak, bool)| if up { 1.0 / peak.a } else { -1.0 / peak.a };
        self.e + self.v * (rate(self.first) + rate(self.second))
    }

    pub fn shape(&self, cruise: f64) -> Shape {
        let sign = |up: bool, peak: Peak| if up { peak } else { Peak { a: -peak.a, hold: peak.hold } };
        // The second change rises backwards in time where it falls forwards.
        let up = (self.first.1, !self.second.1);
        let (first, second) = (sign(up.0, self.first.0), sign(up.1, self.second.0));
        Shape { first, second, cruise, v_peak: self.v, joined: false, up, squeezed: false }
    }
}

/// The motion of duration `t` with one cruise velocity, if there is one.
pub(super) fn solve(p: &Problem, t: f64) -> Option<Shape> {
    let changes = Changes::new(p);
    let (mut lo, mut hi) = (p.v_min, p.v_max);
    let mean = p.d / t;
    let scale = mean.abs() + p.v0.abs() + p.vf.abs();
    let mut v = mean.clamp(lo, hi);
    let mut before = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        let pair = changes.at(v);
        let cruise = t - pair.duration;
        let f = pair.displacement + v * cruise - p.d;
        if f < 0.0 {
            lo = v
        } else {
            hi = v
        }
        let slope = cruise + pair.e;
        let newton = v - f / slope;
        let inside = slope > 0.0 && newton >= lo && newton <= hi && (newton - v).abs() < 0.8 * before;
        let next = if inside { newton } else { 0.5 * (lo + hi) };
        let step = (next - v).abs();
        if f == 0.0 || step <= f64::EPSILON * (v.abs() + scale) || hi <= lo {
            let exact = f.abs() <= 16.0 * f64::EPSILON * (scale + v.abs()) * t;
            // The last step is round-off of the velocities at the ends, but a long cruise goes far
            // with it.
            let v = if inside { newton } else { v };
            return (exact && cruise >= -8.0 * f64::EPSILON * t).then(|| Pair { v, ..pair }.shape(cruise.max(0.0)));
        }
        // Newton's steps have to become smaller. The one after a bisection may lead anywhere in the
        // bracket.
        before = if inside { step } else { f64::INFINITY };
        v = next;
    }
    None
}

/// Bisection in every second step exhausts `f64` within a bracket of moderate ratio.
const MAX_STEPS: usize = 120;
