//! Straight sections of routes and the blends between them; `02_soak lines` has the random ones.
#![allow(clippy::unwrap_used)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{
    MotionOptions, OnlineGenerator, Route, SectionKind, SyncError, Synchronisation, Trajectory, WayPoint,
    WayPointPlanner, WayPointTrajectory,
};

use crate::routes::{CYCLE, check_step};

fn usual<const N: usize>() -> [AxisLimits; N] {
    [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); N]
}

fn blended(place: [f64; 2], deviation: f64) -> WayPoint<2> {
    WayPoint::new(place).with_straight_section().with_blend(deviation)
}

fn plan(start: [AxisState; 2], points: &[WayPoint<2>], target: [AxisState; 2]) -> WayPointTrajectory<2> {
    let route = Route::new(points, target, usual()).with_straight_section();
    WayPointPlanner::new().plan(&start, &route).unwrap()
}

/// The motion in steps of a millisecond.
fn samples(motion: &WayPointTrajectory<2>) -> Vec<[f64; 2]> {
    let count = (motion.duration() / CYCLE) as usize;
    (0..=count).map(|i| motion.at(i as f64 * CYCLE)).map(|s| [s.q[0], s.q[1]]).collect()
}

#[test]
fn a_corner_is_passed_at_its_deviation() {
    let mut before = 0.0;
    for deviation in [5e-3, 1e-2, 4e-2] {
        let rest = [0.0, 0.0].map(AxisState::rest);
        let motion = plan(rest, &[blended([1.0, 0.0], deviation)], [1.0, 1.0].map(AxisState::rest));
        assert_eq!(motion.section_durations().len(), 3);
        let nearest = samples(&motion).iter().map(|q| (q[0] - 1.0).hypot(q[1])).fold(f64::INFINITY, f64::min);
        // Between two samples the axes move on by a little.
        assert!(nearest <= deviation * 1.02 && nearest >= deviation * (1.0 - 1e-9), "{nearest} of {deviation}");
        let speed = motion.states()[1][0].v;
        // From acceleration 2 d / T with T d √2 / 12 at the deviation, or jerk 4 d / T².
        let by_acceleration = (6.0 * deviation / 2f64.sqrt() * 5.0).sqrt();
        let by_jerk = (6.0 * deviation / 2f64.sqrt() * 50f64.sqrt()).powf(2.0 / 3.0);
        let expected = by_acceleration.min(by_jerk).min(1.0);
        assert!((speed - expected).abs() < 1e-9 && speed > before, "{speed}, {expected}");
        assert!(samples(&motion).iter().all(|q| q[0].min(1.0) >= q[0] - 1e-12 && q[1] >= -1e-12));
        before = speed;
    }
    // Without a blend, or with one of no size, or where that is faster, the axes rest in the corner.
    let rests = [0.0, 1e-4, 1e-3, 3e-3].map(|deviation| blended([1.0, 0.0], deviation));
    for point in rests.into_iter().chain([WayPoint::new([1.0, 0.0]).with_straight_section()]) {
        let motion = plan([0.0, 0.0].map(AxisState::rest), &[point], [1.0, 1.0].map(AxisState::rest));
        let direct =
            Trajectory::new(&[AxisState::rest(0.0)], &[AxisState::rest(1.0)], &usual::<1>(), &MotionOptions::default());
        assert!((motion.duration() - 2.0 * direct.unwrap().duration()).abs() < 1e-12);
    }
}

#[test]
fn points_on_one_line_are_passed_at_full_speed() {
    let points: Vec<_> = (1..8).map(|i| blended([0.5 * f64::from(i), 0.25 * f64::from(i)], 1e-3)).collect();
    let (start, target) = ([0.0, 0.0].map(AxisState::rest), [4.0, 2.0].map(AxisState::rest));
    let motion = plan(start, &points, target);
    let direct = Trajectory::new(&start, &target, &usual(), &MotionOptions::default()).unwrap();
    assert!(motion.duration() < 1.001 * direct.duration(), "{} {}", motion.duration(), direct.duration());
    assert!(samples(&motion).iter().all(|q| (q[0] - 2.0 * q[1]).abs() < 1e-12));
}

