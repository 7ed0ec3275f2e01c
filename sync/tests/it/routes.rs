//! Routes through way-points on the online generator: set in any state of motion, followed, interrupted, left.
#![allow(clippy::unwrap_used)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{OnlineGenerator, Route, SyncError, Synchronisation, WayPoint, WayPointPlanner, WayPointTrajectory};
use arcfeed_testing::{Random, allocations_in};

use crate::way_points::{random_limits, random_points};

pub(crate) const CYCLE: f64 = 1e-3;

pub(crate) type OnRoutes<const N: usize> = Box<OnlineGenerator<N, WayPointTrajectory<N>>>;

pub(crate) fn at_rest<const N: usize>(place: [f64; N], limits: [AxisLimits; N]) -> OnRoutes<N> {
    let start = place.map(AxisState::rest);
    Box::new(OnlineGenerator::new(start, limits, CYCLE, Synchronisation::Time).unwrap().with_way_points())
}

fn usual<const N: usize>() -> [AxisLimits; N] {
    [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); N]
}

/// Checks a step by differences: the jerk, and that the position follows from the velocity.
pub(crate) fn check_smooth(was: &[AxisState], now: &[AxisState], limits: &[AxisLimits]) {
    for ((was, now), l) in was.iter().zip(now).zip(limits) {
        let (jerk, most) = ((now.a - was.a) / CYCLE, l.j_max().max(-l.j_min()));
        assert!(jerk.abs() <= most * (1.0 + 1e-7), "jerk {jerk} of {most}");
        let off = now.p - was.p - 0.5 * CYCLE * (was.v + now.v);
        assert!(off.abs() <= most * CYCLE.powi(3) * 0.1 + 1e-12, "{was:?} {now:?}");
    }
}

/// Checks a step as [`check_smooth`], and velocity and acceleration at its end.
pub(crate) fn check_step(was: &[AxisState], now: &[AxisState], limits: &[AxisLimits]) {
    check_smooth(was, now, limits);
    now.iter().zip(limits).for_each(|(now, l)| assert!(l.contain(now), "{now:?} {l:?}"));
}

/// Cycles until the end, each checked.
pub(crate) fn finish<const N: usize>(g: &mut OnRoutes<N>, limits: &[AxisLimits; N]) -> usize {
    for cycle in 1..200_000 {
        let was = *g.state();
        let step = g.step();
        check_step(&was, g.state(), limits);
        if step.events.reached {
            return cycle;
        }
    }
    panic!("the end does not come: {:?}", g.state());
}

#[test]
fn routes_change_in_any_cycle_and_the_target_is_reached() {
    let mut planner = Box::new(WayPointPlanner::new());
    for seed in 0..20 {
        let mut rng = Random::new(Random::new(seed).bits());
        let limits = random_limits::<3>(&mut rng);
        let mut g = at_rest([0.0; 3], limits);
        let mut places = vec![];
        for change in 0..6 {
            let count = 2 + rng.below(10);
            places = random_points::<3>(&mut rng, count);
            let points: Vec<_> = places[..count - 1].iter().map(|p| WayPoint::new(*p)).collect();
            if change == 3 {
                g.stop().unwrap();
            } else {
                let route = Route::new(&points, places[count - 1].map(AxisState::rest), limits);
                g.set_route(&route, &mut planner).unwrap();
            }
            for _ in 0..rng.below(700) {
                let was = *g.state();
                g.step();
                check_step(&was, g.state(), &limits);
            }
        }
        let left = g.time_left();
        if g.is_underway() {
            let cycles = finish(&mut g, &limits);
            assert!((cycles as f64 * CYCLE - left).abs() < 1.1 * CYCLE, "seed {seed}: {cycles} cycles, {left} s");
        }
        assert_eq!(*g.state(), places[places.len() - 1].map(AxisState::rest), "seed {seed}");
        assert!(!g.step().events.reached && g.section().is_none());
    }
}

