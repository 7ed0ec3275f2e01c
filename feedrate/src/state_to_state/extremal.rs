//! The extremals of one direction over the duration: the farthest displacement at each, and the
//! durations at which it is not far enough.
//!
//! At a fixed duration `T` the displacements that can be reached form an interval, because the
//! motions that keep the limits form a convex set. [`Extremals`] of the frame going up give its
//! upper end, those of the mirrored frame its lower end. `T` is possible exactly if the
//! displacement wanted lies in between.

use super::brake_to_limits;
use super::displacement_function::{DisplacementFunction, Problem};
use super::durations::Gaps;
use super::shape::Shape;
use super::solve::{OneSided, start_of_peaked, starts_too_fast};

/// Farthest motions of a frame.
pub(super) struct Extremals {
    one_sided: Option<OneSided>,
    beyond: Beyond,
    v_max: f64,
    /// Round-off of durations, which are differences of times from and to zero acceleration.
    round_off: f64,
}

/// The extremals after those on one side of zero.
enum Beyond {
    /// With a peak velocity: from `start`, to `top` at which it is the limit, from where on the
    /// motion cruises.
    Peaked { function: DisplacementFunction, start: f64, top: f64 },
    /// The start is above the velocity limit: brought down to it, cruise, change to the target.
    Settled { shape: Shape, duration: f64, excess: f64 },
}

/// Largest distance of a duration from the range of an extremal that counts as round-off, relative
/// to the duration.
const SLACK: f64 = 1e-12;

impl Extremals {
    /// The extremals of the frame of `p`; the direct change starts with a rise in it or not.
    pub fn new(p: &Problem, direct_rises: bool) -> Self {
        let beyond = if starts_too_fast(p) {
            let (shape, duration, excess) = brake_to_limits::settled(p);
            Beyond::Settled { shape, duration, excess }
        } else {
            let function = DisplacementFunction::new(p);
            let start = start_of_peaked(p, &function);
            Beyond::Peaked { function, start, top: function.at_velocity(p.v_max).max(start) }
        };
        let leads = (p.a0.abs() + p.af.abs()) * p.j.inv_up.max(p.j.inv_down);
        Self {
            one_sided: OneSided::new(p, direct_rises),
            beyond,
            v_max: p.v_max,
            round_off: 2.0 * f64::EPSILON * leads,
        }
    }

    /// The extremal that lasts `t`, and how much farther than wanted it goes; `None` where there is
    /// none.
    pub fn at(&self, t: f64) -> Option<(f64, Shape)> {
        let slack = SLACK * t + self.round_off;
        let (late, early) = (t + slack, t - slack);
        if let Some(OneSided { function, from, to, .. }) = &self.one_sided
            && function.duration(*from) <= late
            && early <= function.duration(*to)
        {
            let s = function.at_duration(t).clamp(*from, *to);
            return Some((function.eval(s).0, Shape::going_up(function, function.at(s))));
        }
        match &self.beyond {
            Beyond::Peaked { function, start, top } => {
                if late < function.duration(*start) {
                    return None;
                }
                let (t_top, f_top) = (function.duration(*top), function.eval(*top).0);
                if t > t_top {
                    let shape = Shape::going_up(function, function.at(*top));
                    let cruise = t - t_top;
                    return Some((
                        f_top + cruise * self.v_max,
                        Shape { cruise, v_peak: self.v_max, joined: false, ..shape },
                    ));
                }
                let s = function.at_duration(t).clamp(*start, *top);
                Some((function.eval(s).0, Shape::going_up(function, function.at(s))))
            }
            Beyond::Settled { shape, duration, excess } => {
                let cruise = (t - duration).max(0.0);
                (late >= *duration).then(|| (excess + cruise * self.v_max, Shape { cruise, ..*shape }))
            }
        }
    }

    /// Adds the durations later than `gaps.after` at which the farthest motion is too short.
    /// `solved` says that the one lasting `gaps.after` is an extremal of this frame.
    pub fn blocked(&self, solved: bool, gaps: &mut Gaps) {
        let mut t_end = None;
        if let Some(OneSided { function, from, to, gap_follows }) = &self.one_sided {
            self.blocked_on(function, *from, *to, solved, gaps);
            t_end = gap_follows.then(|| function.duration(*to));
        }
        match &self.beyond {
            Beyond::Peaked { function, start, top } => {
                let t_start = function.duration(*start);
                if let Some(t) = t_end {
                    gaps.add(t, t_start);
                }
                self.blocked_on(function, *start, *top, solved, gaps);
                let f_top = function.eval(*top).0;
                if f_top < 0.0 {
                    let t_top = function.duration(*top);
                    gaps.add(t_top, t_top - f_top / self.v_max);
                }
            }
            Beyond::Settled { duration, excess, .. } => {
                gaps.add(t_end.unwrap_or(0.0), duration + (-excess).max(0.0) / self.v_max);
            }
        }
    }

    /// As [`Extremals::blocked`] for the extremals of one function from `from` to `to`.
    fn blocked_on(&self, function: &DisplacementFunction, from: f64, to: f64, solved: bool, gaps: &mut Gaps) {
        if from >= to || function.duration(to) <= gaps.after {
            return;
        }
        let (mut s, (mut f, slope)) = (from, function.eval(from));
        // Only a displacement that turns can fall short again: over the duration it bends up where
        // the acceleration passes through zero.
        if from >= 0.0 && slope >= 0.0 && f >= 0.0 {
            return;
        }
        let turns = if from >= 0.0 && slope >= 0.0 { [f64::NAN; 7] } else { function.stationary() };
        for next in turns.into_iter().filter(|x| *x > from && *x < to).chain([to]) {
            let f_next = function.eval(next).0;
            let t = (function.duration(s), function.duration(next));
            match (f >= 0.0, f_next >= 0.0) {
                (true, true) => {}
                (false, false) => gaps.add(t.0, t.1),
                (true, false) => gaps.add(function.duration(function.crossing(s, next)), t.1),
                (false, true) if solved && t.0 <= gaps.after && gaps.after <= t.1 => {}
                (false, true) => gaps.add(t.0, function.duration(function.crossing(s, next))),
            }
            (s, f) = (next, f_next);
        }
    }
}
