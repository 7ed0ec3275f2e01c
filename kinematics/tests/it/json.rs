//! Arms from JSON files.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{ArmDescription, Dynamics, JointKind, Joints, KinematicsError, models};
use common::{chain, pose_distance};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/tests/fixtures/arms/{name}.json", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn every_file_is_read() {
    let q = [0.3, -1.2, 1.1, -0.4, 0.9, -0.3, 0.2];
    for name in ["cr7", "ur5e", "kr6_r700_2", "kr6_r700_sixx", "puma560", "drv70l_inferred"] {
        let arm = ArmDescription::from_json(&text(name)).unwrap().build_any().unwrap();
        assert_eq!(arm.joints(), 6, "{name}");
        if name == "drv70l_inferred" {
            continue;
        }
        let expected =
            arcfeed_kinematics::ForwardKinematics::forward(&chain::<6>(name), &Joints::from_column_slice(&q[..6]));
        assert!(pose_distance(&arm.forward(&q[..6]).unwrap(), &expected) < 1e-14, "{name}");
    }
    let sixx = ArmDescription::from_json(&text("kr6_r700_sixx")).unwrap();
    assert!(sixx.missing().iter().any(|line| line.starts_with("link inertia: joint_1, ")), "{:?}", sixx.missing());
}

#[test]
fn files_and_built_in_arms_are_the_same() {
    for (file, name) in [("cr7", "cr7"), ("ur5e", "ur5e"), ("kr6_r700_2", "kr6_r700"), ("puma560", "puma560")] {
        let read = ArmDescription::from_json(&text(file)).unwrap();
        let built_in = models::description(name).unwrap();
        assert!(read.source.contains("github.com") && read.licence.starts_with(&built_in.licence[..3]), "{name}");
        let (read, built_in) = (read.build::<6>().unwrap(), built_in.build::<6>().unwrap());
        let q = Joints::from([0.3, -1.2, 1.1, -0.4, 0.9, -0.3]);
        let [a, b] = [&read, &built_in].map(|arm| arm.dynamics().unwrap().torque(&q, &q, &q));
        assert!((a - b).amax() < 1e-12, "{name}: {a} {b}");
        let [a, b] = [&read, &built_in].map(|arm| *arm.drive_limits());
        for (a, b) in [(a.velocity, b.velocity), (a.acceleration, b.acceleration), (a.torque, b.torque)] {
            let apart = a.zip(b).map(|(a, b)| (a - b).amax() / b.amax());
            assert!(a.is_some() == b.is_some() && apart.is_none_or(|apart| apart < 1e-15), "{name}");
        }
    }
    let panda = ArmDescription::from_json(&text("panda")).unwrap().build::<7>().unwrap();
    let built_in = models::description("panda").unwrap().build::<7>().unwrap();
    let q = Joints::from([0.3, -1.2, 1.1, -0.4, 0.9, -0.3, 0.2]);
    let [a, b] = [&panda, &built_in].map(|arm| arm.dynamics().unwrap().torque(&q, &q, &q));
    assert!((a - b).amax() < 1e-12, "{a} {b}");
}

