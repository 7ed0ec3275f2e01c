//! Arms from URDF: the same numbers as from parameters, and honest refusals.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;
use crate::damaged_urdf;

use arcfeed_kinematics::{
    ArmDescription, Dynamics, ForwardKinematics, Inertial, InverseMethod, Joints, KinematicsError, models, urdf_origin,
};
use common::pose_distance;
use nalgebra::{Isometry3, Matrix3, Vector3};
use proptest::prelude::*;

/// Two turning joints and a slide, with fixed joints before, between, after and beside them.
const GANTRY: &str = r#"<?xml version="1.0"?>
<robot name="gantry">
  <link name="world"/>
  <link name="stand"><inertial><mass value="9"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="arm">
    <inertial><origin xyz="0.1 0 0" rpy="0.3 0 0.2"/><mass value="2"/>
      <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
  </link>
  <link name="bracket"><inertial><origin xyz="0 0.02 0"/><mass value="0.5"/>
      <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.003" iyz="0" izz="0.004"/></inertial></link>
  <link name="camera"><inertial><mass value="0.3"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <link name="slide"><inertial><mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <link name="hand"><inertial><mass value="0.4"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <link name="tool0"/>
  <joint name="stand_joint" type="fixed"><origin xyz="0 0 1" rpy="0 0 0.5"/><parent link="world"/><child link="stand"/></joint>
  <joint name="swing" type="revolute"><origin xyz="0.2 0 0" rpy="0.1 0.2 0.3"/><parent link="stand"/><child link="arm"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="50" velocity="3"/><dynamics damping="0.5" friction="0.2"/></joint>
  <joint name="bracket_joint" type="fixed"><origin xyz="0.3 0 0" rpy="0 0.4 0"/><parent link="arm"/><child link="bracket"/></joint>
  <joint name="camera_joint" type="fixed"><origin xyz="0 0 0.1" rpy="0.2 0 0"/><parent link="bracket"/><child link="camera"/></joint>
  <joint name="reach" type="prismatic"><origin xyz="0 0 0.05"/><parent link="bracket"/><child link="slide"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.4" effort="100" velocity="0.5"/></joint>
  <joint name="spin" type="continuous"><origin xyz="0.1 0 0"/><parent link="slide"/><child link="hand"/>
    <axis xyz="0 0 1"/><limit effort="5" velocity="6"/></joint>
  <joint name="tool_joint" type="fixed"><origin xyz="0 0 0.2"/><parent link="hand"/><child link="tool0"/></joint>
</robot>"#;

fn tip() -> Option<&'static str> {
    Some("tool0")
}

fn read(text: &str) -> Result<ArmDescription, KinematicsError> {
    ArmDescription::from_urdf(text, None, tip())
}

