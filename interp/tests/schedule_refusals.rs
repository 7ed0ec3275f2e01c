//! What a schedule refuses, and that it says where and why; random motions either keep their limits or are refused.

#[path = "common/qb.rs"]
mod qb;

use arcfeed_feedrate::{FeedError, Quantity, RowSource};
use arcfeed_geometry::PoseMotion;
use arcfeed_interp::{
    ArmMotion, JointSpline, PlanError, ScheduleLimits, ScheduleParameter, SchedulePath, Scheduler, SpeedPlanner,
};
use arcfeed_kinematics::{ForwardKinematics, Inertial, Joints, KinematicsError, models};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use proptest::prelude::*;

fn line(to: f64) -> JointSpline<6> {
    JointSpline::through(&[Joints::zeros(), Joints::repeat(to)]).expect("two points")
}

#[test]
fn way_points_are_checked() {
    let p = |v: f64| Joints::<2>::repeat(v);
    assert_eq!(JointSpline::<2>::through(&[]).expect_err("none"), PlanError::TooFewWaypoints { count: 0 });
    assert_eq!(JointSpline::through(&[p(1.0)]).expect_err("one"), PlanError::TooFewWaypoints { count: 1 });
    let error = JointSpline::through(&[p(0.0), p(1.0), p(1.0), p(2.0)]).expect_err("twice the same");
    assert!(matches!(error, PlanError::Waypoint { index: 2, .. }), "{error}");
    assert!(error.to_string().contains("way-point 3 repeats"), "{error}");
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        let error = JointSpline::through(&[p(0.0), Joints::<2>::new(0.0, bad)]).expect_err("no number");
        assert!(matches!(error, PlanError::Waypoint { index: 1, .. }) && error.to_string().contains("joint 2"));
    }
}

#[test]
fn limits_and_settings_are_checked() {
    let arm = qb::arm();
    for bad in [0.0, -1.0, f64::NAN] {
        let mut velocity = Joints::repeat(1.0);
        velocity[3] = bad;
        let limits = ScheduleLimits { velocity: Some(velocity), ..Default::default() };
        let error = Scheduler::new(&arm, limits).expect_err("no limit").to_string();
        assert!(error.contains("joint 4") && error.contains("velocity"), "{error}");
        let limits = ScheduleLimits { linear_speed: Some(bad), ..qb::kinematic() };
        assert!(matches!(Scheduler::new(&arm, limits), Err(PlanError::Limit { what: "linear speed", .. })));
    }
    let scheduler = Scheduler::new(&arm, qb::kinematic()).expect("limits");
    for n in [0, 3, usize::MAX] {
        assert!(matches!(scheduler.with_intervals(n), Err(PlanError::Intervals { .. })));
    }
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(scheduler.with_end_speeds(0.0, bad), Err(PlanError::Feed(_))));
    }
    let path = line(1.0);
    let plan = scheduler.plan(&path, SpeedPlanner::Certified).expect("a plan");
    assert!(plan.sampler(0.0).is_err() && plan.sampler(f64::NAN).is_err() && plan.check(0).is_err());
    // Infinite limits are none; without any there is no fastest motion.
    let free = ScheduleLimits { velocity: Some(Joints::repeat(f64::INFINITY)), ..Default::default() };
    let error = Scheduler::new(&arm, free).expect("limits").plan(&path, SpeedPlanner::BothEnds).expect_err("unbounded");
    assert!(matches!(error, PlanError::Feed(FeedError::Unbounded { .. })), "{error}");
}

#[test]
fn what_is_missing_is_named() {
    let arm = qb::arm();
    let path = line(1.0);
    let error = Scheduler::new(&arm, qb::with_torque()).expect("limits").plan(&path, SpeedPlanner::BothEnds);
    assert!(
        error.expect_err("no dynamics").to_string().contains("the dynamics of the arm is needed for limits on torque")
    );
    let error = Scheduler::new(&arm, qb::kinematic()).expect("limits").plan(&path, SpeedPlanner::JerkLimited);
    assert!(error.expect_err("no jerk").to_string().contains("a jerk limit of the joints is needed"));
}

