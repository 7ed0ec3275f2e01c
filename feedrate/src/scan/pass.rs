//! One directional pass: the greediest jerk-limited motion under a ceiling, taken back where it
//! would break it.
//!
//! The motion accelerates as hard as it may. Where that leads above the ceiling, the pass goes back
//! along what it has laid down to the last point from which the acceleration can still be taken off
//! in time, and lands there tangentially. The same is done, in the second pass, towards the curve
//! of the first.

use super::ceiling::Piece;
use crate::scurve::phase::Phase;

/// A phase with its duration and the index of the piece it starts in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub phase: Phase,
    pub dt: f64,
    pub piece: usize,
}

/// Relative round-off granted before a speed counts as above the ceiling.
pub(super) const ROUND: f64 = 1e-12;

/// The state the next phase starts from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Here {
    pub s: f64,
    pub v: f64,
    pub a: f64,
    pub piece: usize,
    /// The acceleration is to be held: the motion has landed on a line of the ceiling.
    pub hold: bool,
}

/// A continuous stretch of the braking curve, from `first` to `last` (exclusive) in a list of steps
/// by position.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub first: usize,
    pub last: usize,
    pub s1: f64,
    /// Strongest braking on the run (m/s², positive).
    pub steepest: f64,
    /// Speed at the end of the run (m/s).
    pub v_end: f64,
}

/// The braking curve: what the backward pass found, in forward order.
#[derive(Debug, Default)]
pub(super) struct Braking {
    pub steps: Vec<Step>,
    pub runs: Vec<Run>,
}

/// Goes up from `here` until the end of the ceiling, or until a drop of the ceiling that cannot be
/// met; returns the state there. Steps are appended to `steps`, those from `floor` on belong to
/// this stretch.
pub(super) fn climb(pieces: &[Piece], mut here: Here, steps: &mut Vec<Step>, floor: usize) -> Option<Here> {
    let mut budget = 40 * (pieces.len() + 10);
    loop {
        budget -= 1;
        if budget == 0 {
            return None;
        }
        let piece = &pieces[here.piece];
        advance(piece, &mut here, piece.s1, steps);
        if here.v * here.v > piece.x(here.s) * (1.0 + ROUND) {
            here = land(pieces, here.piece, steps, floor)?;
            continue;
        }
        if here.s < piece.s1 {
            continue;
        }
        let Some(next) = pieces.get(here.piece + 1) else { return Some(here) };
        let x = here.v * here.v;
        if x > next.x0 * (1.0 + ROUND) {
            // A drop. A small one is met by easing off before it; otherwise this stretch ends here.
            let drop = here.v - next.x0.sqrt();
            if drop * 2.0 * piece.j_max <= here.a * here.a
                && let Some(eased) = land(pieces, here.piece + 1, steps, floor)
            {
                here = eased;
                continue;
            }
            return Some(here);
        }
        here.piece += 1;
    }
}

/// Lays down the next phase from `here`, inside one piece and not beyond `s_stop`.
pub(super) fn advance(piece: &Piece, here: &mut Here, s_stop: f64, steps: &mut Vec<Step>) {
    let a_to = piece.a_safe;
    let (j, dt) = if here.hold || here.a == a_to {
        (0.0, f64::INFINITY)
    } else if here.a < a_to {
        (piece.j_max, (a_to - here.a) / piece.j_max)
    } else {
        (-piece.j_max, (here.a - a_to) / piece.j_max)
    };
    let phase = Phase { t: 0.0, s: here.s, v: here.v, a: here.a, j };
    let left = s_stop - here.s;
    // A stretch of round-off at a boundary is not worth a step, and would be judged by the wrong
    // side's limits.
    if left <= 1e-14 * s_stop {
        here.s = s_stop;
        return;
    }
    if dt.is_finite() && phase.advance(dt) <= left {
        let end = phase.after(dt);
        steps.push(Step { phase, dt, piece: here.piece });
        (here.s, here.v, here.a) = (end.p.min(s_stop), end.v, a_to);
        return;
    }
    // Ends at s_stop. An upper bound of the time: at constant speed, or from rest by acceleration
    // or jerk.
    let bound = if j == 0.0 {
        // s = v t + a t^2 / 2, solved without cancellation.
        2.0 * left / (here.v + (here.v * here.v + 2.0 * here.a * left).sqrt())
    } else {
        phase.time_to_cover(left, dt)
    };
    let end = phase.after(bound);
    steps.push(Step { phase, dt: bound, piece: here.piece });
    (here.s, here.v, here.a) = (s_stop, end.v, end.a);
    if here.hold {
        here.hold = false;
    }
}

