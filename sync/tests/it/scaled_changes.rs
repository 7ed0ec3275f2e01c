//! Limits, targets and ranges that are set while the scale of time changes.
#![allow(clippy::unwrap_used)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_sync::{OnlineGenerator, Route, Synchronisation, WayPoint, WayPointPlanner};
use arcfeed_testing::{Random, allocations_in};

use crate::common::moving_problem;

const CYCLE: f64 = 1e-3;

/// The limits of velocity, acceleration and jerk by differences, one axis after the other.
fn check(was: &AxisState, now: &AxisState, l: &AxisLimits, case: usize) {
    let jerk = (now.a - was.a) / CYCLE;
    let within = |x: f64, low: f64, high: f64, part: f64| x <= high * (1.0 + part) && x >= low * (1.0 + part);
    assert!(within(jerk, l.j_min(), l.j_max(), 1e-6), "case {case}: jerk {jerk} from {was:?} to {now:?}");
    assert!(within(now.a, l.a_min(), l.a_max(), 1e-9), "case {case}: {was:?} to {now:?}");
    assert!(within(now.v, l.v_min(), l.v_max(), 1e-9), "case {case}: {was:?} to {now:?}");
}

/// The ramp of the scale covered what followed the target before, and the braking before the new end took too much jerk.
#[test]
fn ranges_that_are_set_while_the_scale_changes_keep_the_limits() {
    let mut rng = Random::new(97);
    let (mut taken, mut ramps) = (0, 0);
    for case in 0..3000 {
        let l = AxisLimits::symmetric(1.0, rng.log(1.0, 10.0), rng.log(5.0, 100.0)).unwrap();
        let mut g = OnlineGenerator::new([AxisState::rest(0.0)], [l], CYCLE, Synchronisation::Time).unwrap();
        let target = AxisState::new(rng.between(0.3, 1.5), rng.between(0.2, 0.95), 0.0);
        g.set_target([target]).unwrap();
        // The ramp begins at the target or shortly before it.
        let before = rng.between(0.0, 0.05);
        while g.is_underway() && g.time_left() > before {
            g.step();
        }
        if rng.chance(0.3) {
            g.set_scale(rng.unit()).unwrap();
        } else if rng.chance(0.5) {
            g.hold();
        } else {
            g.stop_on_path();
        }
        let (ramp, mut was) = (rng.below(60), g.state()[0]);
        for cycle in 0..1500 {
            if cycle == ramp {
                ramps += usize::from(g.scale() != 1.0);
                // As near as the axis can stop, and some more.
                let stop = StateToState::stop(&AxisState::new(0.0, target.v, 0.0), &l).unwrap();
                let end = target.p.max(was.p) + stop.at(stop.duration()).p;
                let range = (-1.0, end + rng.log(1e-6, 0.1));
                if let Ok(other) = g.clone().with_ranges([range]) {
                    taken += 1;
                    g = other;
                }
            }
            g.step();
            check(&was, &g.state()[0], &l, case);
            was = g.state()[0];
            if cycle == 1000 {
                g.resume();
            }
        }
    }
    assert!(taken > 1000 && ramps > 500, "{taken} {ramps}");
}

/// At a scale below 1 the axes are inside limits that the state of the plan exceeds: the plan from there took them out.
#[test]
fn limits_that_only_the_plan_exceeds_are_kept_at_any_scale() {
    let mut rng = Random::new(98);
    let mut inside = 0;
    for case in 0..600 {
        let p = moving_problem::<2>(&mut rng, 0.0);
        let mut g = OnlineGenerator::new(p.start, p.limits, CYCLE, Synchronisation::Time).unwrap();
        g.set_target(p.target).unwrap();
        g.set_scale(rng.between(0.1, 0.9)).unwrap();
        let count = (rng.unit() * g.time_left() / CYCLE) as usize;
        (0..count).for_each(|_| {
            g.step();
        });
        // Just above what the axes do now.
        let lower: [AxisLimits; 2] = std::array::from_fn(|k| {
            let (s, l) = (g.state()[k], &p.limits[k]);
            let later = s.v.abs() + 0.5 * s.a * s.a / l.j_max().min(-l.j_min());
            let part = |x: f64, most: f64| (1.0001 * x.abs()).max(0.3 * most);
            AxisLimits::symmetric(part(later, l.v_max()), part(s.a, l.a_max()), l.j_max().min(-l.j_min())).unwrap()
        });
        if g.set_limits(lower).is_err() || !g.state().iter().zip(&lower).all(|(s, l)| l.contain(s)) {
            continue;
        }
        inside += 1;
        for _ in 0..4000 {
            let was = *g.state();
            let step = g.step();
            assert!(!step.events.outside_limits, "case {case}");
            (0..2).for_each(|k| check(&was[k], &g.state()[k], &lower[k], case));
        }
    }
    assert!(inside > 300, "{inside}");
}

