//! Bidirectional scan with one S-profile per segment (Liu et al. 2023, section 4, algorithm 2).

use super::segment::{Segment, boundaries, boundary_caps};
use crate::error::{FeedError, not_negative};
use crate::limits::AxisLimits;
use crate::scurve::profile::{Adjusted, SProfile};
use crate::scurve::solve::{distance, fits, lower, lowest, raise};
use crate::speed_law::{Builder, SpeedLaw};

/// Plans one S-profile per segment with the whole path in view: acceleration is zero at every
/// boundary.
///
/// Backwards, each boundary gets the highest speed from which the rest can still be run; forwards,
/// the highest speed that can be reached below it. Every speed from 0 up to the backward bound then
/// is feasible, so the forward scan cannot fail, and the bisection and re-planning of the printed
/// algorithm are not needed.
///
/// `v_start` and `v_end` (m/s) are the speeds at the ends of the path, both with zero acceleration.
///
/// # Errors
/// [`FeedError::Empty`] without segments; [`FeedError::StartTooFast`] and
/// [`FeedError::EndTooFast`], before anything is planned, if the speeds at the ends cannot be kept;
/// [`FeedError::Negative`] or [`FeedError::NotFinite`] for invalid speeds.
pub fn plan_per_segment(segments: &[Segment], v_start: f64, v_end: f64) -> Result<SpeedLaw, FeedError> {
    let speeds = boundary_speeds(segments, v_start, v_end)?;
    assemble(segments, &speeds)
}

/// The speeds at the segment boundaries of [`plan_per_segment`], one more than there are segments
/// (m/s).
///
/// # Errors
/// As [`plan_per_segment`].
pub fn boundary_speeds(segments: &[Segment], v_start: f64, v_end: f64) -> Result<Vec<f64>, FeedError> {
    let caps = checked_caps(segments, v_start, v_end)?;
    let bound = backward(segments, &caps, v_end);
    check_start(segments, &caps, &bound, v_start)?;
    let mut speeds = Vec::with_capacity(caps.len());
    let mut v = v_start;
    speeds.push(v);
    for (segment, &bound) in segments.iter().zip(&bound[1..]) {
        v = forward(segment, v, bound);
        speeds.push(v);
    }
    // With v_end > 0 the last bound is v_end itself, and the forward scan may fall short of it.
    if v < v_end * (1.0 - 1e-12) {
        return Err(FeedError::EndTooFast { speed: v_end, highest: v });
    }
    if let Some(last) = speeds.last_mut() {
        *last = v_end;
    }
    Ok(speeds)
}

/// Plans with a look-ahead window of `window` segments, as a controller does that does not know the
/// rest of the path yet.
///
/// At each segment the window is scanned as if the path ended at rest at its end (Liu et al. 2023,
/// algorithm 2), and the first segment of the result is kept. With `window >= segments.len()` the
/// result is that of [`plan_per_segment`] to rest. A window that has moved on never sees a lower
/// bound than before, so no step can fail.
///
/// # Errors
/// As [`plan_per_segment`], the start being judged by the first window; [`FeedError::NotPositive`]
/// if `window` is 0.
pub fn plan_windowed(segments: &[Segment], v_start: f64, window: usize) -> Result<SpeedLaw, FeedError> {
    if window == 0 {
        return Err(FeedError::NotPositive { what: "window", value: 0.0 });
    }
    let caps = checked_caps(segments, v_start, 0.0)?;
    let n = segments.len();
    let first = window.min(n);
    let bound = backward(&segments[..first], &caps[..=first], 0.0);
    check_start(&segments[..first], &caps[..=first], &bound, v_start)?;

    let mut speeds = Vec::with_capacity(n + 1);
    let mut v = v_start;
    speeds.push(v);
    for i in 0..n {
        let last = (i + window).min(n);
        let mut bound = 0.0;
        for k in (i + 1..last).rev() {
            bound = backward_step(&segments[k], caps[k], bound, true);
        }
        v = forward(&segments[i], v, bound);
        speeds.push(v);
    }
    assemble(segments, &speeds)
}

