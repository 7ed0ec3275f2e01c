//! The S-profile: limits, exact ends, optimality against a dense search, adjusted speeds, scale.
use arcfeed_feedrate::{
    Adjust, Adjusted, AxisLimits, FeedError, MotionLaw, SProfile, distance_for_change, highest_speed_over,
    lowest_speed_over,
};
use proptest::prelude::*;

/// Eqs. 17 and 18, written out independently of the crate.
fn distance(v0: f64, v1: f64, a: f64, j: f64) -> f64 {
    let dv = (v1 - v0).abs();
    if dv <= a * a / j { (v0 + v1) * (dv / j).sqrt() } else { 0.5 * (v0 + v1) * (a / j + dv / a) }
}

fn duration_of_change(v0: f64, v1: f64, a: f64, j: f64) -> f64 {
    let dv = (v1 - v0).abs();
    if dv <= a * a / j { 2.0 * (dv / j).sqrt() } else { a / j + dv / a }
}

/// Limits that hold at dense samples, phases that chain, and ends that are exact.
fn hold(p: &SProfile, length: f64, v0: f64, v1: f64, v: f64, a: f64, j: f64) {
    let t_end = p.duration();
    assert!(t_end.is_finite() && t_end >= 0.0);
    let (first, last) = (p.at(0.0), p.at(t_end));
    assert_eq!((first.p, first.v, first.a), (0.0, v0, 0.0));
    assert_eq!((last.p, last.v, last.a), (length, v1, 0.0));
    let phases: Vec<_> = p.phases().collect();
    for (i, &(phase, dt)) in phases.iter().enumerate() {
        assert!(dt >= -1e-12 * t_end, "phase {i} lasts {dt}");
        for k in 0..=8 {
            let x = phase.after(dt * f64::from(k) / 8.0);
            assert!(x.v <= v * (1.0 + 1e-9) && x.v >= -1e-9 * v, "v {} of {v}", x.v);
            assert!(
                x.a.abs() <= a * (1.0 + 1e-9) && x.j.abs() <= j * (1.0 + 1e-9),
                "a {} of {a}, j {} of {j}",
                x.a,
                x.j
            );
        }
        let x = phase.after(dt);
        let next = phases.get(i + 1).map_or((length, v1, 0.0), |(n, _)| (n.s, n.v, n.a));
        // Round-off in time costs speed times its own: the clock carries one unit in the last place of t_end.
        let scale = p.v_peak();
        assert!((x.p - next.0).abs() <= 1e-9 * length, "phase {i}: s {} then {}", x.p, next.0);
        assert!((x.v - next.1).abs() <= 1e-9 * scale, "phase {i}: v {} then {}", x.v, next.1);
        assert!((x.a - next.2).abs() <= 1e-9 * a, "phase {i}: a {} then {}", x.a, next.2);
    }
}

fn decades(lo: f64, hi: f64) -> impl Strategy<Value = f64> {
    (lo..hi).prop_map(|e| 10f64.powf(e))
}

