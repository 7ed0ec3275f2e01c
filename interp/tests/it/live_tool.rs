//! Targets of the tool that change while it moves: limits of tool and joints, straight ways, refusals.

use crate::common;

use arcfeed_interp::{JointCheck, JointRates, JointSample, LiveTool, PathArm, ToolTargetError};
use arcfeed_kinematics::{ForwardKinematics, JointLimits, Joints, models};
use arcfeed_sync::{PoseLimits, ProjectionStatus};
use arcfeed_testing::{Counting, Random, cases};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3, vector};

const PERIOD: f64 = 2e-3;
const HOME: [f64; 6] = [0.1, -1.4, 1.8, -1.9, -1.5, 0.2];

fn tool() -> PoseLimits {
    PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0]).expect("limits above 0")
}

/// A pose within some decimetres and a radian of `pose`.
fn beside(random: &mut Random, pose: &Isometry3<f64>) -> Isometry3<f64> {
    let by = |random: &mut Random, most: f64| Vector3::from_fn(|_, _| random.between(-most, most));
    let turn = UnitQuaternion::from_scaled_axis(by(random, 0.6));
    Isometry3::from_parts(Translation3::from(pose.translation.vector + by(random, 0.2)), turn * pose.rotation)
}

/// Norms of the derivatives of the tool, by forward kinematics alone: at `now`, and as means of the cycle.
fn tool_uses(positions: &[Isometry3<f64>; 4]) -> [f64; 6] {
    let p = positions.map(|pose| pose.translation.vector);
    let turned = |k: usize| (positions[k + 1].rotation * positions[k].rotation.inverse()).scaled_axis() / PERIOD;
    let v = [0, 1, 2].map(|k| (p[k + 1] - p[k]) / PERIOD);
    let w = [0, 1, 2].map(turned);
    let differences = |v: [Vector3<f64>; 3]| {
        let a = [0, 1].map(|k| (v[k + 1] - v[k]) / PERIOD);
        [v[2].norm(), a[1].norm(), (a[1] - a[0]).norm() / PERIOD]
    };
    let ([lv, la, lj], [av, aa, aj]) = (differences(v), differences(w));
    [lv, la, lj, av, aa, aj]
}

/// Counts of a random run: targets accepted and refused, and those that had to be slowed down.
#[derive(Debug, Default)]
struct Counts {
    accepted: usize,
    refused: usize,
    slowed: usize,
    too_fast_to_turn: usize,
}

/// Goes for random targets, each set in a random cycle, and holds joints and tool against every limit.
fn runs<A: PathArm<6>>(arm: &A, home: [f64; 6], limits: &JointLimits<6>, seed: u64, counts: &mut Counts) {
    let mut random = Random::new(seed);
    let start = Joints::from(home);
    let mut motion = LiveTool::new(arm, &start, limits, &tool(), PERIOD).expect("a pose to start from");
    let first = arm.forward(&start);
    let rates = JointRates::from(limits);
    let mut check = JointCheck::new(limits.range());
    let sample = |t: f64, s: &LiveTool<'_, A, 6>| {
        let j = s.joints();
        JointSample { t, q: j.q, qd: j.qd, qdd: j.qdd }
    };
    check.see(&sample(0.0, &motion), PERIOD, &rates);
    let mut poses = [first; 4];
    let (mut cycle, mut t) = (0, 0.0);
    for _ in 0..8 {
        let target = beside(&mut random, &first);
        match motion.set_target(&target) {
            Ok(()) => {
                counts.accepted += 1;
                counts.slowed += usize::from(motion.share() < 1.0);
            }
            Err(ToolTargetError::Unreachable { .. } | ToolTargetError::TooFast { .. }) => counts.refused += 1,
            Err(ToolTargetError::TooFastToTurn { .. }) => counts.too_fast_to_turn += 1,
            Err(other) => panic!("seed {seed}: {other}"),
        }
        let cycles = (random.log(5.0, 1000.0)) as usize;
        for _ in 0..cycles {
            let step = motion.step().unwrap_or_else(|e| panic!("seed {seed}, cycle {cycle}: {e}"));
            (cycle, t) = (cycle + 1, t + PERIOD);
            check.see(&sample(t, &motion), PERIOD, &rates);
            poses.rotate_left(1);
            poses[3] = arm.forward(&step.joints.q);
            let off = (poses[3].translation.vector - step.tool.pose.translation.vector).norm();
            assert!(off < 1e-10, "seed {seed}: the joints are {off} m beside the tool");
            // The rotation of a cycle is no exact integral of the angular velocity: a part in 1e5.
            let limits = [0.5, 3.0, 40.0, 1.5, 8.0, 100.0];
            for (k, (used, limit)) in tool_uses(&poses).iter().zip(limits).enumerate() {
                let noise = [1e-9, 1e-6, 1e-3][k % 3];
                assert!(*used <= limit * (1.0 + 1e-4) + noise, "seed {seed}, cycle {cycle}: limit {k} at {used}");
            }
        }
    }
    while !matches!(motion.step().expect("accepted").status, ProjectionStatus::Reached { .. }) {
        t += PERIOD;
        check.see(&sample(t, &motion), PERIOD, &rates);
    }
    let end = arm.forward(&motion.joints().q);
    let target = motion.target();
    let miss = (end.translation.vector - target.translation.vector).norm() + end.rotation.angle_to(&target.rotation);
    assert!(miss < 1e-11, "seed {seed}: misses by {miss}");
    let found = check.finish();
    assert!(found.holds(1e-6), "seed {seed}: {:?}", found.worst());
}

