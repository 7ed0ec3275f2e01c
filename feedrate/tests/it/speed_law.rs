//! Speed laws: derivatives that belong together, positions and times that invert each other, refusals by name.

use arcfeed_feedrate::AxisLimits;
use arcfeed_feedrate::{FeedError, MotionLaw, MotionState, SProfile, SpeedLaw};
use proptest::prelude::*;

/// Speed, acceleration and jerk against differences of what is one derivative below, at `t`.
fn assert_derivatives(law: &SpeedLaw, t: f64, scale: [f64; 3]) {
    let h = 1e-5 * law.duration();
    let (before, here, after) = (law.at(t - h), law.at(t), law.at(t + h));
    let slope = |f: fn(&MotionState) -> f64| (f(&after) - f(&before)) / (2.0 * h);
    for (what, got, expected, scale) in [
        ("speed", here.v, slope(|m| m.p), scale[0]),
        ("acceleration", here.a, slope(|m| m.v), scale[1]),
        ("jerk", here.j, slope(|m| m.a), scale[2]),
    ] {
        assert!((got - expected).abs() <= 1e-4 * scale, "{what} at t = {t}: {got}, by differences {expected}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Constant acceleration between random knots: `v^2` is linear in `s`, the time is the sum of `2 h / (v0 + v1)`.
    #[test]
    fn knots_are_joined_by_constant_acceleration(
        knots in prop::collection::vec((1e-3f64..1.0, 1e-2f64..2.0), 2..12), rests in (any::<bool>(), any::<bool>()), at in 0.0f64..1.0,
    ) {
        let mut s = vec![0.5];
        let mut v: Vec<f64> = knots.iter().map(|k| k.1).collect();
        s.extend(knots[1..].iter().scan(0.5, |sum, k| { *sum += k.0; Some(*sum) }));
        if rests.0 { v[0] = 0.0; }
        if rests.1 && v.len() > 2 { *v.last_mut().unwrap() = 0.0; }
        let law = SpeedLaw::from_knots(&s, &v).unwrap();
        let time: f64 = (1..s.len()).map(|k| 2.0 * (s[k] - s[k - 1]) / (v[k] + v[k - 1])).sum();
        prop_assert!((law.duration() - time).abs() <= 1e-13 * time, "{s:?} {v:?}");
        let place = s[0] + at * (s[s.len() - 1] - s[0]);
        let k = s.partition_point(|&x| x <= place).clamp(1, s.len() - 1);
        let part = (place - s[k - 1]) / (s[k] - s[k - 1]);
        let x = v[k - 1] * v[k - 1] * (1.0 - part) + v[k] * v[k] * part;
        let state = law.at_position(place);
        prop_assert!((state.v * state.v - x).abs() <= 1e-12 * (x + 1e-3), "{s:?} {v:?} at {place}: {}", state.v);
        // Before the last knot all stretches have their time, on the rest of the way the mean speed counts.
        let whole: f64 = (1..k).map(|k| 2.0 * (s[k] - s[k - 1]) / (v[k] + v[k - 1])).sum();
        let expected = if place > s[k - 1] { whole + 2.0 * (place - s[k - 1]) / (v[k - 1] + x.sqrt()) } else { whole };
        let passed = law.time_at_position(place);
        prop_assert!((passed - expected).abs() <= 1e-5 * time, "{s:?} {v:?} at {place}: {passed}, not {expected}");
        prop_assert!((law.at(passed).p - place).abs() <= 2e-12 * s[s.len() - 1], "{s:?} {v:?} at {place}: {passed}");
        for (t, knot) in law.knots() {
            prop_assert_eq!(law.time_at_position(knot.p), t);
        }
        prop_assert_eq!(law.time_at_position(s[s.len() - 1]), law.duration());
        // Time and position invert each other.
        let t = at * law.duration();
        let by_time = law.at(t);
        let by_place = law.at_position(by_time.p);
        prop_assert!((by_time.v - by_place.v).abs() <= 1e-7, "{s:?} {v:?} at t = {t}");
    }

    /// Phases of constant jerk: the sums are those of the closed form, and every state has the derivatives that it states.
    #[test]
    fn phases_hold_their_derivatives(phases in prop::collection::vec((-1.0f64..1.0, 1e-2f64..1.0), 1..8), at in 0.01f64..0.99) {
        let start = MotionState { p: -1.0, v: 20.0, a: 0.3, j: 0.0 };
        let law = SpeedLaw::from_phases(start, &phases).unwrap();
        let mut state = start;
        for &(j, dt) in &phases {
            state = MotionState {
                p: state.p + dt * (state.v + dt * (state.a / 2.0 + dt * j / 6.0)),
                v: state.v + dt * (state.a + dt * j / 2.0),
                a: state.a + dt * j,
                j,
            };
        }
        prop_assert!((law.end().p - state.p).abs() <= 1e-12 * 200.0 && (law.end().v - state.v).abs() <= 1e-12 * 30.0);
        let t = at * law.duration();
        let borders = law.knots().map(|(t, _)| t).chain([law.duration()]).collect::<Vec<_>>();
        if borders.iter().all(|b| (b - t).abs() > 2e-5 * law.duration()) {
            assert_derivatives(&law, t, [20.0, 10.0, 10.0]);
        }
        let by_time = law.at(t);
        let by_place = law.at_position(by_time.p);
        prop_assert!((by_time.v - by_place.v).abs() <= 1e-9 && (by_time.a - by_place.a).abs() <= 1e-9);
        let mut cursor = law.cursor();
        prop_assert_eq!(cursor.at(0.3 * t), law.at(0.3 * t));
        prop_assert_eq!(cursor.at(t), law.at(t));
        prop_assert_eq!(cursor.at(0.1 * t), law.at(0.1 * t));
    }
}

#[test]
fn a_profile_is_a_law_of_its_phases() {
    let profile = SProfile::new(0.3, 0.0, 0.05, &AxisLimits::symmetric(0.2, 1.0, 15.0).unwrap()).unwrap();
    let durations: Vec<(f64, f64)> = profile.phases().map(|(phase, dt)| (phase.j, dt)).collect();
    let law = SpeedLaw::from_phases(MotionState::default(), &durations).unwrap();
    for i in 0..=1000 {
        let t = profile.duration() * f64::from(i) / 1000.0;
        assert!((law.at(t).p - profile.at(t).p).abs() < 1e-14, "t = {t}");
    }
    // Near the standstill the distance is a cubic of the time: positions still give the speed in full.
    for ds in [1e-18, 1e-15, 1e-12, 1e-9, 1e-6] {
        let v = (ds * ds * 4.5 * 15.0_f64).cbrt();
        assert!((law.at_position(ds).v / v - 1.0).abs() < 1e-9, "ds = {ds}");
    }
}

#[test]
fn chained_laws_follow_one_another() {
    let part = SpeedLaw::from_knots(&[3.0, 3.5, 4.0], &[0.0, 1.0, 0.0]).unwrap();
    let chained = SpeedLaw::chain(-1.0, [part.clone(), part]);
    assert_eq!((chained.start(), chained.end().p, chained.duration()), (-1.0, 1.0, 4.0));
    assert_eq!(chained.at(3.0).v, 1.0);
    assert_eq!(chained.at_position(0.0).v, 0.0);
    assert_eq!(SpeedLaw::chain(2.0, []).end().p, 2.0);
}

#[test]
fn what_is_no_law_is_refused() {
    let refused = |s: &[f64], v: &[f64]| SpeedLaw::from_knots(s, v).unwrap_err();
    assert!(matches!(refused(&[0.0, 1.0], &[1.0]), FeedError::LengthMismatch { .. }));
    assert!(matches!(refused(&[0.0], &[1.0]), FeedError::Empty { .. }));
    assert!(matches!(refused(&[0.0, f64::NAN], &[1.0, 1.0]), FeedError::NotFinite { .. }));
    assert!(matches!(refused(&[0.0, 1.0], &[1.0, -1.0]), FeedError::Negative { .. }));
    assert!(matches!(refused(&[0.0, 0.0], &[1.0, 1.0]), FeedError::BadGrid { index: 1, .. }));
    assert!(matches!(refused(&[0.0, 1.0, 2.0], &[1.0, 0.0, 0.0]), FeedError::StandsStill { index: 1, .. }));
    let phases = |list: &[(f64, f64)]| SpeedLaw::from_phases(MotionState::default(), list).unwrap_err();
    assert!(matches!(phases(&[]), FeedError::Empty { .. }));
    assert!(matches!(phases(&[(1.0, -1.0)]), FeedError::Negative { what: "duration of a phase", .. }));
    assert!(matches!(phases(&[(1.0, 1.0), (-1.0, 3.0)]), FeedError::Negative { what: "speed in a phase", .. }));
    assert!(matches!(phases(&[(f64::INFINITY, 1.0)]), FeedError::NotFinite { .. }));
}
