//! Stops, jogs, holds and scales of time: what they take, what they keep, what they refuse.
#![allow(clippy::unwrap_used)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_sync::{OnlineGenerator, SyncError, Synchronisation};
use arcfeed_testing::{Random, allocations_in};

use crate::common::moving_problem;

const CYCLE: f64 = 1e-3;

fn one_axis() -> OnlineGenerator<1> {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap()];
    OnlineGenerator::new([AxisState::rest(0.0)], limits, CYCLE, Synchronisation::Time).unwrap()
}

fn steps<const N: usize>(g: &mut OnlineGenerator<N>, count: usize) {
    for _ in 0..count {
        g.step();
    }
}

/// Cycles until the event.
fn until_reached<const N: usize>(g: &mut OnlineGenerator<N>) -> usize {
    (1..100_000).find(|_| g.step().events.reached).unwrap()
}

#[test]
fn a_stop_takes_the_textbook_time() {
    let mut g = one_axis();
    g.set_target([AxisState::rest(3.0)]).unwrap();
    steps(&mut g, 1000);
    assert_eq!(g.state()[0].v, 1.0);
    let from = g.state()[0].p;
    for on_path in [false, true] {
        let mut g = g.clone();
        if on_path {
            g.stop_on_path();
        } else {
            g.stop().unwrap();
        }
        // From v = 1 with a = 5 and j = 50: 1 / 5 + 5 / 50 seconds, half of them at v = 1 in the mean.
        assert!((299..=301).contains(&until_reached(&mut g)));
        assert!((g.state()[0].p - from - 0.15).abs() < 1e-12);
        assert_eq!(*g.target(), *g.state());
        // The old target was given up; it can be set again.
        g.set_target([AxisState::rest(3.0)]).unwrap();
        assert!(g.step().events.replanned);
        until_reached(&mut g);
        assert_eq!(g.state()[0], AxisState::rest(3.0));
    }
}

/// Every axis brakes in the shortest time of its own, whatever the others do.
#[test]
fn a_stop_is_the_shortest_of_each_axis() {
    let mut rng = Random::new(71);
    for i in 0..200 {
        let p = moving_problem::<3>(&mut rng, 0.0);
        let mut g = OnlineGenerator::new(p.start, p.limits, CYCLE, Synchronisation::Time).unwrap();
        g.set_target(p.target).unwrap();
        let count = (rng.unit() * g.time_left() / CYCLE) as usize;
        steps(&mut g, count);
        let shortest = g.state().iter().zip(&p.limits).map(|(s, l)| StateToState::stop(s, l).unwrap().duration());
        let shortest = shortest.fold(0.0, f64::max);
        g.stop().unwrap();
        let taken = until_reached(&mut g) as f64 * CYCLE;
        assert!(taken <= shortest + 1.001 * CYCLE, "case {i}: {taken} instead of {shortest}");
    }
}

#[test]
fn a_stop_near_the_end_of_the_range_turns_there() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap()];
    let g = OnlineGenerator::new([AxisState::rest(0.0)], limits, CYCLE, Synchronisation::Time).unwrap();
    let mut g = g.with_ranges([(-1.0, 0.5)]).unwrap();
    // Turns back shortly before the end of the range, harder than a stop brakes.
    g.set_target([AxisState::rest(0.49)]).unwrap();
    steps(&mut g, 480);
    g.set_target([AxisState::new(0.3, -0.5, 0.0)]).unwrap();
    let mut least = f64::INFINITY;
    while g.is_underway() {
        let mut other = g.clone();
        other.stop().unwrap();
        until_reached(&mut other);
        assert!(other.state()[0].p <= 0.5);
        least = least.min(0.5 - other.state()[0].p);
        g.step();
    }
    assert!(least < 0.05, "{least}");
}