/// A straight section between two that are not: the axes rest where it begins and ends, and the others pass.
#[test]
fn straight_and_free_sections_follow_each_other() {
    let points = [
        WayPoint::new([0.3, 0.4]),
        WayPoint::new([0.6, 0.2]),
        WayPoint::new([1.0, 0.8]).with_straight_section(),
        WayPoint::new([1.3, 0.4]),
    ];
    let route = Route::new(&points, [1.5, 0.0].map(AxisState::rest), usual());
    let motion = WayPointPlanner::new().plan(&[AxisState::rest(0.0); 2], &route).unwrap();
    assert_eq!(motion.section_durations().len(), 5);
    let states = motion.states();
    for (node, moves) in [(1, true), (2, false), (3, false), (4, true)] {
        assert_eq!(states[node].iter().any(|s| s.v != 0.0), moves, "{node}");
        assert_eq!(states[node].map(|s| s.p), points[node - 1].position());
    }
    let line = motion.section(2).unwrap();
    assert!(line.is_straight());
    for i in 0..100 {
        let q = line.at(0.01 * f64::from(i) * line.duration()).q;
        assert!(((q[0] - 0.6) * 0.6 - (q[1] - 0.2) * 0.4).abs() < 1e-14);
    }
}

/// On the way to the point the axes go on; anywhere else they come to rest first.
#[test]
fn a_start_in_motion_goes_on_where_it_is_on_the_line() {
    let target = [2.0, 1.0].map(AxisState::rest);
    let towards = [AxisState::new(0.0, 0.6, 0.0), AxisState::new(0.0, 0.3, 0.0)];
    let motion = plan(towards, &[blended([1.0, 0.5], 1e-2)], target);
    assert!(motion.section(0).unwrap().is_straight());
    let beside = [AxisState::new(0.0, 0.6, 0.0), AxisState::new(0.0, -0.3, 1.0)];
    let motion = plan(beside, &[blended([1.0, 0.5], 1e-2)], target);
    assert!(!motion.section(0).unwrap().is_straight() && motion.section(1).unwrap().is_straight());
    assert!(motion.states()[1].iter().all(|s| s.v == 0.0 && s.a == 0.0 && s.p != 0.0));
    // Too fast to stop before the point: the line begins where they rest, behind it.
    let fast = [AxisState::new(0.98, 0.6, 0.0), AxisState::new(0.49, 0.3, 0.0)];
    let motion = plan(fast, &[WayPoint::new([1.0, 0.5]).with_straight_section()], target);
    assert!(motion.states()[1][0].p > 1.0 && motion.states()[2].map(|s| s.p) == [1.0, 0.5]);
}

#[test]
fn a_target_may_move_along_its_line() {
    let along = [AxisState::new(2.0, 0.4, 0.0), AxisState::new(1.0, 0.2, 0.0)];
    let motion = plan([AxisState::rest(0.0); 2], &[blended([1.0, 0.5], 1e-2)], along);
    assert_eq!(motion.states()[motion.section_durations().len()], along);
    for target in [[AxisState::new(2.0, 0.4, 0.0), AxisState::rest(1.0)], along.map(|s| AxisState::new(s.p, -s.v, 0.0))]
    {
        let route = [blended([1.0, 0.5], 1e-2)];
        let route = Route::new(&route, target, usual()).with_straight_section();
        let e = WayPointPlanner::new().plan(&[AxisState::rest(0.0); 2], &route).unwrap_err();
        assert!(matches!(e, SyncError::NotStraight { .. }), "{e}");
    }
}

#[test]
fn what_is_no_straight_route_is_refused_by_name() {
    let rest = [AxisState::rest(0.0); 2];
    let refuse = |points: &[WayPoint<2>]| {
        let route = Route::new(points, [1.0, 1.0].map(AxisState::rest), usual());
        WayPointPlanner::new().plan(&rest, &route).unwrap_err()
    };
    let corner = blended([0.5, 0.0], 1e-3);
    let e = refuse(&[WayPoint::new([0.1, 0.1]), corner]);
    assert!(matches!(e, SyncError::Blend { index: 1, value: 1e-3, .. }), "{e}");
    assert!(e.to_string().contains("way-point 2") && e.to_string().contains("straight"), "{e}");
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let e = refuse(&[blended([0.5, 0.0], bad), WayPoint::new([1.0, 0.0]).with_straight_section()]);
        assert!(matches!(e, SyncError::Blend { index: 0, .. }), "{e}");
    }
    let e =
        refuse(&[WayPoint::new([0.5, 0.5]).with_velocity(1, 0.1), WayPoint::new([0.7, 0.5]).with_straight_section()]);
    assert!(matches!(e, SyncError::WayPoint { index: 0, axis: 1, what: "velocity", value: 0.1, .. }), "{e}");
    let e = refuse(&[WayPoint::new([0.5, 0.5]).with_velocity(1, 0.1).with_straight_section()]);
    assert!(matches!(e, SyncError::WayPoint { index: 0, axis: 1, what: "velocity", value: 0.1, .. }), "{e}");
    let e = refuse(&[corner; 33]);
    assert!(matches!(e, SyncError::TooManyWayPoints { count: 66, most: 64 }), "{e}");
}