/// An axis behind its target went on for ever with what the scale of time had left of its velocity, when its neighbour was
/// planned anew from the state commanded last, or when it was held.
#[test]
fn an_axis_behind_its_target_keeps_its_velocity() {
    let mut rng = Random::new(99);
    let (mut anew, mut at_ends) = (0, 0);
    for case in 0..200 {
        let l = AxisLimits::symmetric(1.0, rng.log(1.0, 10.0), rng.log(5.0, 100.0)).unwrap();
        let mode = rng.one_of(&[Synchronisation::None, Synchronisation::Time]);
        let mut g = OnlineGenerator::new([AxisState::rest(0.0); 2], [l; 2], CYCLE, mode).unwrap();
        let velocity = rng.between(0.3, 0.9);
        g.set_target([AxisState::new(0.2, velocity, 0.0), AxisState::rest(rng.between(0.5, 1.5))]).unwrap();
        while !g.step().events.arrived[0] {}
        if rng.chance(0.5) {
            g.hold()
        } else {
            g.set_scale(rng.between(0.1, 0.9)).unwrap()
        };
        let mut end = f64::INFINITY;
        for cycle in 0..1000 {
            let (was, scale) = (*g.state(), g.scale());
            if cycle % 100 == 50 {
                if rng.chance(0.6) {
                    let slower = AxisLimits::symmetric(rng.between(0.3, 1.0), l.a_max(), l.j_max()).unwrap();
                    g.set_axis_limits(1, slower).unwrap();
                } else if rng.chance(0.3) {
                    // An order for the axis itself: other limits, which permit its velocity.
                    g.set_axis_limits(0, AxisLimits::symmetric(rng.between(0.9, 1.0), l.a_max(), l.j_max()).unwrap())
                        .unwrap();
                } else {
                    let new = was[0].p + rng.log(0.2, 10.0);
                    if let Ok(other) = g.clone().with_ranges([(-1.0, new), (-10.0, 10.0)]) {
                        (g, end) = (other, new);
                    }
                }
                anew += usize::from(scale > 0.0 && scale < 1.0 && g.scale() == 1.0);
            }
            g.step();
            (0..2).for_each(|k| check(&was[k], &g.state()[k], &l, case));
        }
        g.resume();
        g.set_scale(1.0).unwrap();
        at_ends += usize::from(has_velocity_again(&mut g, &l, (velocity, end), case));
        assert!(g.target()[0].v == velocity, "case {case}");
        let mut cycles = 0;
        while g.is_underway() && cycles < 20_000 {
            g.step();
            cycles += 1;
        }
        assert_eq!(g.state()[1], g.target()[1], "case {case} {mode:?}");
    }
    assert!(anew > 50 && at_ends > 20, "{anew} {at_ends}");
}

/// Goes on until axis 0 has had the time to return to its velocity, and checks that it has it, or is as near to the end of its range
/// as it takes to stop from there. Returns true in the second case.
fn has_velocity_again<const N: usize>(
    g: &mut OnlineGenerator<N>,
    l: &AxisLimits,
    (velocity, end): (f64, f64),
    case: usize,
) -> bool {
    let (a, j) = (l.a_max(), l.j_max());
    let mut cycles = 0;
    while g.scale() != 1.0 && cycles < 20_000 {
        g.step();
        cycles += 1;
    }
    assert_eq!(g.scale(), 1.0, "case {case}");
    let back = (velocity / a + 2.0 * a / j) / CYCLE;
    let stop = velocity * velocity / (2.0 * a) + velocity * a / (2.0 * j);
    // With less than the whole acceleration it takes longer.
    let stop = if velocity < a * a / j { velocity * (velocity / j).sqrt() } else { stop };
    let mut brakes = false;
    for cycle in 0..back as usize + 200 {
        g.step();
        let now = g.state()[0];
        brakes = end - now.p < stop + 1e-9;
        if cycle as f64 > back {
            assert!(brakes || (now.v - velocity).abs() < 1e-9, "case {case}: {now:?} of {velocity}, {end} {stop}");
        }
    }
    brakes
}