/// What the file says, multiplied out by hand.
fn by_hand(q: &[f64; 3]) -> Isometry3<f64> {
    let at = |x: f64, y: f64, z: f64, r: f64, p: f64, w: f64| {
        let turn = |axis, angle| Isometry3::rotation(axis * angle);
        Isometry3::translation(x, y, z) * turn(Vector3::z(), w) * turn(Vector3::y(), p) * turn(Vector3::x(), r)
    };
    at(0.0, 0.0, 1.0, 0.0, 0.0, 0.5)
        * at(0.2, 0.0, 0.0, 0.1, 0.2, 0.3)
        * Isometry3::rotation(Vector3::y() * q[0])
        * at(0.3, 0.0, 0.0, 0.0, 0.4, 0.0)
        * at(0.0, 0.0, 0.05, 0.0, 0.0, 0.0)
        * Isometry3::translation(q[1], 0.0, 0.0)
        * at(0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
        * Isometry3::rotation(Vector3::z() * q[2])
        * Isometry3::translation(0.0, 0.0, 0.2)
}

#[test]
fn fixed_joints_are_folded() {
    let arm = read(GANTRY).unwrap();
    let names: Vec<&str> = arm.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["swing", "reach", "spin"]);
    assert_eq!(arm.joints[0].range, Some([-1.0, 2.0]));
    assert_eq!((arm.joints[1].torque, arm.joints[1].velocity), (Some(100.0), Some(0.5)));
    assert_eq!((arm.joints[2].range, arm.joints[2].velocity), (None, Some(6.0)));
    assert_eq!(arm.joints[0].friction, Some([0.5, 0.2, 0.2]));
    assert_eq!(arm.missing()[0], "range (taken as +- one turn): spin");
    let built = arm.build_any().unwrap();
    for q in [[0.0; 3], [0.4, 0.2, -1.0], [-0.7, 0.1, 2.0]] {
        assert!(pose_distance(&built.forward(&q).unwrap(), &by_hand(&q)) < 1e-14);
    }
    // The swinging link: arm, bracket and camera; the stand does not swing.
    let body = arm.joints[0].inertial.unwrap();
    assert!((body.mass() - 2.8).abs() < 1e-15);
    let diagonal = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&Vector3::new(a, b, c));
    let own = Matrix3::new(0.02, 0.001, 0.0, 0.001, 0.03, 0.0, 0.0, 0.0, 0.04);
    let turn = nalgebra::UnitQuaternion::from_euler_angles(0.3, 0.0, 0.2);
    let own = Inertial::new(2.0, Vector3::zeros(), own)
        .unwrap()
        .seen_from(&Isometry3::from_parts(Vector3::new(0.1, 0.0, 0.0).into(), turn));
    let bracket_at = Isometry3::new(Vector3::new(0.3, 0.0, 0.0), Vector3::y() * 0.4);
    let camera_at = bracket_at * Isometry3::new(Vector3::new(0.0, 0.0, 0.1), Vector3::x() * 0.2);
    let bracket =
        Inertial::new(0.5, Vector3::new(0.0, 0.02, 0.0), diagonal(0.002, 0.003, 0.004)).unwrap().seen_from(&bracket_at);
    let camera = Inertial::new(0.3, Vector3::zeros(), Matrix3::identity() * 0.001).unwrap().seen_from(&camera_at);
    let all = own.joined(&bracket).joined(&camera);
    assert!((body.centre() - all.centre()).amax() < 1e-15 && (body.tensor() - all.tensor()).amax() < 1e-15);
    // A chain that starts and ends inside.
    let part = ArmDescription::from_urdf(GANTRY, Some("arm"), Some("slide")).unwrap();
    assert_eq!(part.joints.len(), 1);
    let moved = part.build_any().unwrap().forward(&[0.2]).unwrap();
    let expected =
        Isometry3::new(Vector3::new(0.3, 0.0, 0.0), Vector3::y() * 0.4) * Isometry3::translation(0.2, 0.0, 0.05);
    assert!(pose_distance(&moved, &expected) < 1e-15);
}

#[test]
fn the_same_arm_as_urdf_and_as_parameters_gives_the_same_numbers() {
    for name in ["cr7", "ur5e", "kr6_r700"] {
        let parameters = models::description(name).unwrap();
        let read = ArmDescription::from_urdf(&parameters.to_urdf(), Some("base_link"), None).unwrap();
        let (a, b) = (parameters.build::<6>().unwrap(), read.build::<6>().unwrap());
        assert_eq!(a.method(), b.method());
        assert_eq!((a.range(), a.drive_limits().velocity), (b.range(), b.drive_limits().velocity));
        for k in 0..20 {
            let q = Joints::from_fn(|i, _| (1.0 + i as f64) * 0.37 * f64::from(k) - 2.0);
            assert!(pose_distance(&a.forward(&q), &b.forward(&q)) < 1e-13, "{name}");
            let [ours, theirs] = [&a, &b].map(|arm| arm.dynamics().unwrap().torque(&q, &q, &q));
            assert!((ours - theirs).amax() < 1e-10 * ours.amax().max(1.0), "{name}");
        }
    }
    let panda = models::description("panda").unwrap();
    let read = ArmDescription::from_urdf(&panda.to_urdf(), None, None).unwrap().build::<7>().unwrap();
    let q = Joints::from([0.3, -1.2, 1.1, -0.4, 0.9, 0.3, 0.2]);
    assert!(pose_distance(&read.forward(&q), &models::panda().forward(&q)) < 1e-13);
    assert_eq!(read.method(), InverseMethod::Numeric);
}

