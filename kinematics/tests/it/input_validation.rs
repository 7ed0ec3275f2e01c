//! Whatever comes in, nothing panics, and what is wrong is named.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use arcfeed_kinematics::{
    AnalyticInverse, Arm, Chain, DhRow, ForwardKinematics, InverseKinematics, Joint, JointLimits, JointRange, Joints,
    KinematicsError, MIN_SINGULAR_VALUE, ParallelAxisArm, SphericalWristArm, ToolDerivatives, Twist, joint_derivatives,
    least_norm_derivatives, models, singular_values,
};
use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;

#[test]
fn limits_name_joint_value_and_rule() {
    let one = Joints::<3>::repeat(1.0);
    let with = |joint: usize, value: f64| {
        let mut v = one;
        v[joint] = value;
        v
    };
    let text = |result: Result<JointLimits<3>, KinematicsError>| result.unwrap_err().to_string();
    assert_eq!(
        text(JointLimits::new(-one, one, one, one, with(1, 0.0))),
        "joint 2: jerk limit 0 must be finite and greater than 0"
    );
    assert_eq!(
        text(JointLimits::new(-one, one, with(2, -3.5), one, one)),
        "joint 3: velocity limit -3.5 must be finite and greater than 0"
    );
    assert_eq!(
        text(JointLimits::new(-one, one, one, with(0, f64::NAN), one)),
        "joint 1: acceleration limit NaN must be finite and greater than 0"
    );
    assert_eq!(
        text(JointLimits::new(with(0, 2.0), one, one, one, one)),
        "joint 1: lower limit 2 must be less than the upper limit"
    );
    assert_eq!(
        text(JointLimits::new(-one, with(1, f64::INFINITY), one, one, one)),
        "joint 2: upper limit inf must be finite"
    );
    assert!(JointRange::<3>::new(one, one).is_err());
}

#[test]
fn joints_and_frames_are_checked() {
    let identity = Isometry3::identity();
    assert_eq!(Joint::revolute(identity, Vector3::zeros()), Err(KinematicsError::ZeroAxis { length: 0.0 }));
    assert!(Joint::revolute(identity, Vector3::repeat(f64::NAN)).is_err());
    assert!(Joint::prismatic(Isometry3::translation(f64::INFINITY, 0.0, 0.0), Vector3::x()).is_err());
    let stretched =
        Isometry3::from_parts(Translation3::identity(), Unit::new_unchecked(Quaternion::new(2.0, 0.0, 0.0, 0.0)));
    assert!(
        matches!(Joint::revolute(stretched, Vector3::x()), Err(KinematicsError::NotUnit { norm, .. }) if norm == 2.0)
    );
    let arm = models::cr7();
    assert!(arm.with_tool(Isometry3::translation(f64::NAN, 0.0, 0.0)).is_err());
    assert!(arm.with_base(stretched).is_err());
    assert!(Chain::from_dh(&[DhRow::revolute(f64::NAN, 0.0, 0.0, 0.0)]).is_err());
    assert!(Chain::from_modified_dh(&[DhRow::revolute(0.0, f64::INFINITY, 0.0, 0.0)]).is_err());
    let far = DhRow::revolute(f64::MAX, 0.0, 0.0, 0.0);
    assert!(Chain::from_dh(&[far, far]).is_err());
    assert!(Chain::<0>::new([]).unwrap().forward(&Joints::zeros()) == Isometry3::identity());
}

#[test]
fn both_denavit_hartenberg_conventions_give_the_same_arm() {
    let half = std::f64::consts::FRAC_PI_2;
    let modified = Chain::from_modified_dh(&[
        DhRow::revolute(0.0, 0.0, 0.147, 0.0),
        DhRow::revolute(0.0, half, 0.0, -half),
        DhRow::revolute(-0.377, 0.0, 0.0, 0.0),
        DhRow::revolute(-0.307, 0.0, 0.141, -half),
        DhRow::revolute(0.0, half, 0.116, 0.0),
        DhRow::revolute(0.0, -half, 0.105, 0.0),
    ])
    .unwrap();
    let q = Joints::<6>::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.1]);
    let (a, b) = (modified.forward(&q), models::cr7().forward(&q));
    assert!((a.translation.vector - b.translation.vector).norm() < 1e-15 && a.rotation.angle_to(&b.rotation) < 1e-7);
    // A sliding joint adds to d.
    let slide = Chain::from_dh(&[DhRow::prismatic(0.1, half, 0.2, half)]).unwrap();
    let moved = slide.forward(&Joints::<1>::new(0.05)).translation.vector;
    assert!((moved - Vector3::new(0.0, 0.1, 0.25)).norm() < 1e-15);
}

