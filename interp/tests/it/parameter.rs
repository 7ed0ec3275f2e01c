//! Four ways from the feed to the parameter, held against true arc length: on a circle, where it is an angle, and on a
//! spline by quadrature.

use crate::common;

use std::f64::consts::{FRAC_PI_2, PI};

use arcfeed_feedrate::{AxisLimits, MotionLaw, SProfile};
use arcfeed_geometry::{ArcLengthCurve, Curve, NurbsCurve};
use arcfeed_interp::parameter::{
    ArcLengthStep, CompensatedTaylor, FeedCycle, FirstTaylor, Fluctuation, ParameterStep, SecondTaylor, fluctuation,
};
use arcfeed_interp::{LimitError, PlanError};
use common::{by_length, knotted};
use nalgebra::Isometry3;

const PERIOD: f64 = 1e-3;

fn law(length: f64) -> SProfile {
    let limits = AxisLimits::symmetric(0.1, 1.0, 50.0).expect("valid limits");
    SProfile::new(length, 0.0, 0.0, &limits).expect("long enough")
}

/// Every way, in the order first, second, compensated, map.
fn all(curve: &ArcLengthCurve<3>) -> [Box<dyn ParameterStep + '_>; 4] {
    let nurbs = curve.curve();
    [
        Box::new(FirstTaylor::new(nurbs)),
        Box::new(SecondTaylor::new(nurbs)),
        Box::new(CompensatedTaylor::new(nurbs, 1e-15).expect("a tolerance above 0")),
        Box::new(ArcLengthStep::new(curve)),
    ]
}

fn measure(curve: &ArcLengthCurve<3>) -> [Fluctuation; 4] {
    let law = law(curve.length());
    all(curve).map(|mut step| fluctuation(curve, &law, PERIOD, step.as_mut()).expect("a period above 0"))
}

#[test]
fn closed_loops_end_exactly_and_open_loops_drift() {
    let curve = by_length(knotted());
    let [first, second, compensated, map] = measure(&curve);
    for (name, closed) in [("compensated", compensated), ("map", map)] {
        assert_eq!(closed.end, 1.0, "{name}");
        assert!(closed.truncation.abs() < 1e-15, "{name}: {closed:?}");
        assert!(closed.largest < 1e-9 && closed.rms <= closed.largest, "{name}: {closed:?}");
    }
    // The first order arrives early here, the second late; each cycle it is wrong by a fraction of its step.
    assert!(first.largest == 1.0 || first.truncation.abs() > 1e-6, "{first:?}");
    assert!(second.largest == 1.0 || second.truncation.abs() > 1e-9, "{second:?}");
    assert!(second.rms > 1e-6 && second.rms < 0.1 * first.rms, "{second:?} {first:?}");
    let law = law(curve.length());
    let [first, second, ..] = all(&curve).map(|mut step| {
        let middle = (0.5 * law.duration() / PERIOD) as usize;
        let (mut u, mut before) = (0.0, law.at(0.0));
        for i in 1..=middle {
            let now = law.at(i as f64 * PERIOD);
            u = step.step(&FeedCycle { period: PERIOD, feed: before.v, acceleration: before.a, s: now.p });
            before = now;
        }
        (curve.curve().arc_length_between(0.0, u, 1e-15).expect("inside the domain") - before.p).abs()
    });
    println!("drift half-way, m: first order {first:.1e}, second {second:.1e}");
    assert!(first > 1e-6 && second > 1e-9 && second < 0.1 * first, "{first} {second}");
}

#[test]
fn on_a_circle_the_arc_length_is_the_angle() {
    const RADIUS: f64 = 0.05;
    let half = NurbsCurve::<3>::arc(&Isometry3::identity(), RADIUS, 0.0, PI).expect("an arc");
    let curve = by_length(half);
    assert!((curve.length() - PI * RADIUS).abs() < 1e-15);
    let law = law(PI * RADIUS);
    let arc = |u: f64| {
        let p = curve.curve().point(u);
        RADIUS * p.y.atan2(p.x)
    };
    let mut worst = [0.0f64; 4];
    for (mut step, worst) in all(&curve).into_iter().zip(&mut worst) {
        let mut before = law.at(0.0);
        let mut last = 0.0;
        let cycles = (law.duration() / PERIOD).ceil() as usize;
        for i in 1..=cycles {
            let now = law.at(i as f64 * PERIOD);
            let u = step.step(&FeedCycle { period: PERIOD, feed: before.v, acceleration: before.a, s: now.p });
            assert!((last..=1.0).contains(&u), "{}: from {last} to {u}", step.name());
            *worst = worst.max((arc(u) - now.p).abs());
            (before, last) = (now, u);
        }
    }
    let [first, second, compensated, map] = worst;
    println!("largest distance from the asked place, m: {worst:?}");
    assert!(compensated < 1e-15 && map < 1e-15, "{worst:?}");
    assert!(first > 1e-5 && second < 0.1 * first && second > 1e-9, "{worst:?}");
}

#[test]
fn steps_stay_on_the_curve_whatever_the_feed_asks() {
    let curve = by_length(knotted());
    for s in [1e9, -1.0, 0.0, f64::NAN, f64::INFINITY] {
        for feed in [1e12, 0.0, -1.0, f64::NAN] {
            for mut step in all(&curve) {
                let mut last = 0.0;
                for _ in 0..3 {
                    let u = step.step(&FeedCycle { period: PERIOD, feed, acceleration: feed, s });
                    assert!((last..=1.0).contains(&u), "{}: {u} at s = {s}, feed {feed}", step.name());
                    last = u;
                }
            }
        }
    }
}

#[test]
fn a_bad_period_or_tolerance_is_refused() {
    let curve = by_length(NurbsCurve::<3>::arc(&Isometry3::identity(), 0.1, 0.0, FRAC_PI_2).expect("an arc"));
    let law = law(curve.length());
    for period in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        match fluctuation(&curve, &law, period, &mut ArcLengthStep::new(&curve)) {
            Err(PlanError::Limit(LimitError::NotPositive { what: "control period", value })) => {
                assert_eq!(value.to_bits(), period.to_bits());
            }
            other => panic!("{other:?}"),
        }
        assert!(period.is_infinite() || CompensatedTaylor::new(curve.curve(), period).is_err());
    }
}
