//! The built-in arms, their descriptions, and the Denavit-Hartenberg form.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    Arm, ArmDescription, Chain, Dynamics, ForwardKinematics, InverseMethod, Joint, Joints, KinematicsError, models,
};
use common::{chain, inertials, isometry, pose_distance, records};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Sample {
    arm: String,
    q: Vec<f64>,
    qd: Vec<f64>,
    #[serde(default)]
    qdd: Vec<f64>,
    #[serde(default)]
    tau: Vec<f64>,
    #[serde(default)]
    pos: [f64; 3],
    #[serde(default)]
    quat_xyzw: [f64; 4],
}

fn described(record: &str) -> Option<ArmDescription> {
    models::description(if record == "kr6_r700_2" { "kr6_r700" } else { record })
}

#[test]
fn built_in_arms_move_and_weigh_as_pinocchio_says() {
    let mut seen = 0;
    for sample in records::<Sample>("kinematics.jsonl") {
        let Some(described) = described(&sample.arm) else { continue };
        let arm = described.build_any().unwrap();
        let distance = pose_distance(&arm.forward(&sample.q).unwrap(), &isometry(&sample.pos, &sample.quat_xyzw));
        assert!(distance < 1e-12, "{}: {distance:e}", sample.arm);
        seen += 1;
    }
    for sample in records::<Sample>("dynamics.jsonl") {
        let described = described(&sample.arm).unwrap();
        // Rotors and friction are known of the Puma; the record is without.
        let torque = if let Ok(arm) = described.build::<6>() {
            bare_torque(&arm, &sample)
        } else {
            bare_torque(&described.build::<7>().unwrap(), &sample)
        };
        let size = sample.tau.iter().fold(1e-3_f64, |most, t| most.max(t.abs()));
        for (ours, theirs) in torque.iter().zip(&sample.tau) {
            assert!((ours - theirs).abs() < 1e-10 * size, "{}: {ours} {theirs}", sample.arm);
        }
        seen += 1;
    }
    assert_eq!(seen, 5 * 40 + 5 * 16);
}

#[test]
fn an_arm_of_any_number_of_joints_has_the_range_of_its_joints() {
    for name in models::NAMES {
        let described = models::description(name).unwrap();
        let arm = described.build_any().unwrap();
        let (lower, upper) = arm.range();
        let ranges: Vec<_> = lower.iter().zip(upper).map(|(lower, upper)| Some([*lower, *upper])).collect();
        assert_eq!(ranges, described.joints.iter().map(|joint| joint.range).collect::<Vec<_>>(), "{name}");
    }
}

fn bare_torque<const N: usize>(arm: &Arm<N>, sample: &Sample) -> Vec<f64> {
    let vector = |values: &[f64]| Joints::<N>::from_column_slice(values);
    let (q, qd, qdd) = (vector(&sample.q), vector(&sample.qd), vector(&sample.qdd));
    let dynamics = arm.dynamics().unwrap();
    let extra = dynamics.friction_torque(&qd) + dynamics.rotor_inertia().component_mul(&qdd);
    (dynamics.torque(&q, &qd, &qdd) - extra).as_slice().to_vec()
}

#[test]
fn descriptions_and_short_forms_are_the_same_arms() {
    let q = Joints::from([0.3, -1.2, 1.1, 0.4, 0.9, -0.3]);
    let six = |name: &str| models::description(name).unwrap().build::<6>().unwrap();
    let same = |name: &str, arm: &dyn ForwardKinematics<6>, range: arcfeed_kinematics::JointRange<6>| {
        assert!(pose_distance(&six(name).forward(&q), &arm.forward(&q)) < 1e-14, "{name}");
        assert!((six(name).range().lower() - range.lower()).amax() < 1e-12, "{name}");
        assert!((six(name).range().upper() - range.upper()).amax() < 1e-12, "{name}");
    };
    same("cr7", &models::cr7(), *models::cr7().range());
    same("ur5e", &models::ur5e(), *models::ur5e().range());
    same("kr6_r700", &models::kr6_r700(), *models::kr6_r700().range());
    same("puma560", &models::puma560(), *models::puma560().range());
    let panda = models::description("panda").unwrap().build::<7>().unwrap();
    assert_eq!(panda.range(), models::panda().range());
    for name in models::NAMES {
        let described = models::description(name).unwrap();
        assert!(!described.notes.is_empty() && !described.source.is_empty() && !described.licence.is_empty(), "{name}");
        let arm = described.build_any().unwrap();
        let method = match name {
            "cr7" | "ur5e" => InverseMethod::ParallelAxis,
            "kr6_r700" | "puma560" => InverseMethod::SphericalWrist,
            _ => InverseMethod::Numeric,
        };
        assert_eq!((arm.name(), arm.method()), (name, method));
    }
    assert!(models::description("robot").is_none());
    let puma = six("puma560");
    let friction = puma.dynamics().unwrap().friction();
    assert!(
        (friction.backward()[0] - 24.7313845).abs() < 1e-12 && (friction.viscous()[1] - 9.496868641825).abs() < 1e-9
    );
    assert!((puma.dynamics().unwrap().rotor_inertia()[5] - 0.194064505668).abs() < 1e-12);
    assert_eq!(puma.drive_limits().torque, None);
    assert_eq!(six("kr6_r700").drive_limits().torque.unwrap()[0], 186.0);
    // Identified bodies are what they are; the others can exist.
    for name in ["cr7", "ur5e", "kr6_r700_2"] {
        let described = described(name).unwrap();
        for (joint, body) in described.joints.iter().zip(inertials::<6>(name)) {
            let ours = joint.inertial.unwrap();
            let apart = (ours.tensor() - body.tensor()).amax() + (ours.centre() - body.centre()).amax();
            assert!(apart < 1e-15 && (ours.mass() - body.mass()).abs() < 1e-14, "{name} {}", joint.name);
        }
    }
}

