//! One directional pass: the greediest jerk-limited motion under a ceiling, taken back where it would break it.
//!
//! The motion accelerates as hard as it may. Where that leads above the ceiling, the pass goes back along what it has
//! laid down to the last point from which the acceleration can still be taken off in time, and lands there tangentially.
//! The same is done, in the second pass, towards the curve of the first.

use super::ceiling::Piece;
use crate::scurve::phase::Phase;
use crate::state::MotionState;

/// A phase with its duration and the index of the piece it starts in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub phase: Phase,
    pub dt: f64,
    pub piece: usize,
}

/// Relative round-off granted before a speed counts as above the ceiling.
const ROUND: f64 = 1e-12;

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

/// A continuous stretch of the braking curve, from `first` to `last` (exclusive) in a list of steps by position.
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

/// Goes up from `here` until the end of the ceiling, or until a drop of the ceiling that cannot be met; returns the
/// state there. Steps are appended to `steps`, those from `floor` on belong to this stretch.
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
    // A stretch of round-off at a boundary is not worth a step, and would be judged by the wrong side's limits.
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
    // Ends at s_stop. An upper bound of the time: at constant speed, or from rest by acceleration or jerk.
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
fn ease(s: f64, v: f64, a: f64, g: f64, j: f64) -> (f64, f64, f64) {
    let tau = ((a - g) / j).max(0.0);
    (tau, s + tau * (v + tau * (0.5 * a - tau * j / 6.0)), v + tau * (a - 0.5 * tau * j))
}

