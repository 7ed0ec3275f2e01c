//! Continuous acceleration across segments: a climbing pass, a braking pass and tangential joins.
//!
//! One S-profile per segment brings the acceleration to zero at each of a thousand boundaries (Liu
//! et al. 2023, section 4). Here it is zero only where the speed has a minimum. The braking pass
//! runs over the path backwards and finds the highest jerk-limited curve from which every drop of
//! the caps ahead can still be met; the climbing pass accelerates as hard as it may under the caps
//! and joins the braking curve tangentially (see `pass`). The result is checked against the
//! segments before it is returned; where no join passes the check the path is cut.

use super::ceiling::{Piece, ceiling};
use super::forward_pass::run;
use super::pass::{Braking, Here, Run, Step, climb};
use super::per_segment::{boundary_speeds, checked_caps};
use super::segment::{Segment, boundaries};
use crate::error::FeedError;
use crate::limits::AxisLimits;
use crate::scurve::phase::Phase;
use crate::scurve::profile::{Adjusted, SProfile};
use crate::speed_law::{Builder, SpeedLaw};

/// Plans with continuous acceleration over the segments: everywhere, inside the segments too,
/// speed, acceleration and jerk keep the bounds of the segment where the motion is.
///
/// `v_start` and `v_end` (m/s) are the speeds at the ends of the path, both with zero acceleration.
/// On paths with thousands of short segments the duration is typically 3 to 6 % above that of the
/// optimum *without* any jerk limit (which no jerk-limited motion reaches), where one S-profile per
/// segment is 7 to 23 % above it. Where no join can be found the path is cut in two at a speed of
/// the per-segment plan, and so on down to single segments.
///
/// ```
/// use arcfeed_feedrate::{MotionLaw, Segment, plan_continuous, plan_per_segment};
/// // A cap that rises over a hundred short segments.
/// let segments: Vec<Segment> =
///     (0..100).map(|i| Segment::new(1e-4, 0.02 + 4e-4 * f64::from(i), 1.0, 50.0)).collect::<Result<_, _>>()?;
/// let joined = plan_continuous(&segments, 0.0, 0.0)?;
/// assert!(joined.duration() < plan_per_segment(&segments, 0.0, 0.0)?.duration());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
///
/// # Errors
/// As [`plan_per_segment`](crate::plan_per_segment).
pub fn plan_continuous(segments: &[Segment], v_start: f64, v_end: f64) -> Result<SpeedLaw, FeedError> {
    let caps = checked_caps(segments, v_start, v_end)?;
    let s = boundaries(segments);
    let mut plan = Builder::with_capacity(2 * segments.len());
    if v_start > caps[0] || !join(segments, 0.0, v_start, v_end, &mut plan) {
        // Between halves, the speed and the zero acceleration of the per-segment plan.
        let speeds = boundary_speeds(segments, v_start, v_end)?;
        split(segments, &s, &speeds, &mut plan);
    }
    plan.finish(s[segments.len()], v_end)
}

/// Like [`plan_continuous`], if the whole path can be joined at the first attempt, else `None`: a
/// fraction of the time, for callers who have several lists of segments to choose from.
///
/// # Errors
/// If there is no segment, or a speed is negative, not finite or above the cap at its end of the
/// path.
pub fn plan_continuous_at_once(segments: &[Segment], v_start: f64, v_end: f64) -> Result<Option<SpeedLaw>, FeedError> {
    let caps = checked_caps(segments, v_start, v_end)?;
    if v_start > caps[0] {
        return Ok(None);
    }
    let s = boundaries(segments);
    let Some(steps) = attempt(segments, &s, v_start, v_end, SLACKS[0], None) else { return Ok(None) };
    let mut plan = Builder::with_capacity(steps.len());
    for step in &steps {
        plan.push_phase(step.phase.s, step.phase.v, step.phase.a, step.phase.j, step.dt);
    }
    plan.finish(s[segments.len()], v_end).map(Some)
}

