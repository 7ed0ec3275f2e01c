//! Change of speed from any state: limits, exact end, minimality against an independent search.
use arcfeed_feedrate::{AxisLimits, FeedError, MotionLaw, SpeedChange};
use proptest::prelude::*;

/// Least time from (v0, a0) to (v1, 0) among all jerk-limited motions that visit one peak acceleration: the brute force
/// searches first-phase targets on a grid and solves only the remaining hold, keeping what ends at v1. It contains
/// the printed order (acceleration to zero first, then one trapezoid of acceleration).
fn brute_force(v0: f64, a0: f64, v1: f64, a: f64, j: f64) -> f64 {
    let mut best = f64::INFINITY;
    let steps = 4000;
    // Sequence: a0 -> p1 -> p2 -> 0, holding at p1 (p1 and p2 on a grid that includes 0), each ramp at full jerk.
    for i in -steps..=steps {
        let p = a * f64::from(i) / f64::from(steps);
        for via_zero in [false, true] {
            let mut v = v0;
            let mut t = 0.0;
            let mut acc = a0;
            if via_zero {
                v += 0.5 * acc * acc.abs() / j;
                t += acc.abs() / j;
                acc = 0.0;
            }
            let ramp = (p - acc).abs() / j;
            v += 0.5 * (acc + p) * ramp;
            t += ramp;
            let down = p.abs() / j;
            v += 0.5 * p * down;
            t += down;
            // What is missing has to be made up by holding p.
            let hold = (v1 - v) / p;
            if hold >= 0.0 {
                best = best.min(t + hold);
            }
        }
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn is_the_shortest_way_and_keeps_the_limits(
        v0 in 0.0..3.0_f64, a0 in -6.0..6.0_f64, v1 in 0.0..2.0_f64, a in 0.5..4.0_f64, j in 1.0..60.0_f64,
    ) {
        let limits = AxisLimits::symmetric(2.0, a, j).unwrap();
        let c = SpeedChange::new(v0, a0, v1, &limits).unwrap();
        let best = brute_force(v0, a0, v1, a, j);
        prop_assert!(c.duration() <= best * (1.0 + 1e-9), "{} against {best}", c.duration());
        // On the grid the search comes close, so a duration far below would be no motion at all.
        prop_assert!(c.duration() >= best - 0.05 * best - 1e-3, "{} against {best}", c.duration());
        let end = c.at(c.duration());
        prop_assert_eq!((end.v, end.a), (v1, 0.0));
        let first = c.at(0.0);
        prop_assert_eq!((first.p, first.v, first.a), (0.0, v0, a0));
        let phases: Vec<_> = c.phases().collect();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, &(phase, dt)) in phases.iter().enumerate() {
            prop_assert!(dt >= 0.0 && phase.j.abs() <= j * (1.0 + 1e-12));
            for k in 0..=20 {
                let x = phase.after(dt * f64::from(k) / 20.0);
                // Outside the limit only while it is being brought back from where it started.
                prop_assert!(x.a.abs() <= a.max(a0.abs()) * (1.0 + 1e-12));
                prop_assert!(x.a.abs() <= a * (1.0 + 1e-9) || i == 0 && x.a * a0 > 0.0);
                low = f64::min(low, x.v);
                high = f64::max(high, x.v);
            }
            let x = phase.after(dt);
            let (s, v, acc) = phases.get(i + 1).map_or((end.p, end.v, end.a), |(n, _)| (n.s, n.v, n.a));
            prop_assert!((x.p - s).abs() < 1e-12 * (1.0 + s.abs()) && (x.v - v).abs() < 1e-12 * 10.0 && (x.a - acc).abs() < 1e-11, "phase {i}");
        }
        prop_assert!(c.lowest_speed() <= low + 1e-12 && c.highest_speed() >= high - 1e-12);
        prop_assert!((c.lowest_speed() - low).abs() < 0.02 * (1.0 + a0.abs()) && (c.highest_speed() - high).abs() < 0.02 * (1.0 + a0.abs()));
        // Below 0 only where taking off the braking at once goes below 0 too.
        let unavoidable = v0 - 0.5 * a0.min(0.0).powi(2) / j;
        prop_assert!(!c.reverses() || unavoidable < 0.0, "dips to {} although {unavoidable}", c.lowest_speed());
        prop_assert!(c.lowest_speed() >= unavoidable.min(v1).min(v0) - 1e-12);
    }

    #[test]
    fn units_do_not_matter(v0 in 0.0..3.0_f64, a0 in -6.0..6.0_f64, v1 in 0.0..2.0_f64, p in -30..30_i32) {
        let l = 2f64.powi(2 * p);
        let one = SpeedChange::new(v0, a0, v1, &AxisLimits::symmetric(2.0, 3.0, 40.0).unwrap()).unwrap();
        let other = SpeedChange::new(v0 * l, a0 * l, v1 * l, &AxisLimits::symmetric(2.0 * l, 3.0 * l, 40.0 * l).unwrap()).unwrap();
        prop_assert_eq!(one.duration(), other.duration());
    }
}

