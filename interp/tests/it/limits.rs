//! Limits along the path against closed forms: feed by section, speeds at the ends, torque, angular speed of the tool.

use crate::common;

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::sync::Arc;

use arcfeed_feedrate::{Segment, plan_per_segment};
use arcfeed_geometry::{NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Extent, FeedSection, Infeasibility, LimitError, Limits, Method, MotionPath, PathEnd, PlanError, Planner, Quantity,
    RowsNeeded, SpeedError, ToolLimits, ToolPath, Trajectory,
};
use arcfeed_kinematics::{ArmDynamics, Friction, Inertial, JointLimits, Joints, ParallelAxisArm};
use common::{
    FEED, TANGENTIAL_ACCELERATION, TANGENTIAL_JERK, arm, by_length, down, knotted, limits, line_and_arc, tool,
    tool_down, tool_with_feed,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3, vector};

const LENGTH: f64 = 0.3;

/// A level line in front of the arm.
fn line() -> NurbsCurve<3> {
    NurbsCurve::line(vector![0.40, -0.15, 0.25], vector![0.40, -0.15 + LENGTH, 0.25]).expect("a line")
}

/// Joints that never matter.
fn free(arm: &ParallelAxisArm) -> JointLimits<6> {
    arm.range().with_rates(Joints::repeat(1e3), Joints::repeat(1e4), Joints::repeat(1e6)).expect("valid limits")
}

fn planner(arm: &ParallelAxisArm, tool: ToolLimits) -> Planner<'_> {
    with_limits(arm, Limits::new(free(arm)).with_tool(tool))
}

fn with_limits<'a>(arm: &'a ParallelAxisArm, limits: Limits<'a>) -> Planner<'a> {
    let planner = Planner::new(arm, limits).with_period(2e-3).and_then(|p| p.with_chord_tolerance(1e-5));
    planner.expect("valid")
}

fn plan<'a>(planner: &Planner<'a>, arm: &'a ParallelAxisArm, path: PosePath) -> Result<Trajectory<'a>, PlanError> {
    planner.plan_shared(Arc::new(ToolPath::new(arm, path, arm.range())?))
}

fn worst_of(plan: &Trajectory<'_>, quantity: Quantity) -> arcfeed_interp::Check {
    plan.verification().worst_of(quantity).expect("looked at")
}

/// Time and distance of a change of speed with the tool's tangential limits: the trapezium or triangle of acceleration.
fn change(v0: f64, v1: f64) -> (f64, f64) {
    let (a, j) = (TANGENTIAL_ACCELERATION, TANGENTIAL_JERK);
    let dv = (v1 - v0).abs();
    let t = if dv > a * a / j { dv / a + a / j } else { 2.0 * (dv / j).sqrt() };
    (t, 0.5 * (v0 + v1) * t)
}

/// The least time over stretches of the given lengths at the given speeds, where each change of speed is done on the side of the
/// faster one.
fn least_time(stretches: &[(f64, f64)], v_start: f64, v_end: f64, change: impl Fn(f64, f64) -> (f64, f64)) -> f64 {
    let mut left: Vec<f64> = stretches.iter().map(|s| s.0).collect();
    let speeds: Vec<f64> =
        std::iter::once(v_start).chain(stretches.iter().map(|s| s.1)).chain(std::iter::once(v_end)).collect();
    let mut time = 0.0;
    for (i, pair) in speeds.windows(2).enumerate() {
        let (t, distance) = change(pair[0], pair[1]);
        time += t;
        // Border i lies before stretch i.
        let faster = if i == 0 || (i < left.len() && pair[1] > pair[0]) { i } else { i - 1 };
        left[faster] -= distance;
    }
    assert!(left.iter().all(|&l| l > 0.0), "a stretch is too short for its changes of speed: {left:?}");
    time + left.iter().zip(stretches).map(|(left, s)| left / s.1).sum::<f64>()
}

fn near_optimum(plan: &Trajectory<'_>, least: f64) {
    let ratio = plan.duration() / least;
    assert!(ratio > 1.0 - 1e-6 && ratio < 1.005, "{} s against {least} s, {}", plan.duration(), plan.info());
}

fn section(from: f64, to: f64, feed: f64) -> FeedSection {
    FeedSection { extent: Extent::Length { from, to }, feed }
}

