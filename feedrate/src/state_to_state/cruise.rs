//! A motion of a given duration by one number: the velocity it cruises at.
//!
//! The shortest change to velocity `v` and zero acceleration, cruise, the shortest change to the target (Liu et al. 2024, section
//! 4.1, whose five cases are the places of `v` relative to both ends; `v` ranges over all velocities here, not only over those
//! between the mean one and the nearer end). At a fixed duration the displacement grows with `v`:
//!
//! ```text
//! D(v) = d_1(v) + v (T - t_1(v) - t_3(v)) + d_3(v),     D'(v) = (T - t_1 - t_3) + e_1 + e_3 > 0,
//! e = d' - v t' = (q - k) min(a, a_max)  with the peak acceleration a of a change,
//! ```
//!
//! so that Newton's method has one root to find. Where the two changes take longer than `T` there is no such motion.

use super::family::{Jerks, Peak, Problem};
use super::solve::Shape;

/// Shortest changes of one direction from a fixed state to a velocity without acceleration, in the frame in which they rise.
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

/// The motion of duration `t` with one cruise velocity, if there is one.
pub(super) fn solve(p: &Problem, t: f64) -> Option<Shape> {
    let swapped = p.j.swapped();
    let first = End::new(p.v0, p.a0, p.rise, p.fall, &p.j, &swapped);
    // Backwards in time the second change is one from the target: its acceleration and limits on it have other signs.
    let second = End::new(p.vf, -p.af, p.fall, p.rise, &p.j, &swapped);
    let (mut lo, mut hi) = (p.v_min, p.v_max);
    let mean = p.d / t;
    let scale = mean.abs() + p.v0.abs() + p.vf.abs();
    let mut v = mean.clamp(lo, hi);
    let mut before = hi - lo;
    for _ in 0..MAX_STEPS {
        let (peak1, t1, d1, e1, up1) = first.to(v);
        let (peak3, t3, d3, e3, up3) = second.to(v);
        let cruise = t - t1 - t3;
        let f = d1 + d3 + v * cruise - p.d;
        if f < 0.0 {
            lo = v
        } else {
            hi = v
        }
        let slope = cruise + e1 + e3;
        let newton = v - f / slope;
        let inside = slope > 0.0 && newton >= lo && newton <= hi && (newton - v).abs() < 0.8 * before;
        let next = if inside { newton } else { 0.5 * (lo + hi) };
        let step = (next - v).abs();
        if f == 0.0 || step <= f64::EPSILON * (v.abs() + scale) || hi <= lo {
            let exact = f.abs() <= 16.0 * f64::EPSILON * (scale + v.abs()) * t;
            if cruise < -8.0 * f64::EPSILON * t || !exact {
                return None;
            }
            let sign = |up: bool, peak: Peak| if up { peak } else { Peak { a: -peak.a, hold: peak.hold } };
            // The second change rises backwards in time where it falls forwards.
            let (first, second) = (sign(up1, peak1), sign(!up3, peak3));
            return Some(Shape {
                first,
                second,
                cruise: cruise.max(0.0),
                v_peak: v,
                joined: false,
                up: (up1, !up3),
                squeezed: false,
            });
        }
        before = step;
        v = next;
    }
    None
}

/// Bisection alone needs this many steps to exhaust `f64` within a bracket of moderate ratio.
const MAX_STEPS: usize = 100;
