//! Continuous acceleration across segments.

use super::ceiling::{Piece, ceiling};
use super::pass::{Braking, Here, Run, Step, climb, run};
use super::{Segment, boundaries};
use crate::error::FeedError;
use crate::plan::{PlanBuilder, SpeedPlan};
use crate::scurve::phases::Phase;

/// Placeholder.
pub fn plan_joined(segments: &[Segment], v_start: f64, v_end: f64) -> Result<SpeedPlan, FeedError> {
    match try_joined(segments, v_start, v_end) {
        Some(plan) => Ok(plan),
        None => super::segment::plan_per_segment(segments, v_start, v_end),
    }
}

pub fn try_joined(segments: &[Segment], v_start: f64, v_end: f64) -> Option<SpeedPlan> {
    let s = boundaries(segments);
    let n = segments.len();
    let length = s[n];
    let mut ahead = Vec::new();
    let mut behind = Vec::new();
    ceiling(segments.iter(), |k| s[k], &mut ahead);
    ceiling(segments.iter().rev(), |k| length - s[n - k], &mut behind);
    let braking = backward(&ahead, &behind, v_end)?;
    let mut steps = Vec::with_capacity(4 * ahead.len());
    run(&ahead, &braking, v_start, &mut steps)?;
    let mut plan = PlanBuilder::with_capacity(steps.len());
    for step in &steps {
        let p = step.phase;
        plan.push(p.s, p.v, p.a, p.j, step.dt);
    }
    Some(plan.finish(length, v_end))
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
    // Mirror: time and position run backwards, so speed and jerk stay and acceleration changes sign.
    let mut braking = Braking::default();
    for &(first, last, s_start, v_start) in ends.iter().rev() {
        let start = braking.steps.len();
        for step in found[first..last].iter().rev() {
            let e = step.phase.after(step.dt);
            let phase = Phase { t: 0.0, s: length - e.p, v: e.v, a: -e.a, j: step.phase.j };
            braking.steps.push(Step { phase, dt: step.dt, piece: 0 });
        }
        let s1 = if s_start == 0.0 { length } else { length - s_start };
        braking.runs.push(Run { first: start, last: braking.steps.len(), s1 });
        braking.v_end.push(v_start);
    }
    Some(braking)
}