#[test]
fn the_end_is_found_or_asked_for() {
    // What is fixed to links before the last is no end.
    assert_eq!(ArmDescription::from_urdf(GANTRY, None, None).unwrap(), read(GANTRY).unwrap());
    // Two on the last link, and none has the customary name.
    let two = GANTRY
        .replace("tool0", "grip")
        .replace(r#"<parent link="bracket"/><child link="camera"/>"#, r#"<parent link="hand"/><child link="camera"/>"#);
    let two = ArmDescription::from_urdf(&two, None, None).unwrap_err();
    assert!(two.to_string().contains("one of these") && two.to_string().contains("camera, hand, grip"), "{two}");
    let plain = models::description("ur5e").unwrap().to_urdf();
    let with_sensor = plain.replace(
        "</robot>",
        r#"<link name="ft"/><joint name="ft_joint" type="fixed"><parent link="wrist_3_joint_link"/><child link="ft"/></joint></robot>"#,
    );
    assert_eq!(ArmDescription::from_urdf(&with_sensor, None, None).unwrap().joints.len(), 6);
}

/// A chain of `joints` turning joints to the link `hand`, and `fingers` of `length` sliding joints each on it, the second on
/// the link `other` if `apart`.
fn with_fingers(joints: usize, fingers: usize, length: usize, apart: bool) -> String {
    let mut text = String::from("<robot name=\"x\"><link name=\"l0\"/>");
    let mut link = |name: &str, parent: &str, kind: &str| {
        text +=
            &format!("<link name=\"{name}\"/><joint name=\"to {name}\" type=\"{kind}\"><origin xyz=\"0.1 0 0.1\"/>");
        text += &format!("<parent link=\"{parent}\"/><child link=\"{name}\"/><axis xyz=\"0 1 0\"/>");
        text += "<limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>";
    };
    for k in 1..=joints {
        link(&format!("l{k}"), &format!("l{}", k - 1), "revolute");
    }
    link("hand", &format!("l{joints}"), "fixed");
    link("other", "hand", "fixed");
    for f in 0..fingers {
        let mut parent = if apart && f == 1 { "other".to_owned() } else { "hand".to_owned() };
        for k in 0..length {
            let name = format!("f{f}{k}");
            link(&name, &parent, "prismatic");
            parent = name;
        }
    }
    text + "</robot>"
}

#[test]
fn an_arm_with_fingers_ends_at_the_hand() {
    for (joints, fingers, length) in [(7, 2, 1), (4, 3, 3), (6, 5, 2)] {
        let text = with_fingers(joints, fingers, length, false);
        let arm = ArmDescription::from_urdf(&text, None, None).unwrap();
        let named = ArmDescription::from_urdf(&text, None, Some("hand")).unwrap();
        assert_eq!((&arm.joints, arm.flange), (&named.joints, named.flange));
        assert_eq!(arm.joints.len(), joints);
        assert!(arm.notes[0].contains("to f00, to f10") && named.notes.is_empty(), "{:?}", arm.notes);
    }
    let tool = with_fingers(6, 2, 1, true).replace("other", "tool0");
    let arm = ArmDescription::from_urdf(&tool, None, None).unwrap();
    assert!(arm.source.contains("to link 'tool0'"), "{}", arm.source);
    // A camera that turns on the last link but one of an arm is no finger, and what carries the mounting face is none.
    let turning = with_fingers(6, 2, 1, false).replace("prismatic", "continuous");
    let mounted = with_fingers(6, 2, 1, false).replace("f00", "tool0");
    let called = turning.replace("to f", "finger ");
    assert!(ArmDescription::from_urdf(&called, None, None).unwrap().source.contains("to link 'hand'"));
    for text in [turning, mounted] {
        let error = ArmDescription::from_urdf(&text, None, None).unwrap_err().to_string();
        assert!(error.contains("the tip link must be named"), "{error}");
    }
    // Legs rather than fingers, a trunk rather than an arm, two hands.
    for text in [with_fingers(7, 2, 4, false), with_fingers(3, 2, 1, false), with_fingers(7, 2, 1, true)] {
        let error = ArmDescription::from_urdf(&text, None, None).unwrap_err().to_string();
        assert!(error.contains("the tip link must be named") && error.contains("hand"), "{error}");
    }
}

/// An arm with a rod beside joint 2 and one behind joint 3, as those of palletisers and of large arms, which follow these; `mount` is its
/// last link.
fn with_rods(mount: &str) -> String {
    let mut text = String::from("<robot name=\"x\"><link name=\"l0\"/>");
    let mut link = |name: &str, parent: &str, follows: &str| {
        text +=
            &format!("<link name=\"{name}\"/><joint name=\"to {name}\" type=\"revolute\"><origin xyz=\"0.1 0 0.1\"/>");
        text += &format!("<parent link=\"{parent}\"/><child link=\"{name}\"/><axis xyz=\"0 1 0\"/>");
        text += &format!("{follows}<limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>");
    };
    for k in 1..=6 {
        link(&format!("l{k}"), &format!("l{}", k - 1), "");
    }
    link("rod", "l1", "<mimic joint=\"to l2\" multiplier=\"-1\"/>");
    link("end of rod", "rod", "<mimic joint=\"to l2\"/>");
    link("cylinder", "l3", "<mimic joint=\"to l3\"/>");
    text += &format!(
        "<link name=\"{mount}\"/><joint name=\"to face\" type=\"fixed\"><parent link=\"l6\"/><child link=\"{mount}\"/></joint>"
    );
    text + "</robot>"
}

/// The IRB 6640 and the M-900iA of ROS-Industrial were refused until the tip was named.
#[test]
fn rods_beside_an_arm_are_left_out() {
    for mount in ["tool0", "flange"] {
        let text = with_rods(mount);
        let arm = ArmDescription::from_urdf(&text, None, None).unwrap();
        let named = ArmDescription::from_urdf(&text, None, Some(mount)).unwrap();
        assert_eq!((&arm.joints, arm.flange, arm.joints.len()), (&named.joints, named.flange, 6));
        assert!(
            arm.notes[0].contains("to rod, to cylinder follow others") && named.notes.is_empty(),
            "{:?}",
            arm.notes
        );
    }
    // Without a mounting face, or with a second joint of its own, it is not clear which is the arm.
    let driven = with_rods("tool0").replacen("<mimic joint=\"to l2\" multiplier=\"-1\"/>", "", 1);
    for text in [with_rods("l7"), driven] {
        let error = ArmDescription::from_urdf(&text, None, None).unwrap_err().to_string();
        assert!(error.contains("the tip link must be named"), "{error}");
    }
}

#[test]
fn hostile_files_are_refused_by_name() {
    let refused = |from: &str, to: &str| {
        assert!(GANTRY.contains(from), "{from}");
        let read = read(&GANTRY.replacen(from, to, 1)).and_then(|arm| arm.build_any());
        read.unwrap_err().to_string()
    };
    let about = |text: String, what: [&str; 2]| assert!(what.iter().all(|what| text.contains(what)), "{text}");
    for text in ["", "this is no XML", "<robot", "<robot name=\"x\">", "\u{0}\u{1}", "<a><b></a></b>"] {
        let error = read(text).unwrap_err();
        assert!(matches!(error, KinematicsError::Unreadable { format: "URDF", .. }), "{text}: {error}");
    }
    let error = read("<robot name=\"x\"/>").unwrap_err();
    assert!(matches!(error, KinematicsError::Structure { .. } | KinematicsError::Unreadable { .. }), "{error}");
    // A loop: the stand hangs on the hand.
    about(refused(r#"<parent link="world"/>"#, r#"<parent link="hand"/>"#), ["joint '", "must not form a loop"]);
    about(refused(r#"<parent link="stand"/>"#, r#"<parent link="nowhere"/>"#), ["joint 'swing'", "'nowhere'"]);
    about(refused(r#"<child link="hand"/>"#, r#"<child link="slide"/>"#), ["link 'slide'", "one parent joint"]);
    about(refused(r#"<joint name="swing""#, r#"<joint name="spin""#), ["name of its own", "'spin'"]);
    about(refused(r#"<link name="tool0"/>"#, r#"<link name="world"/>"#), ["name of its own", "'world'"]);
    about(refused(r#"<axis xyz="0 1 0"/>"#, r#"<axis xyz="0 0 0"/>"#), ["joint 'swing'", "length 0"]);
    about(refused(r#"<axis xyz="0 1 0"/>"#, r#"<axis xyz="0 1 1"/>"#), ["joint 'swing'", "not 1"]);
    about(refused(r#"<axis xyz="0 1 0"/>"#, r#"<axis xyz="0 NaN 1"/>"#), ["joint 'swing'", "NaN"]);
    about(refused(r#"xyz="0.2 0 0" rpy="0.1 0.2 0.3""#, r#"xyz="0.2 NaN 0""#), ["joint 'swing'", "not finite"]);
    about(refused(r#"lower="-1" upper="2""#, r#"lower="3" upper="2""#), ["joint 'swing'", "less than the upper"]);
    about(refused(r#"lower="-1" upper="2""#, r#"lower="NaN" upper="2""#), ["joint 'swing'", "a number"]);
    about(refused(r#"lower="0" upper="0.4""#, r#"lower="0" upper="0""#), ["joint 'reach'", "sliding joint must have"]);
    about(refused(r#""swing" type="revolute""#, r#""swing" type="floating""#), ["joint 'swing'", "'floating' are not"]);
    about(refused(r#""swing" type="revolute""#, r#""swing" type="planar""#), ["joint 'swing'", "'planar' are not"]);
    about(
        refused(r#"<dynamics damping="0.5" friction="0.2"/>"#, r#"<mimic joint="spin"/>"#),
        ["joint 'swing'", "'spin'"],
    );
    about(refused(r#"ixx="0.02""#, r#"ixx="NaN""#), ["link 'arm'", "inertia tensor"]);
    about(refused(r#"<mass value="2"/>"#, r#"<mass value="inf"/>"#), ["link 'arm'", "mass"]);
    about(refused(r#"damping="0.5""#, r#"damping="-0.5""#), ["joint 'swing'", "viscous friction"]);
    let missing = |base, tip| ArmDescription::from_urdf(GANTRY, base, tip).unwrap_err().to_string();
    about(missing(Some("foot"), None), ["link 'foot'", "world, stand"]);
    about(missing(None, Some("finger")), ["link 'finger'", "tool0"]);
    about(missing(Some("hand"), Some("arm")), ["must be below the base link", "hand, arm"]);
    about(missing(Some("hand"), Some("tool0")), ["moving joint", "hand, tool0"]);
    about(missing(Some("arm"), Some("arm")), ["below the base link", "arm, arm"]);
}

#[test]
fn deep_files_are_refused_or_read() {
    let deep =
        format!("<robot name=\"x\">{}{}</robot>", "<link name=\"a\">".repeat(100_000), "</link>".repeat(100_000));
    let error = read(&deep).unwrap_err();
    assert!(error.to_string().contains("nested more than 100 deep"), "{error}");
    // Many links in a row are no reason to refuse.
    let mut long = String::from("<robot name=\"x\"><link name=\"l0\"/>");
    for k in 0..300 {
        let kind = if k == 7 { "continuous" } else { "fixed" };
        long += &format!("<link name=\"l{}\"/><joint name=\"j{k}\" type=\"{kind}\"><origin xyz=\"0.01 0 0\"/>", k + 1);
        long += &format!("<parent link=\"l{k}\"/><child link=\"l{}\"/></joint>", k + 1);
    }
    let arm = ArmDescription::from_urdf(&(long + "</robot>"), None, None).unwrap().build_any().unwrap();
    assert!((arm.forward(&[0.0]).unwrap().translation.x - 3.0).abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_files_give_an_answer_or_an_error(at in 0.0..1.0_f64, length in 0_usize..60, with in "[0-9eE.<>/=\"a-z -]{0,10}") {
        let start = (at * (GANTRY.len() - 1) as f64) as usize;
        let end = (start + length).min(GANTRY.len());
        let damaged = format!("{}{with}{}", &GANTRY[..start], &GANTRY[end..]);
        if let Ok(arm) = read(&damaged).and_then(|arm| arm.build_any()) {
            let _ = arm.forward(&vec![0.1; arm.joints()]);
        }
    }
}

const HAND: &str = include_str!("../fixtures/hand.urdf");

/// An arm of one joint in whose file `more` stands beside the links.
fn one_joint(parent: &str, more: &str) -> String {
    format!(
        r#"<robot name="x">{more}<link name="b"/><joint name="j" type="revolute"><parent link="{parent}"/><child link="b"/>
        <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#
    )
}

fn refusal(text: &str) -> String {
    ArmDescription::from_urdf(text, None, None).and_then(|arm| arm.build_any()).unwrap_err().to_string()
}

/// The stack overflowed: a count of levels took the `/>` in an attribute for the end of an element.
#[test]
fn deep_elements_behind_a_bracket_in_an_attribute_are_refused() {
    for element in ["<a b=\"/>\">", "<a b='/>'>", "<a b=\"-->\" c=\"/>\">", "<a\nb=\">/>\"\n>"] {
        let text = format!("<robot name=\"x\">{}{}</robot>", element.repeat(200_000), "</a>".repeat(200_000));
        assert!(refusal(&text).contains("nested more than 100 deep"), "{element}");
        let text = format!("<robot name=\"x\"><link name=\"a\">{}", element.repeat(200_000));
        assert!(refusal(&text).contains("nested more than 100 deep"), "{element}");
    }
}

/// What belongs to looks and simulators has no influence on the arm.
#[test]
fn two_materials_a_mesh_without_file_and_foreign_names_do_not_matter() {
    let link = |inside: &str| one_joint("a", &format!("<link name=\"a\">{inside}</link>"));
    let plain = ArmDescription::from_urdf(&link(""), None, None).unwrap();
    for text in [
        link("<visual><geometry><box size=\"1 1 1\"/></geometry><material name=\"m\"/><material name=\"n\"/></visual>"),
        link("<visual><geometry><mesh/></geometry></visual><collision/><collision/>"),
        link("<visual><origin xyz=\"a b\"/></visual>"),
        link("<sensor:camera k:l=\"1\"/><inertia/><![CDATA[<]]>&unknown;"),
        one_joint(
            "a",
            "<link name=\"a\"/><material name=\"m\"/><material name=\"m\"/><transmission><joint name=\"j\"/></transmission>",
        ),
        link("").replacen("name=\"x\"", "name=\"x\" xmlns=\"u\" xmlns:xacro=\"v\" xmlns:s=\"w\"", 1),
        one_joint("world", ""),
        format!(
            "\u{feff}<?xml version=\"1.0\"?><!DOCTYPE robot [<!ENTITY e SYSTEM \"file:///etc/passwd\">]>{}",
            link("")
        ),
    ] {
        let read = ArmDescription::from_urdf(&text, None, None).unwrap();
        assert_eq!(read.joints, plain.joints, "{text}");
    }
}

/// Only the fingers were offered, one of which mimics the other.
#[test]
fn an_arm_with_a_hand_offers_the_hand_as_its_tip() {
    let error = ArmDescription::from_urdf(HAND, None, None).unwrap_err().to_string();
    assert!(error.contains("'panda_link2, panda_link8, panda_hand, panda_leftfinger'"), "{error}");
    for (tip, joints) in [("panda_hand", 2), ("panda_link8", 2), ("panda_link2", 2), ("panda_leftfinger", 3)] {
        let arm = ArmDescription::from_urdf(HAND, None, Some(tip)).unwrap();
        assert_eq!(arm.joints.len(), joints, "{tip}");
        assert!(arm.build_any().is_ok());
    }
    assert_eq!(
        ArmDescription::from_urdf(HAND, None, Some("panda_hand")).unwrap().joints[1].inertial.unwrap().mass(),
        0.7
    );
    let error = ArmDescription::from_urdf(HAND, None, Some("panda_rightfinger")).unwrap_err().to_string();
    assert!(error.contains("panda_finger_joint1"), "{error}");
}

#[test]
fn what_is_wrong_is_told_with_line_and_name() {
    let text = one_joint("a", "<link name=\"a\"/>\n");
    let about = |from: &str, to: &str, what: [&str; 2]| {
        assert!(text.contains(from), "{from}");
        let error = refusal(&text.replacen(from, to, 1));
        assert!(what.iter().all(|what| error.contains(what)), "{error}");
    };
    about("xyz=\"0 0 1\"", "xyz=\"0 0\"", ["line 3", "joint 'j': <axis>: xyz is \"0 0\", it must be 3 numbers"]);
    about("lower=\"-1\"", "lower=\"${-pi}\"", ["joint 'j': <limit>: lower is \"${-pi}\"", "xacro"]);
    about("lower=\"-1\"", "lower=\"-1\" lower=\"-2\"", ["joint 'j'", "two attributes lower"]);
    about("<parent link=\"a\"/>", "", ["joint 'j'", "no <parent"]);
    about("<parent link=\"a\"/>", "<parent link=\"a\"/><parent link=\"a\"/>", ["joint 'j'", "two <parent>"]);
    about("type=\"revolute\"", "type=\"ball\"", ["joint 'j'", "'ball'"]);
    about("type=\"revolute\"", "", ["joint 'j'", "<joint> has no type"]);
    about("<link name=\"a\"/>", "<link/>", ["line 1", "<link> has no name"]);
    about("<link name=\"a\"/>", "<link name=\"&e;\"/>", ["line 1", "<link>: name"]);
    about("<link name=\"a\"/>", "<link name=\"&#27;[2J\"/>", ["line 1", "control character"]);
    about("name=\"a\"/>", "name=\"a\"><inertial><mass value=\"1\"/></inertial></link>", ["link 'a'", "no <inertia>"]);
    about("</robot>", "</robot><robot/>", ["line 3", "second element"]);
    about("</robot>", "</robot>more", ["line 3", "text outside"]);
    about("</robot>", "", ["line 3", "ends inside"]);
    about("<robot name=\"x\">", "<model>", ["line 1", "must be <robot>"]);
    let long = "n".repeat(5000);
    about("<link name=\"a\"/>", &format!("<link name=\"{long}\"/>"), ["line 1", "longer than 1000 bytes"]);
    let many = (0..5000).map(|k| format!("<link name=\"link{k}\"/>")).collect::<String>();
    about("<link name=\"a\"/>", &format!("<link name=\"a\"/>{many}"), ["one link without parent", "and 4981 more"]);
}

/// Each link was walked up to the root, and every joint searched for each: a file as long as this
/// took hours.
#[test]
fn a_file_of_a_hundred_thousand_links_is_read() {
    let mut text = String::from("<robot name=\"x\"><link name=\"l0\"/>");
    for k in 0..100_000 {
        let kind = if k == 7 { "continuous" } else { "fixed" };
        text += &format!("<link name=\"l{}\"/><joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{k}\"/>", k + 1);
        text += &format!("<child link=\"l{}\"/></joint>", k + 1);
    }
    assert_eq!(ArmDescription::from_urdf(&(text + "</robot>"), None, None).unwrap().joints.len(), 1);
}

/// Later versions of the format say more of limits and know quaternions; earlier ones ignore both.
/// An origin of an element that is skipped is read as that of a joint.
#[test]
fn an_origin_on_its_own_is_read_as_that_of_a_joint() {
    let read = |version: &str, attributes: &[(&'static str, &'static str)]| {
        let of = |name: &str| attributes.iter().find(|(own, _)| *own == name).map(|(_, text)| *text);
        let own = urdf_origin(Some(version), of);
        let text = attributes.iter().map(|(name, text)| format!(" {name}=\"{text}\"")).collect::<String>();
        let text = one_joint("world", "").replace("<axis", &format!("<origin{text}/><axis"));
        let text = text.replacen("name=\"x\"", &format!("name=\"x\" version=\"{version}\""), 1);
        let joint = ArmDescription::from_urdf(&text, None, None).map(|arm| arm.joints[0].origin);
        assert_eq!(own.as_ref().ok(), joint.as_ref().ok(), "{version} {attributes:?}: {own:?} {joint:?}");
        own.map_err(|error| error.to_string())
    };
    let turned = ("quat_xyzw", "0 0 3 4");
    assert_eq!(read("1.0", &[]).unwrap(), Isometry3::identity());
    assert_eq!(read("1.0", &[("xyz", "1 2 3"), turned]).unwrap(), Isometry3::translation(1.0, 2.0, 3.0));
    let angle = read("1.1", &[turned]).unwrap().rotation.angle();
    assert!((angle - 2.0 * (0.6f64).asin()).abs() < 1e-12, "{angle}");
    assert!((read("1.0", &[("rpy", "0 0 1")]).unwrap().rotation.angle() - 1.0).abs() < 1e-12);
    for (version, attributes, words) in [
        ("1.1", &[("rpy", "0 0 1"), turned][..], "both rpy and quat_xyzw"),
        ("1.1", &[("quat_xyzw", "0 0 0 0")], "length 0"),
        ("1.0", &[("xyz", "1 2")], "xyz is \"1 2\", it must be 3 numbers"),
        ("1.0", &[("xyz", "0 0 nan")], "origin"),
        ("1.0", &[("xyz", "0 0 \u{7}")], "control character"),
    ] {
        let said = read(version, attributes).expect_err("no origin");
        assert!(said.contains(words), "{said}");
    }
    let long = "1 ".repeat(600);
    let said = urdf_origin(None, |_| Some(long.as_str())).expect_err("too long").to_string();
    assert!(said.contains("xyz is longer than 1000 bytes"), "{said}");
}

#[test]
fn the_version_of_a_file_decides_what_counts() {
    let text = one_joint("world", "")
        .replace("<axis", "<origin xyz=\"1 2 3\" quat_xyzw=\"0 0 3 4\"/><axis")
        .replace("velocity=\"1\"", "velocity=\"1\" acceleration=\"5\" jerk=\"70\"");
    let read = |version: &str| {
        let text = text.replacen("name=\"x\"", &format!("name=\"x\" version=\"{version}\""), 1);
        let joint = ArmDescription::from_urdf(&text, None, None).unwrap().joints.remove(0);
        (joint.origin.rotation.angle() > 0.1, joint.acceleration, joint.jerk)
    };
    assert_eq!(read("1.0"), (false, None, None));
    assert_eq!(read("1.1"), (true, None, None));
    assert_eq!(read("1.2"), (true, Some(5.0), Some(70.0)));
    assert_eq!(read("new"), (false, None, None));
}

#[test]
fn ten_thousand_damaged_files_give_an_answer_or_an_error() {
    let built_in = ["ur5e", "panda"].map(|name| models::description(name).unwrap().to_urdf());
    let sound: Vec<String> = built_in.into_iter().chain([GANTRY, HAND].map(str::to_owned)).collect();
    let arms = (0..10_000).filter(|seed| damaged_urdf::read(&damaged_urdf::damaged(&sound, *seed))).count();
    assert!((100..9_900).contains(&arms), "{arms}");
}

/// Hands and legs of `example-robot-data` (allegro, hyq, icub_reduced) were refused for one such link, and nobody could use their kinematics.
#[test]
fn an_inertia_that_no_body_can_have_is_unknown_and_noted() {
    let sound = ArmDescription::from_urdf(GANTRY, None, Some("tool0")).unwrap();
    assert!(sound.notes.is_empty() && sound.joints[0].inertial.is_some());
    for (from, to, rule) in [
        (r#"ixx="0.02""#, r#"ixx="0.2""#, "at most the sum of the other two"),
        (r#"ixx="0.02""#, r#"ixx="-0.02""#, "not negative"),
        (r#"<mass value="2"/>"#, r#"<mass value="-2"/>"#, "mass"),
        // A link that hangs on the arm by a fixed joint.
        (r#"ixx="0.002""#, r#"ixx="0.02""#, "link 'bracket'"),
    ] {
        let text = GANTRY.replacen(from, to, 1);
        assert_ne!(text, GANTRY, "{from}");
        let arm = ArmDescription::from_urdf(&text, None, Some("tool0")).unwrap();
        let [note] = arm.notes.as_slice() else { panic!("{from}: {:?}", arm.notes) };
        for part in [rule, "link '", "behind joint 'swing' is taken as unknown"] {
            assert!(note.contains(part), "{part} is missing in: {note}");
        }
        assert!(arm.joints[0].inertial.is_none() && arm.joints[1..] == sound.joints[1..], "{from}");
        assert!(arm.missing().iter().any(|line| line.starts_with("link inertia") && line.contains("swing")));
        // Kinematics as before, and no dynamics.
        let (built, whole) = (arm.build_any().unwrap(), sound.build_any().unwrap());
        let q = vec![0.1; built.joints()];
        assert_eq!(built.forward(&q).unwrap(), whole.forward(&q).unwrap());
        assert!(whole.torque(&q, &q, &q).is_ok());
        let refused = built.torque(&q, &q, &q).unwrap_err().to_string();
        assert!(refused.contains("inertia of every link"), "{refused}");
    }
}
