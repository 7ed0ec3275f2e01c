//! The ranges of the online generator: nothing leaves them, and what would is refused.
#![allow(clippy::unwrap_used)]
use arcfeed_sync::feedrate::{AxisLimits, AxisState, BoundedProblem, FeedError, MotionLaw, PositionLimits};
use arcfeed_sync::{OnlineGenerator, SyncError, Synchronisation};
use arcfeed_testing::Random;

use crate::common::moving_problem;

const CYCLE: f64 = 1e-3;
const MODES: [Synchronisation; 3] = [Synchronisation::Time, Synchronisation::None, Synchronisation::StraightLine];

fn generator(mode: Synchronisation) -> OnlineGenerator<2> {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    OnlineGenerator::new([AxisState::rest(0.0); 2], limits, CYCLE, mode)
        .unwrap()
        .with_ranges([(-1.0, 1.0), (-2.0, f64::INFINITY)])
        .unwrap()
}

/// A target of 1000 degrees was followed to 625 % of the joint's range.
#[test]
fn a_target_outside_the_range_was_followed() {
    for mode in MODES {
        let mut g = generator(mode);
        let e = g.set_target([AxisState::rest(1000f64.to_radians()), AxisState::rest(0.0)]).unwrap_err();
        assert!(matches!(e, SyncError::OutsideRange { axis: 0, what: "target", upper: 1.0, .. }), "{e}");
        assert!(e.to_string().contains("outside its range [-1, 1]"), "{e}");
        assert!(matches!(
            g.set_axis_target(1, AxisState::rest(-2.1)),
            Err(SyncError::OutsideRange { axis: 1, lower: -2.0, .. })
        ));
        assert!(!g.is_underway());
        g.set_target([AxisState::rest(1.0), AxisState::rest(1e3)]).unwrap();
    }
}

#[test]
fn starts_and_ranges_that_do_not_fit_are_refused() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap()];
    let at = |s: AxisState| OnlineGenerator::new([s], limits, CYCLE, Synchronisation::Time).unwrap();
    let outside = at(AxisState::rest(3.0)).with_ranges([(-1.0, 1.0)]).unwrap_err();
    assert!(matches!(outside, SyncError::OutsideRange { axis: 0, what: "start", .. }), "{outside}");
    for range in [(1.0, -1.0), (0.0, 0.0), (f64::NAN, 1.0), (-1.0, f64::NAN)] {
        assert!(matches!(at(AxisState::rest(0.0)).with_ranges([range]), Err(SyncError::Range { axis: 0, .. })));
    }
    // 1 / s takes 0.15 to stop: 1 (1 / 5 + 5 / 50) / 2.
    let fast = at(AxisState::new(0.86, 1.0, 0.0)).with_ranges([(-1.0, 1.0)]).unwrap_err();
    assert!(matches!(fast, SyncError::CannotStop { axis: 0, limit: 1.0, .. }), "{fast}");
    assert!(at(AxisState::new(0.84, 1.0, 0.0)).with_ranges([(-1.0, 1.0)]).is_ok());
    // Under way already: what is left counts.
    let mut g = at(AxisState::rest(0.0));
    g.set_target([AxisState::new(0.5, 0.3, 0.0)]).unwrap();
    g.step();
    assert!(matches!(g.clone().with_ranges([(-1.0, 0.4)]), Err(SyncError::OutsideRange { what: "target", .. })));
    assert!(matches!(g.clone().with_ranges([(-1.0, 0.501)]), Err(SyncError::CannotStop { what: "target", .. })));
    let mut g = g.with_ranges([(-1.0, 0.6)]).unwrap();
    while !g.step().events.reached {}
    assert_eq!(g.state()[0], AxisState::new(0.5, 0.3, 0.0));
}

#[test]
fn a_motion_that_leaves_the_range_between_is_refused_and_the_old_one_goes_on() {
    for mode in MODES {
        let mut g = generator(mode);
        g.set_target([AxisState::rest(1.0), AxisState::rest(0.0)]).unwrap();
        while g.state()[0].p < 0.7 {
            g.step();
        }
        // At full speed towards the end of its range; a fifth of the acceleration would not stop it in time.
        let mut same = g.clone();
        let slow = [AxisLimits::symmetric(1.0, 1.0, 50.0).unwrap(), *g.limits().last().unwrap()];
        let e = g.set_limits(slow).unwrap_err();
        assert!(matches!(e, SyncError::LeavesRange { axis: 0, limit: 1.0, .. }), "{e}");
        assert!(e.to_string().contains("stop it first"), "{e}");
        loop {
            let (step, other) = (g.step(), same.step());
            assert_eq!(step, other);
            assert!(step.state.q[0] <= 1.0);
            if step.events.reached {
                break;
            }
        }
        assert_eq!(g.state()[0], AxisState::rest(1.0));
    }
}