/// What a stop on the path costs against the shortest stop of the slowest axis, which leaves it.
#[test]
fn stops_on_the_path_are_short() {
    let mut rng = Random::new(72);
    let mut ratios = Vec::new();
    for i in 0..300 {
        let p = moving_problem::<6>(&mut rng, 0.0);
        let mut g = OnlineGenerator::new(p.start, p.limits, CYCLE, Synchronisation::Time).unwrap();
        g.set_target(p.target).unwrap();
        let left = g.time_left();
        let count = (rng.between(0.1, 0.9) * left / CYCLE) as usize;
        steps(&mut g, count);
        let rest_of_plan = g.time_left();
        let shortest = g.state().iter().zip(&p.limits).map(|(s, l)| StateToState::stop(s, l).unwrap().duration());
        let shortest = shortest.fold(0.0, f64::max);
        g.stop_on_path();
        let taken = until_reached(&mut g) as f64 * CYCLE;
        assert!(taken <= 2.0 * rest_of_plan + shortest, "case {i}: {taken} of {rest_of_plan}, {shortest}");
        ratios.push(taken / shortest);
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "time of a stop on the path by the shortest: median {:.3}, 90 % {:.3}, worst {:.3}",
        ratios[150], ratios[270], ratios[299]
    );
    assert!(ratios[150] < 2.0);
}

/// The distance of a point from a curve that is given by points.
fn distance_from(curve: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
    let distance = |from: &[f64; 2], to: &[f64; 2]| {
        let (along, off) = ([to[0] - from[0], to[1] - from[1]], [x - from[0], y - from[1]]);
        let length = along[0] * along[0] + along[1] * along[1];
        let part = ((off[0] * along[0] + off[1] * along[1]) / length).clamp(0.0, 1.0);
        (off[0] - part * along[0]).hypot(off[1] - part * along[1])
    };
    curve.windows(2).map(|pair| distance(&pair[0], &pair[1])).fold(f64::INFINITY, f64::min)
}

/// Both axes move straight towards their targets when they are to stop, but their plan leaves that line.
#[test]
fn a_stop_on_the_path_of_axes_that_begin_along_a_line_stays_on_their_curve() {
    let limits = [AxisLimits::symmetric(1.0, 2.0, 20.0).unwrap(), AxisLimits::symmetric(1.0, 8.0, 200.0).unwrap()];
    let start = [AxisState::new(0.0, 0.4, 0.0), AxisState::new(0.0, 0.2, 0.0)];
    let mut g = OnlineGenerator::new(start, limits, CYCLE, Synchronisation::Time).unwrap();
    g.set_target([AxisState::rest(0.2), AxisState::rest(0.1)]).unwrap();
    let mut going = g.clone();
    let mut curve = vec![[0.0; 2]];
    while !going.step().events.reached {
        curve.push(going.state().each_ref().map(|s| s.p));
    }
    g.stop_on_path();
    let mut off_line = 0.0_f64;
    while !g.step().events.reached {
        let p = g.state().each_ref().map(|s| s.p);
        let off = distance_from(&curve, p);
        assert!(off < 1e-6, "{off} from the curve at {p:?}");
        off_line = off_line.max((p[0] - 2.0 * p[1]).abs());
    }
    assert!(off_line > 1e-3, "{off_line}");
}

/// Limits that are raised during a stop on the path change nothing of it.
#[test]
fn a_stop_on_the_path_keeps_the_limits_that_it_began_with() {
    let mut rng = Random::new(74);
    for i in 0..60 {
        let p = moving_problem::<6>(&mut rng, 0.0);
        let mut stopping = OnlineGenerator::new(p.start, p.limits, CYCLE, Synchronisation::Time).unwrap();
        stopping.set_target(p.target).unwrap();
        let count = (rng.between(0.1, 0.9) * stopping.time_left() / CYCLE) as usize;
        steps(&mut stopping, count);
        stopping.stop_on_path();
        let mut raised = stopping.clone();
        let twice = |l: &AxisLimits| {
            let twice = |(low, high): (f64, f64)| (2.0 * low, 2.0 * high);
            AxisLimits::new(twice((l.v_min(), l.v_max())), twice((l.a_min(), l.a_max())), twice((l.j_min(), l.j_max())))
        };
        raised.set_limits(p.limits.each_ref().map(|l| twice(l).unwrap())).unwrap();
        for cycle in 0..20_000 {
            let (a, b) = (stopping.step(), raised.step());
            assert_eq!(a.state, b.state, "case {i}, cycle {cycle}");
            if a.events.reached {
                break;
            }
        }
    }
}

