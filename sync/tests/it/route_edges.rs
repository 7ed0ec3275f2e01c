//! Routes at their edges: starts outside the limits, points given twice, targets that move, ranges that are set on the way,
//! limits that differ between sections, sections that end next to a cycle.
#![allow(clippy::unwrap_used)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{
    OnlineGenerator, Route, SectionKind, Synchronisation, WayPoint, WayPointPlanner, WayPointTrajectory,
};

use crate::routes::{CYCLE, OnRoutes, at_rest, check_smooth, check_step, finish};

fn symmetric<const N: usize>(v: f64, a: f64, j: f64) -> [AxisLimits; N] {
    [AxisLimits::symmetric(v, a, j).unwrap(); N]
}

fn plan<const N: usize>(route: &Route<'_, N>) -> WayPointTrajectory<N> {
    WayPointPlanner::new().plan(&[AxisState::rest(0.0); N], route).unwrap()
}

/// Cycles, each checked.
fn run<const N: usize>(g: &mut OnRoutes<N>, count: usize, limits: &[AxisLimits; N]) {
    for _ in 0..count {
        let was = *g.state();
        g.step();
        check_step(&was, g.state(), limits);
    }
}

/// The place of the start is given once or twice more, and the limits of the route are below its velocity.
#[test]
fn a_start_outside_the_limits_is_brought_back_where_its_place_is_given() {
    let (fast, slow) = (symmetric::<1>(2.0, 5.0, 50.0), symmetric::<1>(1.0, 5.0, 50.0));
    for (count, range) in [(0, 9.0), (1, 9.0), (2, 9.0), (1, f64::INFINITY), (2, f64::INFINITY), (5, f64::INFINITY)] {
        let g = OnlineGenerator::new([AxisState::new(0.0, 1.5, 0.0)], fast, CYCLE, Synchronisation::Time).unwrap();
        let mut g = Box::new(g.with_ranges([(-range, range)]).unwrap().with_way_points());
        let points = [WayPoint::new([0.0]); 5];
        let route = Route::new(&points[..count], [AxisState::rest(1.0)], slow);
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        assert_eq!(g.route().at(0.0).qd[0], 1.5, "{count}");
        let mut cycles = 0;
        while g.is_underway() && cycles < 5000 {
            let was = *g.state();
            g.step();
            check_smooth(&was, g.state(), &slow);
            cycles += 1;
            let planned = g.route().at(cycles as f64 * CYCLE);
            assert!((planned.q[0] - g.state()[0].p).abs() < 2e-3, "{count}: {planned:?} {:?}", g.state());
        }
        assert_eq!(*g.state(), [AxisState::rest(1.0)], "{count}, {range}");
    }
}

/// The target takes the place of the last point, and the route ends at some part of a cycle.
#[test]
fn a_target_that_is_the_last_point_too_is_passed_without_a_jump() {
    let limits = symmetric::<1>(1.0, 5.0, 50.0);
    for i in 0..40 {
        let mut g = at_rest([0.0], limits);
        let points = [0.3, 0.6 + 1e-4 * f64::from(i)].map(|p| WayPoint::new([p]));
        let route = Route::new(&points, [AxisState::new(points[1].position()[0], 0.5, 0.0)], limits);
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        let (left, mut reached) = (g.time_left(), None);
        for cycle in 1..2000 {
            let was = *g.state();
            if g.step().events.reached {
                assert!(reached.is_none());
                reached = Some(cycle);
            }
            check_step(&was, g.state(), &limits);
        }
        let reached = f64::from(reached.unwrap()) * CYCLE;
        assert!(reached >= left - 1e-9 && reached < left + CYCLE + 1e-9, "{reached} {left}");
        let on = points[1].position()[0] + 0.5 * (1999.0 * CYCLE - left);
        assert!((g.state()[0].p - on).abs() < 1e-9, "{i}: {on} {:?}", g.state());
    }
}

#[test]
fn ranges_that_are_set_in_the_last_section_stop_the_axis_after_the_target() {
    let limits = symmetric::<1>(1.0, 5.0, 50.0);
    for points in [&[][..], &[WayPoint::new([0.3])]] {
        let mut g = at_rest([0.0], limits);
        let route = Route::new(points, [AxisState::new(1.0, 0.5, 0.0)], limits);
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        run(&mut g, 900, &limits);
        assert!(g.is_underway() && g.section() == Some(points.len()));
        let mut g = Box::new((*g).with_ranges([(-2.0, 2.0)]).unwrap());
        run(&mut g, 6000, &limits);
        assert_eq!(*g.state(), [AxisState::rest(2.0)]);
    }
}