#[test]
fn feed_by_section_takes_the_time_of_its_profiles() {
    let arm = arm();
    // Slower, back to the feed, faster, and to rest from there.
    let sections = vec![section(0.2, LENGTH, 0.3), section(0.05, 0.12, 0.05)];
    let planner = planner(&arm, tool_with_feed(0.15));
    let stretches = [(0.05, 0.15), (0.07, 0.05), (0.08, 0.15), (0.1, 0.3)];
    let least = least_time(&stretches, 0.0, 0.0, change);
    let without_jerk = least_time(&stretches, 0.0, 0.0, |v0, v1| {
        let t = (v1 - v0).abs() / TANGENTIAL_ACCELERATION;
        (t, 0.5 * (v0 + v1) * t)
    });
    for method in [Method::JerkLimited, Method::ContinuousAcceleration] {
        let plan = plan(&planner.clone().with_method(method).with_sections(sections.clone()), &arm, tool_down(line()))
            .expect("in reach");
        if method == Method::JerkLimited {
            // Its changes of speed reach into the slower stretch, so that it takes less; but no less than without a limit on jerk.
            assert!(plan.duration() < 1.001 * least && plan.duration() > without_jerk, "{} s", plan.duration());
        } else {
            near_optimum(&plan, least);
        }
        let check = worst_of(&plan, Quantity::Feed);
        assert!(check.ratio > 0.9999 && check.ratio <= 1.0 + 1e-6, "{check:?}");
        // The borders are on the grid, and the limit curve shows the sections.
        for (s, feed) in [(0.02, 0.15), (0.06, 0.05), (0.11, 0.05), (0.16, 0.15), (0.25, 0.3)] {
            let curve = plan.limit_curve().expect("finite");
            let cap = curve.into_iter().take_while(|c| c.s <= s).last().expect("on the path").speed;
            assert!((cap - feed).abs() < 1e-12, "{cap} at {s}, {:?}", plan.info());
            assert!(plan.law().v_at_s(s) <= feed * (1.0 + 1e-9));
        }
        assert_eq!(plan.sections().len(), 2);
        assert!((plan.sections()[0].from - 0.05).abs() < 1e-9);
    }
}

#[test]
fn sections_by_parameter_and_by_segment_are_the_same_places() {
    let arm = arm();
    let planner = planner(&arm, tool());
    let path = tool_down(knotted());
    let plain = plan(&planner, &arm, path.clone()).expect("in reach");
    let (first, last) = (3, plain.breaks().len() - 4);
    let (from, to) = (plain.breaks()[first - 1], plain.breaks()[last]);
    let u = |k: usize| plain.segmentation().expect("a curve").breaks()[k];
    let mut durations = Vec::new();
    for extent in [
        Extent::Length { from, to },
        Extent::Parameter { from: u(first - 1), to: u(last) },
        Extent::Segments { first, last },
    ] {
        let planner = planner.clone().with_sections(vec![FeedSection { extent, feed: 0.1 }]);
        let plan = plan(&planner, &arm, path.clone()).expect("in reach");
        assert!((plan.sections()[0].from - from).abs() < 1e-9 && (plan.sections()[0].to - to).abs() < 1e-9);
        durations.push(plan.duration());
    }
    assert!(durations[0] > plain.duration() && durations.iter().all(|d| (d / durations[0] - 1.0).abs() < 1e-6));
}

#[test]
fn sections_off_the_path_are_refused() {
    let arm = arm();
    let wrong = |sections: Vec<FeedSection>| {
        plan(&planner(&arm, tool()).with_sections(sections), &arm, tool_down(line()))
            .expect_err("not on the path")
            .to_string()
    };
    for (extent, words) in [
        (Extent::Length { from: 0.2, to: 0.1 }, "begin before it ends"),
        (Extent::Length { from: -0.1, to: 0.1 }, "on the path"),
        (Extent::Length { from: f64::NAN, to: 0.1 }, "on the path"),
        (Extent::Length { from: 0.1, to: 0.4 }, "0.1 to 0.4 m of arc length"),
        (Extent::Parameter { from: 0.5, to: 1.5 }, "domain"),
        (Extent::Segments { first: 0, last: 1 }, "count from 1"),
        (Extent::Segments { first: 1, last: 2000 }, "exist at this chord tolerance"),
    ] {
        let text = wrong(vec![section(0.0, 0.01, 0.1), FeedSection { extent, feed: 0.1 }]);
        assert!(text.contains("section 2") && text.contains(words), "{text}");
    }
    let text = wrong(vec![section(0.1, 0.2, 0.1), section(0.0, 0.15, 0.1)]);
    assert!(text.contains("sections 2 and 1 overlap at s = 0.100000"), "{text}");
    assert!(wrong(vec![section(0.1, 0.2, 0.0)]).contains("feed of a section is 0"));
}

