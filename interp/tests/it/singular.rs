//! Paths through singular poses: found ahead, slowed down, gone round or refused.

use crate::common;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Command, HybridMotion, HybridState, Limits, LiveError, MotionPath, PathError, PlanError, Planner, SingularityKind,
    SingularityPolicy, ToolPath,
};
use arcfeed_kinematics::{ForwardKinematics, Joints, ParallelAxisArm};
use nalgebra::vector;

/// A planner under the limits of all these tests.
fn planner(arm: &ParallelAxisArm) -> Planner<'_> {
    Planner::new(arm, Limits::new(common::limits(arm)).with_tool(common::tool()))
}

/// A straight line of the tool between two configurations; the fifth joint of the one and of the other have opposite signs.
fn through_the_wrist(arm: &ParallelAxisArm, offset: f64) -> ToolPath<'_> {
    let start = Joints::from([0.2, -1.2, 1.5, -0.6, 0.5, 0.3]);
    let end = start + Joints::from([0.3, 0.05, 0.05, 0.05 + offset, -1.0, 0.0]);
    let (a, b) = (arm.forward(&start), arm.forward(&end));
    let curve = NurbsCurve::line(a.translation.vector, b.translation.vector).expect("two points");
    let curve = ArcLengthCurve::new(curve, 1e-15).expect("a length");
    let turning = OrientationPath::slerp(curve.length(), a.rotation, b.rotation).expect("a length above 0");
    ToolPath::starting_near(arm, PosePath::new(curve, turning), &start).expect("in reach")
}

#[test]
fn a_stretch_near_a_singular_pose_is_found_where_the_joints_are_fast() {
    let arm = common::arm();
    let path = through_the_wrist(&arm, 0.0);
    let planner = planner(&arm);
    let found = planner.find_singular_intervals(&arm, &path, 0.2).expect("the start is in reach");
    assert_eq!(found.len(), 1, "{found:?}");
    let stretch = &found[0];
    assert!(stretch.from > 0.0 && stretch.to < path.length() && stretch.from < stretch.to, "{stretch:?}");
    // On either side the fifth joint is small, and inside it passes 0.
    let (before, after) = (stretch.joints.0, stretch.joints.1.expect("followed again"));
    assert!(before[4].abs() < 0.3 && after[4].abs() < 0.3, "{before} {after}");
    // With a lower threshold less is left out.
    let narrow = planner.find_singular_intervals(&arm, &path, 0.05).expect("the start is in reach");
    assert!(narrow.len() <= 1);
    if let Some(narrow) = narrow.first() {
        assert!(narrow.from >= stretch.from && narrow.to <= stretch.to);
    }
    // No such place on a path far from singular poses.
    let far = common::tool_down(common::analytic());
    let far = ToolPath::new(&arm, far, arm.range()).expect("in reach");
    assert!(planner.find_singular_intervals(&arm, &far, 0.2).expect("in reach").is_empty());
}