/// An axis that becomes faster again so near to its end that it has no time at constant velocity was said to brake from the first cycle
/// on, while it still accelerated.
#[test]
fn the_range_ends_for_an_axis_when_it_begins_to_brake() {
    let mut rng = Random::new(43);
    let (mut accelerating, mut anew) = (0, 0);
    for case in 0..300 {
        let l = AxisLimits::symmetric(1.0, rng.log(1.0, 10.0), rng.log(5.0, 100.0)).unwrap();
        let low = AxisLimits::symmetric(0.1, l.a_max(), l.j_max()).unwrap();
        let g = OnlineGenerator::new([AxisState::rest(0.0)], [l], CYCLE, Synchronisation::Time).unwrap();
        let sign = rng.one_of(&[1.0, -1.0]);
        let mut g = g.with_ranges([(-1.0, 1.0)]).unwrap();
        g.set_target([AxisState::new(sign * 0.2, sign * 0.4, 0.0)]).unwrap();
        while !g.step().events.arrived[0] {}
        g.set_limits([low]).unwrap();
        // Sometimes it brakes already.
        let left = rng.log(1e-4, 0.2);
        while 1.0 - sign * g.state()[0].p > left {
            g.step();
        }
        anew += usize::from(sign * g.state()[0].a < 0.0);
        g.set_limits([l]).unwrap();
        let mut cycles = vec![];
        while g.state()[0] != AxisState::rest(sign) && cycles.len() < 5000 {
            let brakes = g.step().events.range_ends[0];
            cycles.push((brakes, sign * g.state()[0].a));
        }
        assert_eq!(g.state()[0], AxisState::rest(sign), "case {case}");
        let begin = cycles.iter().position(|(brakes, _)| *brakes).unwrap();
        let accelerates = cycles.iter().rposition(|(_, a)| *a > 1e-9).map_or(0, |last| last + 1);
        accelerating += usize::from(accelerates > 0);
        for (cycle, (brakes, a)) in cycles.iter().enumerate() {
            assert_eq!(*brakes, cycle >= begin, "case {case}, {cycle}: {begin}");
            assert!(!brakes || *a < 1e-9, "case {case}, {cycle}: accelerates by {a} from {accelerates} on");
            // Else it releases the brake, to less than the jerk of a cycle.
            let releases = cycles[cycle..=begin.max(cycle)].iter().any(|(_, later)| later > a);
            assert!(*brakes || releases || *a > -l.j_max() * CYCLE, "case {case}, {cycle}: brakes by {a}");
        }
    }
    assert!(accelerating > 100 && anew > 10, "{accelerating} {anew}");
}

#[test]
fn an_axis_that_goes_on_brakes_before_its_range_ends() {
    for mode in MODES {
        let mut g = generator(mode);
        let e = g.set_target([AxisState::new(0.9, 0.9, 0.0), AxisState::rest(0.0)]).unwrap_err();
        assert!(matches!(e, SyncError::CannotStop { axis: 0, what: "target", .. }), "{e}");
        g.set_target([AxisState::new(0.3, 0.4, 0.5), AxisState::rest(0.5)]).unwrap();
        let (mut was, mut braking, mut arrived) = (*g.state(), 0, false);
        for _ in 0..6000 {
            let step = g.step();
            let now = g.state()[0];
            assert!((now.a - was[0].a).abs() / CYCLE <= 50.0 * (1.0 + 1e-6) && now.p <= 1.0);
            braking += usize::from(step.events.range_ends[0]);
            assert!(!step.events.range_ends[1]);
            if arrived && braking == 0 {
                assert!(now.v >= was[0].v - 1e-15);
            }
            arrived |= step.events.arrived[0];
            was = *g.state();
        }
        assert!(arrived && braking > 50, "{mode:?}: {braking}");
        assert_eq!(g.state()[0], AxisState::rest(1.0));
        // From there it can be sent back.
        g.set_target([AxisState::rest(-1.0), AxisState::rest(0.5)]).unwrap();
        while !g.step().events.reached {}
    }
}

/// Position and velocity change as the acceleration allows: nothing is cut off at the end of a range.
fn smooth(was: &AxisState, now: &AxisState, jerk: f64) -> bool {
    let (dp, dv) = (now.p - was.p - CYCLE * 0.5 * (was.v + now.v), now.v - was.v - 0.5 * CYCLE * (was.a + now.a));
    dp.abs() <= jerk * CYCLE.powi(3) / 12.0 * (1.0 + 1e-6) + 1e-14
        && dv.abs() <= jerk * CYCLE.powi(2) / 4.0 * (1.0 + 1e-6) + 1e-14
        && (now.a - was.a).abs() <= jerk * CYCLE * (1.0 + 1e-6)
}