#[test]
fn ranges_that_are_set_during_a_jog_leave_it_its_velocity() {
    let mut g = one_axis();
    g.jog([0.5], 10.0).unwrap();
    steps(&mut g, 20);
    let mut g = g.with_ranges([(-9.0, 9.0)]).unwrap();
    for _ in 0..2000 {
        g.jog([0.5], 10.0).unwrap();
        g.step();
    }
    assert_eq!(g.state()[0].v, 0.5);
}

/// A stop button is held down: the stop is that of one call.
#[test]
fn a_stop_on_the_path_asked_for_in_every_cycle_is_the_same_stop() {
    let mut rng = Random::new(73);
    for i in 0..60 {
        let p = moving_problem::<6>(&mut rng, 0.0);
        let mut once = OnlineGenerator::new(p.start, p.limits, CYCLE, Synchronisation::Time).unwrap();
        once.set_target(p.target).unwrap();
        let count = (rng.between(0.1, 0.9) * once.time_left() / CYCLE) as usize;
        steps(&mut once, count);
        let mut held = once.clone();
        once.stop_on_path();
        for cycle in 0..20_000 {
            held.stop_on_path();
            let (a, b) = (once.step(), held.step());
            assert_eq!(a.state, b.state, "case {i}, cycle {cycle}");
            if a.events.reached {
                break;
            }
        }
    }
}

#[test]
fn half_the_scale_takes_twice_the_time() {
    let run = |scale: f64| {
        let mut g = one_axis();
        g.set_scale(scale).unwrap();
        g.set_target([AxisState::rest(3.0)]).unwrap();
        until_reached(&mut g)
    };
    let full = run(1.0);
    assert_eq!(run(0.5), 2 * full);
    // The plan uses its limits: a higher scale changes nothing.
    assert_eq!(run(1.5), full);
}

/// A plan that leaves a margin is played faster, as far as the limits go.
#[test]
fn a_scale_above_one_uses_the_margin_of_the_limits() {
    let limits = AxisLimits::symmetric(1.0, 50.0, 5000.0).unwrap();
    let mut g = OnlineGenerator::new([AxisState::rest(0.0)], [limits], CYCLE, Synchronisation::Time).unwrap();
    g.jog([0.8], 10.0).unwrap();
    steps(&mut g, 200);
    g.set_scale(1.5).unwrap();
    steps(&mut g, 500);
    assert!((g.state()[0].v - 1.0).abs() < 1e-9, "{:?}", g.state());
    assert!((g.scale() - 1.25).abs() < 1e-9);
}

#[test]
fn a_hold_rests_and_a_target_set_meanwhile_is_planned_from_rest() {
    let mut g = one_axis();
    g.set_target([AxisState::rest(3.0)]).unwrap();
    steps(&mut g, 1000);
    g.hold();
    steps(&mut g, 400);
    assert!(g.is_held() && g.scale() == 0.0);
    let held = *g.state();
    assert_eq!((held[0].v, held[0].a), (0.0, 0.0));
    g.set_target([AxisState::rest(-1.0)]).unwrap();
    steps(&mut g, 100);
    assert_eq!(*g.state(), held);
    g.resume();
    let mut before = held[0].p;
    while g.is_underway() {
        let now = g.step().state.q[0];
        assert!(now <= before);
        before = now;
    }
    assert_eq!(g.state()[0], AxisState::rest(-1.0));
}

#[test]
fn a_jog_ends_when_it_is_not_renewed() {
    let mut g = one_axis();
    for n in 0..1000 {
        g.jog([-0.3], 0.02).unwrap();
        let step = g.step();
        assert_eq!(step.events.replanned, n == 0);
    }
    assert_eq!(g.state()[0].v, -0.3);
    // 20 cycles more, and a stop: 2 sqrt(0.3 / 50) s.
    let taken = until_reached(&mut g);
    assert!((174..=177).contains(&taken), "{taken}");
    // Another axis target lets the others rest.
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    let mut g = OnlineGenerator::new([AxisState::rest(0.0); 2], limits, CYCLE, Synchronisation::Time).unwrap();
    g.jog([0.5, 0.5], 1.0).unwrap();
    steps(&mut g, 500);
    g.set_axis_target(0, AxisState::rest(1.0)).unwrap();
    until_reached(&mut g);
    assert_eq!(g.state()[0].p, 1.0);
    assert!(g.state()[1].v == 0.0 && g.state()[1].p < 0.5);
}

