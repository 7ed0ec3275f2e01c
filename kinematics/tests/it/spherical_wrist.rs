//! Closed-form inverse of spherical wrists: properties at random and singular poses, whatever the axes' order and sense.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    AnalyticInverse, Chain, ForwardKinematics, InverseKinematics, Joint, JointRange, Joints, KinematicsError,
    SingularityKind, SphericalWristArm, models, smallest_singular_value,
};
use common::closed_forms::{
    WRIST_SINGULAR, joints, manufacturing_errors, nearest, nothing_is_lost_at, poses, solutions_are_polished,
    solutions_at, solutions_reproduce_the_pose, special_joints, tracks_through_the_wrist, with_errors,
};
use common::{angle_difference, chain, pose_distance};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;

fn arms() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec!["kr6_r700_2", "puma560", "kr6_r700_sixx", "drv70l"])
}

/// Wide enough that no limit is in the way.
fn wide() -> JointRange<6> {
    JointRange::new(Joints::repeat(-12.0), Joints::repeat(12.0)).unwrap()
}

fn arm_named(name: &str) -> SphericalWristArm {
    match name {
        "kr6_r700_2" => models::kr6_r700().with_range(wide()),
        "puma560" => models::puma560().with_range(wide()),
        "drv70l" => {
            let at = |x: f64, z: f64| Isometry3::translation(x, 0.0, z);
            let joint = |x: f64, z: f64, axis: Vector3<f64>| Joint::revolute(at(x, z), axis).unwrap();
            let joints = [
                joint(0.0, 0.374, Vector3::z()),
                joint(0.025, 0.0, Vector3::y()),
                joint(0.0, 0.33, Vector3::y()),
                joint(0.0, 0.04, Vector3::x()),
                joint(0.342, 0.0, Vector3::y()),
                joint(0.077, 0.0, Vector3::x()),
            ];
            SphericalWristArm::new(Chain::new(joints).unwrap(), wide()).unwrap()
        }
        name => SphericalWristArm::new(chain(name), wide()).unwrap(),
    }
}