#[test]
fn a_singular_stretch_is_gone_round_with_the_deviation_that_was_stated() {
    let arm = common::arm();
    for offset in [-0.1, 0.0, 0.02] {
        let path = through_the_wrist(&arm, offset);
        let limits = common::limits(&arm);
        let planner = planner(&arm);
        let route = planner.route(&arm, path.clone(), SingularityPolicy::GoRound { stall: 0.2 }).expect("in reach");
        assert_eq!((route.parts().len(), route.detours().len()), (2, 1));
        let detour = &route.detours()[0];
        let mut motion = HybridMotion::along(&route, 0.1).expect("a valid feed");
        let (mut rounds, mut deviation, mut before) = (0, 0.0_f64, *motion.setpoint());
        let period = route.parts()[0].period();
        loop {
            let step = motion.step(&Command::None);
            let now = step.setpoint;
            for k in 0..6 {
                assert!(now.qd[k].abs() <= limits.velocity()[k] * (1.0 + 1e-6));
                assert!(now.qdd[k].abs() <= limits.acceleration()[k] * (1.0 + 1e-6));
                assert!((now.qdd[k] - before.qdd[k]).abs() <= limits.jerk()[k] * period * (1.0 + 1e-6));
                let step = now.q[k] - before.q[k] - 0.5 * period * (now.qd[k] + before.qd[k]);
                assert!(step.abs() <= limits.jerk()[k] * period.powi(3) / 12.0 * 1.01 + 1e-12);
            }
            let tool = arm.forward(&now.q).translation.vector;
            if step.state == HybridState::GoingRound {
                rounds += 1;
                let (from, to) = (detour.interval.from, detour.interval.to);
                let off = (0..=2000)
                    .map(|i| (path.pose_path().curve().point(from + (to - from) * f64::from(i) / 2000.0) - tool).norm())
                    .fold(f64::INFINITY, f64::min);
                deviation = deviation.max(off);
            } else if step.on_path {
                assert!((path.pose_path().curve().point(now.s) - tool).norm() < 1e-9);
            }
            before = now;
            if step.state == HybridState::Done {
                break;
            }
        }
        assert!(rounds > 10);
        assert!((deviation - detour.deviation).abs() < 1e-4, "stated {} m, measured {deviation} m", detour.deviation);
        assert!((f64::from(rounds) * period - detour.duration).abs() < 2.0 * period);
        assert_eq!(before.s, path.length());
    }
}

#[test]
fn a_singular_stretch_is_slowed_down_for_or_refused_by_name() {
    let arm = common::arm();
    // Passing by: slow, but possible.
    let path = through_the_wrist(&arm, -0.1);
    let planner = planner(&arm);
    let slow = planner.route(&arm, path.clone(), SingularityPolicy::SlowDown).expect("it passes by");
    let live = &slow.parts()[0];
    let lowest = live.curve().caps().iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lowest < 0.2 * common::FEED && lowest > 0.0, "lowest cap {lowest}");
    let error = planner.route(&arm, path.clone(), SingularityPolicy::Refuse { stall: 0.2 }).expect_err("refused");
    let LiveError::Plan(PlanError::Path(PathError::Singular { from, to, .. })) = error else { panic!("{error}") };
    assert!(0.0 < from && from < to && to < path.length());
    assert!(matches!(
        planner.find_singular_intervals(&arm, &path, 0.2).expect("found")[0].kind,
        SingularityKind::Stall { .. } | SingularityKind::NotFollowed(_)
    ));
    for stall in [0.0, -1.0, 1.0, f64::NAN] {
        assert!(planner.find_singular_intervals(&arm, &path, stall).is_err());
    }
}

#[test]
fn a_path_that_ends_out_of_reach_has_no_way_round() {
    let arm = common::arm();
    let start = vector![0.5, 0.1, 0.3];
    let curve = NurbsCurve::line(start, start + vector![0.9, 0.0, 0.0]).expect("two points");
    let path =
        PosePath::new(ArcLengthCurve::new(curve, 1e-15).expect("a length"), OrientationPath::Constant(common::down()));
    let planner = planner(&arm);
    let all = arcfeed_kinematics::AnalyticInverse::inverse_all(&arm, &path.pose(0.0)).expect("in reach");
    let start = *all.iter().next().expect("a solution");
    let path = ToolPath::starting_near(&arm, path, &start).expect("in reach");
    let error = planner.route(&arm, path, SingularityPolicy::GoRound { stall: 0.1 }).expect_err("out of reach");
    assert!(error.to_string().contains("no way round"), "{error}");
}

#[test]
fn a_live_path_runs_from_rest_to_rest() {
    let arm = common::arm();
    let path = common::tool_down(common::analytic());
    let path = ToolPath::new(&arm, path, arm.range()).expect("in reach");
    let error = planner(&arm).with_end_speeds(0.0, 0.02).expect("valid").live(path).expect_err("it ends at rest");
    assert!(error.to_string().contains("from rest to rest"), "{error}");
}