fn share() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..1.0_f64]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    #[test]
    fn adaptive_profiles_keep_every_limit_and_end_exactly(
        v in decades(-1.0, 1.0), a in decades(-1.0, 1.0), j in decades(-1.0, 2.0), length in decades(-4.0, 3.0),
        s0 in share(), s1 in share(), unit in -9..9_i32, clock in -3..3_i32, start in any::<bool>(),
    ) {
        let (l, t) = (10f64.powi(unit), 10f64.powi(clock));
        let (v, a, j, length) = (v * l / t, a * l / t / t, j * l / t / t / t, length * l);
        let limits = AxisLimits::symmetric(v, a, j).unwrap();
        let (v0, v1) = (s0 * v, s1 * v);
        let adjust = if start { Adjust::Start } else { Adjust::End };
        let p = SProfile::adaptive(length, v0, v1, &limits, adjust).unwrap();
        hold(&p, length, p.v_start(), p.v_end(), v, a, j);
        let fits = distance(v0, v1, a, j) <= length * (1.0 + 1e-9);
        match p.adjusted() {
            Adjusted::No => prop_assert!(fits && p.v_start() == v0 && p.v_end() == v1),
            Adjusted::End { asked, reached } => {
                prop_assert!(!start && asked == v1 && p.v_start() == v0 && p.v_end() == reached);
                prop_assert!(reached >= v0.min(v1) && reached <= v0.max(v1));
                // As little as possible: the displacement is used up.
                let used = distance(v0, reached, a, j);
                prop_assert!((used / length - 1.0).abs() < 1e-6 || (reached - v0).abs() < 1e-9 * v, "used {used} of {length}");
            }
            Adjusted::Start { asked, needed } => {
                prop_assert!(start && asked == v0 && p.v_end() == v1 && p.v_start() == needed);
                prop_assert!(needed >= v0.min(v1) && needed <= v0.max(v1));
            }
        }
        if distance(v0, v1, a, j) > length * (1.0 + 1e-6) {
            let refused = matches!(SProfile::new(length, v0, v1, &limits), Err(FeedError::TooShort { .. }));
            prop_assert!(refused || (v0 - v1).abs() < 1e-9 * v);
        }
    }

    #[test]
    fn no_cruise_speed_is_faster(
        v in decades(-1.0, 1.0), a in decades(-1.0, 1.0), j in decades(-1.0, 2.0), spare in decades(-6.0, 2.0),
        s0 in share(), s1 in share(),
    ) {
        let limits = AxisLimits::symmetric(v, a, j).unwrap();
        let (v0, v1) = (s0 * v, s1 * v);
        let length = distance(v0, v1, a, j) + spare;
        let p = SProfile::new(length, v0, v1, &limits).unwrap();
        // Dense search over the cruise speed, also below both ends.
        let mut best = f64::INFINITY;
        for k in 1..=4000 {
            let c = v * f64::from(k) / 4000.0;
            let left = length - distance(v0, c, a, j) - distance(c, v1, a, j);
            if left >= 0.0 {
                best = best.min(duration_of_change(v0, c, a, j) + duration_of_change(c, v1, a, j) + left / c);
            }
        }
        prop_assert!(p.duration() <= best * (1.0 + 1e-12), "{} against {best}", p.duration());
    }

    #[test]
    fn units_do_not_matter(length in decades(-3.0, 2.0), s0 in share(), s1 in share(), p in -10..10_i32, q in -5..5_i32) {
        // Powers of 64 scale exactly through square and cube roots.
        let (l, t) = (64f64.powi(p), 64f64.powi(q));
        let plain = AxisLimits::symmetric(1.0, 2.0, 30.0).unwrap();
        let scaled = AxisLimits::symmetric(l / t, 2.0 * l / t / t, 30.0 * l / t / t / t).unwrap();
        let one = SProfile::adaptive(length, s0, s1, &plain, Adjust::End).unwrap();
        let other = SProfile::adaptive(length * l, s0 * l / t, s1 * l / t, &scaled, Adjust::End).unwrap();
        prop_assert!((other.duration() / t / one.duration() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn reach_inverts_distance(v0 in share(), length in decades(-5.0, 1.0), a in decades(-1.0, 1.0), j in decades(0.0, 3.0)) {
        let limits = AxisLimits::symmetric(1e3, a, j).unwrap();
        let up = highest_speed_over(v0, length, &limits).unwrap();
        prop_assert!((distance(v0, up, a, j) / length - 1.0).abs() < 1e-6 || up - v0 < 1e-9);
        prop_assert!(distance(v0, up * (1.0 + 1e-6), a, j) > length);
        let down = lowest_speed_over(v0, length, &limits).unwrap();
        prop_assert!(distance(v0, down, a, j) <= length * (1.0 + 1e-6) || v0 - down < 1e-9);
        // Nothing lower is in reach.
        for k in 0..200 {
            let lower = down * (1.0 - 1e-6) * f64::from(k) / 200.0;
            prop_assert!(down == 0.0 || distance(v0, lower, a, j) > length, "{lower} < {down}");
        }
        let d = distance_for_change(v0, up, &limits).unwrap();
        prop_assert!((d - distance(v0, up, a, j)).abs() <= 1e-12 * d);
    }

    #[test]
    fn position_finds_the_state(length in decades(-3.0, 1.0), s0 in share(), s1 in share(), x in 0.0..1.0_f64) {
        let limits = AxisLimits::symmetric(1.0, 2.0, 30.0).unwrap();
        let p = SProfile::adaptive(length, s0, s1, &limits, Adjust::End).unwrap();
        let state = p.at(x * p.duration());
        let found = p.at_position(state.p);
        prop_assert!((found.v - state.v).abs() < 1e-7 * p.v_peak(), "{found:?} {state:?}");
    }
}

#[test]
fn invalid_input_is_named() {
    let limits = AxisLimits::symmetric(1.0, 1.0, 1.0).unwrap();
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        for (field, name) in ["length", "v_start", "v_end"].iter().enumerate() {
            let mut x = [0.5, 0.1, 0.1];
            x[field] = bad;
            for result in
                [SProfile::new(x[0], x[1], x[2], &limits), SProfile::adaptive(x[0], x[1], x[2], &limits, Adjust::End)]
            {
                let message = result.unwrap_err().to_string();
                assert!(message.starts_with(name), "{message}");
            }
        }
        for field in 0..3 {
            let mut x = [1.0; 3];
            x[field] = bad;
            let message = AxisLimits::symmetric(x[0], x[1], x[2]).unwrap_err().to_string();
            assert!(message.starts_with(["v_max", "a_max", "j_max"][field]), "{message}");
        }
    }
    assert!(matches!(SProfile::new(1.0, 2.0, 0.0, &limits), Err(FeedError::AboveLimit { what: "v_start", .. })));
    assert!(matches!(SProfile::new(0.0, 0.5, 0.0, &limits), Err(FeedError::TooShort { .. })));
    let still = SProfile::new(0.0, 0.5, 0.5, &limits).unwrap();
    assert_eq!((still.duration(), still.at(1.0).v), (0.0, 0.5));
    let kept = SProfile::adaptive(0.0, 0.5, 0.0, &limits, Adjust::End).unwrap();
    assert_eq!(kept.adjusted(), Adjusted::End { asked: 0.0, reached: 0.5 });
}

/// The closed forms are those of bounds that are the same in both directions. Others are refused, and not taken by one of their sides.
#[test]
fn bounds_that_differ_by_direction_are_refused() {
    for (name, a, j) in [("a", (-2.0, 1.0), (-20.0, 20.0)), ("j", (-1.0, 1.0), (-20.0, 10.0))] {
        let limits = AxisLimits::forward(1.0, a, j).unwrap();
        let results = [
            distance_for_change(0.2, 0.5, &limits).map(|_| ()),
            highest_speed_over(0.2, 1.0, &limits).map(|_| ()),
            lowest_speed_over(0.2, 1.0, &limits).map(|_| ()),
            SProfile::new(2.0, 0.2, 0.5, &limits).map(|_| ()),
            SProfile::adaptive(2.0, 0.2, 0.5, &limits, Adjust::End).map(|_| ()),
        ];
        for (i, result) in results.into_iter().enumerate() {
            let refused = matches!(result, Err(FeedError::NotSymmetric { what, .. }) if what == name);
            assert!(refused, "{name}, call {i}: {result:?}");
        }
    }
}

#[test]
fn extreme_numbers_never_panic_and_never_yield_nan() {
    let odd = [0.0, 5e-324, 1e-300, 1e-150, 1e-9, 1.0, 1e9, 1e150, 1e300, f64::MAX];
    for v in &odd[1..] {
        for a in &odd[1..] {
            for j in &odd[1..] {
                let limits = AxisLimits::symmetric(*v, *a, *j).unwrap();
                for length in odd {
                    for (v0, v1) in [(0.0, 0.0), (0.0, *v), (*v, 0.0), (*v, *v), (0.3 * v, 0.7 * v)] {
                        if let Ok(p) = SProfile::adaptive(length, v0, v1, &limits, Adjust::End) {
                            for t in [0.0, 0.3 * p.duration(), f64::NAN, f64::INFINITY, -1.0] {
                                let s = p.at(t);
                                assert!(!(s.p + s.v + s.a).is_nan(), "{v} {a} {j} {length} {v0} {v1}: {s:?}");
                            }
                        }
                    }
                }
            }
        }
    }
}