#[test]
fn random_targets_at_random_times_keep_every_limit() {
    let arm = common::arm();
    let limits = common::limits(&arm);
    let mut counts = Counts::default();
    for seed in cases(6) {
        runs(&arm, HOME, &limits, seed, &mut counts);
    }
    // Slow joints: the tool has to move more slowly.
    let slow = arm.range().with_rates(Joints::repeat(0.6), Joints::repeat(2.0), Joints::repeat(15.0)).expect("limits");
    for seed in cases(6).map(|i| 1_000_000 + i) {
        runs(&arm, HOME, &slow, seed, &mut counts);
    }
    let kuka = models::kr6_r700();
    let limits =
        kuka.range().with_rates(Joints::repeat(2.0), Joints::repeat(9.0), Joints::repeat(90.0)).expect("limits");
    for seed in cases(6).map(|i| 2_000_000 + i) {
        runs(&kuka, [0.1, -1.2, 1.5, 0.2, 0.8, 0.1], &limits, seed, &mut counts);
    }
    assert!(counts.accepted > 100 && counts.refused > 2 && counts.slowed > 50, "{counts:?}");
    println!("{counts:?}");
}

#[test]
fn the_tool_goes_straight_and_turns_about_one_axis() {
    let arm = common::arm();
    let start = Joints::from(HOME);
    let mut motion = LiveTool::new(&arm, &start, &common::limits(&arm), &tool(), PERIOD).expect("a pose");
    let from = arm.forward(&start);
    let turn = Vector3::new(0.3, -0.2, 0.4);
    let by = vector![0.12, 0.1, -0.15];
    let to = Isometry3::from_parts(
        Translation3::from(from.translation.vector + by),
        UnitQuaternion::from_scaled_axis(turn) * from.rotation,
    );
    motion.set_target(&to).expect("in reach");
    loop {
        let step = motion.step().expect("accepted");
        let pose = arm.forward(&step.joints.q);
        let way = pose.translation.vector - from.translation.vector;
        let turned = (pose.rotation * from.rotation.inverse()).scaled_axis();
        let share = way.dot(&by) / by.norm_squared();
        assert!((way - by * share).norm() < 1e-12, "beside the line");
        assert!((turned - turn * share).norm() < 1e-11, "position and orientation go together");
        if matches!(step.status, ProjectionStatus::Reached { .. }) {
            break;
        }
    }
}

#[test]
fn a_target_that_cannot_be_followed_is_refused_and_the_motion_goes_on() {
    let arm = common::arm();
    let start = Joints::from(HOME);
    let from = arm.forward(&start);
    let limits = common::limits(&arm);
    let mut motion = LiveTool::new(&arm, &start, &limits, &tool(), PERIOD).expect("a pose");
    let near = Translation3::new(0.1, 0.0, 0.0) * from;
    motion.set_target(&near).expect("in reach");
    for _ in 0..50 {
        motion.step().expect("accepted");
    }
    let mut twin = motion.clone();
    let far = Translation3::new(3.0, 0.0, 0.0) * from;
    let error = motion.set_target(&far).expect_err("3 m away");
    assert!(matches!(error, ToolTargetError::Unreachable { time, .. } if time > 0.0), "{error}");
    assert!(error.to_string().contains("straight way"), "{error}");
    let slow = PoseLimits::new([1e-9; 3], [1e-9; 3]).expect("above 0");
    let error = motion.set(&near, &slow).expect_err("it cannot brake with so little jerk");
    assert!(!matches!(error, ToolTargetError::Tool(_)), "{error}");
    // Through the wrist singularity: joint 5 passes 0.
    let mut beyond = start;
    beyond[4] = 1.5;
    let error = motion.set_target(&arm.forward(&beyond)).expect_err("a wrist that would have to flip");
    assert!(matches!(error, ToolTargetError::TooFast { .. } | ToolTargetError::Unreachable { .. }), "{error}");
    let nan = Translation3::new(f64::NAN, 0.0, 0.0) * from;
    assert!(matches!(motion.set_target(&nan), Err(ToolTargetError::Tool(_))));
    loop {
        let (a, b) = (motion.step().expect("accepted"), twin.step().expect("accepted"));
        assert_eq!(a, b);
        if matches!(a.status, ProjectionStatus::Reached { .. }) {
            break;
        }
    }
    // From rest the slowest motion is only long.
    assert_eq!(motion.set(&from, &slow), Err(ToolTargetError::TooLong));
    let singular = LiveTool::new(&arm, &Joints::zeros(), &limits, &tool(), PERIOD);
    assert!(matches!(singular, Err(ToolTargetError::Unreachable { .. })));
}

#[test]
fn a_step_allocates_nothing() {
    let arm = common::arm();
    let start = Joints::from(HOME);
    let mut motion = LiveTool::new(&arm, &start, &common::limits(&arm), &tool(), PERIOD).expect("a pose");
    let target = Translation3::new(0.1, -0.1, 0.0) * arm.forward(&start);
    let before = Counting::count();
    motion.set_target(&target).expect("in reach");
    while !matches!(motion.step().expect("accepted").status, ProjectionStatus::Reached { .. }) {}
    assert_eq!(Counting::count() - before, 0);
}
