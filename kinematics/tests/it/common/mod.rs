//! What several tests need: fixtures and distances.
#![allow(dead_code, reason = "each test file uses its own part")]
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

pub mod closed_forms;

use arcfeed_kinematics::{Chain, Inertial, Joint, Joints};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::f64::consts::TAU;

fn fixture(name: &str) -> String {
    let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// One record per line.
pub fn records<T: DeserializeOwned>(name: &str) -> Vec<T> {
    fixture(name).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[derive(Deserialize)]
struct ArmRecord {
    joints: Vec<JointRecord>,
    flange: [f64; 12],
}

#[derive(Deserialize)]
struct JointRecord {
    axis: [f64; 3],
    origin: [f64; 12],
}

/// An arm of `arms.json` from its joint origins and axes.
pub fn chain<const N: usize>(name: &str) -> Chain<N> {
    let mut arms: HashMap<String, ArmRecord> = serde_json::from_str(&fixture("arms.json")).unwrap();
    let arm = arms.remove(name).unwrap();
    let joints: Vec<Joint> = arm
        .joints
        .iter()
        .map(|joint| Joint::revolute(frame(&joint.origin), Vector3::from(joint.axis)).unwrap())
        .collect();
    Chain::new(joints.try_into().unwrap()).unwrap().with_flange(frame(&arm.flange)).unwrap()
}

/// A state of motion of an arm, by its number in the record.
#[derive(Deserialize)]
pub struct ArmState {
    pub arm: String,
    pub id: usize,
    pub q: Vec<f64>,
    pub qd: Vec<f64>,
}

/// The links of an arm of `arms/`, as published: not all of them can exist.
pub fn inertials<const N: usize>(name: &str) -> [Inertial; N] {
    let arm: serde_json::Value = serde_json::from_str(&fixture(&format!("arms/{name}.json"))).unwrap();
    std::array::from_fn(|i| {
        let body = &arm["joints"][i]["inertial"];
        let number = |key: &str| body["inertia"][key].as_f64().unwrap();
        let (xy, xz, yz) = (number("ixy"), number("ixz"), number("iyz"));
        let tensor = Matrix3::new(number("ixx"), xy, xz, xy, number("iyy"), yz, xz, yz, number("izz"));
        let centre = Vector3::from_fn(|k, _| body["com"][k].as_f64().unwrap());
        Inertial::identified(body["mass"].as_f64().unwrap(), centre, tensor).unwrap()
    })
}

fn frame(numbers: &[f64; 12]) -> Isometry3<f64> {
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&numbers[3..]));
    let translation = Translation3::new(numbers[0], numbers[1], numbers[2]);
    Isometry3::from_parts(translation, UnitQuaternion::from_rotation_matrix(&rotation))
}

/// A pose from position (m) and quaternion x y z w.
pub fn isometry(position: &[f64; 3], xyzw: &[f64; 4]) -> Isometry3<f64> {
    let quaternion = Quaternion::new(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
    Isometry3::from_parts(Translation3::from(*position), UnitQuaternion::from_quaternion(quaternion))
}

/// The larger of the distance of the points (m) and of the entries of the rotation matrices.
pub fn pose_distance(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    let turned = a.rotation.to_rotation_matrix().matrix() - b.rotation.to_rotation_matrix().matrix();
    (a.translation.vector - b.translation.vector).norm().max(turned.amax())
}

/// Largest difference of the joint angles modulo 2 pi.
pub fn angle_difference(a: &Joints<6>, b: &Joints<6>) -> f64 {
    (a - b).map(|d| d - TAU * (d / TAU).round()).amax()
}