/// Motions that would leave their range between touch its end instead, and arrive together all the same.
#[test]
fn motions_are_bent_at_the_end_of_their_range() {
    let mut rng = Random::new(91);
    let mut bent = [0; 2];
    for i in 0..60_000 {
        let p = moving_problem::<2>(&mut rng, 0.9);
        let mode = [Synchronisation::Time, Synchronisation::None][i % 2];
        let Ok(mut free) = OnlineGenerator::new(p.start, p.limits, CYCLE, mode) else { continue };
        free.set_target(p.target).unwrap();
        // The free motion leaves most of these by a little: more is impossible for most states.
        let ranges = std::array::from_fn(|k| {
            let way = free.plan().axes()[k].position_range();
            let (lo, hi) = (p.start[k].p.min(p.target[k].p), p.start[k].p.max(p.target[k].p));
            let part = rng.between(0.7, 1.0);
            (lo + part * (way.min - lo) - 1e-3, hi + part * (way.max - hi) + 1e-3)
        });
        let started = OnlineGenerator::new(p.start, p.limits, CYCLE, mode).and_then(|g| g.with_ranges(ranges));
        let Ok(mut g) = started else { continue };
        let leaves = free.plan().axes().iter().zip(&ranges).any(|(m, r)| m.check_within(*r).is_err());
        if !leaves || g.set_target(p.target).is_err() {
            continue;
        }
        bent[i % 2] += 1;
        assert!(g.time_left() >= free.time_left(), "case {i}");
        let (mut was, mut arrivals) = (*g.state(), 0);
        while g.is_underway() {
            let step = g.step();
            arrivals += usize::from(step.events.arrived.contains(&true));
            for k in 0..2 {
                let (now, l) = (g.state()[k], &p.limits[k]);
                let jerk = l.j_max().max(-l.j_min());
                assert!(smooth(&was[k], &now, jerk), "case {i} axis {k}: {:?} {now:?}", was[k]);
                assert!(l.contain(&now), "case {i} axis {k}: {now:?}");
                assert!(ranges[k].0 <= now.p && now.p <= ranges[k].1, "case {i} axis {k}: {now:?}");
            }
            was = *g.state();
        }
        assert!(mode == Synchronisation::None || arrivals == 1, "case {i}: {arrivals}");
    }
    // From most states that leave a range every motion does.
    println!("bent: {bent:?} by time and alone");
    assert!(bent[0] >= 15, "{bent:?}");
}

#[test]
fn a_stop_that_would_leave_the_range_is_bent() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap()];
    let mut g = OnlineGenerator::new([AxisState::rest(0.0)], limits, CYCLE, Synchronisation::Time).unwrap();
    g.set_target([AxisState::rest(2.0)]).unwrap();
    for _ in 0..900 {
        g.step();
    }
    let upper = g.state()[0].p + 0.1485;
    g.set_target([AxisState::rest(0.0)]).unwrap();
    let mut g = g.with_ranges([(-3.0, upper)]).unwrap();
    g.stop().unwrap();
    let mut was = g.state()[0];
    while g.is_underway() {
        g.step();
        assert!(smooth(&was, &g.state()[0], 50.0) && g.state()[0].p <= upper, "{was:?} {:?}", g.state()[0]);
        was = g.state()[0];
    }
    assert!(was.p < upper && was.v == 0.0);
}

/// The search of touches finds none here; the motion was refused.
#[test]
fn where_no_touch_is_found_the_axis_rests_on_the_way() {
    let limits = AxisLimits::new(
        (-0.33810943477643285, 0.33810943477643285),
        (-11.526684112534907, 4.604596061940169),
        (-98.5887559069809, 27.251353725965053),
    )
    .unwrap();
    let positions = PositionLimits::new(-0.01680318107124213, f64::INFINITY).unwrap();
    let target = AxisState::new(-0.016101356836060867, 0.07895839993142235, 4.604595768643944);
    let problem = BoundedProblem::new(&AxisState::rest(0.0), &target, &limits, &positions).unwrap();
    let motion = problem.shortest();
    positions.check(&motion).unwrap();
    let (phase, dt) = motion.phases().last().unwrap();
    let end = phase.after(dt);
    assert!((end.p - target.p).abs() < 1e-12 && (end.v - target.v).abs() < 1e-10, "{end:?}");
    assert!(motion.duration() < 0.69, "{}", motion.duration());
    // The axis starts at rest, so that it can wait: every longer duration is possible.
    for duration in [1.0001, 1.5, 10.0, 1000.0].map(|k| k * motion.duration()) {
        let longer = problem.with_duration(duration).unwrap();
        positions.check(&longer).unwrap();
        assert_eq!(longer.duration(), duration);
    }
}

/// The target can be reached, but no stop stays inside: longer durations are named as impossible.
#[test]
fn where_no_stop_stays_inside_no_longer_duration_is_named() {
    let limits = AxisLimits::symmetric(10.0, 9.0, 1e4).unwrap();
    let positions = PositionLimits::new(-1.0, 0.01).unwrap();
    let (start, target) = (AxisState::new(0.0, 9.5, 0.0), AxisState::new(0.01, 9.5, 0.0));
    let problem = BoundedProblem::new(&start, &target, &limits, &positions).unwrap();
    let e = problem.with_duration(2.0).unwrap_err();
    assert!(matches!(e, FeedError::DurationImpossible { above: f64::INFINITY, .. }), "{e}");
}
