//! What a planner refuses, and that it says where and why; random motions either keep their limits or are refused.

use crate::qb;

use arcfeed_geometry::PoseMotion;
use arcfeed_interp::{
    Infeasibility, JointSpline, LimitError, LimitId, Limits, Method, MotionPath, PathError, PathParameter, PlanError,
    Planner, PoseMove, Quantity, SpeedError, ToolLimits,
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
    assert_eq!(JointSpline::<2>::through(&[]).expect_err("none"), PathError::TooFewWaypoints { count: 0 });
    assert_eq!(JointSpline::through(&[p(1.0)]).expect_err("one"), PathError::TooFewWaypoints { count: 1 });
    let error = JointSpline::through(&[p(0.0), p(1.0), p(1.0), p(2.0)]).expect_err("twice the same");
    assert!(matches!(error, PathError::Waypoint { index: 2, .. }), "{error}");
    assert!(error.to_string().contains("way-point 3 repeats"), "{error}");
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        let error = JointSpline::through(&[p(0.0), Joints::<2>::new(0.0, bad)]).expect_err("no number");
        assert!(matches!(error, PathError::Waypoint { index: 1, .. }) && error.to_string().contains("joint 2"));
    }
}

#[test]
fn limits_and_settings_are_checked() {
    let arm = qb::arm();
    for bad in [0.0, -1.0, f64::NAN] {
        let mut velocity = Joints::repeat(1.0);
        velocity[3] = bad;
        let error = arm.range().with_rates(velocity, Joints::repeat(1.0), Joints::repeat(1.0));
        let error = error.expect_err("no limit").to_string();
        assert!(error.contains("joint 4") && error.contains("velocity"), "{error}");
        let mut torque = Joints::from(qb::TORQUE);
        torque[3] = bad;
        let error = qb::kinematic(&arm).with_torque(arm.dynamics().expect("known"), torque).expect_err("no limit");
        let error = error.to_string();
        assert!(error.contains("joint 4") && error.contains("torque"), "{error}");
        assert!(matches!(ToolLimits::new().with_feed(bad), Err(LimitError::NotPositive { what: "feed rate", .. })));
        let planner = Planner::new(&arm, qb::kinematic(&arm));
        let refused = planner.clone().with_period(bad);
        assert!(matches!(refused, Err(LimitError::NotPositive { what: "control period", .. })));
        let refused = planner.with_chord_tolerance(bad);
        assert!(matches!(refused, Err(LimitError::NotPositive { what: "chord tolerance", .. })));
    }
    let planner = Planner::new(&arm, qb::kinematic(&arm)).with_method(Method::InterpolatedReachability);
    for n in [0, 3, usize::MAX] {
        assert!(matches!(planner.clone().with_intervals(n), Err(LimitError::Intervals { .. })));
    }
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        let refused = planner.clone().with_end_speeds(0.0, bad);
        assert!(matches!(refused, Err(PlanError::Speed(SpeedError::Feed(_)))));
    }
    let path = line(0.5);
    let plan = planner.plan(&path).expect("a plan");
    assert!(plan.setpoints(0.0).is_err() && plan.setpoints(f64::NAN).is_err());
}

#[test]
fn limits_that_mean_nothing_on_a_path_are_named() {
    let arm = qb::arm();
    let path = line(0.5);
    type With = fn(ToolLimits, f64) -> Result<ToolLimits, LimitError>;
    let without_meaning: [(&str, With); 4] = [
        ("tangential acceleration", ToolLimits::with_tangential_acceleration),
        ("tangential jerk", ToolLimits::with_tangential_jerk),
        ("normal acceleration", ToolLimits::with_normal_acceleration),
        ("normal jerk", ToolLimits::with_normal_jerk),
    ];
    for (name, with) in without_meaning {
        let tool = with(ToolLimits::new(), 1.0).expect("valid");
        let error = Planner::new(&arm, qb::kinematic(&arm).with_tool(tool)).plan(&path).expect_err("no meaning");
        let PlanError::Limit(LimitError::Unsuited { limit, .. }) = error else { panic!("{error}") };
        assert_eq!(limit, name);
    }
}

