//! All families.

use arcfeed_kinematics::{AnyArm, ParallelAxisArm, models};
use arcfeed_testing::{Counting, Random};
use integration_tests::blended_polylines::{self, BlendedPolyline};
use integration_tests::fuzz::{TARGETS, Target, Verdict};
use integration_tests::hybrid_scenario::Stage;
use integration_tests::raised_limits::RaisedLimit;
use integration_tests::random_jobs::{self, random_job};
use integration_tests::tight_bends::{self, TightBend};

use crate::compiled;
use crate::family::{Family, Outcome};

/// A duration may grow by so much of itself where a limit is raised.
const LONGER: f64 = 1e-3;
/// Largest difference of a pose and that of a solution of the inverse, m and rad.
const SAME_POSE: f64 = 1e-6;

/// The families; `arms` are those of motions in both spaces.
pub fn all<'a>(arms: &'a [ParallelAxisArm; 2], six: &'a ParallelAxisArm) -> Vec<Family<'a>> {
    let mut families = vec![
        Family::new("jobs", |seed| match random_job(seed, false) {
            random_jobs::Outcome::Done(_) => Outcome::Done,
            random_jobs::Outcome::NoPath(_) => Outcome::Refused,
            random_jobs::Outcome::Failed(what) => Outcome::Failed(what),
        }),
        Family::new("compiled", |seed| compiled::play(six, seed)),
        Family::new("polylines", polyline),
        Family::new("tight-bends", tight_bend),
        Family::new("raised-limits", raised_limit),
        hybrid(arms),
        inverse(),
    ];
    families.extend(TARGETS.iter().map(|target| arbitrary(*target)));
    families
}

/// Polylines with blends.
fn polyline(seed: u64) -> Outcome {
    let polyline = BlendedPolyline::random(seed);
    match polyline.play() {
        Ok(blended_polylines::Outcome::Planned(_)) => Outcome::Done,
        Ok(blended_polylines::Outcome::OutOfReach) => Outcome::Refused,
        Err(what) => Outcome::Failed(format!("{what}\n{polyline:?}")),
    }
}

/// Paths with places that are nearly a corner.
fn tight_bend(seed: u64) -> Outcome {
    let path = TightBend::random(seed);
    match path.play() {
        Ok(tight_bends::Outcome::Planned(_)) => Outcome::Done,
        Ok(_) => Outcome::Refused,
        Err(what) => Outcome::Failed(format!("{what}\n{path:?}\n{}", path.path_file())),
    }
}

/// Motions before and after one limit is raised: no longer by more than 0.1 %.
fn raised_limit(seed: u64) -> Outcome {
    let case = RaisedLimit::random(seed);
    match case.durations() {
        None => Outcome::Refused,
        Some(Ok([before, after])) if after / before - 1.0 <= LONGER => Outcome::Done,
        Some(Ok([before, after])) => Outcome::Failed(format!("{before:.6} s, then {after:.6} s\n{case:?}")),
        Some(Err(error)) => Outcome::Failed(format!("{error}\n{case:?}")),
    }
}

/// Motion in both spaces; five scenarios share a stage of arm, path and limits.
fn hybrid(arms: &[ParallelAxisArm; 2]) -> Family<'_> {
    let mut stage: Option<(u64, Option<Stage<'_>>)> = None;
    Family::new("hybrid", move |seed| {
        if stage.as_ref().is_none_or(|(of, _)| *of != seed / 5) {
            stage = Some((seed / 5, Stage::random(arms, seed / 5)));
        }
        let Some((_, Some(ready))) = &stage else { return Outcome::Refused };
        match ready.play(seed, Counting::count) {
            Ok(played) => Outcome::Used(played.worst),
            Err(what) => Outcome::Failed(format!("stage {}: {what}", seed / 5)),
        }
    })
}

/// The inverse of every built-in arm: each solution leads to the pose.
fn inverse() -> Family<'static> {
    let built = |name: &&str| models::description(name)?.build_any().ok();
    let arms: Vec<AnyArm> = models::NAMES.iter().filter_map(built).collect();
    Family::new("inverse", move |seed| {
        let random = &mut Random::new(seed ^ 0x1AF0_11E5);
        let arm = &arms[random.below(arms.len())];
        let q: Vec<f64> = (0..arm.joints()).map(|_| random.between(-3.0, 3.0)).collect();
        let failed = |what: String| Outcome::Failed(format!("{:?} at {q:?}: {what}", arm.joint_names()));
        let Ok(pose) = arm.forward(&q) else { return Outcome::Refused };
        // Seven joints have no list of solutions.
        let solutions = match arm.inverse_all(&pose) {
            Ok((solutions, _)) => solutions,
            Err(_) => match arm.inverse(&pose, &q) {
                Ok(one) => vec![one],
                Err(_) => return Outcome::Refused,
            },
        };
        for solution in &solutions {
            let Ok(reached) = arm.forward(solution) else { return failed(format!("no pose at {solution:?}")) };
            let off = (reached.translation.vector - pose.translation.vector).norm();
            let turned = reached.rotation.angle_to(&pose.rotation);
            if !(off < SAME_POSE && turned < SAME_POSE) {
                return failed(format!("{solution:?} is {off:e} m and {turned:e} rad away"));
            }
        }
        if solutions.is_empty() { Outcome::Refused } else { Outcome::Done }
    })
}

/// Arbitrary inputs of a reader or a planner.
fn arbitrary(target: Target) -> Family<'static> {
    let found = target.find();
    Family::new(target.name, move |seed| match found.feed(seed).verdict {
        Verdict::Accepted => Outcome::Done,
        Verdict::Refused => Outcome::Refused,
        Verdict::Broken(what) => Outcome::Failed(what),
    })
}
