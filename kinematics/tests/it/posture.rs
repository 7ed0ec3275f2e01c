//! Postures: one name for each solution, whatever base and tool, and no change but at singular poses.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    AnalyticInverse, ClosedForm, ClosedFormArm, ForwardKinematics, JointRange, Joints, Posture, models,
    smallest_singular_value,
};
use common::closed_forms::{joints, poses};
use nalgebra::Isometry3;
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;

fn each_solution_has_its_name(
    arm: ClosedFormArm<impl ClosedForm>,
    q: &Joints<6>,
    [tool, base]: [Isometry3<f64>; 2],
    step: &Joints<6>,
) -> Result<(), TestCaseError> {
    let wide = JointRange::new(Joints::repeat(-12.0), Joints::repeat(12.0)).unwrap();
    let arm = arm.with_range(wide);
    // Away from singular poses, where two of the solutions are one.
    let apart = |q: &Joints<6>| {
        let d = arm.singularity_distances(q);
        d.wrist.min(d.elbow).min(d.shoulder)
    };
    if apart(q) < 0.05 || smallest_singular_value(&arm.jacobian(q)) < 1e-3 {
        return Ok(());
    }
    let all = arm.inverse_all(&arm.forward(q)).unwrap();
    let mut names: Vec<String> = all.iter().map(|q| arm.posture(q).unwrap().to_string()).collect();
    names.sort();
    let count = names.len();
    names.dedup();
    prop_assert_eq!(names.len(), count, "two solutions of one name at {}", q);
    // Base, tool and full turns change nothing.
    let posture = arm.posture(q);
    let elsewhere = arm.with_tool(tool).unwrap().with_base(base).unwrap();
    prop_assert_eq!(elsewhere.posture(q), posture);
    prop_assert_eq!(arm.posture(&q.map(|v| v + std::f64::consts::TAU)), posture);
    // On a straight way of joints that stays away from singular poses it stays.
    let way = |k: i32| q + step * (f64::from(k) / 200.0);
    if (0..=200).all(|k| apart(&way(k)) > 0.02) {
        prop_assert_eq!(arm.posture(&(q + step)), posture, "{} to {}", q, q + step);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn each_solution_has_a_name_of_its_own(
        arm in 0..4_usize, q in joints(3.1), tool in poses(), base in poses(), step in joints(0.4),
    ) {
        let frames = [tool, base];
        match arm {
            0 => each_solution_has_its_name(models::cr7(), &q, frames, &step)?,
            1 => each_solution_has_its_name(models::ur5e(), &q, frames, &step)?,
            2 => each_solution_has_its_name(models::kr6_r700(), &q, frames, &step)?,
            _ => each_solution_has_its_name(models::puma560(), &q, frames, &step)?,
        }
    }
}

#[test]
fn names_are_those_of_the_picture() {
    // The UR5e with joint 2 at -90 degrees stands upright; 30 degrees more lean it to the front.
    let arm = models::ur5e();
    let lean = 0.5;
    let posture = |q: [f64; 6]| arm.posture(&Joints::from(q)).unwrap();
    let front = posture([0.0, -FRAC_PI_2 + lean, 0.3, 0.0, 1.0, 0.0]);
    assert!(front.front);
    assert!(!posture([0.0, -FRAC_PI_2 - lean, -0.3, 0.0, 1.0, 0.0]).front);
    // A forearm that bends on, forwards and down, leaves the elbow above; bent back it is below.
    assert!(front.up);
    assert!(!posture([0.0, 0.3, -0.9, 0.0, 1.0, 0.0]).up);
    // The same on the other side.
    assert!(posture([0.0, -FRAC_PI_2 - lean, -0.3, 0.0, 1.0, 0.0]).up);
    assert_ne!(posture([0.0, -1.0, 0.3, 0.0, -1.0, 0.0]).flip, posture([0.0, -1.0, 0.3, 0.0, 1.0, 0.0]).flip);
}

#[test]
fn texts_name_postures_and_say_which_there_are() {
    for index in 0..8 {
        let posture = Posture { front: index & 1 == 0, up: index & 2 == 0, flip: index & 4 == 0 };
        assert_eq!(posture.to_string().parse(), Ok(posture));
    }
    for text in ["", "front", "front up", "up front flip", "front up flip flip", "front sideways flip"] {
        let error = text.parse::<Posture>().unwrap_err().to_string();
        assert!(error.contains("front or back") && error.contains("no-flip"), "{error}");
    }
}
