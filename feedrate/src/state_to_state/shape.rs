//! The shape of a solution: two halves, a cruise between them, and how long each phase of it lasts.

use super::displacement_function::{DisplacementFunction, Peaks, Problem};
use crate::scurve::closed_form::Peak;

/// The phases of a solution, in the frame it was found in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    pub first: Peak,
    pub second: Peak,
    /// Time at the peak velocity.
    pub cruise: f64,
    /// Velocity between the two halves, where the acceleration is zero.
    pub v_peak: f64,
    /// True if the two halves are joined by one phase from peak to peak, without stopping at zero
    /// acceleration.
    pub joined: bool,
    /// Jerk directions of the two halves: `true` is up, hold, down.
    pub up: (bool, bool),
    /// True if a start outside the velocity limits left too little way to settle at the limit:
    /// braking harder at first may then be shorter.
    pub squeezed: bool,
}

impl Shape {
    pub fn going_up(function: &DisplacementFunction, peaks: Peaks) -> Self {
        let (first, second) = function.ramps(peaks);
        Self { first, second, cruise: 0.0, v_peak: 0.0, joined: true, up: (true, false), squeezed: false }
    }
}

/// Durations of the phases of a shape, each of them 0 or more.
#[inline]
pub(super) fn times(p: &Problem, shape: &Shape) -> [f64; 7] {
    let Shape { first, second, cruise, joined, up, .. } = *shape;
    let inverse = |up: bool| if up { p.j.inv_up } else { -p.j.inv_down };
    let (a1, a2) = (first.a, second.a);
    let t1 = ((a1 - p.a0) * inverse(up.0)).max(0.0);
    let t7 = ((p.af - a2) * inverse(!up.1)).max(0.0);
    let (t3, t4, t5) = if joined {
        (((a2 - a1) * inverse(up.1)).max(0.0), 0.0, 0.0)
    } else {
        ((-a1 * inverse(!up.0)).max(0.0), cruise.max(0.0), (a2 * inverse(up.1)).max(0.0))
    };
    [t1, first.hold.max(0.0), t3, t4, t5, second.hold.max(0.0), t7]
}

/// The duration of a shape given in the frame of the problem, or in the mirrored one, that begins
/// at `t`: the same sum as of the phases written.
pub(super) fn end_of(p: &Problem, shape: &Shape, mirrored: bool, t: f64) -> f64 {
    let times = if mirrored { times(&p.mirrored(), shape) } else { times(p, shape) };
    times.into_iter().fold(t, |sum, dt| sum + dt)
}