/// A stop on the path that begins in the last cycle before a moving target goes on behind it: ranges that are set then are kept by a
/// stop of each axis, or refused.
#[test]
fn ranges_that_are_set_while_a_stop_passes_the_target_are_kept() {
    let limits = [AxisLimits::symmetric(2.0, 5.0, 50.0).unwrap(), AxisLimits::symmetric(2.0, 0.5, 5.0).unwrap()];
    let mut accepted = 0;
    for way in [0.15, 0.2, 0.3, 0.45, 0.7] {
        let mut g = at_rest([0.0; 2], limits);
        let target = [AxisState::new(1.0, 1.0, 0.0), AxisState::new(1.0, 0.5, 0.0)];
        g.set_route(&Route::new(&[], target, limits), &mut WayPointPlanner::new()).unwrap();
        while g.time_left() > CYCLE {
            g.step();
        }
        g.stop_on_path();
        for _ in 0..5 {
            g.step();
        }
        assert!(!g.is_underway());
        let upper = g.state()[0].p + way;
        let Ok(ranged) = (*g).with_ranges([(-2.0, upper), (-9.0, 9.0)]) else { continue };
        accepted += 1;
        let mut g = Box::new(ranged);
        run(&mut g, 4000, &limits);
        assert!(g.state().iter().all(|axis| axis.v == 0.0), "{way}: {:?}", g.state());
    }
    assert!(accepted > 0);
}

/// The axis goes on after the target and brakes before its range ends: a hold, a stop and a scale count that.
#[test]
fn time_is_scaled_within_the_limits_past_a_target_that_moves() {
    let limits = symmetric::<1>(0.5, 5.0, 50.0);
    let points = [WayPoint::new([0.98]).with_velocity(0, 0.5), WayPoint::new([1.0])];
    for count in 1..3 {
        let route = Route::new(&points[..count], [AxisState::new(1.0, 0.5, 0.0)], limits);
        for (command, begin) in (0..3).flat_map(|command| (1950..2200).step_by(3).map(move |begin| (command, begin))) {
            let g = OnlineGenerator::new([AxisState::rest(0.0)], limits, CYCLE, Synchronisation::Time).unwrap();
            let mut g = Box::new(g.with_ranges([(-1.0, 1.05)]).unwrap().with_way_points());
            g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
            run(&mut g, begin, &limits);
            match command {
                0 => g.hold(),
                1 => g.set_scale(0.3).unwrap(),
                _ => g.stop_on_path(),
            }
            run(&mut g, 1500, &limits);
            g.resume();
            run(&mut g, 1500, &limits);
            assert!(
                g.state()[0].v == 0.0 && (command == 2 || g.state()[0].p == 1.05),
                "{command} {begin} {:?}",
                g.state()
            );
        }
    }
}

#[test]
fn a_scale_above_one_counts_how_the_axis_stops_after_the_route() {
    let limits = symmetric::<1>(0.5, 5.0, 50.0);
    let points = [WayPoint::new([0.9]).with_velocity(0, 0.3), WayPoint::new([1.0])];
    for count in 1..3 {
        let mut slow =
            [points[0].with_velocity(0, 0.3), points[1].with_velocity(0, 0.3).with_least_duration(1.0 / 3.0)];
        let mut route = Route::new(&slow[..count], [AxisState::new(1.0, 0.3, 0.0)], limits);
        if count == 1 {
            route = route.with_least_duration(1.0 / 3.0);
        }
        let g = OnlineGenerator::new([AxisState::rest(0.0)], limits, CYCLE, Synchronisation::Time).unwrap();
        let mut g = Box::new(g.with_ranges([(-1.0, 1.2)]).unwrap().with_way_points());
        g.set_scale(1.5).unwrap();
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        run(&mut g, 6000, &limits);
        assert_eq!(*g.state(), [AxisState::rest(1.2)]);
        slow.reverse();
    }
}

/// Two sections of different limits meet in a blend: it keeps the velocities of both.
#[test]
fn a_blend_keeps_the_velocities_of_both_lines() {
    let (slow, fast) = (symmetric::<2>(0.1, 5.0, 50.0), symmetric::<2>(1.0, 5.0, 50.0));
    for (turn, slow_first) in [(false, true), (false, false), (true, true), (true, false)] {
        let (first, last) = if slow_first { (slow, fast) } else { (fast, slow) };
        let end = if turn { [1.0, 1.0] } else { [2.0, 0.0] };
        let points = [WayPoint::new([1.0, 0.0]).with_straight_section().with_blend(0.05).with_limits(first)];
        let route = Route::new(&points, end.map(AxisState::rest), last).with_straight_section();
        let motion = plan(&route);
        let mut blends = 0;
        for i in 0..motion.section_durations().len() {
            let section = motion.section(i).unwrap();
            let blend = motion.section_kind(i) == Ok(SectionKind::Blend);
            blends += usize::from(blend);
            let most = if blend || (i == 0) == slow_first { 0.1 } else { 1.0 };
            for (phase, dt) in section.axes().iter().flat_map(|axis| axis.phases().collect::<Vec<_>>()) {
                for t in [0.0, phase.turn(dt).unwrap_or(0.0), dt] {
                    assert!(phase.after(t).v.abs() <= most * (1.0 + 1e-12), "{turn} {slow_first} {i}: {phase:?}");
                }
            }
        }
        // On one line the corner is passed at the lower velocity.
        assert!(blends <= 1 && (turn || motion.states()[1][0].v > 0.0999), "{turn} {slow_first} {:?}", motion.states());
    }
}