pub(super) fn checked_caps(segments: &[Segment], v_start: f64, v_end: f64) -> Result<Vec<f64>, FeedError> {
    not_negative("v_start", v_start)?;
    not_negative("v_end", v_end)?;
    if segments.is_empty() {
        return Err(FeedError::Empty { what: "segments" });
    }
    let caps = boundary_caps(segments);
    let limit = caps[caps.len() - 1];
    if v_end > limit {
        return Err(FeedError::EndTooFast { speed: v_end, highest: limit });
    }
    Ok(caps)
}

/// For each boundary the highest speed from which the rest can be run. Where the path ends at rest,
/// every lower speed can be continued too.
fn backward(segments: &[Segment], caps: &[f64], v_end: f64) -> Vec<f64> {
    let mut bound = vec![0.0; caps.len()];
    bound[segments.len()] = v_end;
    for k in (0..segments.len()).rev() {
        bound[k] = backward_step(&segments[k], caps[k], bound[k + 1], v_end == 0.0);
    }
    bound
}

/// The highest speed at the start of a segment from which a speed up to `bound` at its end can be
/// reached. A full stop takes less distance than braking to a third of the speed, so it may allow
/// more.
fn backward_step(segment: &Segment, cap: f64, bound: f64, may_stop: bool) -> f64 {
    let mut v = raise(bound, segment.length, segment.a_max, segment.j_max);
    if may_stop && bound > 0.0 {
        v = v.max(raise(0.0, segment.length, segment.a_max, segment.j_max));
    }
    cap.min(v)
}

/// The highest speed at the end of a segment, at most `bound`, that is reached from `v` at its
/// start.
pub(crate) fn forward(segment: &Segment, v: f64, bound: f64) -> f64 {
    let (a, j) = (segment.a_max, segment.j_max);
    if bound >= v {
        bound.min(raise(v, segment.length, a, j)).max(v)
    } else if fits(v, bound, segment.length, a, j) {
        bound
    } else {
        slower_than(segment, v, bound)
    }
}

/// The highest end speed below `bound` that can be reached from `v` although `bound` itself cannot:
/// braking harder than to a third of the speed takes less distance again.
fn slower_than(segment: &Segment, v: f64, bound: f64) -> f64 {
    let (mut lo, mut hi) = (0.0, bound);
    for _ in 0..60 {
        let mid = 0.5 * (lo + hi);
        if distance(v, mid, segment.a_max, segment.j_max) <= segment.length {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    lo
}

/// Reports a start speed from which the path cannot be run: where hardest braking first fails to
/// get under the cap.
fn check_start(segments: &[Segment], caps: &[f64], bound: &[f64], v_start: f64) -> Result<(), FeedError> {
    if v_start <= bound[0] * (1.0 + 1e-12) && v_start <= caps[0] {
        return Ok(());
    }
    let highest_start = bound[0];
    let mut low = v_start;
    let fail =
        |segment, allowed, lowest| FeedError::StartTooFast { speed: v_start, segment, allowed, lowest, highest_start };
    if v_start > caps[0] {
        return Err(fail(0, caps[0], v_start));
    }
    for (k, segment) in segments.iter().enumerate() {
        let allowed = if k + 1 == segments.len() { bound[k + 1] } else { caps[k + 1] };
        let next = if allowed < low && distance(low, allowed, segment.a_max, segment.j_max) <= segment.length {
            lower(low, segment.length, segment.a_max, segment.j_max).min(allowed)
        } else {
            lowest(low, segment.length, segment.a_max, segment.j_max)
        };
        if next > allowed {
            return Err(fail(k + 1, allowed, next));
        }
        low = next;
    }
    Err(fail(0, highest_start, v_start))
}

/// One S-profile per segment between speeds that are known to be feasible.
fn assemble(segments: &[Segment], speeds: &[f64]) -> Result<SpeedLaw, FeedError> {
    let s = boundaries(segments);
    let mut plan = Builder::with_capacity(7 * segments.len());
    for (k, segment) in segments.iter().enumerate() {
        let limits = AxisLimits::symmetric_unchecked(segment.v_max, segment.a_max, segment.j_max);
        plan.push_profile(s[k], &SProfile::build(segment.length, speeds[k], speeds[k + 1], &limits, Adjusted::No));
    }
    plan.finish(s[segments.len()], speeds[segments.len()])
}
