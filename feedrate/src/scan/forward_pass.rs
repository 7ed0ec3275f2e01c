//! The forward pass: the motion climbs under the ceiling and joins the braking curve of the
//! backward pass.

use super::ceiling::Piece;
use super::pass::{Braking, Here, ROUND, Run, Step, advance, ease, land, root};
use crate::scurve::phase::Phase;
use crate::state::MotionState;

/// The forward pass: climbs under the ceiling and joins the braking curve wherever it meets it.
/// `None` if no join exists.
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

    /// Leaves the steps laid down at the last point from which jerk `-j` leads tangentially onto
    /// run `r`, follows that run to its end, and returns the state there.
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
            // By round-off the curve may end beyond the last piece.
            let landing = pieces.partition_point(|piece| piece.s1 < b.p).min(pieces.len() - 1);
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

/// Takes off the acceleration of state `e` with jerk `-j` and cruises to the end of the run, above
/// whose end speed the motion is not.
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

/// Eases off from state `e` to the peak speed, cruises over the distance that is `missing`, and
/// goes on easing to the acceleration of `b` on the braking curve. False if the two states do not
/// meet so, but for a distance of round-off.
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

/// A place on the braking curve: step, time in it, and how far beyond it (m) the motion is when it
/// has the speed and acceleration the curve has there.
struct Place {
    gap: f64,
    k: usize,
    u: f64,
}

/// The place at which easing off from state `e` with jerk `-j` has speed and acceleration of the
/// braking curve. `None` if the acceleration is gone below the whole run; a gap without bound if it
/// is above the whole run.
///
/// Along jerk `-j` the level `v + a^2 / (2 j)` stays, so the place is where the curve falls through
/// that level. If it does so more than once the most restrictive place counts.
fn meet(run: &Run, curve: &[Step], j: f64, e: &MotionState) -> Option<Place> {
    let level = |v: f64, a: f64| v + 0.5 * a * a / j;
    let w = level(e.v, e.a);
    // A run that begins with a cruise lets nothing rise above it.
    let begin = &curve[0].phase;
    if begin.a == 0.0 && w > begin.v * (1.0 + ROUND) {
        return Some(Place { gap: f64::INFINITY, k: 0, u: 0.0 });
    }
    // The speed falls along the curve, and the level lies above it by no more than the strongest
    // braking gives.
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
