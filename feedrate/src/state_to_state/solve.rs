//! The choice of the shortest extremal: direct change of velocity, direction, gap in the durations.
//!
//! Let `D0` be the displacement of the shortest change from `(v0, a0)` to `(vf, af)` wherever it
//! ends. At a fixed duration the displacements that can be reached form an interval (the
//! constraints are convex), whose upper end is the extremal going up and whose lower end the one
//! going down; both start at `D0`. So the sign of `D - D0` gives the direction, and the first
//! duration at which that extremal covers `D` is the shortest: when the upper end of the interval
//! has come up to `D`, the lower one is still below. Nothing else has to be tried.
//!
//! One complication: where both accelerations have the same sign and the change of velocity is
//! small, durations between the direct change and one that brings the acceleration through zero do
//! not exist. The durations then fall into a short first range, between two direct changes, and a
//! second one without end.

use super::brake_to_limits;
use super::displacement_function::{DisplacementFunction, Peaks, Problem};
use super::shape::Shape;
use crate::limits::SLACK;
use crate::scurve::closed_form::{Change, Peak};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// The shortest change of velocity and acceleration, wherever it ends.
pub(super) struct Direct {
    /// Up, hold, down; the other way round if false.
    pub up: bool,
    pub displacement: f64,
    pub shape: Shape,
}

impl Direct {
    pub fn new(p: &Problem) -> Self {
        let change = Change::new((p.v0, p.a0), (p.vf, p.af), (p.rise, p.fall), &p.j);
        let Change { up, peak, t1, d2, d3, .. } = change;
        let d1 = t1 * (p.v0 + t1 * (2.0 * p.a0 + peak.a) / 6.0);
        let (first, second) =
            if up { (peak, Peak { a: p.af, hold: 0.0 }) } else { (Peak { a: p.a0, hold: 0.0 }, peak) };
        let shape = Shape { first, second, cruise: 0.0, v_peak: 0.0, joined: true, up: (true, false), squeezed: false };
        Self { up, displacement: d1 + d2 + d3, shape }
    }
}

/// The shortest motion, and whether it is given in the mirrored frame. `noise` is the round-off in
/// `p.d`.
pub(super) fn solve(p: &Problem, noise: f64) -> (Shape, bool) {
    let direct = Direct::new(p);
    // On the direct change itself round-off must not decide: right beside it the duration may jump.
    if (p.d - direct.displacement).abs() <= noise && !starts_too_fast(p) && !starts_too_fast(&p.mirrored()) {
        return (direct.shape, false);
    }
    let up = p.d >= direct.displacement;
    let frame = if up { *p } else { p.mirrored() };
    let (shape, flipped) = solve_up(&frame, direct.up == up);
    (shape, flipped == up)
}

/// Returns true if the velocity will still be above its limit when the acceleration has been
/// brought to zero.
pub(super) fn starts_too_fast(p: &Problem) -> bool {
    let inv = if p.a0 > 0.0 { p.j.inv_down } else { p.j.inv_up };
    p.v0 + 0.5 * p.a0 * p.a0.abs() * inv > p.v_max + SLACK * p.v_max.max(-p.v_min)
}

/// Extremals with the acceleration on one side of zero throughout, from the direct change on.
pub(super) struct OneSided {
    pub function: DisplacementFunction,
    /// First and last value of `s`.
    pub from: f64,
    pub to: f64,
    /// True if durations beyond the last one do not exist until the acceleration passes through
    /// zero.
    pub gap_follows: bool,
}

impl OneSided {
    pub fn new(p: &Problem, direct_rises: bool) -> Option<Self> {
        let reach = if direct_rises { p.af } else { -p.a0 };
        if reach <= 0.0 {
            return None;
        }
        let other = if direct_rises { p.a0 } else { -p.af };
        let function = DisplacementFunction::forced(p, direct_rises);
        let beyond = other.max(0.0).powi(2) - function.gap();
        let gap_follows = beyond > 0.0;
        (gap_follows || !starts_too_fast(p)).then(|| Self {
            function,
            from: -reach,
            to: -beyond.max(0.0).sqrt(),
            gap_follows,
        })
    }
}

/// As [`solve`] for a displacement above that of the direct change, which starts with a rise or
/// not.
fn solve_up(p: &Problem, direct_rises: bool) -> (Shape, bool) {
    let mut gap_in_durations = false;
    if let Some(OneSided { function, from, to, gap_follows }) = OneSided::new(p, direct_rises) {
        gap_in_durations = gap_follows;
        if let Some(peaks) = root_one_sided(&function, from, to) {
            return (Shape::going_up(&function, peaks), false);
        }
    }
    let function = DisplacementFunction::new(p);
    let start = start_of_peaked(p, &function);
    let f_start = function.eval(start).0;
    if gap_in_durations && f_start > 0.0 {
        let mirrored = p.mirrored();
        let function = DisplacementFunction::new(&mirrored);
        let start = start_of_peaked(&mirrored, &function);
        return (solve_peaked(&mirrored, &function, start, function.eval(start).0), true);
    }
    (solve_peaked(p, &function, start, f_start), false)
}

/// First root between `from` and `to <= 0`. The displacement may rise, fall and rise again in
/// between.
fn root_one_sided(function: &DisplacementFunction, from: f64, to: f64) -> Option<Peaks> {
    if from >= to {
        return None;
    }
    let (mut from, mut f_from) = (from, function.eval(from).0);
    if f_from >= 0.0 {
        return Some(function.at(from));
    }
    if function.gap() == 0.0 {
        // Rise and fall cancel: all of them are the direct change, one phase, and differ by
        // round-off.
        return (function.eval(to).0 >= 0.0).then(|| function.at(from));
    }
    if let Some(top) = function.summit(from, to) {
        let f_top = function.eval(top).0;
        if f_top >= 0.0 {
            return Some(function.root(from, f_from, top, f_top));
        }
        (from, f_from) = (top, f_top);
    }
    let f_to = function.eval(to).0;
    (f_to >= 0.0).then(|| function.root(from, f_from, to, f_to))
}

/// The lowest `s` at which the acceleration passes through zero between rise and fall.
pub(super) fn start_of_peaked(p: &Problem, function: &DisplacementFunction) -> f64 {
    let (rise, fall) = (p.a0.max(0.0).powi(2), p.af.min(0.0).powi(2));
    let (small, large) = if function.small_is_fall() { (fall, rise) } else { (rise, fall) };
    small.max(large - function.gap()).max(0.0).sqrt()
}

/// Extremals with a peak velocity, and cruising at the limit where they do not suffice.
fn solve_peaked(p: &Problem, function: &DisplacementFunction, start: f64, f_start: f64) -> Shape {
    if starts_too_fast(p) {
        return brake_to_limits::solve(p);
    }
    let top = function.at_velocity(p.v_max).max(start);
    let f_top = function.eval(top).0;
    if f_top <= 0.0 {
        let shape = Shape::going_up(function, function.at(top));
        return Shape { cruise: -f_top / p.v_max, v_peak: p.v_max, joined: false, ..shape };
    }
    let peaks = if f_start >= 0.0 { function.at(start) } else { function.root(start, f_start, top, f_top) };
    Shape::going_up(function, peaks)
}
