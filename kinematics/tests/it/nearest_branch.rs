//! The inverse solves only branches that may be nearest to the seed: the answer is that of all branches, to the last bit.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common::closed_forms::{joints, special_joints};
use arcfeed_kinematics::{
    AnalyticInverse, Candidate, ClosedForm, ClosedFormArm, ForwardKinematics, InverseKinematics, JointRange, Joints,
    KinematicsError, largest_step, models, nearest_solution,
};
use nalgebra::Isometry3;
use proptest::prelude::*;

/// The nearest of all solutions inside the range; none if all are outside.
fn nearest_of_all(
    arm: &ClosedFormArm<impl ClosedForm>,
    target: &Isometry3<f64>,
    seed: &Joints<6>,
) -> Result<Option<Joints<6>>, KinematicsError> {
    let usable = arm.candidates(target, seed)?.filter_map(|candidate| match candidate {
        Candidate::Usable { q, step, .. } => Some((step, (q - seed).norm_squared(), q)),
        Candidate::OutsideLimits { .. } => None,
    });
    let nearer = |best: (f64, f64, Joints<6>), one: (f64, f64, Joints<6>)| {
        if (one.0, one.1) < (best.0, best.1) { one } else { best }
    };
    Ok(usable.reduce(nearer).map(|(.., q)| q))
}

/// All solutions on any turn; where a singular pose leaves a joint free, with its value of `free`.
fn solutions(
    arm: &ClosedFormArm<impl ClosedForm>,
    target: &Isometry3<f64>,
    free: &Joints<6>,
) -> Result<Vec<Joints<6>>, KinematicsError> {
    let value = |candidate| match candidate {
        Candidate::Usable { q, .. } | Candidate::OutsideLimits { q, .. } => q,
    };
    Ok(arm.candidates(target, free)?.map(value).collect())
}

/// Where all solutions are outside the range and the wrist is singular, the free joint may be moved into it: that pose is the target's.
/// Elsewhere the refusal stands.
fn moved_into_the_range(arm: &ClosedFormArm<impl ClosedForm>, target: &Isometry3<f64>, found: &Joints<6>) -> bool {
    let free = arm.inverse_all(target).is_ok_and(|all| all.wrist_singular());
    let at = arm.forward(found);
    let apart = (at.translation.vector - target.translation.vector).norm() + at.rotation.angle_to(&target.rotation);
    let inside = (0..6).all(|j| arm.range().lower()[j] <= found[j] && found[j] <= arm.range().upper()[j]);
    free && inside && apart < 1e-9
}

/// In a singular pose, with a seed outside the range: what is free takes the end of the range that is nearest to the seed, and the solution
/// is the nearest one to the seed itself. Turns are counted twice on the way, so that it is so but for rounding.
fn agrees_from_outside(
    arm: &ClosedFormArm<impl ClosedForm>,
    target: &Isometry3<f64>,
    [seed, free]: [&Joints<6>; 2],
) -> Result<(), TestCaseError> {
    let all = solutions(arm, target, free).and_then(|all| nearest_solution(&all, seed, arm.range()));
    match (all, arm.inverse(target, seed)) {
        (Ok(all), Ok(found)) => {
            let steps = [all, found].map(|q| largest_step(&q, seed).1);
            prop_assert!((steps[0] - steps[1]).abs() < 1e-12, "{:?} of all, {:?} found, seed {:?}", all, found, seed);
        }
        (Err(_), Ok(found)) => prop_assert!(moved_into_the_range(arm, target, &found), "seed {:?}: {:?}", seed, found),
        (Err(all), Err(found)) => {
            prop_assert_eq!(std::mem::discriminant(&all), std::mem::discriminant(&found), "{:?} {:?}", all, found);
        }
        (all, found) => prop_assert!(false, "{:?} of all, {:?} found, seed {:?}", all, found, seed),
    }
    Ok(())
}

fn agrees(arm: &ClosedFormArm<impl ClosedForm>, q: &Joints<6>, seed: &Joints<6>) -> Result<(), TestCaseError> {
    let target = arm.forward(q);
    let possible = seed.zip_zip_map(arm.range().lower(), arm.range().upper(), f64::clamp);
    let singular = arm.inverse_all(&target).is_ok_and(|all| all.wrist_singular() || all.shoulder_singular());
    if singular && possible != *seed {
        return agrees_from_outside(arm, &target, [seed, &possible]);
    }
    match (nearest_of_all(arm, &target, seed), arm.inverse(&target, seed)) {
        (Ok(Some(all)), Ok(found)) => prop_assert_eq!(all, found, "q {:?}, seed {:?}", q, seed),
        (Ok(None), Ok(found)) => {
            prop_assert!(moved_into_the_range(arm, &target, &found), "q {:?}, seed {:?}: {:?}", q, seed, found);
        }
        (Ok(None), Err(found @ KinematicsError::OutsideLimits { .. })) => {
            // All solutions, the joint and the excess of the one that misses the range least.
            let all = nearest_solution(&solutions(arm, &target, seed).unwrap(), seed, arm.range());
            prop_assert_eq!(all, Err(found), "q {:?}, seed {:?}", q, seed);
        }
        (Err(all), Err(found)) => prop_assert_eq!(all, found),
        (all, found) => prop_assert!(false, "{:?} of all, {:?} found, q {:?}, seed {:?}", all, found, q, seed),
    }
    Ok(())
}

/// The same arm with ranges of `half` (rad) to both sides: some branches have no turn inside, others several.
fn with_half<S: ClosedForm>(arm: ClosedFormArm<S>, half: f64) -> ClosedFormArm<S> {
    arm.with_range(JointRange::new(Joints::repeat(-half), Joints::repeat(half)).unwrap())
}

/// Joints beside `q` as along a path, or anywhere in the range.
fn seeds() -> impl Strategy<Value = (bool, Joints<6>, f64)> {
    (any::<bool>(), joints(1.0), (-9.0..0.0_f64).prop_map(|e| 10.0_f64.powf(e)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_nearest_branch_is_the_nearest_of_all(
        q in prop_oneof![joints(3.1), special_joints()],
        near in special_joints(),
        blend in prop::sample::select(vec![0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0]),
        (beside, way, size) in seeds(),
        half in 0.5..7.0_f64,
    ) {
        // Ordinary, singular, and at every distance from singular.
        let q = q * (1.0 - blend) + near * blend;
        let seed = if beside { q + way * size } else { way * half };
        for arm in [models::cr7(), models::ur5e()] {
            agrees(&arm, &q, &seed)?;
            agrees(&with_half(arm, half), &q, &seed)?;
        }
        for arm in [models::kr6_r700(), models::puma560()] {
            agrees(&arm, &q, &seed)?;
            agrees(&with_half(arm, half), &q, &seed)?;
        }
    }
}