/// The points are passed where the plan says, all of them, in the cycle that is said.
#[test]
fn every_point_is_passed_and_counted() {
    let (limits, mut planner) = (usual::<2>(), Box::new(WayPointPlanner::new()));
    let mut g = at_rest([0.0; 2], limits);
    // Two of them within one cycle.
    let fast = |p: [f64; 2]| WayPoint::new(p).with_velocity(0, 0.4).with_velocity(1, 0.1);
    let points = [fast([0.4, 0.1]), fast([0.40004, 0.10001]), fast([0.40008, 0.10002]), WayPoint::new([0.8, 0.5])];
    g.set_route(&Route::new(&points, [1.0, 0.2].map(AxisState::rest), limits), &mut planner).unwrap();
    assert!(g.section() == Some(0) && g.is_underway());
    let ends: Vec<f64> = g
        .route()
        .section_durations()
        .iter()
        .scan(0.0, |t, d| {
            Some({
                *t += d;
                *t
            })
        })
        .collect();
    let (mut passed, mut cycle, mut most) = (0, 0, 0);
    loop {
        let step = g.step();
        cycle += 1;
        passed += step.events.passed;
        most = most.max(step.events.passed);
        let expected = ends[..4].iter().filter(|&&t| t <= cycle as f64 * CYCLE + 1e-11).count();
        assert_eq!(passed, expected, "cycle {cycle}");
        if step.events.reached {
            break;
        }
        let planned = g.route().at(cycle as f64 * CYCLE);
        assert!((planned.q - step.state.q).amax() < 1e-12 && (planned.qd - step.state.qd).amax() < 1e-11);
    }
    assert!(passed == 4 && most >= 2, "{passed} {most}");
}

/// A stop keeps the limits of the section under way, however much the later ones allow.
#[test]
fn a_stop_keeps_the_limits_of_its_section() {
    let fast = [AxisLimits::symmetric(2.0, 20.0, 400.0).unwrap(); 2];
    let calm = [AxisLimits::symmetric(0.5, 1.0, 10.0).unwrap(); 2];
    let points = [WayPoint::new([1.0, 0.5]).with_limits(calm)];
    let route = Route::new(&points, [2.0, 1.0].map(AxisState::rest), fast);
    for command in 0..3 {
        let mut g = at_rest([0.0; 2], fast);
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        assert_eq!(*g.limits(), calm);
        (0..900).for_each(|_| assert_eq!(g.step().events.passed, 0));
        match command {
            0 => g.stop().unwrap(),
            1 => g.stop_on_path(),
            _ => g.set_target([AxisState::rest(0.2); 2]).unwrap(),
        }
        finish(&mut g, &calm);
    }
}

/// Past the calm section the generator has the limits of the fast one.
#[test]
fn limits_in_effect_are_those_of_the_section() {
    let fast = [AxisLimits::symmetric(2.0, 20.0, 400.0).unwrap(); 2];
    let calm = [AxisLimits::symmetric(0.5, 1.0, 10.0).unwrap(); 2];
    let points = [WayPoint::new([0.5, 0.25]).with_limits(calm)];
    let route = Route::new(&points, [2.0, 1.0].map(AxisState::rest), fast);
    let mut g = at_rest([0.0; 2], fast);
    g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
    while g.step().events.passed == 0 {
        assert_eq!(*g.limits(), calm);
    }
    assert_eq!(*g.limits(), fast);
    finish(&mut g, &fast);
    assert_eq!(*g.limits(), fast);
}

/// A jog leaves a margin for a scale above 1; the route that follows has none.
#[test]
fn a_route_that_is_set_at_a_scale_above_one_keeps_its_limits() {
    let limits = [AxisLimits::symmetric(1.0, 50.0, 5000.0).unwrap()];
    let mut g = at_rest([0.0], limits);
    g.jog([0.8], 10.0).unwrap();
    g.set_scale(1.5).unwrap();
    (0..700).for_each(|_| {
        g.step();
    });
    assert!((g.scale() - 1.25).abs() < 1e-9);
    let points = [WayPoint::new([1.5]), WayPoint::new([0.4]), WayPoint::new([0.9])];
    g.set_route(&Route::new(&points, [AxisState::rest(0.2)], limits), &mut WayPointPlanner::new()).unwrap();
    finish(&mut g, &limits);
    assert_eq!(g.state()[0], AxisState::rest(0.2));
}

/// The limits of each section hold while time is scaled over the border between a calm and a fast one.
#[test]
fn a_hold_over_a_point_keeps_the_limits_of_both_sections() {
    let fast = [AxisLimits::symmetric(2.0, 20.0, 400.0).unwrap(); 2];
    let calm = [AxisLimits::symmetric(0.5, 1.0, 10.0).unwrap(); 2];
    let points = [WayPoint::new([0.5, 0.25]).with_limits(calm), WayPoint::new([1.0, 0.0]), WayPoint::new([1.2, 0.5])];
    let route = Route::new(&points, [2.0, 1.0].map(AxisState::rest), fast);
    let mut planner = WayPointPlanner::new();
    for begin in (0..3000).step_by(53) {
        let mut g = at_rest([0.0; 2], fast);
        g.set_route(&route, &mut planner).unwrap();
        let mut held = false;
        for cycle in 0..20_000 {
            if cycle == begin {
                g.hold();
            }
            let was = (*g.state(), g.section());
            let step = g.step();
            let slow = was.1 == Some(0) && g.section() == Some(0);
            check_step(&was.0, g.state(), if slow { &calm } else { &fast });
            held |= g.scale() == 0.0;
            if held && g.is_held() {
                assert!(g.state().iter().all(|s| s.v == 0.0 && s.a == 0.0));
                g.resume();
            }
            if step.events.reached {
                break;
            }
        }
        assert_eq!(*g.state(), [2.0, 1.0].map(AxisState::rest), "{begin}");
        assert!(held || begin > 2000, "{begin}");
    }
}

