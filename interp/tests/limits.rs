//! Limits along the path against closed forms: feed by section, speeds at the ends, torque, angular speed of the tool.

mod common;

use arcfeed_feedrate::Fallback;
use arcfeed_geometry::{NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Extent, FeedSection, Infeasibility, Method, Plan, PlanError, Planner, Quantity, Scan, ToolLimits, best_start,
};
use arcfeed_kinematics::{ArmDynamics, Friction, Inertial, JointLimits, Joints, ParallelAxisArm};
use common::{TOOL, arm, by_length, down, knotted, limits, line_and_arc, tool_down};
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

fn planner<'a>(arm: &'a ParallelAxisArm, tool: ToolLimits) -> Planner<'a, ParallelAxisArm> {
    let planner = Planner::new(arm, free(arm), tool).and_then(|p| p.with_period(2e-3)).expect("valid");
    planner.with_chord_tolerance(1e-5).expect("valid")
}

fn plan(planner: &Planner<'_, ParallelAxisArm>, arm: &ParallelAxisArm, path: PosePath) -> Result<Plan, PlanError> {
    let range = arm.range();
    let start = best_start(arm, &path, range.lower(), range.upper())?;
    planner.plan(path, &start)
}

/// Time and distance of a change of speed with the tool's tangential limits: the trapezium or triangle of acceleration.
fn change(v0: f64, v1: f64) -> (f64, f64) {
    let (a, j) = (TOOL.tangential_acceleration, TOOL.tangential_jerk);
    let dv = (v1 - v0).abs();
    let t = if dv > a * a / j { dv / a + a / j } else { 2.0 * (dv / j).sqrt() };
    (t, 0.5 * (v0 + v1) * t)
}

/// The least time over stretches of the given lengths at the given speeds, where each change of speed is done on the side of the
/// faster one.
fn least_time(stretches: &[(f64, f64)], v_start: f64, v_end: f64) -> f64 {
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

fn near_optimum(plan: &Plan, least: f64) {
    let ratio = plan.duration() / least;
    assert!(ratio > 1.0 - 1e-6 && ratio < 1.005, "{} s against {least} s, {}", plan.duration(), plan.made_by());
}

fn section(from: f64, to: f64, feed: f64) -> FeedSection {
    FeedSection { extent: Extent::Length { from, to }, feed }
}

#[test]
fn feed_by_section_takes_the_time_of_its_profiles() {
    let arm = arm();
    // Slower, back to the feed, faster, and to rest from there.
    let sections = vec![section(0.2, LENGTH, 0.3), section(0.05, 0.12, 0.05)];
    let planner = planner(&arm, ToolLimits { feed: 0.15, ..TOOL });
    let least = least_time(&[(0.05, 0.15), (0.07, 0.05), (0.08, 0.15), (0.1, 0.3)], 0.0, 0.0);
    for scan in [Scan::JerkLimited, Scan::Joined] {
        let plan = plan(&planner.clone().with_scan(scan).with_sections(sections.clone()), &arm, tool_down(line()))
            .expect("in reach");
        near_optimum(&plan, least);
        let check = plan.verification().expect("verified").worst_of(Quantity::Feed);
        assert!(check.ratio > 0.9999 && check.ratio <= 1.0 + 1e-6, "{check:?}");
        // The borders are on the grid, and the limit curve shows the sections.
        for (s, feed) in [(0.02, 0.15), (0.06, 0.05), (0.11, 0.05), (0.16, 0.15), (0.25, 0.3)] {
            let cap = plan.limit_curve().take_while(|c| c.0 <= s).last().expect("on the path").1;
            assert!((cap - feed).abs() < 1e-12, "{cap} at {s}, {:?}", plan.made_by());
            assert!(plan.speed().v_at_s(s) <= feed * (1.0 + 1e-9));
        }
        assert_eq!(plan.sections().len(), 2);
        assert!((plan.sections()[0].from - 0.05).abs() < 1e-9);
    }
}

#[test]
fn sections_by_parameter_and_by_segment_are_the_same_places() {
    let arm = arm();
    let planner = planner(&arm, TOOL);
    let path = tool_down(knotted());
    let plain = plan(&planner, &arm, path.clone()).expect("in reach");
    let (first, last) = (3, plain.breaks().len() - 4);
    let (from, to) = (plain.breaks()[first - 1], plain.breaks()[last]);
    let u = |k: usize| plain.segmentation().breaks()[k];
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
        plan(&planner(&arm, TOOL).with_sections(sections), &arm, tool_down(line()))
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
        for scan in [Scan::JerkLimited, Scan::Joined] {
            let planner = planner(&arm, TOOL).with_scan(scan).with_end_speeds(v_start, v_end).expect("not negative");
            let plan = plan(&planner, &arm, tool_down(line())).expect("in reach");
            near_optimum(&plan, least_time(&[(LENGTH, TOOL.feed)], v_start, v_end));
            let (first, last) = (plan.speed().v_at_s(0.0), plan.speed().v_at_s(LENGTH));
            assert!((first - v_start).abs() < 1e-9 && (last - v_end).abs() < 1e-9, "{first} {last}");
            assert!(plan.verification().expect("verified").worst_of(Quantity::Ends).ratio <= 1.0);
        }
    }
}

