//! The configuration from which a path is followed, and the walk along it that judges one.

use std::f64::consts::TAU;

use arcfeed_kinematics::{ForwardKinematics, JointRange, Joints, smallest_singular_value};

use super::follow::check_step;
use super::jet::JointJet;
use super::motion_path::MotionPath;
use super::passage::{Passage, crosses_singular_pose, is_singular, passage_at};
use crate::error::PathError;

/// Places of the walk that judges a configuration.
const WALK: usize = 64;
/// The walk does not halve its steps below this part of the path.
const SHORTEST_STEP: f64 = 1e-8;
/// A step that misses the prediction by more than this is halved, or is a change of branch, rad.
const JUMP: f64 = 1.0;

/// A start of a path, and what the walk along it has shown.
#[derive(Debug, Clone)]
pub(crate) struct Walked<const N: usize> {
    /// The least of the smallest singular value and a tenth of the distance to the end of a joint's range.
    pub quality: f64,
    /// Joint values at the start, rad.
    pub start: Joints<N>,
    /// Smooth passages through singular poses, in their order on the path.
    pub passages: Vec<Passage<N>>,
}

/// The one of the configurations `candidates` at the start of `path` from which it is followed best, by a coarse walk along the path.
///
/// # Errors
/// [`PathError::NoConfiguration`] when none gets to the end.
pub(crate) fn select_configuration<'c, const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    candidates: impl ExactSizeIterator<Item = &'c Joints<N>>,
    range: &JointRange<N>,
) -> Result<Walked<N>, PathError> {
    let count = candidates.len();
    let middle = (range.lower() + range.upper()) / 2.0;
    let mut best: Option<Walked<N>> = None;
    let mut farthest: Option<(f64, PathError)> = None;
    for candidate in candidates {
        // The turn nearest to the middle of the joint ranges leaves most room for turning on.
        let start = candidate.zip_map(&middle, |q, m| q + ((m - q) / TAU).round() * TAU);
        match walk_from_any_turn(path, arm, start, range) {
            Ok(walked) if best.as_ref().is_none_or(|b| walked.quality > b.quality) => best = Some(walked),
            Ok(_) => {}
            Err((s, error)) if farthest.as_ref().is_none_or(|f| s > f.0) => farthest = Some((s, error)),
            Err(_) => {}
        }
    }
    match (best, farthest) {
        (Some(best), _) => Ok(best),
        (None, Some((_, error))) => Err(PathError::NoConfiguration { candidates: count, best: Box::new(error) }),
        // An inverse that returns has a solution at least, so that one of the two is there.
        (None, None) => Ok(Walked { quality: 0.0, start: middle, passages: Vec::new() }),
    }
}

/// [`walk`], and where a joint uses up its range on the way, again with that joint a turn further from that end of it.
fn walk_from_any_turn<const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    mut start: Joints<N>,
    range: &JointRange<N>,
) -> Result<Walked<N>, (f64, PathError)> {
    for _ in 0..N {
        match walk(path, arm, &start, range) {
            Err((s, PathError::JointRange { joint, value, lower, upper, place })) => {
                let turn = if value < lower { TAU } else { -TAU };
                if !(lower..=upper).contains(&(start[joint] + turn)) {
                    return Err((s, PathError::JointRange { joint, value, lower, upper, place }));
                }
                start[joint] += turn;
            }
            other => return other,
        }
    }
    walk(path, arm, &start, range)
}

/// The quality of a start and the passages on the way; or how far it got and why it stopped.
fn walk<const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    start: &Joints<N>,
    range: &JointRange<N>,
) -> Result<Walked<N>, (f64, PathError)> {
    let (mut quality, mut first, mut passages) = (f64::INFINITY, None, Vec::new());
    let looked = visit(path, arm, start, &mut passages, |jet| {
        let distance = (jet.q - range.lower()).zip_map(&(range.upper() - jet.q), f64::min).min();
        quality = quality.min(smallest_singular_value(&arm.jacobian(&jet.q))).min(0.1 * distance);
        first.get_or_insert(jet.q);
    });
    match looked {
        Ok(()) => Ok(Walked { quality, start: first.unwrap_or(*start), passages }),
        Err((s, error)) => Err((s, error.within(range.lower(), range.upper()))),
    }
}

/// The smooth passages through singular poses on the path from `start`, as far as it can be followed.
pub(crate) fn find_passages<const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    start: &Joints<N>,
) -> Vec<Passage<N>> {
    let mut passages = Vec::new();
    // Where the arm cannot follow, the planner says so, with the place.
    let _ = visit(path, arm, start, &mut passages, |_| {});
    passages
}

/// Walks along the path and lets `see` each place; where the arm cannot follow, how far it got and why it stopped. Where a step is not
/// what the one before foretold it is halved: a winding path bends a lot between two places of the walk.
fn visit<const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    start: &Joints<N>,
    passages: &mut Vec<Passage<N>>,
    mut see: impl FnMut(&JointJet<N>),
) -> Result<(), (f64, PathError)> {
    let length = path.length();
    let shortest = SHORTEST_STEP * length;
    let mut last: Option<JointJet<N>> = None;
    let mut ahead: Vec<f64> = (0..=WALK).rev().map(|i| length * i as f64 / WALK as f64).collect();
    while let Some(&s) = ahead.last() {
        let near = last.map_or(*start, |jet: JointJet<N>| jet.q);
        let foretold = last.map_or(*start, |jet| jet.ahead(s - jet.s));
        let jet = match (passage_at(passages, s), path.jet(s, &near)) {
            (Some(passage), _) => passage.jet(s),
            (None, Ok(jet)) => jet,
            (None, Err(error)) if is_singular(&error) => {
                let passage = Passage::around(path, arm, s, &foretold).filter(|new| is_behind(passages, new));
                let Some(passage) = passage else { return Err((s, error)) };
                passages.push(passage);
                passage.jet(s)
            }
            (None, Err(error)) => return Err((s, error)),
        };
        if let Some(before) = last
            && let Err(jump) = check_step(path, &jet, &foretold, JUMP)
        {
            if s - before.s > shortest {
                ahead.push(before.s + 0.5 * (s - before.s));
                continue;
            }
            return Err((s, jump));
        }
        if let Some(before) = last.filter(|before| passages.last().is_none_or(|passage| passage.to < before.s))
            && crosses_singular_pose(arm, &before.q, &jet.q)
        {
            passages.extend(Passage::between(path, arm, [&before, &jet]).filter(|new| is_behind(passages, new)));
        }
        ahead.pop();
        see(&jet);
        last = Some(jet);
    }
    Ok(())
}

/// True where `new` begins no sooner than the last of the others ends.
fn is_behind<const N: usize>(passages: &[Passage<N>], new: &Passage<N>) -> bool {
    passages.last().is_none_or(|last| last.to <= new.from)
}
