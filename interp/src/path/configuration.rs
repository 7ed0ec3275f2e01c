//! The configuration from which a path is followed, and the walk along it that judges one.

use std::f64::consts::TAU;

use arcfeed_kinematics::{ForwardKinematics, JointRange, Joints, smallest_singular_value};

use super::follow::check_step;
use super::jet::JointJet;
use super::motion_path::MotionPath;
use crate::error::PathError;

/// Places of the walk that judges a configuration.
const WALK: usize = 64;
/// The walk does not halve its steps below this part of the path.
const SHORTEST_STEP: f64 = 1e-8;
/// A step that misses the prediction by more than this is halved, or is a change of branch, rad.
const JUMP: f64 = 1.0;

/// The one of the configurations `candidates` at the start of `path` from which it is followed best, with its quality: the least of the
/// smallest singular value and a tenth of the distance to the end of a joint's range, on a coarse walk along the path.
///
/// # Errors
/// [`PathError::NoConfiguration`] when none gets to the end.
pub(crate) fn select_configuration<'c, const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    candidates: impl ExactSizeIterator<Item = &'c Joints<N>>,
    range: &JointRange<N>,
) -> Result<(f64, Joints<N>), PathError> {
    let count = candidates.len();
    let middle = (range.lower() + range.upper()) / 2.0;
    let mut best: Option<(f64, Joints<N>)> = None;
    let mut farthest: Option<(f64, PathError)> = None;
    for candidate in candidates {
        // The turn nearest to the middle of the joint ranges leaves most room for turning on.
        let start = candidate.zip_map(&middle, |q, m| q + ((m - q) / TAU).round() * TAU);
        match walk_from_any_turn(path, arm, start, range) {
            Ok((quality, start)) if best.as_ref().is_none_or(|b| quality > b.0) => best = Some((quality, start)),
            Ok(_) => {}
            Err((s, error)) if farthest.as_ref().is_none_or(|f| s > f.0) => farthest = Some((s, error)),
            Err(_) => {}
        }
    }
    match (best, farthest) {
        (Some(best), _) => Ok(best),
        (None, Some((_, error))) => Err(PathError::NoConfiguration { candidates: count, best: Box::new(error) }),
        // An inverse that returns has a solution at least, so that one of the two is there.
        (None, None) => Ok((0.0, middle)),
    }
}

/// [`walk`], and where a joint uses up its range on the way, again with that joint a turn further from that end of it.
/// Returns the quality and the start that was used.
fn walk_from_any_turn<const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    mut start: Joints<N>,
    range: &JointRange<N>,
) -> Result<(f64, Joints<N>), (f64, PathError)> {
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

/// The quality of a start with the joints there; or how far it got and why it stopped. Where a step is not what the one before foretold it is halved: a
/// winding path bends a lot between two places of the walk.
fn walk<const N: usize>(
    path: &dyn MotionPath<N>,
    arm: &dyn ForwardKinematics<N>,
    start: &Joints<N>,
    range: &JointRange<N>,
) -> Result<(f64, Joints<N>), (f64, PathError)> {
    let length = path.length();
    let shortest = SHORTEST_STEP * length;
    let mut last: Option<JointJet<N>> = None;
    let (mut quality, mut first) = (f64::INFINITY, *start);
    let mut ahead: Vec<f64> = (0..=WALK).rev().map(|i| length * i as f64 / WALK as f64).collect();
    while let Some(&s) = ahead.last() {
        let near = last.map_or(*start, |jet: JointJet<N>| jet.q);
        let jet = path.jet(s, &near).map_err(|e| (s, e))?;
        if let Some(before) = last
            && let Err(jump) = check_step(path, &jet, &before.ahead(s - before.s), JUMP)
        {
            if s - before.s > shortest {
                ahead.push(before.s + 0.5 * (s - before.s));
                continue;
            }
            return Err((s, jump.within(range.lower(), range.upper())));
        }
        ahead.pop();
        let distance = (jet.q - range.lower()).zip_map(&(range.upper() - jet.q), f64::min).min();
        quality = quality.min(smallest_singular_value(&arm.jacobian(&jet.q))).min(0.1 * distance);
        if last.is_none() {
            first = jet.q;
        }
        last = Some(jet);
    }
    Ok((quality, first))
}
