//! Velocity as soon as possible, stops, ranges of positions.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, MotionLaw, StateToState};

use crate::common;
use arcfeed_testing::Random;
use common::axis::{Case, fault, random_case};

#[test]
fn velocity_is_reached_and_nothing_is_earlier() {
    let mut rng = Random::new(31);
    for i in 0..100_000 {
        let case = random_case(&mut rng, i % 3 == 0);
        let limits = case.limits();
        let motion = StateToState::to_velocity(&case.start, case.target.v, case.target.a, &limits).unwrap();
        let end = motion.at(motion.duration());
        let there = Case { target: AxisState::new(end.p, end.v, end.a), ..case };
        assert_eq!((end.v, end.a), (case.target.v, case.target.a));
        if let Some(text) = fault(&there, &motion) {
            panic!("case {i}: {text}: {case:?}");
        }
        // To any position it takes at least as long, and to the place it ends in exactly as long.
        assert!(motion.duration() <= case.solve().unwrap().duration() * (1.0 + 1e-12), "{case:?}");
        if case.start_inside() {
            let same = there.solve().unwrap().duration();
            assert!((same - motion.duration()).abs() <= 1e-9 * same, "{same} {}: {case:?}", motion.duration());
        }
    }
}

#[test]
fn scales_exactly() {
    let mut rng = Random::new(32);
    for i in 0..20_000 {
        let case = random_case(&mut rng, i % 3 == 0);
        let (length, time) =
            (2f64.powi((rng.unit() * 400.0) as i32 - 200), 2f64.powi((rng.unit() * 200.0) as i32 - 100));
        let scaled = case.scaled(length, time);
        let go = |c: &Case| StateToState::to_velocity(&c.start, c.target.v, c.target.a, &c.limits()).unwrap();
        let (here, there) = (go(&case), go(&scaled));
        assert_eq!(here.duration() * time, there.duration());
        assert_eq!(here.at(here.duration()).p * length, there.at(there.duration()).p);
    }
}

#[test]
fn a_stop_respects_positions_if_it_can() {
    let mut rng = Random::new(33);
    let mut counts = [0; 3];
    for i in 0..4000 {
        let case = random_case(&mut rng, i % 10 == 0);
        let limits = case.limits();
        let shortest = StateToState::stop(&case.start, &limits).unwrap();
        let range = shortest.position_range();
        let size = range.max - range.min;
        // A bound a little before or behind the place the shortest stop gets to.
        let shift = size * (0.2 * rng.unit() - 0.15);
        let bounds = if range.max > case.start.p {
            (f64::NEG_INFINITY, range.max + shift)
        } else {
            (range.min - shift, f64::INFINITY)
        };
        if !(bounds.0 <= case.start.p && case.start.p <= bounds.1) || size == 0.0 {
            continue;
        }
        match StateToState::stop_within(&case.start, &limits, bounds) {
            Ok(motion) => {
                let r = motion.position_range();
                assert!(r.min >= bounds.0 && r.max <= bounds.1, "{r:?} {bounds:?}: {case:?}");
                let end = motion.at(motion.duration());
                assert_eq!((end.v, end.a), (0.0, 0.0));
                let there = Case { target: AxisState::rest(end.p), ..case };
                if let Some(text) = fault(&there, &motion) {
                    panic!("case {i}: {text}: {case:?}");
                }
                counts[usize::from(motion != shortest)] += 1;
            }
            Err(FeedError::LeavesPositions { position, time, limit }) => {
                counts[2] += 1;
                assert!(limit == bounds.0 || limit == bounds.1);
                assert!((position - shortest.at(time).p).abs() <= 1e-12 * (size + position.abs()));
                // Jerk and then acceleration to the limit until the velocity is zero: nothing turns earlier.
                let up = limit == bounds.1;
                let c = if up { case } else { case.mirrored() };
                let turn = hardest_turn(&c);
                let bound = if up { bounds.1 } else { -bounds.0 };
                // Unless the velocity limit on the other side does not leave room to come back.
                let room = 0.5 * c.a.0 * c.a.0 / c.j.1 < -c.v.0;
                assert!(!room || turn >= bound - 1e-9 * size, "turns at {turn} within {bound}: {case:?}");
            }
            Err(e) => panic!("{e}: {case:?}"),
        }
    }
    println!("shortest, harder, impossible: {counts:?}");
    assert!(counts.iter().all(|&n| n > 50), "{counts:?}");
    let limits = AxisLimits::symmetric(1.0, 1.0, 1.0).unwrap();
    let bad = StateToState::stop_within(&AxisState::rest(0.0), &limits, (f64::NAN, 1.0));
    assert!(matches!(bad, Err(FeedError::NotFinite { what: "p_min", .. })));
}