/// Distances by which the lines of the ceiling may lie below the caps, relative in v^2; the first
/// is the usual one.
const SLACKS: [f64; 3] = [0.01, 0.02, 0.005];

/// Appends the joined motion over `segments`, which start at `s0`; `false`, and nothing appended,
/// if no join is found.
fn join(segments: &[Segment], s0: f64, v_start: f64, v_end: f64, plan: &mut Builder) -> bool {
    let s = boundaries(segments);
    let least = segments.iter().map(|segment| segment.j_max).fold(f64::INFINITY, f64::min);
    // A join can fail where bounds change in an unlucky place; another set of lines has other
    // places.
    let ways =
        SLACKS.map(|slack| (slack, None)).into_iter().chain([(SLACKS[0], Some(least)), (SLACKS[1], Some(least))]);
    for (slack, jerk) in ways {
        if let Some(steps) = attempt(segments, &s, v_start, v_end, slack, jerk) {
            for step in &steps {
                let p = step.phase;
                plan.push_phase(s0 + p.s, p.v, p.a, p.j, step.dt);
            }
            return true;
        }
    }
    false
}

/// Joins each part of a path that cannot be joined as a whole: cut where the per-segment plan is
/// slowest, away from the ends, down to single segments. `s` and `speeds` are those of the
/// boundaries.
fn split(segments: &[Segment], s: &[f64], speeds: &[f64], plan: &mut Builder) {
    let n = segments.len();
    if n == 1 {
        let limits = AxisLimits::symmetric_unchecked(segments[0].v_max, segments[0].a_max, segments[0].j_max);
        plan.push_profile(s[0], &SProfile::build(segments[0].length, speeds[0], speeds[1], &limits, Adjusted::No));
        return;
    }
    let middle = (n / 4).max(1)..n - n / 4;
    let cut = middle.min_by(|&i, &k| speeds[i].total_cmp(&speeds[k])).unwrap_or(n / 2);
    for part in [0..cut, cut..n] {
        let (first, last) = (part.start, part.end);
        let inside = &segments[part];
        if inside.len() == 1 || !join(inside, s[first], speeds[first], speeds[last], plan) {
            split(inside, &s[first..=last], &speeds[first..=last], plan);
        }
    }
}

/// One way to join: with the given slack of the ceiling, and the jerk bounds of the segments or one
/// bound for all.
fn attempt(
    segments: &[Segment],
    s: &[f64],
    v_start: f64,
    v_end: f64,
    slack: f64,
    jerk: Option<f64>,
) -> Option<Vec<Step>> {
    let n = segments.len();
    let length = s[n];
    let mut ahead = Vec::new();
    let mut behind = Vec::new();
    ceiling(segments.iter(), |k| s[k], slack, jerk, &mut ahead);
    ceiling(segments.iter().rev(), |k| length - s[n - k], slack, jerk, &mut behind);
    let braking = backward(&ahead, &behind, v_end)?;
    let mut steps = Vec::with_capacity(8 * ahead.len());
    run(&ahead, &braking, v_start, &mut steps)?;
    if !keeps_limits(&steps, segments, s, v_start, v_end) {
        return None;
    }
    Some(steps)
}