#[test]
fn printed_order_is_longer_when_the_acceleration_points_the_right_way() {
    let limits = AxisLimits::symmetric(2.0, 2.0, 10.0).unwrap();
    let (v0, a0, v1) = (0.2, 1.5, 1.6);
    let ours = SpeedChange::new(v0, a0, v1, &limits).unwrap();
    // Eqs. 14 to 18: first a to zero, then one S-shaped change.
    let first = SpeedChange::new(v0, a0, v0 + 0.5 * a0 * a0 / 10.0, &limits).unwrap();
    let second = SpeedChange::new(first.at(first.duration()).v, 0.0, v1, &limits).unwrap();
    assert!(ours.duration() < 0.85 * (first.duration() + second.duration()));
}

#[test]
fn a_start_above_the_limit_brakes_and_a_hard_start_dips() {
    let limits = AxisLimits::symmetric(1.0, 2.0, 10.0).unwrap();
    let fast = SpeedChange::new(3.0, 5.0, 1.0, &limits).unwrap();
    assert!(!fast.reverses() && fast.at(fast.duration()).v == 1.0);
    let dip = SpeedChange::brake(0.01, -2.0, &limits).unwrap();
    assert!(dip.reverses() && (dip.lowest_speed() - (0.01 - 0.2)).abs() < 1e-12);
    let rest = SpeedChange::brake(0.0, 0.0, &limits).unwrap();
    assert_eq!(rest.duration(), 0.0);
}

#[test]
fn invalid_input_is_named() {
    let limits = AxisLimits::symmetric(1.0, 2.0, 10.0).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (field, name) in ["v", "a", "target"].iter().enumerate() {
            let mut x = [0.1; 3];
            x[field] = bad;
            let message = SpeedChange::new(x[0], x[1], x[2], &limits).unwrap_err().to_string();
            assert!(message.starts_with(name), "{message}");
        }
    }
    assert!(matches!(SpeedChange::new(0.0, 0.0, 2.0, &limits), Err(FeedError::AboveLimit { what: "target", .. })));
    assert!(matches!(SpeedChange::new(0.0, 0.0, -2.0, &limits), Err(FeedError::Negative { what: "target", .. })));
}

/// A start at its peak acceleration was sampled with the jerk of the first phase, which lasts no time.
#[test]
fn a_start_at_the_peak_acceleration_is_sampled_right() {
    let limits = AxisLimits::symmetric(2.0, 2.0, 10.0).unwrap();
    for (v, a) in [(1.5, -2.0), (-1.5, 2.0), (0.2, -2.0)] {
        let change = SpeedChange::brake(v, a, &limits).unwrap();
        let mut before = change.at(0.0);
        assert_eq!((before.p, before.v, before.a), (0.0, v, a));
        for i in 1..=1000 {
            let h = change.duration() / 1000.0;
            let now = change.at(h * f64::from(i));
            assert!((now.a - before.a).abs() <= 10.0 * h * (1.0 + 1e-9), "{i}: {now:?}");
            assert!(now.a.abs() <= 2.0 * (1.0 + 1e-12), "{i}: {now:?}");
            before = now;
        }
    }
}