fn any_pose() -> impl Strategy<Value = Isometry3<f64>> {
    let number = prop_oneof![any::<f64>(), -1.0..1.0, Just(0.0), Just(1e160), Just(f64::NAN)];
    (prop::collection::vec(number, 3), any::<[f64; 4]>(), -4.0..4.0_f64, any::<bool>()).prop_map(
        |(t, q, angle, sane)| {
            let quaternion = Quaternion::new(q[0], q[1], q[2], q[3]);
            let rotation = if sane {
                UnitQuaternion::from_euler_angles(angle, 2.0 * angle, -angle)
            } else {
                Unit::new_unchecked(quaternion)
            };
            Isometry3::from_parts(Translation3::new(t[0], t[1], t[2]), rotation)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_target_and_seed_give_an_answer_or_an_error(target in any_pose(), seed in any::<[f64; 6]>(), usual in any::<bool>()) {
        let seed = if usual { Joints::repeat(0.1) } else { Joints::from(seed) };
        for arm in [models::cr7(), models::ur5e()] {
            if let Ok(solutions) = arm.inverse_all(&target) {
                prop_assert!(!solutions.is_empty());
                prop_assert!(solutions.iter().all(|q| q.iter().all(|v| v.is_finite())));
            }
            if let Ok(q) = arm.inverse(&target, &seed) {
                prop_assert!(arm.range().contains(&q));
            }
        }
    }

    #[test]
    fn any_joints_and_path_give_an_answer_or_an_error(q in any::<[f64; 6]>(), x in any::<[f64; 6]>(), least in any::<f64>()) {
        let arm = models::cr7();
        let q = Joints::from(q);
        let first = Twist::from(x);
        let tool = ToolDerivatives { first, second: first, third: first };
        if let Ok(found) = joint_derivatives(&arm, &q, &tool, least) {
            prop_assert!((found.first + found.second + found.third).iter().all(|v| !v.is_nan()));
        }
        let _ = singular_values(&arm.jacobian(&q));
        let _ = arm.jerk_bias(&q, &q, &q);
    }
}

#[test]
fn wrong_targets_are_named() {
    let arm = models::cr7();
    let seed = Joints::zeros();
    let error = arm.inverse(&Isometry3::translation(f64::NAN, 0.0, 0.0), &seed).unwrap_err();
    assert_eq!(error.to_string(), "target is not finite: every number in it must be an ordinary number");
    // Millimetres taken for metres.
    let error = arm.inverse(&Isometry3::translation(300.0, 100.0, 400.0), &seed).unwrap_err();
    assert!(matches!(error, KinematicsError::Unreachable { distance, .. } if distance > 400.0));
    assert!(error.to_string().contains("too far by"), "{error}");
    let tool = ToolDerivatives { first: Twist::repeat(f64::NAN), second: Twist::zeros(), third: Twist::zeros() };
    let q = Joints::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.1]);
    assert!(matches!(joint_derivatives(&arm, &q, &tool, MIN_SINGULAR_VALUE), Err(KinematicsError::NotFinite { .. })));
}

