//! Damped least squares, and arms whose inverse is chosen by their geometry.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    AnalyticInverse, Arm, ArmDynamics, BranchTracker, Candidate, Chain, DriveLimits, Dynamics, ForwardKinematics,
    Friction, InverseKinematics, InverseMethod, Joint, JointRange, Joints, KinematicsError, NullSpace, NumericArm,
    NumericSettings, ToolDerivatives, Twist, least_norm_derivatives, models, smallest_singular_value,
};
use common::{chain, inertials, pose_distance};
use nalgebra::{Isometry3, SMatrix, Vector3};
use proptest::prelude::*;

/// A joint vector inside `range`, from numbers in 0..1.
fn inside<const N: usize>(range: &JointRange<N>, parts: &[f64]) -> Joints<N> {
    Joints::from_fn(|i, _| range.lower()[i] + parts[i] * (range.upper()[i] - range.lower()[i]))
}

fn parts(n: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.0..1.0, n)
}

/// A multiplicative sequence, the same on every machine.
fn sequence(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn a_panda_finds_999_of_1000_reachable_poses_from_anywhere() {
    let arm = models::panda();
    let mut draw = sequence(20_260_103);
    let mut some = || inside(arm.range(), &[(); 7].map(|()| draw()));
    let (mut missed, tries) = (0, 2000);
    for _ in 0..tries {
        let (q, seed) = (some(), some());
        let target = arm.forward(&q);
        let end = arm.search(&target, &seed).unwrap();
        assert!(arm.range().contains(&end.q), "{}", end.q);
        let distance = pose_distance(&arm.forward(&end.q), &target);
        assert_eq!(end.converged, distance < 2e-11, "{distance:e}");
        missed += usize::from(!end.converged);
    }
    assert!(missed * 1000 <= tries, "{missed} of {tries}");
}

/// Solutions lay anywhere up to 1e-11 from their targets, and trajectories made of them were not
/// smooth.
#[test]
fn a_target_that_is_reached_is_met_to_rounding() {
    let arm = models::panda();
    let six: Arm<6> = Arm::from(arm).locked(2, 0.3).unwrap();
    let mut draw = sequence(11);
    for _ in 0..1000 {
        let q: Joints<7> = inside(arm.range(), &[(); 7].map(|()| draw()));
        let others = Joints::<6>::from_fn(|i, _| q[i + usize::from(i >= 2)]);
        let shift = 10.0_f64.powf(-1.0 - 7.0 * draw());
        // Next to singular poses Newton's method cannot tell the last digits.
        if smallest_singular_value(&six.jacobian(&others)) < 0.01 {
            continue;
        }
        let target = six.forward(&others);
        if let Ok(found) = six.inverse(&target, &others.map(|v| v + shift)) {
            let (miss, stated) = (six.forward(&found), six.residual(&found));
            let position = (miss.translation.vector - target.translation.vector).norm();
            assert!(position <= stated.position && stated.position < 5e-14, "{position:e} {stated:?}");
        }
    }
}

/// The search ended before it looked at the posture when the tool stood at its target already.
#[test]
fn the_posture_is_approached_by_a_tool_that_stands_at_its_target() {
    let arm = models::panda();
    let q = Joints::from([0.4, -0.4, 0.5, -2.0, 0.3, 1.6, 0.7]);
    // A posture at the end of the one motion that keeps the tool.
    let moving = arm.jacobian(&q).transpose().qr().q();
    let still = SMatrix::<f64, 7, 7>::identity() - moving * moving.transpose();
    let posture = q + still.column(still.diagonal().imax()).normalize() * 0.5;
    let null_space = NullSpace::Towards { posture, gain: 0.2 };
    let drifting = arm.with_settings(NumericSettings { null_space, ..NumericSettings::default() }).unwrap();
    let target = arm.forward(&q);
    let (mut now, mut far) = (q, (q - posture).norm());
    for _ in 0..5 {
        now = drifting.inverse(&target, &now).unwrap();
        let left = (now - posture).norm();
        assert!(left < 0.9 * far, "{left} {far}");
        assert!((arm.forward(&now).translation.vector - target.translation.vector).norm() < 1e-13);
        far = left;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn from_a_near_seed_it_stays_near(q in parts(7), shift in prop::collection::vec(-0.02..0.02, 7)) {
        let arm = models::panda();
        let q = inside(arm.range(), &q);
        let seed = q + Joints::<7>::from_column_slice(&shift);
        let end = arm.search(&arm.forward(&q), &seed).unwrap();
        prop_assert!(end.converged);
        prop_assert!(end.restarts > 0 || (end.q - q).amax() < 1.0, "{}", end.q);
    }

    #[test]
    fn the_best_of_a_miss_is_told_truly(q in parts(7), away in 1.0..3.0) {
        let few = NumericSettings { restarts: 5, ..NumericSettings::default() };
        let arm = models::panda().with_settings(few).unwrap();
        let seed = inside(arm.range(), &q);
        let mut target = arm.forward(&seed);
        target.translation.vector = target.translation.vector.normalize() * (1.0 + away);
        let end = arm.search(&target, &seed).unwrap();
        prop_assert!(!end.converged);
        let at = arm.forward(&end.q);
        prop_assert!((end.position - (at.translation.vector - target.translation.vector).norm()).abs() < 1e-12);
        prop_assert!((end.orientation - at.rotation.angle_to(&target.rotation)).abs() < 1e-7);
        let error = arm.inverse(&target, &seed).unwrap_err();
        let KinematicsError::NotConverged { position, attempts, .. } = error.clone() else { panic!("{error}") };
        prop_assert!(position == end.position && attempts == 6, "{error}");
        // The arm is 1.27 m long from its second joint at 0.333 m.
        prop_assert!(position > away - 0.61, "{error}");
    }

    #[test]
    fn redundant_joints_move_towards_the_posture(q in parts(7)) {
        let arm = models::panda();
        let q = inside(arm.range(), &q);
        let target = arm.forward(&q);
        let posture = Joints::from([0.0, 0.0, 0.0, -1.5, 0.0, 1.8, 0.0]);
        let null_space = NullSpace::Towards { posture, gain: 0.1 };
        let drifting = arm.with_settings(NumericSettings { null_space, ..NumericSettings::default() }).unwrap();
        let mut now = q;
        for _ in 0..20 {
            let next = drifting.inverse(&target, &now).unwrap();
            prop_assert!(pose_distance(&arm.forward(&next), &target) < 2e-11);
            now = next;
        }
        prop_assert!((now - posture).norm() <= (q - posture).norm() + 1e-3, "{now} {q}");
    }

    #[test]
    fn the_torques_of_a_locked_arm_are_those_of_the_whole(q in parts(7), joint in 0_usize..7, rates in prop::collection::vec(-1.0..1.0, 14)) {
        let panda = models::panda();
        let load = inertials::<7>("panda")[6];
        let dynamics = ArmDynamics::new(panda.chain(), inertials("panda"))
            .unwrap()
            .with_friction(Friction::new(Joints::repeat(0.3), Joints::repeat(0.2), Joints::repeat(0.1)).unwrap())
            .with_payload(load)
            .unwrap();
        let arm = Arm::from(panda).with_dynamics(dynamics);
        let q = inside(arm.range(), &q);
        let six: Arm<6> = arm.locked(joint, q[joint]).unwrap();
        let left = |v: &Joints<7>| Joints::<6>::from_fn(|i, _| v[i + usize::from(i >= joint)]);
        prop_assert!(pose_distance(&arm.forward(&q), &six.forward(&left(&q))) < 1e-14);
        let mut qd = Joints::<7>::from_column_slice(&rates[..7]);
        let mut qdd = Joints::<7>::from_column_slice(&rates[7..]);
        (qd[joint], qdd[joint]) = (0.0, 0.0);
        let whole = left(&dynamics.torque(&q, &qd, &qdd));
        let part = six.dynamics().unwrap().torque(&left(&q), &left(&qd), &left(&qdd));
        prop_assert!((whole - part).amax() < 1e-11, "{whole} {part}");
    }

    #[test]
    fn a_locked_panda_is_solved_near_a_seed(q in parts(7), joint in 0_usize..7) {
        let arm = Arm::from(models::panda());
        let q = inside(arm.range(), &q);
        let six: Arm<6> = arm.locked(joint, q[joint]).unwrap();
        let left = Joints::<6>::from_fn(|i, _| q[i + usize::from(i >= joint)]);
        let target = six.forward(&left);
        let found = six.inverse(&target, &left.map(|v| v + 1e-3)).unwrap();
        prop_assert!(pose_distance(&six.forward(&found), &target) < 2e-11);
        prop_assert!(six.range().contains(&found));
    }

    #[test]
    fn least_norm_derivatives_follow_the_tool(q in parts(7), tool in prop::collection::vec(-1.0..1.0, 18)) {
        let arm = models::panda();
        let q = inside(arm.range(), &q);
        let twist = |k: usize| Twist::from_column_slice(&tool[6 * k..6 * k + 6]);
        let tool = ToolDerivatives { first: twist(0), second: twist(1), third: twist(2) };
        let jacobian = arm.jacobian(&q);
        let answer = least_norm_derivatives(&arm, &q, &tool, 1e-2);
        // Refused where the arm is nearly singular, and nowhere else.
        prop_assert_eq!(answer.is_ok(), jacobian.svd(false, false).singular_values[5] >= 1e-2, "{:?}", answer);
        if let Ok(by_s) = answer {
            let first = jacobian * by_s.first - tool.first;
            let second = jacobian * by_s.second + arm.jacobian_dot_qd(&q, &by_s.first) - tool.second;
            let third = jacobian * by_s.third + arm.jerk_bias(&q, &by_s.first, &by_s.second) - tool.third;
            let size = 1.0 + by_s.third.amax();
            prop_assert!(first.amax().max(second.amax()).max(third.amax()) < 1e-10 * size);
            // Least norm: at right angles to every motion that keeps the tool.
            let null = jacobian.svd(false, true).v_t.unwrap();
            let normal = by_s.first - null.transpose() * (null * by_s.first);
            prop_assert!(normal.amax() < 1e-9 * (1.0 + by_s.first.amax()));
        }
    }

    #[test]
    fn any_target_and_seed_give_an_answer_or_an_error(numbers in prop::collection::vec(prop_oneof![
        4 => -10.0..10.0, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(1e300), 1 => Just(0.0),
    ], 13)) {
        let few = NumericSettings { restarts: 2, steps: 20, ..NumericSettings::default() };
        let arm = Arm::from(models::panda()).with_settings(few).unwrap();
        let n = &numbers;
        let target = Isometry3::new(Vector3::new(n[0], n[1], n[2]), Vector3::new(n[3], n[4], n[5]));
        let seed = Joints::<7>::from_column_slice(&n[6..13]);
        if let Ok(found) = arm.inverse(&target, &seed) {
            prop_assert!(arm.range().contains(&found));
        }
        if let Ok(all) = arm.inverse_all(&target) {
            prop_assert!(!all.is_complete() && !all.is_empty());
        }
    }
}

#[test]
fn geometry_chooses_the_inverse() {
    let wide = JointRange::new(Joints::<6>::repeat(-7.0), Joints::repeat(7.0)).unwrap();
    let method = |name: &str| Arm::new(chain::<6>(name), wide).method();
    for name in ["cr7", "ur5e"] {
        assert_eq!(method(name), InverseMethod::ParallelAxis, "{name}");
    }
    for name in ["kr6_r700_2", "kr6_r700_sixx", "puma560"] {
        assert_eq!(method(name), InverseMethod::SphericalWrist, "{name}");
    }
    let panda = Arm::from(models::panda());
    assert_eq!((panda.method(), panda.closed_form_refusals()), (InverseMethod::Numeric, None));
    let six: Arm<6> = panda.locked(2, 0.0).unwrap();
    let refusals = six.closed_form_refusals().unwrap();
    assert!(refusals[0].to_string().contains("must be"), "{}", refusals[0]);
    // A closed form answers as its own type does, base and tool included.
    let tool = Isometry3::new(Vector3::new(0.1, 0.0, 0.2), Vector3::new(0.3, 0.2, 0.1));
    let arm = Arm::from(models::kr6_r700()).with_tool(tool).unwrap().with_base(tool).unwrap();
    let plain = models::kr6_r700().with_tool(tool).unwrap().with_base(tool).unwrap();
    let q = Joints::from([0.3, -1.2, 1.1, 0.4, 0.9, -0.3]);
    let target = arm.forward(&q);
    assert_eq!(arm.inverse(&target, &q).unwrap(), plain.inverse(&target, &q).unwrap());
    assert_eq!(arm.inverse_all(&target).unwrap().as_slice(), plain.inverse_all(&target).unwrap().as_slice());
    assert_eq!(arm.singularity_distances(&q), Some(plain.singularity_distances(&q)));
    let ours: Vec<_> = arm.candidates(&target, &q).unwrap().collect();
    assert_eq!(ours, plain.candidates(&target, &q).unwrap().collect::<Vec<_>>());
    let q = Joints::from([0.1, -0.4, 0.2, -2.0, 0.1, 1.6, 0.7]);
    let target = panda.forward(&q);
    for candidate in panda.candidates(&target, &q).unwrap() {
        let Candidate::Usable { q, .. } = candidate else { panic!("found inside the range") };
        assert!(panda.range().contains(&q) && pose_distance(&panda.forward(&q), &target) < 2e-11);
    }
}

#[test]
fn arms_of_few_joints_reach_what_they_can() {
    let range = JointRange::new(Joints::<2>::repeat(-3.0), Joints::repeat(3.0)).unwrap();
    let arm = NumericArm::new(models::planar_2r(), range);
    let mut draw = sequence(5);
    for _ in 0..200 {
        let q = inside(&range, &[draw(), draw()]);
        let seed = inside(&range, &[draw(), draw()]);
        let target = arm.forward(&q);
        let found = arm.inverse(&target, &seed).unwrap();
        assert!(pose_distance(&arm.forward(&found), &target) < 2e-11);
    }
    let error = arm.inverse(&Isometry3::translation(0.0, 0.0, 0.1), &Joints::<2>::zeros()).unwrap_err();
    assert!(matches!(error, KinematicsError::NotConverged { position, .. } if position >= 0.1), "{error}");
}

#[test]
fn sliding_joints_are_not_turned() {
    // A gantry that also turns: its first three joints slide over more than 2 pi.
    let slide = |axis| Joint::prismatic(Isometry3::identity(), axis).unwrap();
    let turn = |axis| Joint::revolute(Isometry3::identity(), axis).unwrap();
    let chain = Chain::new([
        slide(Vector3::x()),
        slide(Vector3::y()),
        slide(Vector3::z()),
        turn(Vector3::z()),
        turn(Vector3::y()),
        turn(Vector3::x()),
    ])
    .unwrap();
    let range = JointRange::new(Joints::repeat(-20.0), Joints::repeat(20.0)).unwrap();
    let arm = Arm::new(chain, range);
    assert_eq!(arm.method(), InverseMethod::Numeric);
    let mut draw = sequence(6);
    for _ in 0..200 {
        let q = Joints::from_fn(|i, _| if i < 3 { 40.0 * draw() - 20.0 } else { 3.0 * draw() - 1.5 });
        let target = arm.forward(&q);
        let found = arm.inverse(&target, &Joints::zeros()).unwrap();
        assert!((found - q).fixed_rows::<3>(0).amax() < 1e-9, "{found} {q}");
        let all = arm.inverse_all(&target).unwrap();
        assert!(all.iter().all(|s| (s - q).fixed_rows::<3>(0).amax() < 1e-9));
    }
}

#[test]
fn a_path_is_followed_with_bounded_steps() {
    let arm = models::panda();
    let start = Joints::from([0.1, -0.4, 0.2, -2.0, 0.1, 1.6, 0.7]);
    let mut tracker = BranchTracker::new(&arm, start).with_max_step(0.02);
    let first = arm.forward(&start);
    for k in 0..=500 {
        let angle = std::f64::consts::TAU * f64::from(k) / 500.0;
        let mut target = first;
        target.translation.vector += Vector3::new(angle.cos() - 1.0, angle.sin(), 0.3 * angle.sin()) * 0.1;
        let q = tracker.next(&target).unwrap();
        assert!(pose_distance(&arm.forward(&q), &target) < 2e-11);
    }
    let far = arm.forward(&Joints::from([1.5, 0.4, 0.2, -1.0, 0.1, 1.6, 0.7]));
    let error = tracker.next(&far).unwrap_err();
    assert!(matches!(error, KinematicsError::StepTooLarge { .. }), "{error}");
}

#[test]
fn settings_limits_and_locks_are_checked() {
    let arm = Arm::from(models::panda());
    let bad = |settings: NumericSettings<7>| arm.with_settings(settings).unwrap_err();
    let fine = NumericSettings::default();
    bad(NumericSettings { position: 0.0, ..fine });
    bad(NumericSettings { orientation: f64::NAN, ..fine });
    bad(NumericSettings { null_space: NullSpace::Towards { posture: Joints::repeat(f64::NAN), gain: 0.1 }, ..fine });
    let error = bad(NumericSettings { null_space: NullSpace::Towards { posture: Joints::zeros(), gain: 2.0 }, ..fine });
    assert_eq!(error.to_string(), "null-space gain is 2: it must be from 0 to 1");
    let error = arm.locked::<6>(3, 0.5).unwrap_err();
    assert!(error.to_string().starts_with("joint 4 cannot be held at 0.5"), "{error}");
    assert!(arm.locked::<5>(2, 0.0).is_err());
    assert!(arm.locked::<6>(7, 0.0).is_err());
    assert!(arm.locked::<6>(0, f64::NAN).is_err());
    let torque = Some(Joints::from([87.0, 87.0, 87.0, 87.0, 12.0, 0.0, 12.0]));
    let error = arm.with_drive_limits(DriveLimits { torque, ..DriveLimits::default() }).unwrap_err();
    assert!(error.to_string().contains("joint 6: torque limit 0"), "{error}");
    assert!(arm.limits().is_none());
    let rates = Some(Joints::repeat(2.0));
    let drives = DriveLimits { velocity: rates, acceleration: rates, jerk: rates, torque: None };
    assert_eq!(arm.with_drive_limits(drives).unwrap().limits().unwrap().jerk()[3], 2.0);
}
