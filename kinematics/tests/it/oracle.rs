//! Against other people's programs: Pinocchio (forward kinematics, Jacobians) and EAIK (inverse solutions).
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    AnalyticInverse, ClosedForm, ClosedFormArm, ForwardKinematics, InverseKinematics, JointRange, Joints,
    KinematicsError, SphericalWristArm, Twist, manipulability, models, smallest_singular_value,
};
use common::{ArmState, angle_difference, chain, isometry, pose_distance, records};
use nalgebra::{SMatrix, SVector};
use serde::Deserialize;

#[derive(Deserialize)]
struct Sample {
    #[serde(flatten)]
    at: ArmState,
    pos: [f64; 3],
    quat_xyzw: [f64; 4],
    jac: Vec<Vec<f64>>,
    twist: [f64; 6],
    jdot_qd: [f64; 6],
    sigma_min: f64,
}

/// Largest difference of all kinematic quantities from the record.
fn kinematics_error<const N: usize>(arm: &dyn ForwardKinematics<N>, sample: &Sample) -> f64 {
    let q = SVector::<f64, N>::from_column_slice(&sample.at.q);
    let qd = SVector::<f64, N>::from_column_slice(&sample.at.qd);
    let (pose, jacobian) = arm.forward_jacobian(&q);
    let mut worst = pose_distance(&pose, &isometry(&sample.pos, &sample.quat_xyzw));
    worst = worst.max(pose_distance(&pose, &arm.forward(&q)));
    for row in 0..6 {
        for column in 0..N {
            worst = worst.max((jacobian[(row, column)] - sample.jac[row][column]).abs());
        }
    }
    worst = worst.max((jacobian * qd - SVector::<f64, 6>::from(sample.twist)).amax());
    worst = worst.max((arm.jacobian_dot_qd(&q, &qd) - SVector::<f64, 6>::from(sample.jdot_qd)).amax());
    worst.max((smallest_singular_value(&jacobian) - sample.sigma_min).abs())
}

#[test]
fn six_arms_agree_with_pinocchio() {
    let mut counts = std::collections::BTreeMap::new();
    for sample in records::<Sample>("kinematics.jsonl") {
        let error = if sample.at.arm == "panda" {
            kinematics_error::<7>(&chain::<7>(&sample.at.arm), &sample)
        } else {
            kinematics_error::<6>(&chain::<6>(&sample.at.arm), &sample)
        };
        assert!(error < 1e-12, "{} {}: {error:e}", sample.at.arm, sample.at.id);
        *counts.entry(sample.at.arm).or_insert(0) += 1;
    }
    assert_eq!(counts.len(), 6, "{counts:?}");
    assert!(counts.values().all(|count| *count == 40), "{counts:?}");
}

#[test]
fn built_in_arms_agree_with_pinocchio() {
    for sample in records::<Sample>("kinematics.jsonl") {
        let arm: &dyn ForwardKinematics<6> = match sample.at.arm.as_str() {
            "cr7" => &models::cr7(),
            "ur5e" => &models::ur5e(),
            "kr6_r700_2" => &models::kr6_r700(),
            "puma560" => &models::puma560(),
            _ => continue,
        };
        let error = kinematics_error::<6>(arm, &sample);
        assert!(error < 1e-12, "{} {}: {error:e}", sample.at.arm, sample.at.id);
    }
}

#[derive(Deserialize)]
struct Inverse {
    arm: String,
    id: usize,
    pos: [f64; 3],
    quat_xyzw: [f64; 4],
    solutions: Vec<[f64; 6]>,
}

/// Every solution of the record is found and nothing else; what an arm's own file knows of its solutions is kept.
fn check_inverse<S: ClosedForm>(arm: &ClosedFormArm<S>, record: &Inverse) {
    let target = isometry(&record.pos, &record.quat_xyzw);
    let place = format!("{} {}", record.arm, record.id);
    if record.solutions.is_empty() {
        let error = arm.inverse_all(&target).unwrap_err();
        assert!(matches!(error, KinematicsError::Unreachable { distance, .. } if distance > 0.0), "{place}: {error}");
        return;
    }
    let found = arm.inverse_all(&target).unwrap_or_else(|error| panic!("{place}: {error}"));
    assert_eq!(found.len(), record.solutions.len(), "{place}");
    assert!(!found.wrist_singular(), "{place}");
    for known in &record.solutions {
        let known = Joints::<6>::from(*known);
        let nearest = found.iter().map(|q| angle_difference(q, &known)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "{place}: {known} is missing, nearest {nearest:e}");
        if arm.range().contains(&known) {
            assert!((arm.inverse(&target, &known).unwrap() - known).amax() < 1e-9, "{place}");
        }
    }
    for q in &found {
        assert!(pose_distance(&arm.forward(q), &target) < 1e-12, "{place}: {q}");
    }
}

#[test]
fn inverse_solutions_are_exactly_those_of_eaik() {
    let (mut poses, mut unreachable) = (0, 0);
    let range = JointRange::new(Joints::repeat(-7.0), Joints::repeat(7.0)).unwrap();
    for record in records::<Inverse>("inverse_kinematics.jsonl") {
        match record.arm.as_str() {
            "cr7" => check_inverse(&models::cr7(), &record),
            "ur5e" => check_inverse(&models::ur5e(), &record),
            "kr6_r700_2" => check_inverse(&models::kr6_r700(), &record),
            "puma560" => check_inverse(&models::puma560(), &record),
            other => check_inverse(&SphericalWristArm::new(chain(other), range).unwrap(), &record),
        }
        poses += 1;
        unreachable += usize::from(record.solutions.is_empty());
    }
    assert_eq!((poses, unreachable), (395, 60));
}

#[test]
fn manipulability_is_the_root_of_the_determinant() {
    // Yoshikawa 1985: sqrt(det(J J^T)), by elimination instead of singular values.
    let six = models::cr7().jacobian(&Joints::from([0.3, -0.4, 1.2, 0.5, 0.8, 0.3]));
    let by_determinant = six.determinant().abs();
    assert!(by_determinant > 1e-3);
    assert!((manipulability(&six) - by_determinant).abs() < 1e-12 * by_determinant);
    let seven = models::panda().jacobian(&Joints::from([0.3, -0.4, 0.2, -1.5, 0.8, 1.3, 0.1]));
    let by_determinant = (seven * seven.transpose()).determinant().sqrt();
    assert!(by_determinant > 1e-3);
    assert!((manipulability(&seven) - by_determinant).abs() < 1e-12 * by_determinant);
    // Fewer than six joints: of the motions that the arm has.
    let two = SMatrix::<f64, 6, 2>::from_columns(&[
        Twist::repeat(2.0),
        Twist::from_fn(|i, _| if i < 3 { 1.0 } else { -1.0 }),
    ]);
    assert!((manipulability(&two) - 12.0).abs() < 1e-12);
}