/// A route that is played at half its pace takes twice as long, on the same curve.
#[test]
fn half_the_scale_takes_twice_the_time() {
    let (limits, mut planner) = (usual::<2>(), Box::new(WayPointPlanner::new()));
    let points = [[0.4, 0.1], [0.8, 0.5]].map(WayPoint::new);
    let route = Route::new(&points, [1.0, 0.2].map(AxisState::rest), limits);
    let mut run = |scale: f64| {
        let mut g = at_rest([0.0; 2], limits);
        g.set_scale(scale).unwrap();
        g.set_route(&route, &mut planner).unwrap();
        finish(&mut g, &limits)
    };
    let full = run(1.0);
    assert!(run(0.5).abs_diff(2 * full) <= 2, "{full}");
}

/// From every command to a route, and from a route to every command.
#[test]
fn a_route_begins_and_ends_in_every_command() {
    let (limits, mut planner) = (usual::<2>(), Box::new(WayPointPlanner::new()));
    let points = [[0.4, 0.1], [0.6, -0.3], [0.9, 0.2]].map(WayPoint::new);
    let target = [1.0, 0.3].map(AxisState::rest);
    let route = Route::new(&points, target, limits);
    let command = |g: &mut OnRoutes<2>, which: usize| match which {
        0 => g.set_target([AxisState::rest(-0.5), AxisState::new(0.2, 0.3, 0.0)]).unwrap(),
        1 => g.jog([0.6, -0.4], 0.1).unwrap(),
        2 => g.stop().unwrap(),
        3 => g.stop_on_path(),
        4 => g.hold(),
        5 => g.set_scale(0.3).unwrap(),
        6 => g.set_axis_target(1, AxisState::rest(0.7)).unwrap(),
        _ => g.set([AxisState::rest(-0.2); 2], limits).unwrap(),
    };
    for (before, after) in (0..64).map(|i| (i / 8, i % 8)) {
        let mut g = at_rest([0.0; 2], limits);
        let run = |g: &mut OnRoutes<2>, count: usize| {
            for _ in 0..count {
                let was = *g.state();
                g.step();
                check_step(&was, g.state(), &limits);
            }
        };
        g.jog([0.5, 0.2], 1.0).unwrap();
        run(&mut g, 210);
        command(&mut g, before);
        run(&mut g, 60);
        g.set_route(&route, &mut planner).unwrap();
        assert!(g.is_underway() && *g.target() == target);
        run(&mut g, 170);
        command(&mut g, after);
        run(&mut g, 1500);
        g.resume();
        g.set_scale(1.0).unwrap();
        run(&mut g, 4000);
        let end = g.state()[0].p;
        match after {
            0 => assert_eq!(g.state()[0], AxisState::rest(-0.5)),
            1..=3 => assert!(g.state().iter().all(|s| s.v == 0.0) && end < 0.9, "{before} {after} {end}"),
            4 | 5 => assert_eq!(*g.state(), target),
            6 => assert_eq!(g.state()[1], AxisState::rest(0.7)),
            _ => assert_eq!(*g.state(), [AxisState::rest(-0.2); 2]),
        }
    }
}