#[test]
fn speeds_at_the_ends_that_cannot_be_had_are_explained() {
    let arm = arm();
    let ask = |v_start: f64, v_end: f64, sections: Vec<FeedSection>, scan| {
        let planner = planner(&arm, TOOL).with_scan(scan).with_sections(sections);
        plan(&planner.with_end_speeds(v_start, v_end)?, &arm, tool_down(line()))
    };
    for scan in [Scan::JerkLimited, Scan::Joined] {
        // Faster than the feed.
        for (v_start, v_end, word) in [(0.25, 0.0, "start speed 0.25"), (0.0, 0.25, "end speed 0.25")] {
            let error = ask(v_start, v_end, vec![], scan).expect_err("above the feed");
            let PlanError::EndSpeed { highest, .. } = error else { panic!("{error}") };
            assert!((highest - TOOL.feed).abs() < 1e-6, "{highest}");
            assert!(error.to_string().contains(word), "{error}");
        }
        // From 0.2 to 0.02 m/s takes 0.013 m with the tool's acceleration alone; only 5 mm are given. The highest speed by v^2 =
        // 0.02^2 + 2 a s is 0.102 without jerk, less with it.
        let error = ask(0.2, 0.0, vec![section(0.005, 0.1, 0.02)], scan).expect_err("too fast");
        let PlanError::EndSpeed { at_start: true, highest, .. } = error else { panic!("{error}") };
        assert!(highest > 0.02 && highest < 0.1020, "{highest}");
    }
    let windowed = Scan::PerSegment { window: Some(5) };
    assert!(matches!(ask(0.0, 0.1, vec![], windowed), Err(PlanError::WindowEndSpeed { .. })));
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(ask(bad, 0.0, vec![], Scan::Joined), Err(PlanError::Feed(_))));
        assert!(matches!(ask(0.0, bad, vec![], Scan::Joined), Err(PlanError::Feed(_))));
    }
}