/// Highest position when the acceleration goes down to its limit as fast as possible, in small steps.
fn hardest_turn(c: &Case) -> f64 {
    let AxisState { mut p, mut v, mut a } = c.start;
    let mut top = p;
    let dt = ((v.abs() - 0.5 * a * a / c.j.0) / -c.a.0 + (a - c.a.0).abs() / -c.j.0) / 20_000.0;
    for _ in 0..200_000 {
        // Exact for constant jerk; the bound is met within one step.
        let j = if a > c.a.0 {
            c.j.0
        } else if a < c.a.0 - 1e-3 * c.j.1 * dt {
            c.j.1
        } else {
            0.0
        };
        p += dt * (v + dt * (0.5 * a + dt * j / 6.0));
        v += dt * (a + 0.5 * dt * j);
        a += dt * j;
        if a < c.a.0 && j < 0.0 {
            a = c.a.0;
        }
        top = top.max(p);
        if v < 0.0 && a < 0.0 {
            break;
        }
    }
    top
}

/// What no blend leads to is refused by name, and what is accepted has no jump.
#[test]
fn a_blend_leads_to_its_target_or_is_refused() {
    let state = AxisState::new;
    let (start, target) = (state(0.0, 1.0, 0.0), state(0.3, 0.5, 0.0));
    let motion = StateToState::blend(&start, &target, 0.4).unwrap();
    let before = motion.at(0.4 * (1.0 - 1e-12));
    assert!((before.p - 0.3).abs() < 1e-11 && (before.v - 0.5).abs() < 1e-10 && before.a.abs() < 1e-10);
    for (start, target, duration, what) in [
        (state(0.0, 1.0, 0.0), state(100.0, 0.5, 0.0), 0.4, "target.p"),
        (state(0.0, 1.0, 0.0), state(0.3 + 1e-12, 0.5, 0.0), 0.4, "target.p"),
        (state(0.0, 1.0, 0.0), state(0.0, 0.5, 0.0), 0.0, "target.v"),
        (state(0.0, 1.0, 0.0), state(0.1, 1.0, 0.0), 0.0, "target.p"),
        (state(0.0, 1.0, 0.0), state(0.0, 1.0, 1.0), 0.0, "target.a"),
        (state(0.0, 1.0, 2.0), state(0.3, 0.5, 0.0), 0.4, "start.a"),
        (state(0.0, 1.0, 0.0), state(0.3, 0.5, 2.0), 0.4, "target.a"),
    ] {
        let e = StateToState::blend(&start, &target, duration).unwrap_err();
        assert!(matches!(e, FeedError::NoBlend { what: named, .. } if named == what), "{e}");
    }
    for i in 0..6 {
        let mut numbers = [0.0, 1.0, 0.0, 0.3, 0.5, 0.0];
        numbers[i] = f64::NAN;
        let [p0, v0, a0, p1, v1, a1] = numbers;
        let e = StateToState::blend(&state(p0, v0, a0), &state(p1, v1, a1), 0.4).unwrap_err();
        assert!(matches!(e, FeedError::NotFinite { .. }), "{e}");
    }
    assert!(
        StateToState::blend(&start, &target, -1.0).is_err() && StateToState::blend(&start, &target, f64::NAN).is_err()
    );
    // The same state in no time.
    let here = state(0.2, 1.5, 3.0);
    let still = StateToState::blend(&here, &here, 0.0).unwrap();
    assert_eq!((still.duration(), still.at(0.0).v, still.at(0.0).a), (0.0, 1.5, 3.0));
}
