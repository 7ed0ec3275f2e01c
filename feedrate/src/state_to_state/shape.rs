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

/// How far a shape goes that is given in the frame of the problem: the sum of its phases, whose round-off is that of the
/// distances covered, where the formula of an extremal has that of ramps from zero acceleration.
pub(super) fn displacement(p: &Problem, shape: &Shape) -> f64 {
    let [t1, t2, t3, t4, t5, t6, t7] = times(p, shape);
    let (a1, a2) = (shape.first.a, shape.second.a);
    // Forward from the start, and backward from the target.
    let v1 = p.v0 + 0.5 * t1 * (p.a0 + a1);
    let v2 = v1 + a1 * t2;
    let before = t1 * (p.v0 + t1 * (2.0 * p.a0 + a1) / 6.0) + 0.5 * t2 * (v1 + v2);
    let v7 = p.vf - 0.5 * t7 * (p.af + a2);
    let v6 = v7 - a2 * t6;
    let after = t7 * (p.vf - t7 * (2.0 * p.af + a2) / 6.0) + 0.5 * t6 * (v6 + v7);
    let between = if shape.joined {
        t3 * (v2 + t3 * (2.0 * a1 + a2) / 6.0)
    } else {
        t3 * (v2 + t3 * a1 / 3.0) + t4 * shape.v_peak + t5 * (shape.v_peak + t5 * a2 / 6.0)
    };
    before + between + after
}