#[test]
fn descriptions_are_checked_by_name() {
    let fine = models::description("ur5e").unwrap();
    assert!(fine.build::<6>().is_ok());
    let message = |spoil: fn(&mut ArmDescription)| {
        let mut bad = fine.clone();
        spoil(&mut bad);
        let error = bad.build_any().unwrap_err();
        assert_eq!(bad.build::<6>().map(|_| ()).unwrap_err().to_string(), error.to_string());
        error.to_string()
    };
    let elbow = "joint 'elbow_joint': ";
    let about = |text: String, what: &str| assert!(text.starts_with(elbow) && text.contains(what), "{text}");
    about(message(|arm| arm.joints[2].axis = Vector3::zeros()), "length 0");
    about(message(|arm| arm.joints[2].axis = Vector3::new(0.0, 0.0, f64::NAN)), "length NaN");
    about(message(|arm| arm.joints[2].axis = Vector3::new(0.0, 1.0, 1.0)), "not 1");
    about(message(|arm| arm.joints[2].origin.translation.x = f64::NAN), "not finite");
    about(message(|arm| arm.joints[2].range = Some([1.0, -1.0])), "less than the upper");
    about(message(|arm| arm.joints[2].range = Some([f64::NAN, 1.0])), "lower");
    about(message(|arm| arm.joints[2].velocity = Some(-1.0)), "velocity");
    about(message(|arm| arm.joints[2].friction = Some([-1.0, 0.0, 0.0])), "viscous");
    about(message(|arm| arm.joints[2].rotor_inertia = Some(f64::INFINITY)), "rotor");
    about(
        message(|arm| {
            arm.joints[2].kind = arcfeed_kinematics::JointKind::Prismatic;
            arm.joints[2].range = None;
        }),
        "no range",
    );
    let mut none = fine.clone();
    none.joints.clear();
    assert!(matches!(none.build_any().unwrap_err(), KinematicsError::JointCount { given: 0, .. }));
    let mut many = fine.clone();
    (0..3).for_each(|_| many.joints.extend(fine.joints.clone()));
    assert!(matches!(many.build_any().unwrap_err(), KinematicsError::JointCount { given: 24, .. }));
    assert!(fine.build::<7>().is_err());
    let mut gaps = fine;
    gaps.joints[1].inertial = None;
    gaps.joints[4].range = None;
    assert_eq!(gaps.missing()[0], "range (taken as +- one turn): wrist_2_joint");
    assert!(gaps.missing().last().unwrap().ends_with("link inertia: shoulder_lift_joint"));
    assert!(gaps.build::<6>().unwrap().dynamics().is_none());
    assert_eq!(gaps.build::<6>().unwrap().range().upper()[4], std::f64::consts::TAU);
    // Links of no length are an arm all the same, if a useless one.
    let mut point = gaps;
    point.joints.iter_mut().for_each(|joint| joint.origin.translation.vector.fill(0.0));
    let arm = point.build::<6>().unwrap();
    assert_eq!(arm.method(), InverseMethod::Numeric);
    assert!(arm.forward(&Joints::repeat(0.3)).translation.vector.norm() < 1e-15);
}

/// The standard and the modified table, each as a chain again.
fn from_tables<const N: usize>(chain: &Chain<N>) -> [Chain<N>; 2] {
    let (standard, modified) = (chain.to_dh().unwrap(), chain.to_modified_dh().unwrap());
    [
        (Chain::from_dh(&standard.rows).unwrap(), standard.base, standard.flange),
        (Chain::from_modified_dh(&modified.rows).unwrap(), modified.base, modified.flange),
    ]
    .map(|(again, base, flange)| again.with_base(base).unwrap().with_flange(again.flange() * flange).unwrap())
}

