//! Poses of another inverse solver's tests: the forward solution is theirs, and their joint values are among all
//! inverse solutions.
//!
//! Origin: rpiRobotics/ik-geo (BSD-3-Clause), `test_cases`. Only numbers are taken.

use std::f64::consts::{PI, TAU};

use arcfeed_kinematics::{AnalyticInverse, Arm, ArmDescription, ForwardKinematics, InverseMethod, Joints};
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::Deserialize;

const CASES: &str = include_str!("../data/ik_geo_cases.json");

#[derive(Deserialize)]
struct File {
    arm: serde_json::Value,
    poses: Vec<Pose>,
}

#[derive(Deserialize)]
struct Pose {
    rotation: [f64; 9],
    position: [f64; 3],
    q: [f64; 6],
}

/// The largest difference of two sets of joint values modulo full turns.
fn apart(a: &Joints<6>, b: &Joints<6>) -> f64 {
    (a - b).iter().map(|d| ((d + PI).rem_euclid(TAU) - PI).abs()).fold(0.0, f64::max)
}

fn off(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation))
}

#[test]
fn joint_values_of_ik_geo_are_among_all_solutions() {
    let File { arm, poses } = serde_json::from_str(CASES).expect("valid cases");
    let arm: Arm<6> = ArmDescription::from_json(&arm.to_string()).and_then(|arm| arm.build()).expect("six joints");
    assert_eq!(arm.method(), InverseMethod::SphericalWrist);
    let mut solutions = 0;
    for (i, pose) in poses.iter().enumerate() {
        let q = Joints::from(pose.q);
        let matrix = Rotation3::from_matrix_unchecked(Matrix3::from_column_slice(&pose.rotation));
        let turn = UnitQuaternion::from_rotation_matrix(&matrix);
        let target = Isometry3::from_parts(Vector3::from(pose.position).into(), turn);
        let error = off(&arm.forward(&q), &target);
        assert!(error < 1e-13, "pose {}: {error:e}", i + 1);
        let all = arm.inverse_all(&target).unwrap_or_else(|error| panic!("pose {}: {error}", i + 1));
        let nearest = all.iter().map(|solution| apart(solution, &q)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "pose {}: the nearest solution is {nearest} rad away", i + 1);
        for solution in all.iter() {
            let error = off(&arm.forward(solution), &target);
            assert!(error < 1e-12, "pose {}: {error:e}", i + 1);
            solutions += 1;
        }
    }
    assert!(poses.len() == 10 && solutions >= 2 * poses.len(), "{solutions} solutions");
}