#[test]
fn a_tool_that_turns_evenly_is_as_fast_as_its_angular_speed_allows() {
    let arm = arm();
    let angle = 1.2;
    let turned = down() * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let path = || PosePath::new(by_length(line()), OrientationPath::slerp(LENGTH, down(), turned).expect("two ends"));
    // One radian takes a quarter of a metre: 0.32 rad/s are 0.08 m/s.
    let tool = ToolLimits { angular_speed: Some(0.32), ..TOOL };
    let least = least_time(&[(LENGTH, 0.32 * LENGTH / angle)], 0.0, 0.0);
    for scan in [Scan::JerkLimited, Scan::Joined] {
        let plan = plan(&planner(&arm, tool).with_scan(scan), &arm, path()).expect("in reach");
        near_optimum(&plan, least);
        let check = plan.verification().expect("verified").worst_of(Quantity::AngularSpeed);
        assert_eq!(check.quantity, Quantity::AngularSpeed);
        assert!(check.ratio > 0.999 && (check.value - 0.32).abs() < 1e-3, "{check:?}");
    }
    // The check is its own: the same motion without the limit breaks it.
    let unlimited = plan(&planner(&arm, TOOL), &arm, path()).expect("in reach");
    let check = unlimited.verify(&arm, &tool, &free(&arm)).expect("on the path").worst_of(Quantity::AngularSpeed);
    assert!((check.value - TOOL.feed * angle / LENGTH).abs() < 1e-3, "{check:?}");
    assert!(matches!(
        Planner::new(&arm, free(&arm), ToolLimits { angular_speed: Some(0.0), ..TOOL }),
        Err(PlanError::Limit { .. })
    ));
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
    for scan in [Scan::JerkLimited, Scan::Joined] {
        let planner = planner(&arm, TOOL).with_scan(scan).with_dynamics(&dynamics, torque).expect("above 0");
        let error = plan(&planner, &arm, path.clone()).expect_err("too heavy");
        let text = error.to_string();
        let PlanError::Infeasible { s, row, why, value, limit, position } = error else { panic!("{error}") };
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
    let limited = planner(&arm, TOOL).with_dynamics(&dynamics, torque).expect("above 0");
    let lift = plan(&limited, &arm, path()).expect("in reach");
    assert_eq!(lift.made_by().method, Method::JerkLimited);
    // Upwards the drive gives 0.5 m/s^2; slowing down gravity helps, so that the tool's own limit is what counts.
    let change = |dv: f64, a: f64| dv / a + a / TOOL.tangential_jerk;
    let (up, down) = (change(TOOL.feed, room), change(TOOL.feed, TOOL.tangential_acceleration));
    let least = up + down + (0.3 - 0.5 * TOOL.feed * (up + down)) / TOOL.feed;
    near_optimum(&lift, least);
    let check = lift.verification().expect("verified").worst_of(Quantity::JointTorque);
    assert_eq!((check.quantity, check.joint), (Quantity::JointTorque, Some(1)));
    assert!(check.ratio > 0.999 && check.ratio <= 1.0 + 1e-6, "{check:?}");
    // The scan keeps it as well, by what its share of the acceleration leaves.
    let scanned = plan(&limited.clone().with_scan(Scan::Joined), &arm, path()).expect("in reach");
    assert!(scanned.verification().expect("verified").worst_of(Quantity::JointTorque).ratio <= 1.0 + 1e-6);
    // Without the limit the motion is quicker, and the check says what that would take.
    let free = plan(&planner(&arm, TOOL), &arm, path()).expect("in reach");
    assert!(free.duration() < lift.duration());
    let needs = limited.verify(&free).expect("on the path").worst_of(Quantity::JointTorque);
    let expected = (9.81 + TOOL.tangential_acceleration) / (9.81 + room);
    assert!((needs.ratio - expected).abs() < 1e-3, "{needs:?}, {expected} expected");
}

#[test]
fn torque_with_friction_is_kept_on_a_winding_path() {
    let arm = arm();
    let friction = Friction::new(Joints::repeat(3.0), Joints::repeat(2.0), Joints::repeat(1.5)).expect("not negative");
    let dynamics = carrying(&arm, 6.0).with_friction(friction);
    let path = || tool_down(knotted());
    let tool = ToolLimits { feed: 0.3, ..TOOL };
    let limits = limits(&arm);
    let start = best_start(&arm, &path(), limits.lower(), limits.upper()).expect("in reach");
    let base = Planner::new(&arm, limits, tool).and_then(|p| p.with_period(2e-3)).expect("valid");
    let unlimited = base.clone().with_dynamics(&dynamics, Joints::repeat(1e3)).expect("above 0");
    let fast = unlimited.plan(path(), &start).expect("in reach");
    let peak = |joint: usize| {
        let checks = fast.verification().expect("verified").checks().iter();
        let found = checks.into_iter().find(|c| c.quantity == Quantity::JointTorque && c.joint == Some(joint));
        found.expect("checked").value
    };
    // Two percent less than the fast motion takes; the most part of it is gravity.
    let torque = Joints::from_fn(|k, _| 0.98 * peak(k));
    for scan in [Scan::JerkLimited, Scan::Joined] {
        let planner = base.clone().with_scan(scan).with_dynamics(&dynamics, torque).expect("above 0");
        let plan = planner.plan(path(), &start).expect("possible");
        let check = plan.verification().expect("verified").worst_of(Quantity::JointTorque);
        assert!(check.ratio <= 1.0 + 1e-6 && check.ratio > 0.97, "{check:?} {}", plan.made_by());
        assert!(plan.duration() > fast.duration());
        println!(
            "{scan:?}: {} {:.4} s, without {:.4} s, {} rounds",
            plan.made_by(),
            plan.duration(),
            fast.duration(),
            plan.made_by().rounds
        );
    }
    assert!(matches!(base.with_dynamics(&dynamics, Joints::repeat(0.0)), Err(PlanError::Limit { .. })));
}

#[test]
fn one_round_is_enough_where_the_arm_bends_the_path_most() {
    // Jerk of the joints binds all the way, whose third derivatives vary faster than the tool's.
    let arm = arm();
    let limits =
        arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(60.0)).expect("valid");
    let planner = Planner::new(&arm, limits, ToolLimits { tangential_jerk: 200.0, ..TOOL }).expect("valid");
    let start = best_start(&arm, &tool_down(knotted()), limits.lower(), limits.upper()).expect("in reach");
    let plan = planner.plan(tool_down(knotted()), &start).expect("in reach");
    let jerk = plan.verification().expect("verified").worst_of(Quantity::JointJerk);
    assert!(plan.made_by().rounds == 1 && plan.made_by().scale == 1.0, "{:?}", plan.made_by());
    assert!(jerk.ratio > 0.99 && jerk.ratio <= 1.0 + 1e-6, "{jerk:?}");
}

#[test]
fn a_plan_says_who_made_it() {
    let arm = arm();
    let smooth = plan(&planner(&arm, TOOL), &arm, tool_down(knotted())).expect("in reach");
    assert_eq!((smooth.made_by().method, smooth.made_by().fallback), (Method::JerkLimited, None));
    let stepped = plan(&planner(&arm, TOOL), &arm, tool_down(line_and_arc(0.1, 0.05))).expect("in reach");
    let Some(Fallback::AccelerationStep { s }) = stepped.made_by().fallback else { panic!("{}", stepped.made_by()) };
    assert!(stepped.made_by().method == Method::Joined && (s - 0.1).abs() < 1e-9, "{s}");
    assert!(stepped.made_by().to_string().contains("step at s = 0.100000,"));
    let asked = plan(&planner(&arm, TOOL).with_scan(Scan::Joined), &arm, tool_down(knotted())).expect("in reach");
    assert_eq!((asked.made_by().method, asked.made_by().fallback), (Method::Joined, None));
}