/// Goes back along `steps` to the last point from which the line of piece `m` is met tangentially from below, and
/// lands on it. `None` if there is no such point in this stretch.
fn land(pieces: &[Piece], m: usize, steps: &mut Vec<Step>, floor: usize) -> Option<Here> {
    let line = &pieces[m];
    // What meets the line's slope before the line begins is under it where it begins, as it is under the lines before;
    // unless the line begins with a drop, which has to be met ahead of it.
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
        // A start on the line, up to round-off: with more acceleration than the line's it is the place to leave.
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

/// Close to the largest `t` in `[lo, hi]` with `f(t) <= 0`, for `f` that starts at `f_lo <= 0` and rises through 0 once, never beyond
/// it: regula falsi with the Illinois rule and a bisection now and then. What is left below costs a hair of time, not exactness.
fn root(f: impl Fn(f64) -> f64, lo: f64, f_lo: f64, hi: f64) -> f64 {
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

/// The forward pass: climbs under the ceiling and joins the braking curve wherever it meets it. `None` if no join exists.
pub(super) fn run(pieces: &[Piece], braking: &Braking, v_start: f64, steps: &mut Vec<Step>) -> Option<()> {
    let length = pieces[pieces.len() - 1].s1;
    let mut here = Here { s: 0.0, v: v_start, a: 0.0, piece: 0, hold: false };
    let mut r = 0;
    let mut budget = 60 * (pieces.len() + braking.runs.len() + 10);
    loop {
        budget -= 1;
        if budget == 0 {
            return None;
        }
        while r > 0 && here.s < braking.runs[r - 1].s1 {
            r -= 1;
        }
        while here.s >= braking.runs[r].s1 {
            r += 1;
            if r == braking.runs.len() {
                return Some(());
            }
        }
        while here.s >= pieces[here.piece].s1 && here.piece + 1 < pieces.len() {
            here.piece += 1;
        }
        let piece = &pieces[here.piece];
        advance(piece, &mut here, piece.s1.min(braking.runs[r].s1), steps);
        if here.v * here.v > piece.x(here.s) * (1.0 + ROUND) {
            here = land(pieces, here.piece, steps, 0)?;
            continue;
        }
        if here.v > braking.speed_at(r, here.s) * (1.0 + ROUND) {
            here = braking.join(pieces, r, steps)?;
            r += 1;
            if r == braking.runs.len() {
                debug_assert!(here.s == length);
                return Some(());
            }
        }
    }
}

impl Braking {
    /// Speed of the curve at `s` inside run `r`.
    fn speed_at(&self, r: usize, s: f64) -> f64 {
        let run = &self.runs[r];
        if s >= run.s1 || run.first == run.last {
            return run.v_end;
        }
        let (k, u) = self.locate(r, s);
        self.steps[run.first + k].phase.after(u).v
    }

    /// The step of run `r` and the time in it at position `s`.
    fn locate(&self, r: usize, s: f64) -> (usize, f64) {
        let run = &self.runs[r];
        let steps = &self.steps[run.first..run.last];
        let i = steps.partition_point(|step| step.phase.s <= s).saturating_sub(1);
        steps.get(i).map_or((i, 0.0), |step| (i, step.phase.time_to_cover(s - step.phase.s, step.dt)))
    }

    /// Leaves the steps laid down at the last point from which jerk `-j` leads tangentially onto run `r`, follows that
    /// run to its end, and returns the state there.
    fn join(&self, pieces: &[Piece], r: usize, steps: &mut Vec<Step>) -> Option<Here> {
        let run = self.runs[r];
        let curve = &self.steps[run.first..run.last];
        if curve.is_empty() {
            return None;
        }
        let crossing = steps.last()?.piece;
        let mut j = f64::INFINITY;
        // The join ends a little beyond the crossing; how far is known only afterwards.
        let mut upto = (crossing + 1).min(pieces.len() - 1);
        let mut n = steps.len();
        loop {
            j = pieces[crossing..=upto].iter().fold(j, |j, piece| j.min(piece.j_max));
            let found = loop {
                let step = steps[..n].last()?;
                j = pieces[step.piece..=crossing].iter().fold(j, |j, piece| j.min(piece.j_max));
                let gap = |t: f64| meet(&run, curve, j, &step.phase.after(t)).map_or(-run.s1, |place| place.gap);
                let at_start = gap(0.0);
                if at_start <= 0.0 {
                    break root(gap, 0.0, at_start, step.dt);
                }
                n -= 1;
            };
            let step = steps[n - 1];
            let e = step.phase.after(found);
            let Some(Place { gap, k, u }) = meet(&run, curve, j, &e) else {
                steps.truncate(n);
                steps[n - 1].dt = found;
                return cruise_to_end(pieces, &run, (&e, j), steps);
            };
            let b = curve[k].phase.after(u);
            let landing = pieces.partition_point(|piece| piece.s1 < b.p);
            if landing > upto {
                upto = landing;
                continue;
            }
            steps.truncate(n);
            if found > 0.0 {
                steps[n - 1].dt = found;
            } else {
                steps.pop();
            }
            if !ease_into((&e, &b), j, -gap, ROUND * run.s1, step.piece, steps) {
                return None;
            }
            let mut piece = landing;
            let first = Phase { t: 0.0, s: b.p, v: b.v, a: b.a, j: b.j };
            if curve[k].dt > u {
                steps.push(Step { phase: first, dt: curve[k].dt - u, piece });
            }
            for step in &curve[k + 1..] {
                while piece + 1 < pieces.len() && pieces[piece].s1 <= step.phase.s {
                    piece += 1;
                }
                steps.push(Step { piece, ..*step });
            }
            return Some(Here { s: run.s1, v: run.v_end, a: 0.0, piece, hold: false });
        }
    }
}

/// Takes off the acceleration of state `e` with jerk `-j` and cruises to the end of the run, above whose end speed the
/// motion is not.
fn cruise_to_end(pieces: &[Piece], run: &Run, (e, j): (&MotionState, f64), steps: &mut Vec<Step>) -> Option<Here> {
    let mut piece = steps.last()?.piece;
    let (tau, s, v) = ease(e.p, e.v, e.a, 0.0, j);
    if e.a < 0.0 || s > run.s1 {
        return None;
    }
    let cruise = Phase { t: 0.0, s, v, a: 0.0, j: 0.0 };
    for (phase, dt) in [(Phase { t: 0.0, s: e.p, v: e.v, a: e.a, j: -j }, tau), (cruise, (run.s1 - s) / v)] {
        while piece + 1 < pieces.len() && pieces[piece].s1 <= phase.s {
            piece += 1;
        }
        if dt > 0.0 {
            steps.push(Step { phase, dt, piece });
        }
    }
    Some(Here { s: run.s1, v, a: 0.0, piece, hold: false })
}

/// Eases off from state `e` to the peak speed, cruises over the distance that is `missing`, and goes on easing to the
/// acceleration of `b` on the braking curve. False if the two states do not meet so, but for a distance of round-off.
fn ease_into(
    (e, b): (&MotionState, &MotionState),
    j: f64,
    missing: f64,
    round_off: f64,
    piece: usize,
    steps: &mut Vec<Step>,
) -> bool {
    let (tau, s, v) = ease(e.p, e.v, e.a, 0.0, j);
    if e.a > 0.0 {
        steps.push(Step { phase: Phase { t: 0.0, s: e.p, v: e.v, a: e.a, j: -j }, dt: tau, piece });
    }
    let a = e.a.min(0.0);
    if a < b.a || a < 0.0 && missing > round_off {
        return false;
    }
    if missing > 0.0 {
        steps.push(Step { phase: Phase { t: 0.0, s, v, a, j: 0.0 }, dt: missing / v, piece });
    }
    let tau = (a - b.a) / j;
    if tau > 0.0 {
        steps.push(Step { phase: Phase { t: 0.0, s: s + missing, v, a, j: -j }, dt: tau, piece });
    }
    true
}

/// A place on the braking curve: step, time in it, and how far beyond it (m) the motion is when it has the speed and
/// acceleration the curve has there.
struct Place {
    gap: f64,
    k: usize,
    u: f64,
}

/// The place at which easing off from state `e` with jerk `-j` has speed and acceleration of the braking curve. `None` if the
/// acceleration is gone below the whole run; a gap without bound if it is above the whole run.
///
/// Along jerk `-j` the level `v + a^2 / (2 j)` stays, so the place is where the curve falls through that level. If it
/// does so more than once the most restrictive place counts.
fn meet(run: &Run, curve: &[Step], j: f64, e: &MotionState) -> Option<Place> {
    let level = |v: f64, a: f64| v + 0.5 * a * a / j;
    let w = level(e.v, e.a);
    // A run that begins with a cruise lets nothing rise above it.
    let begin = &curve[0].phase;
    if begin.a == 0.0 && w > begin.v * (1.0 + ROUND) {
        return Some(Place { gap: f64::INFINITY, k: 0, u: 0.0 });
    }
    // The speed falls along the curve, and the level lies above it by no more than the strongest braking gives.
    let first = curve.partition_point(|step| step.phase.v > w).saturating_sub(1);
    let last = curve.partition_point(|step| step.phase.v >= w - 0.5 * run.steepest * run.steepest / j);
    let mut worst: Option<Place> = None;
    for (k, step) in curve.iter().enumerate().take(last).skip(first) {
        let p = &step.phase;
        // Levels chain from step to step, so that round-off leaves no gap between them.
        let w0 = level(p.v, p.a);
        let w1 = curve.get(k + 1).map_or(run.v_end, |next| level(next.phase.v, next.phase.a));
        if w0 < w || w1 > w || p.a == 0.0 && p.j == 0.0 {
            continue;
        }
        // w0 + c1 t + c2 t^2 = w
        let c1 = p.a * (1.0 + p.j / j);
        let c2 = 0.5 * p.j * (1.0 + p.j / j);
        let root = (c1 * c1 - 4.0 * c2 * (w0 - w)).max(0.0).sqrt();
        let u = if c1 > 0.0 { (c1 + root) / (-2.0 * c2) } else { 2.0 * (w0 - w) / (root - c1) };
        let u = if u.is_nan() { step.dt } else { u.clamp(0.0, step.dt) };
        let b = p.after(u);
        let gap = ease(e.p, e.v, e.a, b.a, j).1 - b.p;
        if worst.as_ref().is_none_or(|place| gap > place.gap) {
            worst = Some(Place { gap, k, u });
        }
    }
    if worst.is_none() && w > run.v_end {
        return Some(Place { gap: f64::INFINITY, k: first, u: 0.0 });
    }
    worst
}