/// A stop on the path, and then a stop, where another section with other limits is under way.
#[test]
fn a_stop_has_the_limits_of_the_section_it_begins_in() {
    let (fast, calm) = (symmetric::<2>(2.0, 20.0, 400.0), symmetric::<2>(1.5, 2.0, 20.0));
    let points = [WayPoint::new([1.0, 0.5]).with_limits(fast)];
    let route = Route::new(&points, [4.0, 1.0].map(AxisState::rest), calm);
    let mut both = 0;
    for before in 1..60 {
        let mut g = at_rest([0.0; 2], fast);
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        let point = (g.route().section_durations()[0] / CYCLE) as usize;
        run(&mut g, point - before, &fast);
        g.stop_on_path();
        while g.section() == Some(0) && g.state()[0].v > 0.1 {
            run(&mut g, 1, &fast);
        }
        if g.section() == Some(1) && g.state()[0].v > 0.1 {
            both += 1;
            assert_eq!(*g.limits(), calm, "{before}");
            run(&mut g, 1, &fast);
            g.stop().unwrap();
            finish(&mut g, &calm);
        }
    }
    assert!(both > 3, "{both}");
}

#[test]
fn a_stop_in_a_blend_has_the_limits_of_both_lines() {
    let (fast, calm) = (symmetric::<2>(2.0, 20.0, 400.0), symmetric::<2>(1.5, 2.0, 20.0));
    for (first, last) in [(fast, calm), (calm, fast)] {
        let points = [WayPoint::new([1.0, 0.0]).with_straight_section().with_blend(0.05).with_limits(first)];
        let route = Route::new(&points, [2.0, 0.5].map(AxisState::rest), last).with_straight_section();
        let mut g = at_rest([0.0; 2], fast);
        g.set_route(&route, &mut WayPointPlanner::new()).unwrap();
        while g.section() == Some(0) {
            g.step();
        }
        assert_eq!(g.route().section_kind(1), Ok(SectionKind::Blend));
        assert_eq!(*g.limits(), calm);
        g.stop().unwrap();
        finish(&mut g, &calm);
    }
}

/// Whether a section ends in a cycle is decided once: durations beside a whole number of cycles by what counts as round-off.
#[test]
fn a_section_that_ends_next_to_a_cycle_leads_to_the_next_one() {
    let limits = symmetric::<1>(1.0, 5.0, 50.0);
    let mut planner = Box::new(WayPointPlanner::new());
    for cycles in [67_u32, 70, 90, 100, 120, 127] {
        let exact = (f64::from(cycles) + 1e-9) * CYCLE;
        for ulps in 0..64_u64 {
            let duration = f64::from_bits(exact.to_bits() - 32 + ulps);
            let points = [WayPoint::new([1e-4]).with_velocity(0, 0.0).with_least_duration(duration)];
            let mut g = at_rest([0.0], limits);
            g.set_route(&Route::new(&points, [AxisState::rest(0.4)], limits), &mut planner).unwrap();
            run(&mut g, cycles as usize + 5, &limits);
        }
    }
}

/// What two points in one place ask for is kept.
#[test]
fn points_in_one_place_keep_their_velocities_and_limits() {
    let (slow, usual) = (symmetric::<1>(0.2, 5.0, 50.0), symmetric::<1>(1.0, 5.0, 50.0));
    let points = [WayPoint::new([1.0]).with_limits(slow), WayPoint::new([1.0]).with_velocity(0, 0.5)];
    let motion = plan(&Route::new(&points, [AxisState::rest(2.0)], usual));
    assert_eq!(motion.states()[2][0].v, 0.5);
    let mut g = at_rest([0.0], usual);
    let target = [AxisState::new(1.0, 0.5, 0.0)];
    g.set_route(&Route::new(&points[..1], target, usual), &mut WayPointPlanner::new()).unwrap();
    finish(&mut g, &usual);
}

/// A line on which no motion lasts as long as it must has rests at its ends; the other corners keep their blends.
#[test]
fn one_line_that_is_impossible_with_blends_rests_by_itself() {
    let corner = |p: [f64; 2]| WayPoint::new(p).with_straight_section().with_blend(0.01);
    let points =
        [corner([1.0, 0.0]), corner([1.0, 0.1]).with_least_duration(5.0), corner([2.0, 0.1]), corner([2.0, 1.0])];
    let route = Route::new(&points, [3.0, 1.0].map(AxisState::rest), symmetric(1.0, 5.0, 50.0)).with_straight_section();
    let motion = plan(&route);
    let count = motion.section_durations().len();
    let blends = (0..count).filter(|&i| motion.section_kind(i) == Ok(SectionKind::Blend)).count();
    assert_eq!(blends, 2);
}
