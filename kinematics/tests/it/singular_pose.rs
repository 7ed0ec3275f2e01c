//! The search for singular poses, against the closed forms' own distances and against difference quotients.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use arcfeed_kinematics::{
    Arm, Chain, ClosedForm, ClosedFormArm, DhRow, ForwardKinematics, Joint, JointRange, Joints, KinematicsError,
    SingularityKind, ToolDerivatives, Twist, WeakestMotion, condition_number, least_norm_derivatives, models,
    smallest_singular_value, weakest_motion,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn joints<const N: usize>(range: f64) -> impl Strategy<Value = Joints<N>> {
    prop::collection::vec(-range..range, N).prop_map(|v| Joints::from_column_slice(&v))
}

/// The arm with room around every singular pose.
fn wide<S: ClosedForm>(arm: &ClosedFormArm<S>) -> ClosedFormArm<S> {
    arm.with_range(JointRange::new(Joints::repeat(-7.0), Joints::repeat(7.0)).unwrap())
}

fn singular<const N: usize>(arm: &impl ForwardKinematics<N>, q: &Joints<N>) -> bool {
    condition_number(&arm.jacobian(q)) > 1e8
}

/// What the closed form knows: wrist and elbow line up by the motion of one joint, so their angles are the distances.
fn agrees_with_closed_form<S: ClosedForm>(arm: &ClosedFormArm<S>, q: &Joints<6>) -> Result<(), TestCaseError> {
    let arm = wide(arm);
    let known = arm.singularity_distances(q);
    let found = Arm::from(arm).nearest_singular_pose(q).unwrap();
    let by_one_joint = known.wrist.min(known.elbow);
    prop_assert!(singular(&arm, &found.q), "{found:?}");
    prop_assert!((found.distance - (found.q - q).norm()).abs() < 1e-12);
    let there = arm.singularity_distances(&found.q);
    // An elbow beside a shoulder singularity may be taken for one with it.
    let two_close = known.elbow.min(there.elbow) < 0.15 && found.distance < by_one_joint + 0.15;
    prop_assert!(found.distance < by_one_joint + 1e-6 || two_close, "{found:?} {known:?}");
    let (kind, zero) = [
        (SingularityKind::Wrist, there.wrist),
        (SingularityKind::Elbow, there.elbow),
        (SingularityKind::Shoulder, there.shoulder),
    ]
    .into_iter()
    .min_by(|a, b| a.1.total_cmp(&b.1))
    .unwrap();
    prop_assert!(zero < 1e-7, "{found:?} {there:?}");
    prop_assert_eq!(found.kind, Some(kind));
    if kind == SingularityKind::Shoulder {
        // The way there is along the slope of the closed form's distance, or there would be a shorter one. The differences stay on
        // one side of the singularity.
        let h = 1e-4 * (q - found.q).norm();
        let slope = Joints::<6>::from_fn(|i, _| {
            let at = |step: f64| {
                let mut moved = found.q + (q - found.q) * 1e-3;
                moved[i] += step;
                arm.singularity_distances(&moved).shoulder
            };
            (at(h) - at(-h)) / (2.0 * h)
        });
        let way = q - found.q;
        prop_assert!(way.dot(&slope).abs() > 0.99 * way.norm() * slope.norm() || way.norm() < 1e-4, "{way} {slope}");
    } else {
        prop_assert!((found.distance - by_one_joint).abs() < 1e-6, "{found:?} {known:?}");
    }
    Ok(())
}

/// Five joints that turn and slide.
fn mixed() -> Chain<5> {
    let at = |x: f64, y: f64, z: f64, turn: Vector3<f64>| Isometry3::new(Vector3::new(x, y, z), turn);
    Chain::new([
        Joint::revolute(at(0.1, 0.0, 0.3, Vector3::zeros()), Vector3::z()).unwrap(),
        Joint::prismatic(at(0.0, 0.2, 0.0, Vector3::x() * 0.7), Vector3::new(1.0, 0.2, 0.1)).unwrap(),
        Joint::revolute(at(0.3, 0.0, 0.1, Vector3::y() * 1.1), Vector3::y()).unwrap(),
        Joint::prismatic(at(0.0, 0.1, 0.2, Vector3::z() * 0.4), Vector3::z()).unwrap(),
        Joint::revolute(at(0.2, 0.1, 0.0, Vector3::x() * -0.6), Vector3::x()).unwrap(),
    ])
    .unwrap()
    .with_tool(at(0.05, 0.02, 0.1, Vector3::zeros()))
    .unwrap()
}