#[test]
fn a_torque_that_cannot_hold_the_arm_names_place_joint_and_row() {
    let arm = qb::arm();
    let dynamics = arm.dynamics().expect("known");
    let heavy = Inertial::new(40.0, Vector3::new(0.0, 0.0, 0.1), Matrix3::identity() * 0.1).expect("a body");
    let loaded = dynamics.with_payload(heavy).expect("a payload");
    let path = ArmMotion::new(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let scheduler = Scheduler::new(&arm, qb::with_torque()).expect("limits").with_dynamics(&loaded);
    let error = scheduler.plan(&path, SpeedPlanner::BothEnds).expect_err("too heavy");
    let PlanError::Feed(FeedError::StaticallyInfeasible { s, row, value, limit, .. }) = error else {
        panic!("{error}")
    };
    assert_eq!(row.quantity, Quantity::JointTorque);
    assert!(value.abs() > limit.abs() && (0.0..=path.end()).contains(&s));
    let text = error.to_string();
    assert!(text.contains("torque of joint") && text.contains("at s ="), "{text}");
    for planner in [SpeedPlanner::Reachability, SpeedPlanner::Certified] {
        assert!(scheduler.plan(&path, planner).is_err(), "{}", planner.name());
    }
}

#[test]
fn speeds_that_cannot_be_had_at_the_ends_are_refused() {
    let arm = qb::arm();
    let path = ArmMotion::new(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let scheduler = Scheduler::new(&arm, qb::kinematic()).expect("limits").with_end_speeds(5.0, 0.0).expect("a speed");
    for planner in [SpeedPlanner::BothEnds, SpeedPlanner::Reachability, SpeedPlanner::Certified] {
        let error = scheduler.plan(&path, planner).expect_err("too fast").to_string();
        assert!(error.contains("start speed 5"), "{error}");
    }
}

#[test]
fn a_motion_out_of_reach_or_into_a_singular_pose_names_the_place() {
    let arm = models::cr7();
    let q = Joints::from([0.3, -0.4, 1.5, 0.4, -1.5, 0.2]);
    let start = arm.forward(&q);
    let mut goal = start;
    goal.translation.x += 2.0;
    let path =
        ArmMotion::new(&arm, PoseMotion::new(&start, &goal).expect("a motion"), &q).expect("its start is in reach");
    let limits = ScheduleLimits { velocity: Some(Joints::repeat(1.0)), ..Default::default() };
    let error =
        Scheduler::new(&arm, limits).expect("limits").plan(&path, SpeedPlanner::Certified).expect_err("too far");
    let PlanError::OnPath { s, parameter: ScheduleParameter::ArcLength, source } = &error else { panic!("{error}") };
    assert!((0.0..2.0).contains(s) && *s > 0.1, "{s}");
    assert!(matches!(source, KinematicsError::Unreachable { .. } | KinematicsError::Singular { .. }), "{source}");
    // Turning the wrist through its singular pose.
    let far = Isometry3::translation(9.0, 0.0, 0.0);
    let motion = PoseMotion::new(&far, &Isometry3::translation(9.0, 0.0, 1.0)).expect("a motion");
    assert!(matches!(ArmMotion::new(&arm, motion, &q), Err(PlanError::OnPath { s: 0.0, .. })));
    let range = *arm.range();
    assert!(matches!(ArmMotion::from_best_start(&arm, motion, &range), Err(PlanError::OnPath { .. })));
}

#[test]
fn the_best_start_is_one_that_gets_to_the_goal() {
    let arm = qb::arm();
    for motion in [qb::po(), qb::to()] {
        let path = ArmMotion::from_best_start(&arm, motion, arm.range()).expect("the paper's motions are in reach");
        let schedule = Scheduler::new(&arm, qb::kinematic()).expect("limits").plan(&path, SpeedPlanner::Certified);
        let schedule = schedule.expect("a plan");
        for jet in schedule.nodes() {
            assert!(arm.range().contains(&jet.q), "{}", jet.q);
            let there = arm.forward(&jet.q);
            assert!((there.translation.vector - motion.pose(jet.s).translation.vector).norm() < 1e-12);
            assert!(there.rotation.angle_to(&motion.pose(jet.s).rotation) < 1e-7);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// From any configuration a short way to anywhere: refused with a reason, or kept on dense samples.
    #[test]
    fn random_motions_keep_their_limits_or_are_refused(
        q in prop::array::uniform6(-1.5..1.5f64), shift in prop::array::uniform3(-0.2..0.2f64),
        turn in prop::array::uniform3(-1.0..1.0f64), still in 0..3u8,
    ) {
        let arm = models::cr7();
        let q = Joints::from(q);
        let start = arm.forward(&q);
        let shift = if still == 1 { Vector3::zeros() } else { Vector3::from(shift) };
        let turn = if still == 2 { Vector3::zeros() } else { Vector3::from(turn) };
        let goal = Isometry3::from_parts((start.translation.vector + shift).into(), UnitQuaternion::new(turn) * start.rotation);
        let motion = PoseMotion::new(&start, &goal).expect("a motion");
        let Ok(path) = ArmMotion::new(&arm, motion, &q) else { return Ok(()) };
        let limits = ScheduleLimits {
            velocity: Some(Joints::repeat(3.0)), acceleration: Some(Joints::repeat(10.0)),
            linear_speed: Some(0.4), angular_speed: Some(1.5), ..Default::default()
        };
        let scheduler = Scheduler::new(&arm, limits).expect("limits");
        match scheduler.plan(&path, SpeedPlanner::Certified) {
            Ok(schedule) => {
                let check = schedule.check(20).expect("where it was planned");
                prop_assert!(check.worst_ratio() <= 1.0 + 1e-3, "{:?} of {}", check.worst(), schedule.duration());
                prop_assert!(schedule.duration().is_finite() && schedule.duration() > 0.0);
                let tool = RowSource::path(Quantity::LinearSpeed);
                prop_assert!(check.of(tool).is_some_and(|tool| tool.ratio <= 1.0 + 1e-9));
            }
            Err(error) => prop_assert!(matches!(error, PlanError::OnPath { .. }), "{error}"),
        }
    }

    /// Through random way-points with torque (friction included) and jerk limited: a motion that keeps everything and does not
    /// crawl.
    #[test]
    fn random_way_points_keep_torque_and_jerk(
        points in prop::collection::vec(prop::array::uniform6(-1.0..1.0f64), 2..6),
        strength in 0.8..2.0f64, jerk in 60.0..500.0f64,
    ) {
        let arm = qb::arm();
        let centre = Joints::from([0.0, -1.1, 1.5, 0.0, 0.9, 0.0]);
        let points: Vec<Joints<6>> = points.into_iter().map(|p| centre + Joints::from(p) * 0.5).collect();
        let path = JointSpline::through(&points).expect("random points differ");
        let limits = ScheduleLimits {
            velocity: Some(Joints::repeat(2.0)), acceleration: Some(Joints::repeat(12.0)), jerk: Some(Joints::repeat(jerk)),
            torque: Some(Joints::from([150.0, 150.0, 80.0, 30.0, 25.0, 20.0]) * strength), ..Default::default()
        };
        let scheduler = Scheduler::new(&arm, limits).expect("limits").with_dynamics(arm.dynamics().expect("known"));
        let scheduler = scheduler.with_intervals(200).expect("a grid");
        let scan = scheduler.plan(&path, SpeedPlanner::BothEnds).expect("a plan").duration();
        for planner in [SpeedPlanner::Certified, SpeedPlanner::JerkLimited] {
            let schedule = scheduler.plan(&path, planner).expect("a plan");
            let check = schedule.check(20).expect("where it was planned");
            prop_assert!(check.worst_ratio() <= 1.0 + 1e-5, "{} {:?}", planner.name(), check.worst());
            prop_assert!(schedule.duration() < 3.0 * scan, "{}: {} {scan}", planner.name(), schedule.duration());
        }
    }
}