/// An axis behind its target went on with the lower limit for ever, whose clamp had taken the place of its velocity.
#[test]
fn limits_that_are_low_for_a_while_leave_the_velocity_of_the_target() {
    let mut rng = Random::new(101);
    let (mut slow, mut at_ends) = (0, 0);
    for case in 0..200 {
        let l = AxisLimits::symmetric(1.0, rng.log(1.0, 10.0), rng.log(5.0, 100.0)).unwrap();
        let low = AxisLimits::symmetric(rng.between(0.05, 0.3), l.a_max(), l.j_max()).unwrap();
        let mut g = OnlineGenerator::new([AxisState::rest(0.0)], [l], CYCLE, Synchronisation::Time).unwrap();
        let velocity = rng.between(0.3, 0.9);
        g.set_target([AxisState::new(0.2, velocity, 0.0)]).unwrap();
        let mut end = f64::INFINITY;
        if rng.chance(0.5) {
            end = rng.between(0.8, 2.0);
            g = g.with_ranges([(-1.0, end)]).unwrap();
        }
        while !g.step().events.arrived[0] {}
        match rng.below(3) {
            0 => {}
            1 => g.hold(),
            _ => g.set_scale(rng.between(0.1, 0.9)).unwrap(),
        }
        let (lowers, again, raises) = (rng.below(300), rng.below(300), 1 + rng.below(600));
        for cycle in 0..lowers + again + raises {
            let was = *g.state();
            if cycle == lowers {
                g.set_limits([low]).unwrap();
            } else if cycle == lowers + again {
                // Limits that change on the way to the low velocity, or at it.
                let other = AxisLimits::symmetric(low.v_max() * 0.9, l.a_max(), l.j_max()).unwrap();
                g.set_limits([other]).unwrap();
            }
            g.step();
            check(&was[0], &g.state()[0], &l, case);
        }
        slow += usize::from(g.state()[0].v <= low.v_max());
        g.set_limits([l]).unwrap();
        g.resume();
        g.set_scale(1.0).unwrap();
        at_ends += usize::from(has_velocity_again(&mut g, &l, (velocity, end), case));
        if end < f64::INFINITY {
            let mut cycles = 0;
            while g.state()[0] != AxisState::rest(end) && cycles < 20_000 {
                let was = g.state()[0];
                g.step();
                check(&was, &g.state()[0], &l, case);
                cycles += 1;
            }
            // Where the range ended the axis stands, whatever its limits.
            g.set_limits([low]).unwrap();
            g.set_limits([l]).unwrap();
            g.step();
            assert_eq!(g.state()[0], AxisState::rest(end), "case {case}");
        }
    }
    assert!(slow > 100 && at_ends > 10, "{slow} {at_ends}");
}

/// The ramp of the scale was judged anew though nothing had changed, and a route was left where that was refused.
#[test]
fn ranges_that_change_nothing_leave_a_route_as_it_is() {
    let mut rng = Random::new(100);
    let mut planner = Box::new(WayPointPlanner::new());
    let mut ramps = 0;
    for case in 0..300 {
        let l = [(); 3].map(|()| AxisLimits::symmetric(1.0, rng.log(1.0, 10.0), rng.log(5.0, 100.0)).unwrap());
        let mut place = || std::array::from_fn(|_| rng.between(-1.0, 1.0));
        let points: Vec<_> = (0..6).map(|_| WayPoint::new(place())).collect();
        let target = place().map(AxisState::rest);
        let g = OnlineGenerator::new([AxisState::rest(0.0); 3], l, CYCLE, Synchronisation::Time).unwrap();
        let mut g = g.with_way_points();
        g.set_route(&Route::new(&points, target, l), &mut planner).unwrap();
        (0..rng.below(1500)).for_each(|_| {
            g.step();
        });
        if rng.chance(0.5) {
            g.hold()
        } else {
            g.set_scale(rng.unit()).unwrap()
        };
        for _ in 0..100 {
            if g.scale() > 0.0 && g.scale() < 1.0 && g.is_underway() {
                ramps += 1;
                let scale = g.scale();
                g = g.with_ranges([(-5.0, 5.0); 3]).unwrap();
                assert!(g.section().is_some() && g.scale() == scale, "case {case}");
            }
            g.step();
        }
    }
    assert!(ramps > 1000, "{ramps}");
}

#[test]
fn changes_while_the_scale_changes_allocate_nothing() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 6];
    let slow = [AxisLimits::symmetric(0.5, 2.0, 30.0).unwrap(); 6];
    let mut changes = Vec::with_capacity(3);
    let count = allocations_in(|| {
        let mut g = OnlineGenerator::new([AxisState::rest(0.0); 6], limits, CYCLE, Synchronisation::Time).unwrap();
        g.set_target([AxisState::new(0.5, 0.3, 0.0); 6]).unwrap();
        for n in 0..1500 {
            let before = g.scale();
            match n {
                300 => g.hold(),
                310 => g.set_limits(slow).unwrap(),
                700 => g.resume(),
                715 => g.set_limits(limits).unwrap(),
                720 => g = g.with_ranges([(-2.0, 2.0); 6]).unwrap(),
                _ => {}
            }
            let after = g.scale();
            let step = g.step();
            if let 310 | 715 | 720 = n {
                changes.push((before, after, step.events.replanned));
            }
        }
    });
    assert_eq!(count, 0, "{changes:?}");
    // The scale is on its way before each. The first one cannot go on with it and is planned from the state commanded last, at 1.
    assert!(changes.iter().all(|(before, ..)| *before > 0.0 && *before < 1.0), "{changes:?}");
    let goes_on = |i: usize| changes[i].1 == changes[i].0;
    assert!(changes[0].1 == 1.0 && changes[0].2 && goes_on(1) && changes[1].2 && goes_on(2), "{changes:?}");
}