/// Joint 3 at which the arm is stretched: upper arm and forearm in one line.
fn stretched(arm: &SphericalWristArm) -> f64 {
    let mut q = Joints::zeros();
    // The elbow angle grows with joint 3 at rate 1 or -1, so two looks are enough.
    let elbow = |q: &Joints<6>| {
        let at = arm.configuration(q);
        let n = at.axes()[1];
        let wrist = at.points()[4] + at.axes()[4] * at.axes()[4].dot(&(at.points()[3] - at.points()[4]));
        let flat = |v: Vector3<f64>| v - n * n.dot(&v);
        let (a, b) = (flat(at.points()[2] - at.points()[1]), flat(wrist - at.points()[2]));
        a.cross(&b).dot(&n).atan2(a.dot(&b))
    };
    for _ in 0..4 {
        let now = elbow(&q);
        let mut other = q;
        other[2] += 1e-3;
        let rate = ((elbow(&other) - now) / 1e-3).round();
        q[2] -= now * rate;
    }
    assert!(elbow(&q).abs() < 1e-15, "{}", elbow(&q));
    q[2]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn every_solution_reproduces_the_pose_and_one_is_where_it_came_from(
        name in arms(), q in joints(PI), tool in poses(), base in poses(),
    ) {
        let arm = arm_named(name).with_tool(tool).unwrap().with_base(base).unwrap();
        let count = solutions_reproduce_the_pose(&arm, &q)?;
        if smallest_singular_value(&arm.jacobian(&q)) > 1e-4 {
            prop_assert!(count == 8 || count == 4, "{count}");
        }
    }

    #[test]
    fn the_wrist_singularity_loses_nothing(name in arms(), mut q in joints(2.7), straight in any::<bool>(), other in -3.0..3.0) {
        let arm = arm_named(name);
        // Joint 5 at 0 or pi lines up axes 4 and 6 in all four.
        q[4] = if straight { 0.0 } else { PI };
        let (target, all) = solutions_at(&arm, &q)?;
        // Beside a second singularity joints 1 to 3 follow from the target to fewer digits than the wrist's threshold has:
        // the solutions beside the singular one count too, with the same pose.
        let distances = arm.singularity_distances(&q);
        if distances.elbow.min(distances.shoulder) < 1e-4 {
            return Ok(());
        }
        prop_assert!(all.wrist_singular());
        let found = arm.inverse(&target, &q).unwrap();
        prop_assert!((found - q).amax() < 1e-9, "{found}");
        // Any other previous value of the free joint gives an answer with that value.
        let mut seed = q;
        seed[3] = other;
        let found = arm.inverse(&target, &seed).unwrap();
        prop_assert!(pose_distance(&arm.forward(&found), &target) < WRIST_SINGULAR);
        let in_this_branch = (found[2] - q[2]).abs() < 1e-6 && (found[0] - q[0]).abs() < 1e-6;
        prop_assert!(!in_this_branch || (found[3] - other).abs() < 1e-9, "{found}");
    }

    #[test]
    fn the_elbow_singularity_loses_nothing(name in arms(), mut q in joints(2.7), folded in any::<bool>()) {
        let arm = arm_named(name);
        q[2] = stretched(&arm) + if folded { PI } else { 0.0 };
        let target = arm.forward(&q);
        // The folded Puma has its wrist 0.5 mm from axis 2: a thousandfold lever on rounding.
        let (exact, allowed) = if folded && name == "puma560" { (1e-11, 1e-3) } else { (1e-12, 1e-6) };
        for solution in &arm.inverse_all(&target).unwrap() {
            let off = pose_distance(&arm.forward(solution), &target);
            prop_assert!(off < exact, "{off:e} at {solution}");
        }
        let found = arm.inverse(&target, &q).unwrap();
        prop_assert!(pose_distance(&arm.forward(&found), &target) < exact);
        prop_assert!(angle_difference(&found, &q) < allowed, "{found} {q}");
    }

    #[test]
    fn the_shoulder_singularity_loses_nothing(q in joints(2.7), free in -3.0..3.0) {
        // The KR 6 has no shoulder offset: its wrist can stand on axis 1, where joint 1 is free.
        let arm = arm_named("kr6_r700_2");
        let mut on_axis = q;
        let mut wrist = |q2: f64| {
            on_axis[1] = q2;
            let at = arm.configuration(&on_axis);
            let centre = at.points()[4] + at.axes()[4] * at.axes()[4].dot(&(at.points()[3] - at.points()[4]));
            let across = at.axes()[0].cross(&at.axes()[1]);
            across.dot(&(centre - at.points()[0]))
        };
        // Joint 2 turns the wrist through the axis: bisection.
        let (mut low, mut high) = (-3.0, 0.0);
        prop_assume!(wrist(low) * wrist(high) < 0.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if wrist(low) * wrist(middle) <= 0.0 { high = middle } else { low = middle }
        }
        let mut q = q;
        q[1] = low;
        let target = arm.forward(&q);
        prop_assert!(arm.inverse_all(&target).unwrap().shoulder_singular());
        let found = arm.inverse(&target, &q).unwrap();
        prop_assert!(angle_difference(&found, &q) < 1e-9 || q[4].sin().abs() < 1e-4, "{found} {q}");
        let mut seed = q;
        seed[0] = free;
        for solution in [found, arm.inverse(&target, &seed).unwrap()] {
            prop_assert!(pose_distance(&arm.forward(&solution), &target) < 1e-11);
        }
        prop_assert_eq!(arm.nearest_singularity(&q), Some(SingularityKind::Shoulder));
    }

    #[test]
    fn several_singularities_at_once_lose_nothing(name in arms(), q in special_joints()) {
        nothing_is_lost_at(&arm_named(name), &q)?;
    }

    #[test]
    fn any_zero_and_sense_of_rotation_will_do(
        name in arms(), zeros in joints(PI), flips in prop::array::uniform6(any::<bool>()), q in joints(PI),
    ) {
        let arm = arm_named(name);
        let mut joints = *arm.chain().joints();
        for (i, joint) in joints.iter_mut().enumerate() {
            let axis = joint.axis().into_inner();
            let turn = Isometry3::rotation(axis * zeros[i]);
            *joint = Joint::revolute(joint.origin() * turn, if flips[i] { -axis } else { axis }).unwrap();
        }
        let other = SphericalWristArm::new(Chain::new(joints).unwrap(), wide()).unwrap();
        let target = other.forward(&q);
        let all = other.inverse_all(&target).unwrap();
        for solution in &all {
            prop_assert!(pose_distance(&other.forward(solution), &target) < 1e-12);
        }
        if smallest_singular_value(&other.jacobian(&q)) > 1e-4 {
            prop_assert!(nearest(&all, &q) < 1e-9, "{}", nearest(&all, &q));
        }
    }

    #[test]
    fn arms_with_manufacturing_errors_are_polished(q in joints(PI), errors in manufacturing_errors()) {
        let chain = with_errors(models::kr6_r700().chain(), &errors);
        solutions_are_polished(&SphericalWristArm::new(chain, wide()).unwrap(), &q)?;
    }
}