#[test]
fn speeds_at_the_ends_take_the_time_of_their_profile() {
    let arm = arm();
    for (v_start, v_end) in [(0.08, 0.0), (0.0, 0.12), (0.05, 0.2)] {
        for method in [Method::JerkLimited, Method::ContinuousAcceleration] {
            let planner =
                planner(&arm, tool()).with_method(method).with_end_speeds(v_start, v_end).expect("not negative");
            let plan = plan(&planner, &arm, tool_down(line())).expect("in reach");
            near_optimum(&plan, least_time(&[(LENGTH, FEED)], v_start, v_end, change));
            let (first, last) = (plan.law().v_at_s(0.0), plan.law().v_at_s(LENGTH));
            assert!((first - v_start).abs() < 1e-9 && (last - v_end).abs() < 1e-9, "{first} {last}");
            assert!(worst_of(&plan, Quantity::Ends).ratio <= 1.0);
        }
    }
}

#[test]
fn speeds_at_the_ends_that_cannot_be_had_are_explained() {
    let arm = arm();
    let ask = |v_start: f64, v_end: f64, sections: Vec<FeedSection>, method| {
        let planner = planner(&arm, tool()).with_method(method).with_sections(sections);
        plan(&planner.with_end_speeds(v_start, v_end)?, &arm, tool_down(line()))
    };
    for method in [Method::JerkLimited, Method::ContinuousAcceleration] {
        // Faster than the feed.
        for (v_start, v_end, word) in [(0.25, 0.0, "start speed 0.25"), (0.0, 0.25, "end speed 0.25")] {
            let error = ask(v_start, v_end, vec![], method).expect_err("above the feed");
            let PlanError::Speed(SpeedError::EndSpeed { highest, .. }) = error else { panic!("{error}") };
            assert!((highest - FEED).abs() < 1e-6, "{highest}");
            assert!(error.to_string().contains(word), "{error}");
        }
        // From 0.2 to 0.02 m/s takes 0.013 m with the tool's acceleration alone; only 5 mm are given. The highest speed by v^2 =
        // 0.02^2 + 2 a s is 0.102 without jerk, less with it.
        let error = ask(0.2, 0.0, vec![section(0.005, 0.1, 0.02)], method).expect_err("too fast");
        let PlanError::Speed(SpeedError::EndSpeed { end: PathEnd::Start, highest, .. }) = error else {
            panic!("{error}")
        };
        assert!(highest > 0.02 && highest < 0.1020, "{highest}");
    }
    let windowed = Method::PerSegment { window: Some(5) };
    assert!(matches!(ask(0.0, 0.1, vec![], windowed), Err(PlanError::Speed(SpeedError::WindowEndSpeed { .. }))));
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            ask(bad, 0.0, vec![], Method::ContinuousAcceleration),
            Err(PlanError::Speed(SpeedError::Feed(_)))
        ));
        assert!(matches!(
            ask(0.0, bad, vec![], Method::ContinuousAcceleration),
            Err(PlanError::Speed(SpeedError::Feed(_)))
        ));
    }
}

#[test]
fn a_tool_that_turns_evenly_is_as_fast_as_its_angular_speed_allows() {
    let arm = arm();
    let angle = 1.2;
    let turned = down() * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let path = || PosePath::new(by_length(line()), OrientationPath::slerp(LENGTH, down(), turned).expect("two ends"));
    // One radian takes a quarter of a metre: 0.32 rad/s are 0.08 m/s.
    let turning = tool().with_angular_speed(0.32).expect("valid");
    let least = least_time(&[(LENGTH, 0.32 * LENGTH / angle)], 0.0, 0.0, change);
    for method in [Method::JerkLimited, Method::ContinuousAcceleration] {
        let plan = plan(&planner(&arm, turning).with_method(method), &arm, path()).expect("in reach");
        near_optimum(&plan, least);
        let check = worst_of(&plan, Quantity::AngularSpeed);
        assert_eq!(check.quantity(), Quantity::AngularSpeed);
        assert!(check.ratio > 0.999 && (check.value - 0.32).abs() < 1e-3, "{check:?}");
    }
    // The check is its own: the same motion without the limit breaks it.
    let unlimited = plan(&planner(&arm, tool()), &arm, path()).expect("in reach");
    let check = planner(&arm, turning).verify(unlimited.problem(), unlimited.law(), true).expect("on the path");
    let check = check.worst_of(Quantity::AngularSpeed).expect("looked at");
    assert!((check.value - FEED * angle / LENGTH).abs() < 1e-3, "{check:?}");
    assert!(matches!(tool().with_angular_speed(0.0), Err(LimitError::NotPositive { .. })));
}