#[test]
fn a_refused_route_changes_nothing() {
    let (limits, mut planner) = (usual::<2>(), Box::new(WayPointPlanner::new()));
    let g = OnlineGenerator::new([AxisState::rest(0.0); 2], limits, CYCLE, Synchronisation::Time).unwrap();
    let mut g = Box::new(g.with_ranges([(-1.0, 1.0); 2]).unwrap().with_way_points());
    let points = [[0.4, 0.1], [0.8, 0.5]].map(WayPoint::new);
    let target = [0.9, 0.2].map(AxisState::rest);
    g.set_route(&Route::new(&points, target, limits), &mut planner).unwrap();
    (0..300).for_each(|_| {
        g.step();
    });
    let mut same = g.clone();
    let mut refuse = |points: &[WayPoint<2>], target: [AxisState; 2]| {
        g.set_route(&Route::new(points, target, limits), &mut planner).unwrap_err()
    };
    let e = refuse(&[WayPoint::new([0.4, 1.1])], target);
    assert!(matches!(e, SyncError::WayPoint { index: 0, axis: 1, what: "position", .. }), "{e}");
    let e = refuse(&[WayPoint::new([0.4, f64::NAN])], target);
    assert!(matches!(e, SyncError::WayPoint { index: 0, axis: 1, what: "position", .. }), "{e}");
    let e = refuse(&points, [1.2, 0.0].map(AxisState::rest));
    assert!(matches!(e, SyncError::OutsideRange { axis: 0, .. }), "{e}");
    let e = refuse(&points, [AxisState::new(0.99, 0.9, 0.0), AxisState::rest(0.0)]);
    assert!(matches!(e, SyncError::CannotStop { axis: 0, .. }), "{e}");
    // Passed at this velocity, the axis cannot turn before its range ends.
    let e = refuse(&[WayPoint::new([0.99, 0.1]).with_velocity(0, 0.9)], [0.2, 0.2].map(AxisState::rest));
    assert!(matches!(e, SyncError::LeavesRange { axis: 0, limit: 1.0, .. }), "{e}");
    // The free sections are planned before the line is found to be off.
    let route = g.route().clone();
    let half =
        Route::new(&points, [AxisState::new(0.9, 0.1, 0.0), AxisState::rest(0.2)], limits).with_straight_section();
    let e = g.set_route(&half, &mut planner).unwrap_err();
    assert!(matches!(e, SyncError::NotStraight { .. }), "{e}");
    assert_eq!(*g.route(), route);
    let e = g.set_axis_limits(1, limits[0]).unwrap_err();
    assert!(matches!(e, SyncError::LimitsOfRoute), "{e}");
    let narrow = (*g).clone().with_ranges([(-1.0, 0.7), (-1.0, 1.0)]).unwrap_err();
    assert!(matches!(narrow, SyncError::OutsideRange { axis: 0, .. }), "{narrow}");
    let narrow = (*g).clone().with_ranges([(-1.0, 1.0), (-1.0, 0.4)]).unwrap_err();
    assert!(matches!(narrow, SyncError::LeavesRange { axis: 1, .. }), "{narrow}");
    for _ in 0..3000 {
        assert_eq!(g.step(), same.step());
    }
    assert_eq!(*g.state(), target);
}

/// The position of a target that moves is passed on, and the range stops the axis.
#[test]
fn after_a_route_the_axes_go_on_as_after_a_target() {
    let limits = usual::<1>();
    let g = OnlineGenerator::new([AxisState::rest(0.0)], limits, CYCLE, Synchronisation::None).unwrap();
    let mut g = g.with_ranges([(-2.0, 2.0)]).unwrap().with_way_points();
    let route = [WayPoint::new([0.3]), WayPoint::new([0.6])];
    let route = Route::new(&route, [AxisState::new(1.0, 0.5, 0.0)], limits);
    g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
    let (mut reached, mut ends) = (0, 0);
    for _ in 0..5000 {
        let was = *g.state();
        let step = g.step();
        check_step(&was, g.state(), &limits);
        reached += usize::from(step.events.reached);
        ends += usize::from(step.events.range_ends[0]);
        assert!(!step.events.reached || (1.0..1.0006).contains(&g.state()[0].p), "{:?}", g.state());
    }
    assert!(reached == 1 && ends > 0 && g.state()[0] == AxisState::rest(2.0), "{reached} {ends} {:?}", g.state());
}

#[test]
fn routes_allocate_nothing() {
    let limits = usual::<3>();
    let mut rng = Random::new(5);
    let routes: Vec<Vec<_>> =
        (0..12).map(|_| random_points::<3>(&mut rng, 6).into_iter().map(WayPoint::new).collect()).collect();
    let (mut planner, mut g) = (Box::new(WayPointPlanner::new()), at_rest([0.0; 3], limits));
    let count = allocations_in(|| {
        for (i, points) in routes.iter().enumerate() {
            g.set_route(&Route::new(points, [AxisState::rest(0.1 * i as f64); 3], limits), &mut planner).unwrap();
            (0..200).for_each(|_| {
                g.step();
            });
            g.hold();
            (0..200).for_each(|_| {
                g.step();
            });
            g.resume();
            (0..200).for_each(|_| {
                g.step();
            });
        }
    });
    assert_eq!(count, 0);
}
