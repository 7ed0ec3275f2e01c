//! Closed-form inverse: properties at random and singular poses, tools, bases, limits and turns.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    AnalyticInverse, BranchTracker, Candidate, Chain, ForwardKinematics, InverseKinematics, Joint, JointRange, Joints,
    KinematicsError, ParallelAxisArm, ReachSide, largest_step, models, nearest_turns, smallest_singular_value,
};
use arcfeed_testing::{Counting, Random};
use common::closed_forms::{
    WRIST_SINGULAR, joints, manufacturing_errors, nearest, nothing_is_lost_at, poses, solutions_are_polished,
    solutions_at, solutions_reproduce_the_pose, special_joints, tracks_through_the_wrist, with_errors,
};
use common::{angle_difference, chain, pose_distance};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Built-in arms by name, so that failing input is short to read.
fn arms() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec!["cr7", "ur5e"])
}

fn arm_named(name: &str) -> ParallelAxisArm {
    if name == "cr7" { models::cr7() } else { models::ur5e() }
}

/// Wide enough that no limit is in the way.
fn without_limits(arm: &ParallelAxisArm) -> ParallelAxisArm {
    arm.with_range(JointRange::new(Joints::repeat(-12.0), Joints::repeat(12.0)).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_solution_reproduces_the_pose_and_one_is_where_it_came_from(
        name in arms(), q in joints(PI), tool in poses(), base in poses(),
    ) {
        let arm = arm_named(name);
        solutions_reproduce_the_pose(&arm.with_tool(tool).unwrap().with_base(base).unwrap(), &q)?;
    }

    #[test]
    fn the_wrist_singularity_loses_nothing(name in arms(), mut q in joints(2.7), straight in any::<bool>(), other in -3.0..3.0) {
        let arm = arm_named(name);
        q[4] = if straight { 0.0 } else { PI };
        let (target, all) = solutions_at(&arm, &q)?;
        prop_assert!(all.wrist_singular());
        let found = arm.inverse(&target, &q).unwrap();
        prop_assert!(pose_distance(&arm.forward(&found), &target) < WRIST_SINGULAR);
        if q[2].abs() > 1e-2 {
            prop_assert!((found - q).amax() < 1e-9, "{found}");
        }
        // Any other previous value of the free joint gives an answer as well, with that value unless it is out of reach.
        let mut seed = q;
        seed[5] = other;
        let found = without_limits(&arm).inverse(&target, &seed).unwrap();
        prop_assert!(pose_distance(&arm.forward(&found), &target) < WRIST_SINGULAR);
        let stretched = found[2].sin().abs() < 1e-5;
        let in_this_branch = (found[0] - q[0]).abs() < 1e-6;
        prop_assert!(stretched || !in_this_branch || (found[5] - other).abs() < 1e-9, "{found}");
    }

    #[test]
    fn the_elbow_singularity_loses_nothing(name in arms(), mut q in joints(2.7), folded in any::<bool>()) {
        let arm = arm_named(name);
        q[2] = if folded { PI } else { 0.0 };
        let arm = without_limits(&arm);
        let target = arm.forward(&q);
        let all = arm.inverse_all(&target).unwrap();
        // Beside a second singularity the double root is only as exact as the other joints are.
        let second = all.wrist_singular() || arm.singularity_distances(&q).shoulder < 1e-2;
        let exact = if second { WRIST_SINGULAR } else { 1e-12 };
        for solution in &all {
            let off = pose_distance(&arm.forward(solution), &target);
            prop_assert!(off < exact, "{off:e} at {solution}");
        }
        let found = arm.inverse(&target, &q).unwrap();
        prop_assert!(pose_distance(&arm.forward(&found), &target) < exact);
        // A double root: rounding of the pose moves it by the square root of the rounding (1e-8 for lengths of 1 m;
        // more for the folded arm, whose axes 2 and 4 are close together).
        if !second && q[4].sin().abs() > 1e-2 {
            prop_assert!((found - q).amax() < if folded { 1e-5 } else { 1e-6 }, "{found}");
        }
    }

    #[test]
    fn the_shoulder_singularity_loses_nothing(name in arms(), mut q in joints(2.7), back in any::<bool>()) {
        let arm = arm_named(name);
        // Turn joint 2 until the wrist stands over axis 1.
        let at = arm.configuration(&q);
        let (z1, n) = (at.axes()[0], at.axes()[1]);
        let arm_vector = at.points()[5] - at.points()[1];
        let (across, up) = (arm_vector.dot(&z1.cross(&n)), arm_vector.dot(&z1));
        q[1] += if back { -FRAC_PI_2 } else { FRAC_PI_2 } - up.atan2(across);
        let arm = without_limits(&arm);
        let target = arm.forward(&q);
        for solution in &arm.inverse_all(&target).unwrap() {
            prop_assert!(pose_distance(&arm.forward(solution), &target) < 1e-12);
        }
        let found = arm.inverse(&target, &q).unwrap();
        prop_assert!(pose_distance(&arm.forward(&found), &target) < 1e-12);
        if q[2].sin().abs() > 1e-2 && q[4].sin().abs() > 1e-2 {
            prop_assert!(angle_difference(&found, &q) < 1e-5, "{found} {q}");
        }
    }

    #[test]
    fn several_singularities_at_once_lose_nothing(name in arms(), q in special_joints()) {
        nothing_is_lost_at(&without_limits(&arm_named(name)), &q)?;
    }

    #[test]
    fn turns_are_the_nearest_of_all(q in joints(PI), seed in joints(9.0), lower in joints(7.0), width in prop::array::uniform6(0.1..14.0)) {
        let range = JointRange::new(lower, lower + Joints::from(width)).unwrap();
        match nearest_turns(&q, &seed, &range) {
            Ok(found) => {
                for joint in 0..6 {
                    let best = (-5..=5)
                        .map(|k| q[joint] + TAU * f64::from(k))
                        .filter(|v| range.lower()[joint] <= *v && *v <= range.upper()[joint])
                        .map(|v| (v - seed[joint]).abs())
                        .fold(f64::INFINITY, f64::min);
                    prop_assert!(((found[joint] - seed[joint]).abs() - best).abs() < 1e-9);
                }
                prop_assert!(range.contains(&found));
            }
            Err(excess) => {
                let least = (-5..=5)
                    .map(|k| q[excess.joint] + TAU * f64::from(k))
                    .map(|v| (range.lower()[excess.joint] - v).max(v - range.upper()[excess.joint]))
                    .fold(f64::INFINITY, f64::min);
                prop_assert!(least > 0.0 && (least - excess.excess).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_nearest_solution_has_the_least_largest_step(name in arms(), q in joints(PI), seed in joints(6.0)) {
        let arm = arm_named(name);
        let target = arm.forward(&q);
        prop_assume!(smallest_singular_value(&arm.jacobian(&q)) > 1e-4);
        let mut least = f64::INFINITY;
        for candidate in arm.candidates(&target, &seed).unwrap() {
            if let Candidate::Usable { q, joint, step } = candidate {
                prop_assert_eq!((joint, step), largest_step(&q, &seed));
                least = least.min(step);
            }
        }
        match arm.inverse(&target, &seed) {
            Ok(found) => {
                prop_assert!(arm.range().contains(&found));
                prop_assert!(pose_distance(&arm.forward(&found), &target) < 1e-12);
                prop_assert_eq!(largest_step(&found, &seed).1, least);
            }
            Err(error) => prop_assert!(least.is_infinite(), "{error}"),
        }
    }
}

#[test]
fn a_stretched_arm_pulled_outwards_misses_by_the_pull() {
    let arm = models::ur5e();
    let mut exactly = 0;
    for k in 0..200 {
        let k = f64::from(k);
        let q = Joints::from([0.3, -0.6, 0.0, 0.5 + 0.11 * k, 1.1 + 0.07 * k, 0.4]);
        let at = arm.configuration(&q);
        let outwards = (at.points()[2] - at.points()[1]).normalize();
        let mut target = arm.forward(&q);
        target.translation.vector += outwards * 0.4;
        // Another branch may come nearer, or reach.
        if let Err(KinematicsError::Unreachable { distance, side }) = arm.inverse_all(&target) {
            assert_eq!(side, ReachSide::TooFar);
            assert!(distance < 0.4 + 1e-12, "{distance}");
            exactly += usize::from((distance - 0.4).abs() < 1e-12);
        }
    }
    assert!(exactly > 20, "{exactly}");
}

#[test]
fn a_wrist_inside_the_shoulder_offset_is_too_near() {
    // Wrist centre on axis 1, which the shoulder offset of 0.141 m keeps it away from.
    let arm = models::cr7();
    let target = Isometry3::translation(0.0, 0.0, 0.6 + 0.105);
    match arm.inverse_all(&target).unwrap_err() {
        KinematicsError::Unreachable { distance, side } => {
            assert_eq!(side, ReachSide::TooNear);
            assert!((distance - 0.141).abs() < 1e-12, "{distance}");
        }
        error => panic!("{error}"),
    }
}

#[test]
fn limits_say_which_joint_and_by_how_much() {
    let arm = models::cr7();
    let q = Joints::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.1]);
    let target = arm.forward(&q);
    let narrow = |joint: usize| {
        let (mut lower, mut upper) = (Joints::repeat(-TAU), Joints::repeat(TAU));
        (lower[joint], upper[joint]) = (6.0, 6.1);
        arm.with_range(JointRange::new(lower, upper).unwrap())
    };
    let arm5 = narrow(4);
    let error = arm5.inverse(&target, &q).unwrap_err();
    let KinematicsError::OutsideLimits { joint, value, lower, upper, excess, solutions } = error else {
        panic!("{error}")
    };
    assert_eq!((joint, lower, upper, solutions), (4, 6.0, 6.1, 8));
    assert!((excess - (lower - value).max(value - upper)).abs() < 1e-12 && excess > 0.0);
    assert!(error.to_string().contains("joint 5"), "{error}");
    let all: Vec<_> = arm5.candidates(&target, &q).unwrap().collect();
    assert_eq!(all.len(), 8);
    assert!(
        all.iter()
            .all(|c| matches!(c, Candidate::OutsideLimits { excess: e, .. } if e.excess >= excess && e.joint == 4))
    );
    // A limit exactly at the solution does not reject it for its rounding.
    let upper = Joints::from_fn(|i, _| if i == 0 { q[0] } else { TAU });
    let edge = arm.with_range(JointRange::new(Joints::repeat(-TAU), upper).unwrap());
    assert!((edge.inverse(&target, &q).unwrap() - q).amax() < 1e-12);
}

#[test]
fn turns_follow_the_seed() {
    let arm = models::cr7();
    let q = Joints::from([5.9, -0.2, 1.4, 0.3, -1.5, -6.0]);
    let found = arm.inverse(&arm.forward(&q), &q).unwrap();
    assert!((found - q).amax() < 1e-9);
    // Beyond the limit the next turn inside it is taken.
    let seed = q + Joints::from([0.6, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut target_q = q;
    target_q[0] = 6.4;
    let found = arm.inverse(&arm.forward(&target_q), &seed).unwrap();
    assert!(arm.range().contains(&found));
}

#[test]
fn a_path_through_the_wrist_singularity_stays_continuous() {
    tracks_through_the_wrist(&models::cr7(), -0.3);
}

#[test]
fn a_jump_is_refused_and_named() {
    let arm = models::cr7();
    let q = Joints::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.1]);
    let mut moved = q;
    moved[3] += 0.3;
    let mut tracker = BranchTracker::new(&arm, q).with_max_step(0.1);
    let error = tracker.next(&arm.forward(&moved)).unwrap_err();
    let KinematicsError::StepTooLarge { joint, step, bound } = error else { panic!("{error}") };
    assert_eq!((joint, bound), (3, 0.1));
    assert!((step - 0.3).abs() < 1e-9);
    assert!(error.to_string().contains("joint 4"), "{error}");
    assert_eq!(*tracker.joints(), q);
}

#[test]
fn the_arm_at_its_zero_is_solved() {
    // Stretched, wrist lined up, wrist over the shoulder (CR7): three singularities at once.
    for arm in [models::cr7(), models::ur5e()] {
        let target = arm.forward(&Joints::zeros());
        let found = arm.inverse(&target, &Joints::zeros()).unwrap();
        assert!(found.amax() < 1e-7, "{found}");
        assert!(pose_distance(&arm.forward(&found), &target) < 1e-12);
    }
}

#[test]
fn geometry_is_recognised_not_names() {
    let range = JointRange::new(Joints::repeat(-7.0), Joints::repeat(7.0)).unwrap();
    // The same arm with joints 3 and 6 counted the other way and another zero everywhere.
    let mut joints = *chain::<6>("cr7").joints();
    for (i, joint) in joints.iter_mut().enumerate() {
        let turn = Isometry3::rotation(joint.axis().into_inner() * (0.3 * i as f64 - 0.7));
        let axis = if i == 2 || i == 5 { -joint.axis().into_inner() } else { joint.axis().into_inner() };
        *joint = Joint::revolute(joint.origin() * turn, axis).unwrap();
    }
    let arm = ParallelAxisArm::new(Chain::new(joints).unwrap(), range).unwrap();
    let q = Joints::from([0.3, -0.2, 1.1, 0.9, -1.5, 0.1]);
    let target = arm.forward(&q);
    let all = arm.inverse_all(&target).unwrap();
    assert!(nearest(&all, &q) < 1e-12);
    assert!(all.iter().all(|s| pose_distance(&arm.forward(s), &target) < 1e-12));
    for other in ["kr6_r700_2", "kr6_r700_sixx", "puma560"] {
        let error = ParallelAxisArm::new(chain::<6>(other), range).unwrap_err();
        assert!(matches!(error, KinematicsError::NoClosedForm { .. }), "{other}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_target_too_far_comes_into_reach_when_moved_by_the_stated_distance(name in arms(), target in poses()) {
        let arm = arm_named(name);
        if let Err(error) = arm.inverse_all(&target) {
            let KinematicsError::Unreachable { distance, side } = error else { panic!("{error}") };
            prop_assert!(distance > 0.0);
            if side == ReachSide::TooFar {
                // A few per cent more, in one of many directions.
                let reached = (0..4000).any(|k| {
                    let (z, turn) = (1.0 - (f64::from(k) + 0.5) / 2000.0, 2.399_963 * f64::from(k));
                    let flat = (1.0 - z * z).sqrt();
                    let mut moved = target;
                    moved.translation.vector += Vector3::new(flat * turn.cos(), flat * turn.sin(), z) * (distance * 1.02);
                    arm.inverse_all(&moved).is_ok()
                });
                prop_assert!(reached, "{error}");
            }
        }
    }

    #[test]
    fn arms_with_manufacturing_errors_are_polished(q in joints(PI), errors in manufacturing_errors()) {
        let chain = with_errors(&chain::<6>("ur5e"), &errors);
        solutions_are_polished(&ParallelAxisArm::new(chain, JointRange::new(Joints::repeat(-7.0), Joints::repeat(7.0)).unwrap()).unwrap(), &q)?;
    }
}

/// The elbow of an arm whose axes are parallel but for 50 urad, as a file that rounds its angles makes them, from nearly stretched on, and
/// shoulder and wrist beside their singular poses: the ideal geometry misses poses there by some um, which was an error.
#[test]
fn poses_that_only_the_real_chain_reaches_are_reached() {
    let mut random = Random::new(20_261_201);
    let errors = std::array::from_fn(|_| std::array::from_fn(|_| 5e-5 * random.sign()));
    let chain = with_errors(&chain::<6>("ur5e"), &errors);
    let arm = ParallelAxisArm::new(chain, JointRange::new(Joints::repeat(-7.0), Joints::repeat(7.0)).unwrap()).unwrap();
    let mut beside = 0;
    for k in 0..300 {
        let mut q = Joints::<6>::from_fn(|_, _| random.between(-2.5, 2.5));
        match k % 3 {
            0 => q[2] = 1e-2 * random.signed(),
            1 => q[4] = 1e-2 * random.signed(),
            _ => {}
        }
        let target = arm.forward(&q);
        let start = q.map(|value| value + 0.2 * random.sign());
        let before = Counting::count();
        let found = arm.inverse(&target, &start);
        assert_eq!(Counting::count(), before, "{k}: allocates");
        let found = found.unwrap_or_else(|error| panic!("{k}: {error} at {q}"));
        let off = pose_distance(&arm.forward(&found), &target);
        assert!(off < 1e-9, "{k}: {off:e} at {q}");
        beside += usize::from(arm.inverse_all(&target).is_err());
    }
    // Elsewhere the closed form answers.
    assert!((5..100).contains(&beside), "{beside}");
    // What is out of reach by a millimetre and more stays so.
    let away = Isometry3::translation(0.0, 0.0, 3.0);
    assert!(matches!(arm.inverse(&away, &Joints::zeros()), Err(KinematicsError::Unreachable { .. })));
}