/// Between the plane in which the arm moves and the axis of its first joint, m (the maker's table).
const OFFSET: f64 = 0.1333;

/// How far a tool at a distance from the first axis is out from the second one.
fn reach(from_axis: f64) -> f64 {
    (from_axis * from_axis - OFFSET * OFFSET).sqrt()
}

/// An arm without mass that carries a point mass (kg) in its flange.
fn carrying(arm: &ParallelAxisArm, mass: f64) -> ArmDynamics<6> {
    let point = Inertial::new(mass, Vector3::zeros(), Matrix3::zeros()).expect("a point mass");
    let bare = ArmDynamics::new(arm.chain(), [Inertial::none(); 6]).expect("finite");
    bare.with_payload(point).expect("finite")
}

#[test]
fn holding_a_load_too_far_out_is_an_error_that_names_joint_and_place() {
    let arm = arm();
    let mass = 4.0;
    // Outwards along x: the torque of the shoulder is m g times the distance from its axis.
    let path = tool_down(NurbsCurve::line(vector![0.30, 0.0, 0.25], vector![0.55, 0.0, 0.25]).expect("a line"));
    let radius: f64 = 0.45;
    let most = mass * 9.81 * reach(radius);
    let dynamics = carrying(&arm, mass);
    let torque = Joints::from_fn(|k, _| if k == 1 { most } else { f64::INFINITY });
    for method in [Method::JerkLimited, Method::ContinuousAcceleration] {
        let limits = Limits::new(free(&arm)).with_tool(tool()).with_torque(&dynamics, torque).expect("above 0");
        let planner = with_limits(&arm, limits).with_method(method);
        let error = plan(&planner, &arm, path.clone()).expect_err("too heavy");
        let text = error.to_string();
        let PlanError::Speed(SpeedError::Infeasible { place, row, why, value, limit }) = error else {
            panic!("{error}")
        };
        let (s, position) = (place.s, place.tool.expect("a tool path"));
        assert_eq!((row.joint, why), (Some(1), Infeasibility::AtRest));
        // The first point of the grid beyond, of a hundred or more.
        assert!(s >= radius - 0.30 && s < radius - 0.30 + 0.0026, "{s}");
        assert!((value.abs() - mass * 9.81 * reach(position[0])).abs() < 1e-9 && (limit.abs() - most).abs() < 1e-9);
        for part in ["torque of joint 2", "N m", "tool at x 0.45", "carry less"] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}

#[test]
fn a_lift_is_as_quick_as_the_drives_allow() {
    let arm = arm();
    let mass = 4.0;
    // Straight up: the shoulder's torque is m (g + a) times the distance from its axis, which stays.
    let radius = 0.45;
    let path = || tool_down(NurbsCurve::line(vector![radius, 0.0, 0.15], vector![radius, 0.0, 0.45]).expect("a line"));
    let room = 0.5;
    let torque = Joints::from_fn(|k, _| if k == 1 { mass * (9.81 + room) * reach(radius) } else { f64::INFINITY });
    let dynamics = carrying(&arm, mass);
    let limits = Limits::new(free(&arm)).with_tool(tool()).with_torque(&dynamics, torque).expect("above 0");
    let limited = with_limits(&arm, limits);
    let lift = plan(&limited, &arm, path()).expect("in reach");
    assert_eq!(lift.info().method, Some(Method::JerkLimited));
    // Upwards the drive gives 0.5 m/s^2; slowing down gravity helps, so that the tool's own limit is what counts.
    let change = |dv: f64, a: f64| dv / a + a / TANGENTIAL_JERK;
    let (up, down) = (change(FEED, room), change(FEED, TANGENTIAL_ACCELERATION));
    let least = up + down + (0.3 - 0.5 * FEED * (up + down)) / FEED;
    near_optimum(&lift, least);
    let check = worst_of(&lift, Quantity::JointTorque);
    assert_eq!((check.quantity(), check.joint()), (Quantity::JointTorque, Some(1)));
    assert!(check.ratio > 0.999 && check.ratio <= 1.0 + 1e-6, "{check:?}");
    // The scan keeps it as well, by what its share of the acceleration leaves.
    let scanned = plan(&limited.clone().with_method(Method::ContinuousAcceleration), &arm, path()).expect("in reach");
    assert!(worst_of(&scanned, Quantity::JointTorque).ratio <= 1.0 + 1e-6);
    // Without the limit the motion is quicker, and the check says what that would take.
    let free = plan(&planner(&arm, tool()), &arm, path()).expect("in reach");
    assert!(free.duration() < lift.duration());
    let needs = limited.verify(free.problem(), free.law(), true).expect("on the path");
    let needs = needs.worst_of(Quantity::JointTorque).expect("looked at");
    let expected = (9.81 + TANGENTIAL_ACCELERATION) / (9.81 + room);
    assert!((needs.ratio - expected).abs() < 1e-3, "{needs:?}, {expected} expected");
}

#[test]
fn torque_with_friction_is_kept_on_a_winding_path() {
    let arm = arm();
    let friction = Friction::new(Joints::repeat(3.0), Joints::repeat(2.0), Joints::repeat(1.5)).expect("not negative");
    let dynamics = carrying(&arm, 6.0).with_friction(friction);
    let tool = tool_with_feed(0.3);
    let path = ToolPath::new(&arm, tool_down(knotted()), arm.range()).expect("in reach");
    let base = Limits::new(limits(&arm)).with_tool(tool);
    let under = |torque: Joints<6>, method| {
        let limits = base.with_torque(&dynamics, torque).expect("above 0");
        let planner = Planner::new(&arm, limits).with_period(2e-3).expect("valid").with_method(method);
        planner.plan(&path).expect("possible")
    };
    let fast = under(Joints::repeat(1e3), Method::JerkLimited);
    let peak = |joint: usize| {
        let mut checks = fast.verification().checks().iter();
        let found = checks.find(|c| c.quantity() == Quantity::JointTorque && c.joint() == Some(joint));
        found.expect("checked").value.abs()
    };
    // Two percent less than the fast motion takes; the most part of it is gravity.
    let torque = Joints::from_fn(|k, _| 0.98 * peak(k));
    for method in [Method::JerkLimited, Method::ContinuousAcceleration] {
        let plan = under(torque, method);
        let check = worst_of(&plan, Quantity::JointTorque);
        assert!(check.ratio <= 1.0 + 1e-6 && check.ratio > 0.97, "{check:?} {}", plan.info());
        assert!(plan.duration() > fast.duration());
        println!(
            "{method:?}: {} {:.4} s, without {:.4} s, {} rounds",
            plan.info(),
            plan.duration(),
            fast.duration(),
            plan.info().rounds
        );
    }
    assert!(matches!(base.with_torque(&dynamics, Joints::repeat(0.0)), Err(LimitError::Joint(_))));
}

#[test]
fn one_round_is_enough_where_the_arm_bends_the_path_most() {
    // Jerk of the joints binds all the way, whose third derivatives vary faster than the tool's.
    let arm = arm();
    let limits =
        arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(60.0)).expect("valid");
    let tool = tool().with_tangential_jerk(200.0).expect("valid");
    let path = ToolPath::new(&arm, tool_down(knotted()), limits.range()).expect("in reach");
    let plan = Planner::new(&arm, Limits::new(limits).with_tool(tool)).plan(&path).expect("in reach");
    let jerk = worst_of(&plan, Quantity::JointJerk);
    assert!(plan.info().rounds == 1 && plan.info().lowered.is_empty(), "{:?}", plan.info());
    assert!(jerk.ratio > 0.99 && jerk.ratio <= 1.0 + 1e-6, "{jerk:?}");
}