#[test]
fn a_singular_wrist_uses_the_whole_family_to_stay_inside_the_limits() {
    // Joint 6 may stand in half a turn only; with joint 4 kept it would have to leave it.
    let range = JointRange::new(Joints::repeat(-3.0), Joints::from([3.0, 3.0, 3.0, 3.0, 3.0, 0.5])).unwrap();
    let arm = models::kr6_r700().with_range(range);
    let q = Joints::from([0.3, -1.1, 1.2, 0.4, 0.0, 0.2]);
    let target = arm.forward(&q);
    let mut seed = q;
    seed[3] = -1.0;
    let found = arm.inverse(&target, &seed).unwrap();
    assert!(range.contains(&found), "{found}");
    assert!(pose_distance(&arm.forward(&found), &target) < WRIST_SINGULAR);
}

#[test]
fn a_path_through_the_wrist_singularity_stays_continuous() {
    tracks_through_the_wrist(&models::kr6_r700(), -1.3);
}

#[test]
fn other_arms_are_refused_by_the_rule_they_break() {
    let refused = |name: &str| SphericalWristArm::new(chain::<6>(name), wide()).unwrap_err();
    for name in ["cr7", "ur5e"] {
        let error = refused(name);
        assert!(matches!(error, KinematicsError::NoClosedForm { .. }), "{name}: {error}");
    }
    let mut joints = *models::puma560().chain().joints();
    joints[5] = Joint::revolute(joints[5].origin() * Isometry3::translation(0.0, 0.01, 0.0), Vector3::z()).unwrap();
    let error = SphericalWristArm::new(Chain::new(joints).unwrap(), wide()).unwrap_err();
    assert!(error.to_string().contains("axis 6 must pass through"), "{error}");
}

#[test]
fn distances_to_the_singular_poses_are_angles_and_metres() {
    let arm = models::puma560();
    let q = Joints::from([0.3, -0.7, 0.8, 0.4, 0.25, 0.2]);
    let distances = arm.singularity_distances(&q);
    assert!((distances.wrist - 0.25).abs() < 1e-12);
    let at_elbow = Joints::from([0.3, -0.7, stretched(&arm), 0.4, 0.9, 0.2]);
    assert!(arm.singularity_distances(&at_elbow).elbow < 1e-12);
    assert_eq!(arm.singularity_distances(&at_elbow).nearest, SingularityKind::Elbow);
    // The wrist centre is the flange here; its distance from axis 1 less the shoulder offset is what counts.
    let p = arm.forward(&q).translation;
    let expected = (p.x.hypot(p.y).powi(2) - 0.15005_f64.powi(2)).sqrt();
    assert!((distances.shoulder - expected).abs() < 1e-12);
}

#[test]
fn beside_three_singularities_every_solution_still_has_the_pose() {
    // The wrist is straight, the elbow 8e-4 rad from folded and the wrist 3 um from where joint 1 has a double root: the
    // solution that is found beside `q` has joint 5 off by 5e-10, above the threshold of the singular wrist.
    let arm = arm_named("puma560");
    let q = Joints::from([0.0, -2.195130647475426, 1.6185771483566334, 0.0, PI, 0.0]);
    let target = arm.forward(&q);
    let all = arm.inverse_all(&target).unwrap();
    assert_eq!(all.len(), 8);
    for solution in &all {
        assert!(pose_distance(&arm.forward(solution), &target) < 1e-14, "{solution}");
    }
    let found = arm.inverse(&target, &q).unwrap();
    assert!((found - q).rows(0, 3).amax() < 1e-8, "{found}");
    assert!(pose_distance(&arm.forward(&found), &target) < 1e-14, "{found}");
}
