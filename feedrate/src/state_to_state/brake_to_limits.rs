//! Starts above the velocity limit with more way to go than the shortest change of velocity covers.
//!
//! The velocity is brought down to `v_p` and zero acceleration by the shortest way, without dipping
//! below, and changed from there to the target. `v_p` is the limit itself if the way is long
//! enough: braking as hard as possible until the limit is crossed would end the excess sooner, but
//! undershoot it and come back. Otherwise `v_p` is the velocity with which the displacement comes
//! out exactly, unless braking hard at first turns out to be shorter.

use super::cruise::Changes;
use super::displacement_function::Problem;
use super::shape::Shape;
use crate::scurve::closed_form::Peak;
#[cfg(not(feature = "std"))]
use num_traits::Float;

pub(super) fn solve(p: &Problem) -> Shape {
    let changes = Changes::new(p);
    let excess = |v: f64| changes.at(v).displacement - p.d;
    let f_max = excess(p.v_max);
    if f_max <= 0.0 {
        return changes.at(p.v_max).shape(-f_max / p.v_max);
    }
    // Down to this velocity the jerk is still down, or zero, when the limit is passed: braking
    // first is the same until there and goes on in the shortest way.
    let brake = brake_to_limit(p).a;
    let lowest = p.v_max - 0.5 * brake * brake * p.j.inv_up;
    let (f_low, lowest) = if lowest > p.v_min { (excess(lowest), lowest) } else { (excess(p.v_min), p.v_min) };
    if f_low >= 0.0 {
        // No cruise: a motion with one is of no use but where braking first is impossible.
        let cruise = if lowest > p.v_min { f64::INFINITY } else { f_low / -p.v_min };
        return Shape { squeezed: true, ..changes.at(lowest).shape(cruise) };
    }
    // Newton's method inside a bracket.
    let (mut lo, mut hi) = (lowest, p.v_max);
    let mut v = lo - f_low * (hi - lo) / (f_max - f_low);
    let mut before = hi - lo;
    for _ in 0..MAX_STEPS {
        let pair = changes.at(v);
        let f = pair.displacement - p.d;
        if f < 0.0 {
            lo = v
        } else {
            hi = v
        }
        let newton = v - f / pair.slope();
        let inside = newton > lo && newton < hi && (newton - v).abs() < 0.8 * before;
        let next = if inside { newton } else { 0.5 * (lo + hi) };
        before = (next - v).abs();
        if f == 0.0 || before <= f64::EPSILON * v.abs() || hi - lo <= f64::EPSILON * lo.abs().max(hi.abs()) {
            break;
        }
        v = next;
    }
    Shape { squeezed: true, ..changes.at(v).shape(0.0) }
}

/// Settling at the limit, cruising there, and changing to the target: the shape without a cruise,
/// its duration, and how much farther than wanted it goes. No motion that does not rise above the
/// settling one goes farther.
pub(super) fn settled(p: &Problem) -> (Shape, f64, f64) {
    let pair = Changes::new(p).at(p.v_max);
    (pair.shape(0.0), pair.duration, pair.displacement - p.d)
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
    /// The problem from there on, inside the limits.
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

/// Acceleration and time at its limit when the velocity is brought down to `v_max` as soon as
/// possible.
fn brake_to_limit(p: &Problem) -> Peak {
    // Velocity at zero acceleration on the line of constant jerk through the start.
    let top = p.v0 + 0.5 * p.a0 * p.a0 * p.j.inv_down;
    let peak = (2.0 * p.j.down * (top - p.v_max)).max(0.0).sqrt();
    if peak <= p.fall {
        return Peak { a: -peak, hold: 0.0 };
    }
    let excess = top - 0.5 * p.fall * p.fall * p.j.inv_down - p.v_max;
    Peak { a: -p.fall, hold: (excess / p.fall).max(0.0) }
}

const MAX_STEPS: usize = 200;