/// As many sections as there can be: 32 blends and a stop before them.
#[test]
fn the_longest_straight_route_is_possible() {
    let points: Vec<_> = (0..32).map(|i| blended([0.1 * f64::from(i), 0.1 * f64::from(i % 2)], 1e-2)).collect();
    let start = [AxisState::new(-0.3, 0.5, 0.0), AxisState::new(0.0, 0.5, 0.0)];
    let motion = plan(start, &points, [4.0, 0.0].map(AxisState::rest));
    assert_eq!(motion.section_durations().len(), 66);
    // The same point twice, and a way back.
    let points = [blended([0.5, 0.0], 0.1), blended([0.5, 0.0], 0.1), blended([0.2, 0.0], 0.1)];
    let motion = plan([AxisState::rest(0.0); 2], &points, [1.0, 0.0].map(AxisState::rest));
    assert!(motion.duration() < 3.0 && motion.states()[motion.section_durations().len()][0].p == 1.0);
}

/// Stops, holds and counts of a generator on straight lines.
#[test]
fn a_generator_stays_on_the_lines() {
    let corner = blended([0.5, 0.0], 2e-2);
    let route = [corner, WayPoint::new([0.5, 0.5]).with_straight_section()];
    let route = Route::new(&route, [1.0, 0.5].map(AxisState::rest), usual()).with_straight_section();
    let off = |q: [f64; 2]| {
        let first = if q[0] <= 0.5 { q[1].abs() } else { f64::INFINITY };
        let second = (q[0] - 0.5).abs();
        first.min(second).min((q[1] - 0.5).abs())
    };
    for stop in (5..1600).step_by(97) {
        let g = OnlineGenerator::new([AxisState::rest(0.0); 2], usual(), CYCLE, Synchronisation::Time).unwrap();
        let mut g = Box::new(g.with_way_points());
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        let mut through = g.clone();
        let (mut passed, mut cycle, mut blended) = (0, 0, false);
        loop {
            if cycle == stop {
                g.stop_on_path();
            }
            let (was, before) = (*g.state(), g.section());
            let step = g.step();
            check_step(&was, g.state(), &usual::<2>());
            cycle += 1;
            passed += step.events.passed;
            let q = [step.state.q[0], step.state.q[1]];
            let in_blend = |i: usize| g.route().section_kind(i) == Ok(SectionKind::Blend);
            let blend = [before, g.section()].into_iter().flatten().any(in_blend);
            blended |= blend;
            assert!(off(q) <= if blend { 2e-2 } else { 1e-12 }, "stop in cycle {stop}: {q:?}");
            if step.events.reached {
                break;
            }
        }
        assert!(cycle > stop && cycle < stop + 700 && passed <= 2, "{stop}: {cycle}");
        assert!(blended || passed == 0, "{stop}");
        assert!(g.state().iter().all(|s| s.v == 0.0 && s.a == 0.0));
        passed = 0;
        while through.is_underway() {
            passed += through.step().events.passed;
        }
        assert!(passed == 2 && *through.state() == [1.0, 0.5].map(AxisState::rest), "{passed}");
    }
}

/// A way-point on the line, just after a start or before a target that moves along it, costs next to nothing.
#[test]
fn ends_that_move_along_their_lines_keep_their_speed() {
    let moving = |p: f64| [AxisState::new(p, 0.9, 0.0), AxisState::rest(0.0)];
    let still = |p: f64| [p, 0.0].map(AxisState::rest);
    for (start, place, target) in [(moving(0.0), 0.03, still(1.0)), (still(0.0), 0.97, moving(1.0))] {
        let motion = plan(start, &[blended([place, 0.0], 1e-3)], target);
        let direct = Trajectory::new(&start, &target, &usual::<2>(), &MotionOptions::default()).unwrap();
        let (ours, shortest) = (motion.duration(), direct.duration());
        assert!(ours < 1.005 * shortest, "{ours} s, without the point {shortest} s");
    }
}