/// Checks steps against the segments themselves: that they chain, and that speed, acceleration and
/// jerk stay within the bounds of the segment where the motion is, everywhere.
fn keeps_limits(steps: &[Step], segments: &[Segment], s: &[f64], v_start: f64, v_end: f64) -> bool {
    const CHAIN: f64 = 1e-10;
    const LIMIT: f64 = 1.0 + 1e-10;
    let n = segments.len();
    let length = s[n];
    let v_scale = segments.iter().fold(0.0_f64, |m, x| m.max(x.v_max));
    let a_scale = segments.iter().fold(0.0_f64, |m, x| m.max(x.a_max));
    let same = |p: f64, v: f64, a: f64, q: &Phase| {
        (p - q.s).abs() <= CHAIN * length && (v - q.v).abs() <= CHAIN * v_scale && (a - q.a).abs() <= CHAIN * a_scale
    };
    let (mut p, mut v, mut a) = (0.0, v_start, 0.0);
    let mut k = 0;
    for step in steps {
        let phase = &step.phase;
        if !(same(p, v, a, phase) && step.dt >= 0.0) {
            return false;
        }
        let end = phase.after(step.dt);
        (p, v, a) = (end.p, end.v, end.a);
        // A step that starts a hair before a boundary belongs to what follows.
        while k + 1 < n && s[k + 1] <= phase.s + 1e-12 * length {
            k += 1;
        }
        // Speeds can only peak inside a step where the acceleration changes sign; no step does
        // that.
        if phase.a * a < -CHAIN * a_scale * a_scale {
            return false;
        }
        let (mut v_here, mut a_here) = (phase.v, phase.a);
        let mut i = k;
        loop {
            let segment = &segments[i];
            let inside = i + 1 == n || s[i + 1] >= p - 1e-12 * length;
            let (v_next, a_next) = if inside {
                (v, a)
            } else {
                let at = phase.after(phase.time_to_cover(s[i + 1] - phase.s, step.dt));
                (at.v, at.a)
            };
            let fine = v_here.max(v_next) <= segment.v_max * LIMIT
                && v_here.min(v_next) >= -CHAIN * v_scale
                && a_here.abs().max(a_next.abs()) <= segment.a_max * LIMIT
                && phase.j.abs() <= segment.j_max * LIMIT;
            if !fine {
                return false;
            }
            if inside {
                break;
            }
            (v_here, a_here) = (v_next, a_next);
            i += 1;
        }
        k = i;
    }
    (p - length).abs() <= CHAIN * length && (v - v_end).abs() <= CHAIN * v_scale && a.abs() <= CHAIN * a_scale
}

/// The braking curve by a pass over the reversed path.
fn backward(ahead: &[Piece], behind: &[Piece], v_end: f64) -> Option<Braking> {
    let length = ahead[ahead.len() - 1].s1;
    let mut found: Vec<Step> = Vec::with_capacity(4 * behind.len());
    let mut ends = Vec::new();
    let mut here = Here { s: 0.0, v: v_end, a: 0.0, piece: 0, hold: false };
    loop {
        let first = found.len();
        let (s_start, v_start) = (here.s, here.v);
        let end = climb(behind, here, &mut found, first)?;
        ends.push((first, found.len(), s_start, v_start));
        let Some(next) = behind.get(end.piece + 1) else { break };
        // The next run starts under the forward ceiling too, since the motion goes on from here.
        let s = next.s0;
        let forward = length - s;
        let k = ahead.partition_point(|piece| piece.s1 < forward).min(ahead.len() - 1);
        let x = next.x0.min(ahead[k].x(forward));
        here = Here { s, v: x.sqrt(), a: 0.0, piece: end.piece + 1, hold: false };
    }
    // Mirror: time and position run backwards, so speed and jerk stay and acceleration changes
    // sign.
    let mut braking = Braking::default();
    for &(first, last, s_start, v_start) in ends.iter().rev() {
        let start = braking.steps.len();
        for step in found[first..last].iter().rev() {
            let e = step.phase.after(step.dt);
            let phase = Phase { t: 0.0, s: length - e.p, v: e.v, a: -e.a, j: step.phase.j };
            braking.steps.push(Step { phase, dt: step.dt, piece: 0 });
        }
        let s1 = if s_start == 0.0 { length } else { length - s_start };
        let curve = &braking.steps[start..];
        let steepest = curve.iter().fold(0.0_f64, |m, step| m.max(-step.phase.a));
        let v_end = v_start;
        braking.runs.push(Run { first: start, last: braking.steps.len(), s1, steepest, v_end });
    }
    Some(braking)
}