#[test]
fn limits_set_during_a_jog_and_a_stop_hold() {
    let mut g = one_axis();
    g.jog([0.9], 10.0).unwrap();
    steps(&mut g, 600);
    g.set_axis_limits(0, AxisLimits::symmetric(0.4, 5.0, 50.0).unwrap()).unwrap();
    steps(&mut g, 600);
    assert_eq!(g.state()[0].v, 0.4);
    g.stop().unwrap();
    g.step();
    g.set_axis_limits(0, AxisLimits::symmetric(0.4, 2.0, 50.0).unwrap()).unwrap();
    while g.is_underway() {
        g.step();
        assert!(g.state()[0].a >= -2.0 - 1e-12);
    }
    assert_eq!(g.state()[0].v, 0.0);
}

#[test]
fn wrong_commands_change_nothing() {
    let mut g = one_axis();
    g.set_target([AxisState::rest(1.0)]).unwrap();
    steps(&mut g, 100);
    let mut same = g.clone();
    for bad in [f64::NAN, -0.1, 1.6, f64::INFINITY] {
        assert!(matches!(g.set_scale(bad), Err(SyncError::Scale { .. })));
    }
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(matches!(g.jog([0.1], bad), Err(SyncError::Timeout { .. })));
    }
    for bad in [f64::NAN, 1.1, -1.1, f64::NEG_INFINITY] {
        assert!(matches!(g.jog([bad], 1.0), Err(SyncError::State { axis: 0, .. })));
    }
    for _ in 0..100 {
        assert_eq!(g.step(), same.step());
    }
}

#[test]
fn commands_allocate_nothing() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 6];
    let count = allocations_in(|| {
        let mut g = OnlineGenerator::new([AxisState::rest(0.0); 6], limits, CYCLE, Synchronisation::Time).unwrap();
        g = g.with_ranges([(-2.0, 2.0); 6]).unwrap();
        let mut rng = Random::new(73);
        for n in 0..3000 {
            match n % 100 {
                0 => g.set_target(std::array::from_fn(|_| AxisState::rest(rng.signed()))).unwrap(),
                20 => g.hold(),
                40 => g.resume(),
                50 => g.set_scale(rng.unit()).unwrap(),
                70 => g.stop_on_path(),
                80 => g.jog([0.1; 6], 0.01).unwrap(),
                95 => g.stop().unwrap(),
                _ => {}
            }
            g.step();
        }
    });
    assert_eq!(count, 0);
}

#[test]
fn a_stop_is_not_slowed_down_by_the_scale() {
    let mut g = one_axis();
    g.set_target([AxisState::rest(3.0)]).unwrap();
    steps(&mut g, 1000);
    g.stop().unwrap();
    g.set_scale(0.3).unwrap();
    assert!((299..=301).contains(&until_reached(&mut g)));
    steps(&mut g, 1);
    assert_eq!(g.scale(), 0.3);
}

/// Round-off of all the time that a hold takes, here seven days, was in its first cycles: 4 nm on an axis that is fast and brakes slowly.
#[test]
fn a_hold_that_takes_days_begins_without_a_jump() {
    let limits = [AxisLimits::symmetric(60.27226252079074, 0.0015222917785348295, 1.8901378405430034).unwrap()];
    // The acceleration is beyond its limit: the hold begins within the second cycle.
    let start = [AxisState::new(15.031580741987103, -57.4296724592512, 0.0020047136083094284)];
    let mut g = OnlineGenerator::new(start, limits, CYCLE, Synchronisation::Time).unwrap();
    g.hold();
    let mut before = start[0];
    for n in 0..2000 {
        g.step();
        let now = g.state()[0];
        let off = (now.p - before.p) - 0.5 * CYCLE * (now.v + before.v);
        // What the acceleration can do in a cycle, and round-off.
        assert!(off.abs() < 0.5 * 0.0021 * CYCLE * CYCLE, "cycle {n}: {off:e}");
        before = now;
    }
    assert!(g.scale() < 1.0);
}