#[test]
fn a_torque_that_cannot_hold_the_arm_names_place_joint_and_row() {
    let arm = qb::arm();
    let dynamics = arm.dynamics().expect("known");
    let heavy = Inertial::new(40.0, Vector3::new(0.0, 0.0, 0.1), Matrix3::identity() * 0.1).expect("a body");
    let loaded = dynamics.with_payload(heavy).expect("a payload");
    let path = PoseMove::starting_near(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let limits = qb::kinematic(&arm).with_torque(&loaded, Joints::from(qb::TORQUE)).expect("limits");
    let planner = Planner::new(&arm, limits);
    let error = planner.clone().with_method(Method::ForwardBackward).plan(&path).expect_err("too heavy");
    let text = error.to_string();
    let PlanError::Speed(SpeedError::Infeasible { place, row, why, value, limit }) = error else { panic!("{error}") };
    assert_eq!((row.quantity, why), (Quantity::JointTorque, Infeasibility::AtRest));
    assert!(value.abs() > limit.abs() && (0.0..=path.length()).contains(&place.s));
    assert!(text.contains("torque of joint") && text.contains("at s ="), "{text}");
    for method in Method::ALL {
        assert!(planner.clone().with_method(method).plan(&path).is_err(), "{method}");
    }
}

#[test]
fn speeds_that_cannot_be_had_at_the_ends_are_refused() {
    let arm = qb::arm();
    let path = PoseMove::starting_near(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let planner = Planner::new(&arm, qb::kinematic(&arm)).with_end_speeds(5.0, 0.0).expect("a speed");
    for method in [Method::ForwardBackward, Method::Reachability, Method::InterpolatedReachability] {
        let error = planner.clone().with_method(method).plan(&path).expect_err("too fast");
        assert!(matches!(error, PlanError::Speed(SpeedError::EndSpeed { .. })), "{error}");
        assert!(error.to_string().contains("start speed 5"), "{error}");
    }
}

#[test]
fn a_motion_out_of_reach_or_into_a_singular_pose_names_the_place() {
    let arm = models::cr7();
    let q = Joints::from([0.3, -0.4, 1.5, 0.4, -1.5, 0.2]);
    let start = arm.forward(&q);
    let mut goal = start;
    goal.translation.x += 2.0;
    let path = PoseMove::starting_near(&arm, PoseMotion::new(&start, &goal).expect("a motion"), &q);
    let path = path.expect("its start is in reach");
    let limits = arm.range().with_rates(Joints::repeat(1.0), Joints::repeat(qb::FREE), Joints::repeat(qb::FREE));
    let planner = Planner::new(&arm, Limits::new(limits.expect("limits")));
    let error = planner.with_method(Method::InterpolatedReachability).plan(&path).expect_err("too far");
    let PlanError::Path(PathError::Arm { place, source }) = &error else { panic!("{error}") };
    assert_eq!(place.parameter, PathParameter::ArcLength);
    assert!((0.0..2.0).contains(&place.s) && place.s > 0.1, "{place}");
    let tool = place.tool.expect("a pose move");
    assert!((tool[0] - start.translation.x - place.s).abs() < 1e-9, "{place}");
    assert!(matches!(source, KinematicsError::Unreachable { .. } | KinematicsError::Singular { .. }), "{source}");
    // Turning the wrist through its singular pose.
    let far = Isometry3::translation(9.0, 0.0, 0.0);
    let motion = PoseMotion::new(&far, &Isometry3::translation(9.0, 0.0, 1.0)).expect("a motion");
    let at_the_start = |refused: Result<PoseMove<'_>, PathError>| {
        let error = refused.expect_err("out of reach");
        assert!(matches!(&error, PathError::Arm { place, .. } if place.s == 0.0), "{error}");
    };
    at_the_start(PoseMove::starting_near(&arm, motion, &q));
    at_the_start(PoseMove::new(&arm, motion, arm.range()));
}

#[test]
fn the_best_start_is_one_that_gets_to_the_goal() {
    let arm = qb::arm();
    for motion in [qb::po(), qb::to()] {
        let path = PoseMove::new(&arm, motion, arm.range()).expect("the paper's motions are in reach");
        let planner = Planner::new(&arm, qb::kinematic(&arm)).with_method(Method::InterpolatedReachability);
        let plan = planner.plan(&path).expect("a plan");
        for jet in plan.joint_path().nodes() {
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
        let Ok(path) = PoseMove::starting_near(&arm, motion, &q) else { return Ok(()) };
        let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(qb::FREE));
        let tool = ToolLimits::new().with_feed(0.4).and_then(|t| t.with_angular_speed(1.5)).expect("limits");
        let limits = Limits::new(joints.expect("limits")).with_tool(tool);
        let planner = Planner::new(&arm, limits).with_method(Method::InterpolatedReachability);
        match planner.plan(&path) {
            Ok(plan) => {
                let check = plan.verification();
                prop_assert!(check.holds(1e-6), "{:?} of {}", check.worst(), plan.duration());
                prop_assert!(plan.duration().is_finite() && plan.duration() > 0.0);
                let tool = LimitId::path(Quantity::Feed);
                prop_assert!(check.of(tool).is_some_and(|tool| tool.ratio <= 1.0 + 1e-9), "{:?}", check.of(tool));
            }
            Err(error) => prop_assert!(matches!(error, PlanError::Path(PathError::Arm { .. } | PathError::BranchChange { .. } | PathError::JointRange { .. })), "{error}"),
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
        let torque = Joints::from([150.0, 150.0, 80.0, 30.0, 25.0, 20.0]) * strength;
        let joints = arm.range().with_rates(Joints::repeat(2.0), Joints::repeat(12.0), Joints::repeat(jerk));
        let limits = Limits::new(joints.expect("limits")).with_torque(arm.dynamics().expect("known"), torque);
        let planner = Planner::new(&arm, limits.expect("limits")).with_intervals(200).expect("a grid");
        let plan = |method| planner.clone().with_method(method).plan(&path).expect("a plan");
        let scan = plan(Method::ForwardBackward).duration();
        for method in [Method::InterpolatedReachability, Method::JerkLimited] {
            let plan = plan(method);
            let check = plan.verification();
            prop_assert!(check.holds(1e-6), "{method} {:?}", check.worst());
            prop_assert!(plan.duration() < 3.0 * scan, "{method}: {} {scan}", plan.duration());
        }
    }
}

#[test]
fn a_path_of_another_arm_is_refused_before_it_is_planned() {
    let (ours, other) = (qb::arm(), models::ur5e());
    let path = PoseMove::starting_near(&ours, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let joints = other.range().with_rates(Joints::repeat(1.0), Joints::repeat(3.0), Joints::repeat(40.0));
    let error = Planner::new(&other, Limits::new(joints.expect("valid"))).plan(&path).expect_err("another arm");
    let text = error.to_string();
    assert!(matches!(error, PlanError::Limit(LimitError::Unsuited { .. })), "{text}");
    assert!(text.contains("another arm") && text.contains("same arm"), "{text}");
}

#[test]
fn a_way_point_at_the_very_end_of_a_range_is_inside_and_one_beyond_is_refused() {
    let arm = models::ur5e();
    let (lower, upper) = (*arm.range().lower(), *arm.range().upper());
    let joints = arm.range().with_rates(Joints::repeat(2.0), Joints::repeat(8.0), Joints::repeat(80.0)).expect("valid");
    let planner = Planner::new(&arm, Limits::new(joints));
    // Thirds of the range: the end of the line is rounded.
    for share in [0.1, 1.0 / 3.0, 0.7] {
        let from = lower + (upper - lower) * share;
        for end in [lower, upper] {
            let path = JointSpline::through(&[from, end]).expect("two points");
            let trajectory = planner.plan(&path).expect("inside the range");
            assert!(trajectory.verification().holds(1e-6));
        }
    }
    let beyond = JointSpline::through(&[lower * 0.5, upper + Joints::repeat(1e-6)]).expect("two points");
    let error = planner.plan(&beyond).expect_err("beyond the range");
    assert!(matches!(error, PlanError::Path(PathError::JointRange { joint: 0, .. })), "{error}");
}

#[test]
fn laws_of_others_are_rounded_to_whole_cycles_where_that_is_asked_for() {
    let arm = models::ur5e();
    let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0));
    let path = line(0.5);
    let exact = Planner::new(&arm, Limits::new(joints.expect("limits"))).with_period(0.05).expect("a period");
    let whole = exact.clone().with_whole_cycles();
    let law = exact.plan(&path).expect("a motion").law().clone();
    let finish = |planner: &Planner<'_>| {
        let problem = planner.prepare(&path, Method::JerkLimited.needs()).expect("a grid");
        planner.finish(problem, law.clone(), true).map(|motion| motion.duration() / 0.05)
    };
    let (shortest, rounded) = (finish(&exact).expect("keeps its limits"), finish(&whole).expect("is slower"));
    assert!(shortest.fract() > 1e-3 && (rounded - shortest.ceil()).abs() < 1e-9, "{shortest} {rounded}");
    let moving = whole.clone().with_end_speeds(0.0, 0.1).expect("speeds");
    let error = finish(&moving).expect_err("an end in motion");
    assert!(matches!(error, PlanError::Limit(LimitError::Unsuited { .. })), "{error}");
    // A law of another path is refused as such.
    let other = line(0.7);
    let problem = whole.prepare(&other, Method::JerkLimited.needs()).expect("a grid");
    let error = whole.finish(problem, law.clone(), true).expect_err("too short");
    assert!(matches!(error, PlanError::Limit(LimitError::Law { .. })), "{error}");
}
