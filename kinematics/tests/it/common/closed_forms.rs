//! What the tests of both closed forms share: random joints and poses, and the laws that both keep.

use super::{angle_difference, pose_distance};
use arcfeed_kinematics::{
    AnalyticInverse, BranchTracker, Chain, ClosedForm, ClosedFormArm, ForwardKinematics, InverseKinematics, Joint,
    Joints, Solutions, smallest_singular_value,
};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// How exact the orientation is where the wrist counts as singular, rad, as documented.
pub const WRIST_SINGULAR: f64 = 1e-10;

pub fn joints(range: f64) -> impl Strategy<Value = Joints<6>> {
    prop::array::uniform6(-range..range).prop_map(Joints::from)
}

pub fn poses() -> impl Strategy<Value = Isometry3<f64>> {
    prop::array::uniform6(-3.0..3.0)
        .prop_map(|v: [f64; 6]| Isometry3::new(Vector3::new(v[0], v[1], v[2]) * 0.3, Vector3::new(v[3], v[4], v[5])))
}

/// Joint values that are often exactly those of singular poses.
pub fn special_joints() -> impl Strategy<Value = Joints<6>> {
    let special = prop_oneof![
        2 => -3.0..3.0,
        3 => prop::sample::select(vec![0.0, FRAC_PI_2, -FRAC_PI_2, PI, -PI]),
        1 => (-10.0..-1.0_f64).prop_map(|e| 10.0_f64.powf(e)),
    ];
    prop::collection::vec(special, 6).prop_map(|values| Joints::from_column_slice(&values))
}

/// Largest difference of the nearest solution from `q`, rad.
pub fn nearest(solutions: &[Joints<6>], q: &Joints<6>) -> f64 {
    solutions.iter().map(|solution| angle_difference(solution, q)).fold(f64::INFINITY, f64::min)
}

/// Every solution has the pose, and one is `q`. The number of solutions.
pub fn solutions_reproduce_the_pose(
    arm: &ClosedFormArm<impl ClosedForm>,
    q: &Joints<6>,
) -> Result<usize, TestCaseError> {
    let target = arm.forward(q);
    let solutions = arm.inverse_all(&target).unwrap();
    for solution in &solutions {
        let distance = pose_distance(&arm.forward(solution), &target);
        prop_assert!(distance < 1e-12, "{distance:e}");
        prop_assert!(solution.iter().all(|v| -PI < *v && *v <= PI));
    }
    if smallest_singular_value(&arm.jacobian(q)) > 1e-4 {
        prop_assert!(nearest(&solutions, q) < 1e-9, "{}", nearest(&solutions, q));
    }
    Ok(solutions.len())
}

/// The pose at `q` and all its solutions, which have it as exactly as is documented for a singular wrist.
pub fn solutions_at(
    arm: &ClosedFormArm<impl ClosedForm>,
    q: &Joints<6>,
) -> Result<(Isometry3<f64>, Solutions<6>), TestCaseError> {
    let target = arm.forward(q);
    let all = arm.inverse_all(&target).unwrap();
    for solution in &all {
        let distance = pose_distance(&arm.forward(solution), &target);
        prop_assert!(distance < WRIST_SINGULAR, "{distance:e} at {solution}");
    }
    Ok((target, all))
}

/// Wherever `q` is, the nearest solution and all others have its pose.
pub fn nothing_is_lost_at(arm: &ClosedFormArm<impl ClosedForm>, q: &Joints<6>) -> Result<(), TestCaseError> {
    let (target, _) = solutions_at(arm, q)?;
    let found = arm.inverse(&target, q).map_err(|error| TestCaseError::fail(error.to_string()))?;
    let distance = pose_distance(&arm.forward(&found), &target);
    prop_assert!(distance < WRIST_SINGULAR, "{distance:e} at {found}");
    Ok(())
}

/// Two shifts (m) and two turns (rad) of each joint by which a real arm misses its drawing.
pub type Errors = [[f64; 4]; 6];

pub fn manufacturing_errors() -> impl Strategy<Value = Errors> {
    prop::array::uniform6(prop::array::uniform4(-1e-5..1e-5))
}

/// The chain with each joint moved by its errors.
pub fn with_errors(chain: &Chain<6>, errors: &Errors) -> Chain<6> {
    let mut joints = *chain.joints();
    for (joint, e) in joints.iter_mut().zip(errors) {
        let shift = Isometry3::new(Vector3::new(e[0], e[1], 0.0), Vector3::new(e[2], e[3], 0.0));
        *joint = Joint::revolute(joint.origin() * shift, joint.axis().into_inner()).unwrap();
    }
    Chain::new(joints).unwrap()
}

/// Away from singular poses the solutions of an arm with errors have the pose, and one is `q`.
pub fn solutions_are_polished(arm: &ClosedFormArm<impl ClosedForm>, q: &Joints<6>) -> Result<(), TestCaseError> {
    prop_assume!(smallest_singular_value(&arm.jacobian(q)) > 2e-2);
    let target = arm.forward(q);
    let all = arm.inverse_all(&target).unwrap();
    prop_assert!(nearest(&all, q) < 1e-9);
    for solution in &all {
        prop_assert!(pose_distance(&arm.forward(solution), &target) < 1e-11);
    }
    Ok(())
}

/// Joint 5 passes through 0 while the others move slowly. The path is tracked from poses alone.
pub fn tracks_through_the_wrist(arm: &ClosedFormArm<impl ClosedForm>, shoulder: f64) {
    let joints = |t: f64| Joints::from([0.2 + 0.1 * t, shoulder, 1.2 + 0.1 * t, 0.4 - 0.2 * t, 0.5 * t, 0.3 + 0.2 * t]);
    let mut tracker = BranchTracker::new(arm, joints(-1.0)).with_max_step(0.02);
    for k in -100..=100 {
        let t = f64::from(k) / 100.0;
        let q = tracker.next(&arm.forward(&joints(t))).unwrap();
        // In the singular pose itself one joint is free and stays; on either side it is determined.
        let free = if k == 0 { 3e-3 } else { 1e-9 };
        assert!((q - joints(t)).amax() < free, "{t}: {q}");
        assert!(pose_distance(&arm.forward(&q), &arm.forward(&joints(t))) < 1e-12);
    }
}