#[test]
fn denavit_hartenberg_tables_give_the_arms_back() {
    let q = Joints::from([0.3, -1.2, 1.1, 0.4, 0.9, -0.3]);
    for name in ["cr7", "ur5e", "kr6_r700_2", "kr6_r700_sixx", "puma560"] {
        let chain = chain::<6>(name);
        for again in from_tables(&chain) {
            let distance = pose_distance(&again.forward(&q), &chain.forward(&q));
            assert!(distance < 1e-13, "{name}: {distance:e}");
        }
    }
    let panda = chain::<7>("panda");
    let q = Joints::from([0.3, -1.2, 1.1, -0.4, 0.9, -0.3, 0.2]);
    for again in from_tables(&panda) {
        assert!(pose_distance(&again.forward(&q), &panda.forward(&q)) < 1e-13);
    }
    // The maker's table is a modified one; ours is the same up to signs that mean the same.
    let table = models::panda().chain().to_modified_dh().unwrap();
    let lengths = |f: fn(&arcfeed_kinematics::DhRow) -> f64| table.rows.map(|row| (f(&row).abs() * 1e9).round() / 1e9);
    assert_eq!(lengths(|row| row.d), [0.333, 0.0, 0.316, 0.0, 0.384, 0.0, 0.107]);
    assert_eq!(lengths(|row| row.a), [0.0, 0.0, 0.0, 0.0825, 0.0825, 0.0, 0.088]);
    assert_eq!(lengths(|row| row.alpha / std::f64::consts::FRAC_PI_2), [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
    // The makers' tables come out as they went in, up to signs that mean the same.
    let table = models::cr7().chain().to_dh().unwrap();
    let lengths = |f: fn(&arcfeed_kinematics::DhRow) -> f64| table.rows.map(|row| (f(&row) * 1e9).round() / 1e9);
    assert_eq!(lengths(|row| row.d.abs()), [0.147, 0.0, 0.0, 0.141, 0.116, 0.105]);
    assert_eq!(lengths(|row| row.a.abs()), [0.0, 0.377, 0.307, 0.0, 0.0, 0.0]);
    assert!(pose_distance(&table.base, &Isometry3::identity()) < 1e-15);
    assert!(pose_distance(&table.flange, &Isometry3::identity()) < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn the_pose_is_the_product_of_the_frames(
        numbers in prop::collection::vec(-1.0..1.0, 54), quarters in prop::array::uniform5(0_u8..4),
        kinds in prop::array::uniform5(any::<bool>()), plain_base in any::<bool>(), q in prop::array::uniform5(-3.0..3.0),
    ) {
        // Axes at odd angles and at multiples of a right angle, which are worked out in other ways.
        let n = |k: usize| Vector3::new(numbers[k], numbers[k + 1], numbers[k + 2]);
        let joints: [Joint; 5] = std::array::from_fn(|i| {
            let turn = if numbers[6 * i] > 0.0 { n(6 * i) } else { Vector3::x() * (f64::from(quarters[i]) * std::f64::consts::FRAC_PI_2) };
            let origin = Isometry3::new(n(6 * i + 3), turn);
            if kinds[i] { Joint::revolute(origin, Vector3::z()) } else { Joint::prismatic(origin, n(3 * i + 36) + Vector3::z() * 1e-3) }.unwrap()
        });
        let base = if plain_base { Isometry3::identity() } else { Isometry3::new(n(30), n(33)) };
        let (flange, tool) = (Isometry3::new(n(36), n(39)), Isometry3::new(n(42), n(45)));
        let chain = Chain::new(joints).unwrap().with_base(base).unwrap().with_flange(flange).unwrap().with_tool(tool).unwrap();
        let moved = joints.iter().zip(q).fold(base, |at, (joint, q)| at * joint.origin() * joint.motion(q));
        let (expected, q) = (moved * flange * tool, Joints::from(q));
        // Nine products of frames up to 3 m long round by 1e-15 each.
        prop_assert!(pose_distance(&chain.forward(&q), &expected) < 2e-14);
        prop_assert!(pose_distance(&chain.configuration(&q).pose(), &expected) < 2e-14);
        prop_assert!((chain.forward(&q).rotation.norm() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn any_chain_has_a_table(numbers in prop::collection::vec(-1.0..1.0, 36), kinds in prop::array::uniform4(any::<bool>()), q in prop::array::uniform4(-3.0..3.0)) {
        let n = |k: usize| Vector3::new(numbers[k], numbers[k + 1], numbers[k + 2]);
        let joints = std::array::from_fn(|i| {
            let origin = Isometry3::new(n(9 * i), n(9 * i + 3));
            let axis = n(9 * i + 6) + Vector3::z() * 1e-3;
            if kinds[i] { Joint::revolute(origin, axis) } else { Joint::prismatic(origin, axis) }.unwrap()
        });
        let chain = Chain::<4>::new(joints).unwrap().with_base(Isometry3::new(n(5), n(7))).unwrap().with_flange(Isometry3::new(n(1), n(2))).unwrap();
        let q = Joints::<4>::from(q);
        match chain.to_dh() {
            Ok(_) => {
                for again in from_tables(&chain) {
                    prop_assert!(pose_distance(&again.forward(&q), &chain.forward(&q)) < 1e-8);
                }
            }
            Err(error) => {
                let refused = matches!(error, KinematicsError::NoDhForm { .. });
                prop_assert!(refused, "{error}");
            }
        }
    }
}