#[test]
fn a_plan_says_who_made_it() {
    let arm = arm();
    let smooth = plan(&planner(&arm, tool()), &arm, tool_down(knotted())).expect("in reach");
    assert_eq!((smooth.info().method, smooth.info().fallback), (Some(Method::JerkLimited), None));
    let asked = plan(&planner(&arm, tool()).with_method(Method::ContinuousAcceleration), &arm, tool_down(knotted()))
        .expect("in reach");
    assert_eq!((asked.info().method, asked.info().fallback), (Some(Method::ContinuousAcceleration), None));
}

/// At a jump of the curvature the joints' accelerations step. The planner slows down just enough for the step to fit into the jerk of one
/// control period, beside the jerk on either side.
#[test]
fn the_speed_dips_at_a_jump_of_curvature_as_far_as_the_jerk_asks_for() {
    let arm = arm();
    let planner = with_limits(&arm, Limits::new(limits(&arm)).with_tool(tool()));
    let by = |method| plan(&planner.clone().with_method(method), &arm, tool_down(line_and_arc(0.1, 0.05)));
    let planned = by(Method::JerkLimited).expect("in reach");
    let scanned = by(Method::ContinuousAcceleration).expect("in reach");
    println!("{} s, scanned {} s", planned.duration(), scanned.duration());
    assert_eq!((planned.info().method, planned.info().fallback), (Some(Method::JerkLimited), None));
    assert!(planned.duration() < 0.95 * scanned.duration(), "{} {}", planned.duration(), scanned.duration());
    // When the tool is there, by halving.
    let mut setpoints = planned.setpoints(planned.period()).expect("a period");
    let (mut low, mut high) = (0.0, planned.duration());
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        *(if setpoints.at(middle).expect("on the path").s < 0.1 { &mut low } else { &mut high }) = middle;
    }
    let mut at = |t: f64| setpoints.at(t).expect("on the path");
    let step = (at(high + 1e-12).qdd - at(low - 1e-12).qdd).abs();
    let most = planned.limits().joints().jerk() * planned.period();
    let used = step.component_div(&most).max();
    assert!(used <= 1.0 + 1e-6, "the step takes {used} of a period's jerk");
    // No slower than that: the step alone takes most of it.
    assert!(used > 0.9, "the step takes {used} of a period's jerk");
    // The limit curve shows it, and names the jerk.
    let curve = planned.limit_curve().expect("finite");
    let point = curve.iter().min_by(|a, b| (a.s - 0.1).abs().total_cmp(&(b.s - 0.1).abs())).expect("points");
    assert!(at(high).feed <= point.speed * (1.0 + 1e-6) && at(high).feed > 0.9 * point.speed, "{point:?}");
    assert_eq!(point.id.map(|id| id.quantity), Some(Quantity::JointJerk));
    let (before, after) = (at(high - 0.05).feed, at(high + 0.05).feed);
    assert!(at(high).feed < before.min(after), "no dip: {before}, {}, {after}", at(high).feed);
}