fn check_weakest<const N: usize>(arm: &impl ForwardKinematics<N>, q: &Joints<N>) -> Result<(), TestCaseError> {
    let jacobian = arm.jacobian(q);
    let WeakestMotion { sigma, joints, tool } = weakest_motion(&jacobian);
    prop_assert!((sigma - smallest_singular_value(&jacobian)).abs() < 1e-15);
    prop_assert!((joints.norm() - 1.0).abs() < 1e-12 && (tool.norm() - 1.0).abs() < 1e-12);
    prop_assert!((jacobian * joints - tool * sigma).norm() < 1e-14);
    prop_assert!((jacobian.transpose() * tool - joints * sigma).norm() < 1e-14 || N < 6);
    Ok(())
}

/// An arm like the KUKA LBR: shoulder, elbow and wrist in points, seven joints.
fn anthropomorphic() -> Arm<7> {
    let rows = [
        DhRow::revolute(0.0, 0.0, 0.34, 0.0),
        DhRow::revolute(0.0, -FRAC_PI_2, 0.0, 0.0),
        DhRow::revolute(0.0, FRAC_PI_2, 0.4, 0.0),
        DhRow::revolute(0.0, FRAC_PI_2, 0.0, 0.0),
        DhRow::revolute(0.0, -FRAC_PI_2, 0.4, 0.0),
        DhRow::revolute(0.0, -FRAC_PI_2, 0.0, 0.0),
        DhRow::revolute(0.0, FRAC_PI_2, 0.126, 0.0),
    ];
    Arm::new(
        Chain::from_modified_dh(&rows).unwrap(),
        JointRange::new(Joints::repeat(-3.0), Joints::repeat(3.0)).unwrap(),
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn closed_forms_agree_on_distance_and_kind(q in joints::<6>(PI)) {
        agrees_with_closed_form(&models::cr7(), &q)?;
        agrees_with_closed_form(&models::ur5e(), &q)?;
        agrees_with_closed_form(&models::kr6_r700(), &q)?;
        agrees_with_closed_form(&models::puma560(), &q)?;
    }

    #[test]
    fn a_panda_has_singular_poses_inside_its_range(parts in prop::collection::vec(0.0..1.0, 7)) {
        let arm = Arm::from(models::panda());
        let (lower, upper) = (arm.range().lower(), arm.range().upper());
        let q = Joints::<7>::from_fn(|i, _| lower[i] + parts[i] * (upper[i] - lower[i]));
        let found = arm.nearest_singular_pose(&q).unwrap();
        prop_assert!(arm.range().contains(&found.q) && singular(&arm, &found.q), "{found:?}");
        prop_assert!((arm.jacobian(&found.q).transpose() * found.lost).amax() < 1e-8, "{found:?}");
        // Between here and there it only gets worse to the first order.
        let part = |t: f64| smallest_singular_value(&arm.jacobian(&(q + (found.q - q) * t)));
        prop_assert!(part(1.0) < 1e-8 && part(0.999) > 1e-8, "{found:?}");
    }

    #[test]
    fn a_stretched_elbow_of_seven_joints_is_known(q in joints::<7>(2.5)) {
        let arm = anthropomorphic();
        let found = arm.nearest_singular_pose(&q).unwrap();
        prop_assert!(singular(&arm, &found.q));
        // A search is no proof: it may end at another singular pose, a little farther than the stretched elbow.
        let allowed = 1.1 * q[3].abs() + 1e-6;
        prop_assert!(found.distance < allowed, "{found:?}");
        // Where the shoulder or the wrist is singular as well, the pose may be named after it.
        if found.q[3].abs() < 1e-6 && found.q[5].abs() > 1e-3 && found.q[1].abs() > 1e-3 {
            prop_assert_eq!(found.kind, Some(SingularityKind::Elbow));
            prop_assert!(found.distance > q[3].abs() - 1e-6, "{found:?}");
        }
    }

    #[test]
    fn the_weakest_motion_is_that_of_the_smallest_singular_value(six in joints::<6>(3.0), seven in joints::<7>(3.0), five in joints::<5>(2.0)) {
        check_weakest(&models::cr7(), &six)?;
        check_weakest(&models::panda(), &seven)?;
        check_weakest(&mixed(), &five)?;
        let mut wrist = six;
        wrist[4] = 0.0;
        check_weakest(&models::kr6_r700(), &wrist)?;
        check_weakest(&models::puma560(), &Joints::zeros())?;
    }

    #[test]
    fn arms_of_few_and_sliding_joints_are_searched(q in joints::<5>(0.9)) {
        let range = JointRange::new(Joints::repeat(-1.0), Joints::repeat(1.0)).unwrap();
        let arm = Arm::new(mixed(), range);
        if let Some(found) = arm.nearest_singular_pose(&q) {
            prop_assert!(range.contains(&found.q) && singular(&arm, &found.q), "{found:?}");
            prop_assert_eq!(found.kind, None);
        }
    }
}

/// So near to the shoulder's singularity that differences reached across it.
#[test]
fn a_pose_close_to_singular_agrees_with_the_closed_form() {
    let q = Joints::from([0.0, 0.1841147398868281, 1.2441806896008318, 0.0, 0.011068898963529649, 0.0]);
    for arm in [models::kr6_r700(), models::puma560()] {
        agrees_with_closed_form(&arm, &q).unwrap();
    }
}

/// The search went to where the wrist is singular besides, 0.7245 away, past the stretched elbow at 0.7206.
#[test]
fn one_singularity_is_nearer_than_two_at_once() {
    let q = Joints::from([
        0.0,
        -1.839038765834421,
        0.0,
        0.7205936830997396,
        -0.25651747238452643,
        0.07505166257662294,
        0.0,
    ]);
    let found = anthropomorphic().nearest_singular_pose(&q).unwrap();
    assert!((found.distance - q[3]).abs() < 1e-6, "{found:?}");
}

#[test]
fn three_parallel_axes_are_singular_when_in_line() {
    // With two turning joints the tool always keeps two motions; with three, one is lost where the axes are in a plane.
    let joint = |x| Joint::revolute(Isometry3::translation(x, 0.0, 0.0), Vector3::z()).unwrap();
    let chain = Chain::new([joint(0.0), joint(0.4), joint(0.3)]).unwrap();
    let q = Joints::<3>::new(0.4, 0.7, -1.0);
    let search = |lower: f64, upper: f64| {
        let range = JointRange::new(Joints::<3>::new(-1.0, lower, -2.0), Joints::<3>::new(1.0, upper, 2.0)).unwrap();
        Arm::new(chain, range).nearest_singular_pose(&q)
    };
    let stretched = search(-PI, PI).unwrap();
    assert!((stretched.q - Joints::<3>::new(0.4, 0.0, -1.0)).amax() < 1e-7, "{stretched:?}");
    assert!((stretched.distance - 0.7).abs() < 1e-7 && stretched.kind.is_none());
    // The stretched pose outside the range, only the folded one is left; then none.
    let folded = search(0.5, 3.2).unwrap();
    assert!((folded.q - Joints::<3>::new(0.4, PI, -1.0)).amax() < 1e-7, "{folded:?}");
    assert_eq!(search(0.5, 3.0), None);
    let two = Arm::new(models::planar_2r(), JointRange::new(Joints::repeat(-PI), Joints::repeat(PI)).unwrap());
    assert_eq!(two.nearest_singular_pose(&Joints::<2>::new(0.4, 0.7)), None);
}

#[test]
fn an_arm_of_any_number_of_joints_tells_the_same() {
    let described = models::description("panda").unwrap();
    let (any, arm) = (described.build_any().unwrap(), described.build::<7>().unwrap());
    let q = Joints::<7>::from([0.1, -0.05, 0.2, -2.0, 0.1, 1.6, 0.7]);
    let (a, b) = (any.nearest_singular_pose(q.as_slice()).unwrap().unwrap(), arm.nearest_singular_pose(&q).unwrap());
    assert_eq!((a.q.as_slice(), a.distance, a.kind), (b.q.as_slice(), b.distance, b.kind));
    // Axes 1 and 3 line up where joint 2 is 0, and the forearm stands across.
    assert_eq!(b.kind, Some(SingularityKind::Shoulder));
    assert!(b.q[1].abs() < 1e-6 && any.nearest_singular_pose(&[0.0; 6]).is_err());
    let dexterity = any.dexterity(q.as_slice()).unwrap();
    let slow = arm.jacobian(&q).transpose() * Twist::from(dexterity.weakest);
    assert!((slow.norm() - dexterity.sigma_min).abs() < 1e-14);
    // An arm that is stopped by a singular pose says which.
    let tool = ToolDerivatives { first: Twist::x(), second: Twist::zeros(), third: Twist::zeros() };
    let error = least_norm_derivatives(&arm, &b.q, &tool, 1e-6).unwrap_err();
    assert!(matches!(error, KinematicsError::Singular { kind: Some(SingularityKind::Shoulder), .. }), "{error}");
}

#[test]
fn joints_that_are_none_have_no_singular_pose_near() {
    let arm = Arm::from(models::panda());
    assert_eq!(arm.nearest_singular_pose(&Joints::repeat(f64::NAN)), None);
    assert!(arm.nearest_singular_pose(&Joints::repeat(1e300)).is_some_and(|found| arm.range().contains(&found.q)));
    let weakest = weakest_motion(&arm.jacobian(&Joints::repeat(f64::NAN)));
    assert!(weakest.sigma.is_nan() || weakest.sigma == 0.0);
}

#[test]
fn a_search_that_goes_to_and_fro_still_ends_at_the_nearest_pose() {
    // Whole steps end 13 degrees beside the shortest way to the shoulder singularity, 1.17 rad away.
    let q = Joints::from([0.0, -1.0138197271408822, -1.8558650417727838, -1.9371951499069515, 1.5625207084097277, 0.0]);
    agrees_with_closed_form(&models::cr7(), &q).unwrap();
    agrees_with_closed_form(&models::ur5e(), &q).unwrap();
}

/// Shoulder and wrist with three axes through one point each, whose joints stand beside those points.
#[test]
fn the_stretched_elbow_of_seven_joints_is_told_wherever_the_joints_stand_on_their_axes() {
    for beside in [0.0, 0.1, -0.3] {
        // Along an axis that is not at right angles to its neighbours.
        let (turn, bend, tilted) = (Vector3::z(), Vector3::y(), Vector3::new(0.0, 0.8, 0.6));
        let joint = |along: f64, z: f64, axis| {
            Joint::revolute(Isometry3::from_parts((tilted * along + turn * z).into(), UnitQuaternion::identity()), axis)
                .unwrap()
        };
        let chain = Chain::new([
            joint(0.0, 0.1, turn),
            joint(beside, 0.3, tilted),
            joint(-beside, 0.2, turn),
            joint(0.0, 0.2, bend),
            joint(0.0, 0.2, turn),
            joint(-0.7 * beside, 0.2, tilted),
            joint(0.7 * beside, 0.1, turn),
        ]);
        let arm = Arm::new(chain.unwrap(), JointRange::new(Joints::repeat(-PI), Joints::repeat(PI)).unwrap());
        let q = Joints::<7>::from([0.3, 0.6, -0.4, 0.05, 0.7, 0.8, 0.2]);
        let found = arm.nearest_singular_pose(&q).unwrap();
        assert!(found.q[3].abs() < 1e-7 && found.distance < 0.1, "{found:?}");
        assert_eq!(found.kind, Some(SingularityKind::Elbow), "{beside}");
    }
}