#[test]
fn joint_values_that_are_none_are_named() {
    let arm = models::cr7();
    let mut q = Joints::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.1]);
    let target = arm.forward(&q);
    q[2] = f64::NAN;
    let seeded = "joint 3: the seed is NaN: it must be an ordinary number";
    assert_eq!(arm.inverse(&target, &q).unwrap_err().to_string(), seeded);
    assert_eq!(arm.candidates(&target, &q).map(|_| ()).unwrap_err().to_string(), seeded);
    assert_eq!(Arm::from(arm).candidates(&target, &q).map(|_| ()).unwrap_err().to_string(), seeded);
    let mut seven = Joints::<7>::zeros();
    seven[6] = f64::INFINITY;
    let error = models::panda().inverse(&target, &seven).unwrap_err().to_string();
    assert_eq!(error, "joint 7: the seed is inf: it must be an ordinary number");
    let tool = ToolDerivatives { first: Twist::x(), second: Twist::zeros(), third: Twist::zeros() };
    let error = joint_derivatives(&arm, &q, &tool, MIN_SINGULAR_VALUE).unwrap_err().to_string();
    assert_eq!(error, "joint 3: its value is NaN: it must be an ordinary number");
    let error = least_norm_derivatives(&models::panda(), &seven, &tool, MIN_SINGULAR_VALUE).unwrap_err().to_string();
    assert_eq!(error, "joint 7: its value is inf: it must be an ordinary number");
    // Without errors to return, NaN goes through and nothing panics.
    assert!(arm.forward(&q).translation.vector.iter().any(|v| v.is_nan()));
    assert!(arm.configuration(&q).jacobian().iter().any(|v| v.is_nan()));
    // An arm from a file knows the names.
    let any = models::description("ur5e").unwrap().build_any().unwrap();
    let elbow = "joint 'elbow_joint': its value is NaN: it must be an ordinary number";
    let (fine, target) = ([0.1; 6], any.forward(&[0.1; 6]).unwrap());
    assert_eq!(any.forward(q.as_slice()).unwrap_err().to_string(), elbow);
    assert_eq!(any.dexterity(q.as_slice()).unwrap_err().to_string(), elbow);
    assert_eq!(any.nearest_singular_pose(q.as_slice()).unwrap_err().to_string(), elbow);
    assert_eq!(any.inverse(&target, q.as_slice()).unwrap_err().to_string(), elbow);
    assert_eq!(any.torque(&fine, &fine, q.as_slice()).unwrap_err().to_string(), elbow);
    // A row of a table.
    let rows = [DhRow::revolute(0.1, 0.0, 0.0, 0.0), DhRow::revolute(0.1, f64::NAN, 0.0, 0.0)];
    for error in [Chain::from_dh(&rows.map(|row| DhRow { d: row.alpha, ..row })), Chain::from_modified_dh(&rows)] {
        let error = error.unwrap_err().to_string();
        assert_eq!(error, "joint '2': joint origin is not finite: every number in it must be an ordinary number");
    }
}

#[test]
fn links_without_length_are_an_arm_without_reach() {
    let joint = |axis: Vector3<f64>| Joint::revolute(Isometry3::identity(), axis).unwrap();
    let axes = [Vector3::z(), Vector3::y(), Vector3::x(), Vector3::z(), Vector3::y(), Vector3::x()];
    let chain = Chain::new(axes.map(joint)).unwrap();
    let range = JointRange::new(Joints::repeat(-3.0), Joints::repeat(3.0)).unwrap();
    // No closed form, and the rule of each that is broken.
    for error in [ParallelAxisArm::new(chain, range).unwrap_err(), SphericalWristArm::new(chain, range).unwrap_err()] {
        assert!(error.to_string().starts_with("no closed-form inverse for this arm: axes"), "{error}");
    }
    let arm = Arm::new(chain, range);
    let q = Joints::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.1]);
    assert_eq!(arm.forward(&q).translation.vector, Vector3::zeros());
    let found = arm.inverse(&arm.forward(&q), &Joints::zeros()).unwrap();
    assert!(arm.forward(&found).rotation.angle_to(&arm.forward(&q).rotation) < 1e-7);
    let error = arm.inverse(&Isometry3::translation(0.1, 0.0, 0.0), &q).unwrap_err();
    assert!(
        matches!(error, KinematicsError::NotConverged { position, .. } if (position - 0.1).abs() < 1e-9),
        "{error}"
    );
    let there = arm.nearest_singular_pose(&q).unwrap();
    assert!(there.distance == 0.0 && arm.reach() == 0.0, "{there:?}");
}

#[test]
fn a_stretched_arm_is_at_its_reach() {
    let at = |x: f64, z: f64| Isometry3::translation(x, 0.0, z);
    let turning = |origin: Isometry3<f64>| Joint::revolute(origin, Vector3::y()).unwrap();
    let sliding = Joint::prismatic(at(0.4, 0.0), Vector3::x()).unwrap();
    // The first joint stands where it likes; its own distance from the base is no link.
    let joints = [turning(at(0.7, 0.5)), turning(at(0.3, 0.0)), sliding];
    let chain = Chain::new(joints).unwrap().with_flange(at(0.1, 0.0)).unwrap();
    let range = JointRange::new(Joints::from([-3.0, -3.0, -0.05]), Joints::from([3.0, 3.0, 0.2])).unwrap();
    let arm = Arm::new(chain, range);
    assert!((arm.reach() - (0.3 + 0.4 + 0.2 + 0.1)).abs() < 1e-15, "{}", arm.reach());
    let flange = arm.forward(&Joints::from([0.0, 0.0, 0.2])).translation.vector;
    assert!(((flange - Vector3::new(0.7, 0.0, 0.5)).norm() - arm.reach()).abs() < 1e-15, "{flange}");
    // The slide counts by its farther end.
    let back = JointRange::new(Joints::from([-3.0, -3.0, -0.25]), Joints::from([3.0, 3.0, 0.2])).unwrap();
    assert!((Arm::new(chain, back).reach() - 1.05).abs() < 1e-15);
}