/// A controller sees the step of acceleration spread over one of its periods, whenever that begins: what is too much just after the
/// jump counts as much as what is too much just before it.
#[test]
fn jerk_just_after_a_jump_of_curvature_adds_to_its_step() {
    let arm = arm();
    let planner = with_limits(&arm, Limits::new(limits(&arm)).with_tool(tool()));
    // Away from the base and to the right, so that the shoulder turns one way for both.
    let (start, along, across) =
        (vector![0.35, -0.1, 0.2], vector![1.0, 1.0, 0.0] / SQRT_2, vector![1.0, -1.0, 0.0] / SQRT_2);
    let bend = start + along * 0.1;
    let points = vec![start, start + along * 0.05, bend, bend + along * 0.05, bend + (along + across) * 0.05];
    let weights = vec![1.0, 1.0, 1.0, FRAC_1_SQRT_2, 1.0];
    let curve =
        NurbsCurve::new(2, points, weights, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).expect("a valid curve");
    let planned = plan(&planner, &arm, tool_down(curve.clone())).expect("in reach");
    let at_jump = planned.limit_curve().expect("finite").into_iter().find(|point| (point.s - 0.1).abs() < 1e-12);
    let path = ToolPath::new(&arm, tool_down(curve), arm.range()).expect("in reach");
    let used = |part: f64, jerk: f64| {
        // Up to a part of the speed at which the step takes all, with no acceleration there, and on with a jerk at once.
        let v = part * at_jump.expect("a grid point").speed;
        let segments = [(0.1, v, 0.5, 10.0), (path.length() - 0.1, 1.5 * v, 0.5, jerk)];
        let segments: Vec<Segment> =
            segments.map(|(l, v, a, j)| Segment::new(l, v, a, j).expect("valid")).into_iter().collect();
        let law = plan_per_segment(&segments, 0.0, 0.0).expect("fits");
        let problem = planner.prepare(&path, RowsNeeded::Jerk).expect("in reach");
        let verification = planner.verify(&problem, &law, true).expect("runs over the path");
        verification.worst_of(Quantity::JointJerk).expect("looked at").ratio
    };
    let (step, both) = (used(0.9, 0.5), used(0.9, 30.0));
    assert!(step < 1.0 && step > 0.75, "the step alone: {step}");
    assert!(both > 1.05, "with jerk after it: {both}");
}