/// Time, position and speed at which a motion from `(s, v, a)` with jerk `-j` meets slope `g`.
#[inline]
pub(super) fn ease(s: f64, v: f64, a: f64, g: f64, j: f64) -> (f64, f64, f64) {
    let tau = ((a - g) / j).max(0.0);
    (tau, s + tau * (v + tau * (0.5 * a - tau * j / 6.0)), v + tau * (a - 0.5 * tau * j))
}

/// Goes back along `steps` to the last point from which the line of piece `m` is met tangentially
/// from below, and lands on it. `None` if there is no such point in this stretch.
pub(super) fn land(pieces: &[Piece], m: usize, steps: &mut Vec<Step>, floor: usize) -> Option<Here> {
    let line = &pieces[m];
    // What meets the line's slope before the line begins is under it where it begins, as it is
    // under the lines before; unless the line begins with a drop, which has to be met ahead of it.
    let drop = m > steps.last()?.piece;
    let x_line = |s: f64| if drop { line.x(s) } else { line.x(s.max(line.s0)) };
    let mut j = line.j_max;
    while steps.len() > floor {
        let step = steps[steps.len() - 1];
        for piece in &pieces[step.piece..=m.max(step.piece)] {
            j = j.min(piece.j_max);
        }
        let excess = |t: f64| {
            let e = step.phase.after(t);
            let (_, s, v) = ease(e.p, e.v, e.a, line.g, j);
            v * v - x_line(s)
        };
        let at_start = excess(0.0);
        let granted = at_start.max(0.0);
        if granted > 0.5 * ROUND * line.x0 {
            steps.pop();
            continue;
        }
        // A start on the line, up to round-off: with more acceleration than the line's it is the
        // place to leave.
        let t = if granted > 0.0 && step.phase.a >= line.g {
            0.0
        } else {
            // Before the acceleration reaches the slope of the line the motion falls behind it.
            let behind = line.g - step.phase.a;
            let lo = if behind > 0.0 && step.phase.j > 0.0 { (behind / step.phase.j).min(step.dt) } else { 0.0 };
            root(|t| excess(t) - granted, lo, excess(lo) - granted, step.dt)
        };
        let e = step.phase.after(t);
        let (tau, s, _) = ease(e.p, e.v, e.a, line.g, j);
        let top = steps.len() - 1;
        if t > 0.0 {
            steps[top].dt = t;
        } else {
            steps.pop();
        }
        let mut here = Here { s: e.p, v: e.v, a: e.a, piece: step.piece, hold: false };
        if tau > 0.0 {
            let phase = Phase { t: 0.0, s: e.p, v: e.v, a: e.a, j: -j };
            let (dt, s) = if s > line.s1 { (phase.time_to_cover(line.s1 - e.p, tau), line.s1) } else { (tau, s) };
            let end = phase.after(dt);
            steps.push(Step { phase, dt, piece: step.piece });
            here = Here { s, v: end.v, a: if dt < tau { end.a } else { line.g }, piece: step.piece, hold: dt >= tau };
        } else {
            here.hold = e.a >= line.g * (1.0 - ROUND);
        }
        while here.piece < m && here.s >= pieces[here.piece].s1 {
            here.piece += 1;
        }
        return Some(here);
    }
    None
}

/// Close to the largest `t` in `[lo, hi]` with `f(t) <= 0`, for `f` that starts at `f_lo <= 0` and
/// rises through 0 once, never beyond it: regula falsi with the Illinois rule and a bisection now
/// and then. What is left below costs a hair of time, not exactness.
pub(super) fn root(f: impl Fn(f64) -> f64, lo: f64, f_lo: f64, hi: f64) -> f64 {
    let (mut lo, mut f_lo, mut hi, mut f_hi) = (lo, f_lo, hi, f(hi));
    if f_hi <= 0.0 {
        return hi;
    }
    if f_lo == 0.0 {
        f_lo = -1e-3 * f_hi;
    }
    let (width, enough) = (hi - lo, 1e-7 * f_hi);
    let mut side = 0;
    for i in 0..60 {
        if hi - lo <= 1e-6 * width {
            break;
        }
        let secant =
            if f_lo.is_finite() && f_hi.is_finite() { lo - f_lo * (hi - lo) / (f_hi - f_lo) } else { f64::NAN };
        let t = if i % 4 != 3 && secant > lo && secant < hi { secant } else { 0.5 * (lo + hi) };
        let f_t = f(t);
        if f_t > 0.0 {
            (hi, f_hi) = (t, f_t);
            if side == 1 {
                f_lo *= 0.5;
            }
            side = 1;
        } else {
            (lo, f_lo) = (t, f_t);
            if -f_t <= enough && enough.is_finite() {
                break;
            }
            if side == -1 {
                f_hi *= 0.5;
            }
            side = -1;
        }
    }
    lo
}