#[test]
fn written_arms_are_read_back() {
    let close = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs().max(1.0);
    let same = |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(a == b, |(a, b)| close(a, b));
    let mut arms: Vec<ArmDescription> = models::NAMES.iter().map(|name| models::description(name).unwrap()).collect();
    // A slide, an axis askew, a base, names of their own, and gaps.
    let odd = &mut arms.last_mut().unwrap();
    odd.base = Isometry3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.4, 0.5, 0.6));
    odd.joints[0].kind = JointKind::Prismatic;
    odd.joints[0].axis = Vector3::new(0.6, 0.0, 0.8);
    odd.joints[0].link = "carriage \"1\"".to_owned();
    odd.joints[1].range = None;
    odd.joints[1].friction = Some([0.1, 0.2, 0.3]);
    for arm in &arms {
        let read = ArmDescription::from_json(&arm.to_json()).unwrap();
        assert_eq!(
            (&read.name, &read.source, &read.licence, &read.notes),
            (&arm.name, &arm.source, &arm.licence, &arm.notes)
        );
        assert!(pose_distance(&read.base, &arm.base) < 1e-15 && pose_distance(&read.flange, &arm.flange) < 1e-15);
        assert_eq!(read.joints.len(), arm.joints.len());
        for (a, b) in read.joints.iter().zip(&arm.joints) {
            assert_eq!((&a.name, &a.link, a.kind), (&b.name, &b.link, b.kind));
            assert!(pose_distance(&a.origin, &b.origin) < 1e-15 && (a.axis - b.axis).amax() < 1e-15, "{}", a.name);
            for k in 0..2 {
                assert!(same(a.range.map(|range| range[k]), b.range.map(|range| range[k])), "{}", a.name);
            }
            let rates =
                [(a.velocity, b.velocity), (a.acceleration, b.acceleration), (a.jerk, b.jerk), (a.torque, b.torque)];
            assert!(rates.iter().all(|(a, b)| same(*a, *b)) && same(a.rotor_inertia, b.rotor_inertia), "{}", a.name);
            for k in 0..3 {
                assert!(same(a.friction.map(|f| f[k]), b.friction.map(|f| f[k])), "{}", a.name);
            }
            let Some((a, b)) = a.inertial.zip(b.inertial) else {
                assert_eq!(a.inertial.is_some(), b.inertial.is_some());
                continue;
            };
            assert!(close(a.mass(), b.mass()) && (a.centre() - b.centre()).amax() < 1e-15);
            assert!((a.tensor() - b.tensor()).amax() < 1e-14);
        }
    }
}

#[test]
fn bad_files_say_what_and_where() {
    let fine = text("ur5e");
    let refused = |from: &str, to: &str| {
        assert!(fine.contains(from), "{from}");
        ArmDescription::from_json(&fine.replacen(from, to, 1)).and_then(|arm| arm.build_any()).unwrap_err().to_string()
    };
    let about = |text: String, what: [&str; 2]| assert!(what.iter().all(|what| text.contains(what)), "{text}");
    about(refused("arm-params/1", "arm-params/9"), ["JSON", "'arm-params/9', not 'arm-params/1'"]);
    about(refused("\"joints\"", "\"jionts\""), ["JSON", "missing field `joints`"]);
    about(refused("\"revolute\"", "\"floating\""), ["joint 'shoulder_pan_joint'", "'floating' are not supported"]);
    about(refused("\"axis\":[0,0,1]", "\"axis\":[0,0,0]"), ["joint 'shoulder_pan_joint'", "length 0"]);
    about(refused("\"axis\":[0,0,1]", "\"axis\":[0,0,2]"), ["joint 'shoulder_pan_joint'", "not 1"]);
    about(refused("[1.0,0.0,0.0],[0.0,1.0,0.0]", "[1.0,0.0,0.0],[0.5,1.0,0.0]"), ["shoulder_pan_joint", "'rot'"]);
    about(refused("\"ixx\":0.010267499999999999", "\"ixx\":1.5"), ["shoulder_pan_joint", "principal moment"]);
    about(refused("\"mass\":3.761", "\"mass\":-1"), ["shoulder_pan_joint", "mass"]);
    about(refused("\"mass\":3.761", "\"mass\":\"heavy\""), ["JSON", "line 1 column"]);
    let joint = "\"name\":\"shoulder_pan_joint\"";
    for (name, what) in [
        ("", ["must have a name", "''"]),
        (" lift", ["begin or end with a blank", "' lift'"]),
        ("lift\\t", ["begin or end with a blank", "'lift\\t'"]),
        ("li\\nft", ["control character", "'li\\nft'"]),
        ("elbow_joint", ["name of its own", "'elbow_joint'"]),
    ] {
        about(refused(joint, &format!("\"name\":\"{name}\"")), what);
    }
    assert!(matches!(ArmDescription::from_json(""), Err(KinematicsError::Unreadable { format: "JSON", .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_files_give_an_answer_or_an_error(at in 0.0..1.0_f64, length in 0_usize..40, with in "[0-9eE.,\\[\\]{}:\"a-z-]{0,8}") {
        let fine = text("puma560");
        let start = (at * (fine.len() - 1) as f64) as usize;
        let end = (start + length).min(fine.len());
        prop_assume!(fine.is_char_boundary(start) && fine.is_char_boundary(end));
        let damaged = format!("{}{with}{}", &fine[..start], &fine[end..]);
        if let Ok(arm) = ArmDescription::from_json(&damaged).and_then(|arm| arm.build_any()) {
            let _ = arm.forward(&vec![0.1; arm.joints()]);
        }
    }
}
