//! Orientation profiles: keys, rates against finite differences, continuity, headings.
#![allow(clippy::unwrap_used)]

use arcfeed_geometry::nalgebra::{Unit, UnitQuaternion, Vector3, vector};
use arcfeed_geometry::{ArcLengthCurve, GeometryError, NurbsCurve, OrientationPath};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn rotation(v: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(v)
}

/// First derivative by the central difference of order 8.
fn difference(f: impl Fn(f64) -> Vector3<f64>, x: f64, h: f64) -> Vector3<f64> {
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut sum = Vector3::zeros();
    for (k, w) in weights.iter().enumerate() {
        let step = (k + 1) as f64 * h;
        sum += (f(x + step) - f(x - step)) * (w / h);
    }
    sum
}

/// Rates of `path` at `s` against differences of the rotation, of the rate and of its derivative.
fn check_rates(path: &OrientationPath, s: f64, h: f64) {
    let at = path.jet(s);
    let turned = |x: f64| (path.jet(x).rotation * at.rotation.inverse()).scaled_axis();
    let scale = 1.0 + at.rate.norm() + at.d_rate.norm() + at.dd_rate.norm();
    for (what, error) in [
        ("rate", difference(turned, s, h) - at.rate),
        ("d_rate", difference(|x| path.jet(x).rate, s, h) - at.d_rate),
        ("dd_rate", difference(|x| path.jet(x).d_rate, s, h) - at.dd_rate),
    ] {
        assert!(error.norm() < 1e-9 * scale, "{what} is off by {} at {s}", error.norm());
    }
    assert!((at.rotation.norm() - 1.0).abs() < 1e-15);
}

fn check_keys(path: &OrientationPath, keys: &[(f64, UnitQuaternion<f64>)]) {
    for (s, q) in keys {
        let angle = path.jet(*s).rotation.angle_to(q);
        assert!(angle < 1e-14 * 4.0, "off the key at {s} by {angle}");
    }
    for pair in keys.windows(2) {
        for f in [0.1, 0.35, 0.5, 0.8] {
            check_rates(path, pair[0].0 + f * (pair[1].0 - pair[0].0), 0.003 * (pair[1].0 - pair[0].0));
        }
    }
    // Rate and its derivative are continuous.
    for (s, _) in &keys[1..keys.len() - 1] {
        let (before, after) = (path.jet(s - 1e-9), path.jet(s + 1e-9));
        let scale = 1.0 + after.rate.norm() + after.d_rate.norm() + after.dd_rate.norm() + before.dd_rate.norm();
        assert!((before.rate - after.rate).norm() < 1e-8 * scale, "rate jumps at {s}");
        assert!((before.d_rate - after.d_rate).norm() < 1e-8 * scale, "d_rate jumps at {s}");
    }
}

#[test]
fn slerp_turns_at_a_constant_rate_on_the_shorter_arc() {
    let from = rotation(vector![0.3, -0.2, 1.0]);
    for step in [vector![0.5, 0.1, -0.7], vector![0.0, 0.0, 3.1], vector![1e-9, 0.0, 0.0], vector![0.0, 0.0, 0.0]] {
        let to = from * rotation(step);
        let path = OrientationPath::slerp(0.4, from, to).unwrap();
        check_keys(&path, &[(0.0, from), (0.4, to)]);
        for i in 0..=10 {
            let s = 0.04 * f64::from(i);
            let jet = path.jet(s);
            assert!(jet.rotation.angle_to(&(from * rotation(step * (s / 0.4)))) < 1e-15 * 4.0);
            assert!((jet.rate - from * step / 0.4).norm() < 1e-13, "{}", jet.rate);
            assert!(jet.d_rate.norm() < 1e-12 && jet.dd_rate.norm() < 1e-11);
        }
    }
    // 4 rad one way are 2 pi - 4 the other way; the sign of a quaternion means nothing.
    let to = from * rotation(vector![0.0, 4.0, 0.0]);
    for to in [to, UnitQuaternion::new_unchecked(-to.into_inner())] {
        let rate = OrientationPath::slerp(1.0, from, to).unwrap().jet(0.5).rate;
        assert!((rate - from * vector![0.0, 4.0 - TAU, 0.0]).norm() < 1e-13, "{rate}");
    }
}

#[test]
fn half_a_turn_is_a_slerp_too() {
    let path = OrientationPath::slerp(1.0, UnitQuaternion::identity(), rotation(vector![PI, 0.0, 0.0])).unwrap();
    let jet = path.jet(0.5);
    assert!((jet.rate.norm() - PI).abs() < 1e-14);
    assert!((jet.rotation.angle() - FRAC_PI_2).abs() < 1e-14);
}

#[test]
fn several_turns_about_one_axis() {
    // Keys every 100 degrees over three turns: the rate is constant, and nothing happens at pi or 2 pi.
    let axis = Unit::new_normalize(vector![1.0, 2.0, -0.5]);
    let first = rotation(vector![0.1, 0.7, 0.2]);
    for step in [100f64.to_radians(), 90f64.to_radians(), 120f64.to_radians(), 60f64.to_radians()] {
        let keys: Vec<_> = (0..12)
            .map(|i| (0.1 * f64::from(i), UnitQuaternion::from_axis_angle(&axis, step * f64::from(i)) * first))
            .collect();
        let path = OrientationPath::through(&keys).unwrap();
        check_keys(&path, &keys);
        for i in 0..=110 {
            let jet = path.jet(0.01 * f64::from(i));
            assert!((jet.rate - axis.into_inner() * (10.0 * step)).norm() < 1e-10, "{} at {i}", jet.rate);
        }
    }
}

#[test]
fn a_tumble_takes_the_shorter_way_between_keys() {
    // A turn about z in steps of 60 degrees while the axis nods: near a full turn the keys are close to the first
    // orientation without being equal to it.
    for nod in [1e-10, 1e-6, 0.01, 0.3] {
        let keys: Vec<_> = (0..10)
            .map(|i| {
                let i = f64::from(i);
                (
                    i,
                    rotation(vector![0.0, 0.0, i * PI / 3.0])
                        * rotation(vector![nod * (0.7 * i + 1.0).sin(), nod, 0.0]),
                )
            })
            .collect();
        let path = OrientationPath::through(&keys).unwrap();
        check_keys(&path, &keys);
        for pair in keys.windows(2) {
            // The way from key to key, against the direct one.
            let mut way = 0.0;
            for i in 0..100 {
                let s = pair[0].0 + (f64::from(i) + 0.5) / 100.0;
                way += path.jet(s).rate.norm() / 100.0;
            }
            let direct = pair[0].1.angle_to(&pair[1].1);
            assert!(way < 1.2 * direct, "nod {nod}: {way} rad instead of {direct} after {}", pair[0].0);
        }
    }
}

#[test]
fn the_base_frame_does_not_matter() {
    let keys: Vec<_> = (0..6)
        .map(|i| {
            (f64::from(i), rotation(vector![(1.3 * f64::from(i)).sin(), 0.4 * f64::from(i), (f64::from(i)).cos()]))
        })
        .collect();
    let turn = rotation(vector![0.4, -1.0, 2.0]);
    let tool = rotation(vector![-0.3, 0.1, 1.0]);
    let turned: Vec<_> = keys.iter().map(|(s, q)| (*s, turn * q * tool)).collect();
    let (path, other) = (OrientationPath::through(&keys).unwrap(), OrientationPath::through(&turned).unwrap());
    for i in 0..=50 {
        let s = 0.1 * f64::from(i);
        assert!((turn * path.jet(s).rotation * tool).angle_to(&other.jet(s).rotation) < 1e-12);
        assert!((turn * path.jet(s).rate - other.jet(s).rate).norm() < 1e-11);
    }
}

#[test]
fn keys_that_do_not_increase() {
    let q = UnitQuaternion::identity();
    let index = |keys: &[(f64, UnitQuaternion<f64>)]| match OrientationPath::through(keys) {
        Err(GeometryError::OrientationKey { index, .. }) => index,
        other => panic!("{other:?}"),
    };
    assert_eq!(index(&[(0.0, q), (0.0, q)]), 1);
    assert_eq!(index(&[(0.0, q), (1.0, q), (0.5, q)]), 2);
    assert_eq!(index(&[(f64::NAN, q), (1.0, q)]), 0);
    assert_eq!(index(&[(0.0, q), (f64::INFINITY, q)]), 1);
    assert!(matches!(OrientationPath::through(&[(0.0, q)]), Err(GeometryError::TooFewPoints { .. })));
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(OrientationPath::slerp(length, q, q), Err(GeometryError::NotPositive { .. })));
    }
}

fn wave() -> ArcLengthCurve<3> {
    let points = vec![
        vector![0.0, 0.0, 0.0],
        vector![0.1, 0.2, 0.0],
        vector![0.3, -0.2, 0.05],
        vector![0.4, 0.2, 0.1],
        vector![0.2, 0.4, 0.1],
        vector![0.0, 0.3, 0.1],
    ];
    let knots = vec![0.0, 0.0, 0.0, 0.0, 0.4, 0.7, 1.0, 1.0, 1.0, 1.0];
    ArcLengthCurve::new(NurbsCurve::new(3, points, vec![1.0, 2.0, 1.0, 0.5, 1.0, 1.0], knots).unwrap(), 1e-13).unwrap()
}

#[test]
fn heading_follows_the_tangent() {
    let curve = wave();
    let axis = Unit::new_normalize(vector![0.1, 0.0, 1.0]);
    let start = rotation(vector![PI, 0.0, 0.3]);
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
        let path = OrientationPath::following_tangent(&curve, axis, start, tolerance).unwrap();
        let OrientationPath::Heading(heading) = &path else { panic!("not a heading") };
        assert!(heading.deviation() <= tolerance);
        let across = |t: Vector3<f64>| (t - axis.into_inner() * axis.dot(&t)).normalize();
        let at_start = across(curve.jet(0.0).d1);
        let mut worst = 0.0f64;
        for i in 0..=20_000 {
            let s = curve.length() * f64::from(i) / 20_000.0;
            // The direction that lay along the tangent at the start.
            let carried = path.jet(s).rotation * start.inverse() * at_start;
            let tangent = across(curve.jet(s).d1);
            worst = worst.max(2.0 * (0.5 * (carried - tangent).norm()).asin());
        }
        assert!(worst <= tolerance, "{worst} with {tolerance}");
        let knots = path.knots();
        for pair in knots.windows(2).step_by(knots.len() / 20 + 1) {
            check_rates(&path, 0.5 * (pair[0] + pair[1]), 0.01 * (pair[1] - pair[0]));
        }
        for &s in &knots[1..knots.len() - 1] {
            let (before, after) = (path.jet(s - 1e-10), path.jet(s + 1e-10));
            let scale = 1.0 + after.rate.norm() + after.d_rate.norm() + after.dd_rate.norm() + before.dd_rate.norm();
            assert!((before.d_rate - after.d_rate).norm() < 1e-9 * scale);
        }
    }
}

#[test]
fn heading_turns_through_a_whole_circle() {
    let circle = NurbsCurve::<3>::circle(&arcfeed_geometry::nalgebra::Isometry3::identity(), 0.05).unwrap();
    let curve = ArcLengthCurve::new(circle, 1e-14).unwrap();
    let path = OrientationPath::following_tangent(&curve, Vector3::z_axis(), UnitQuaternion::identity(), 1e-6).unwrap();
    for i in 1..100 {
        let s = curve.length() * f64::from(i) / 100.0;
        assert!((path.jet(s).rate - vector![0.0, 0.0, 20.0]).norm() < 1e-3, "{} at {s}", path.jet(s).rate);
    }
}

#[test]
fn headings_that_do_not_exist() {
    let q = UnitQuaternion::identity();
    let curve = wave();
    for tolerance in [0.0, -1.0, f64::NAN] {
        let refused = OrientationPath::following_tangent(&curve, Vector3::z_axis(), q, tolerance);
        assert!(matches!(refused, Err(GeometryError::NotPositive { .. })));
    }
    let up = NurbsCurve::line(vector![0.0, 0.0, 0.0], vector![0.0, 0.0, 1.0]).unwrap();
    let up = ArcLengthCurve::new(up, 1e-12).unwrap();
    let refused = OrientationPath::following_tangent(&up, Vector3::z_axis(), q, 1e-6);
    assert!(matches!(refused, Err(GeometryError::NoHeading { .. })));
    let corner = NurbsCurve::polyline(vec![vector![0.0, 0.0, 0.0], vector![1.0, 0.0, 0.0], vector![1.0, 1.0, 0.0]]);
    let corner = ArcLengthCurve::new(corner.unwrap(), 1e-12).unwrap();
    let refused = OrientationPath::following_tangent(&corner, Vector3::z_axis(), q, 1e-6);
    assert!(matches!(refused, Err(GeometryError::HeadingJump { s, .. }) if (s - 1.0).abs() < 1e-12));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_keys(steps in proptest::collection::vec((0.1f64..1.0, -1.8f64..1.8, -1.8f64..1.8, -1.8f64..1.8), 2..10)) {
        let mut keys = vec![(0.0, UnitQuaternion::identity())];
        for (h, x, y, z) in steps {
            let (s, q) = keys[keys.len() - 1];
            keys.push((s + h, q * rotation(vector![x, y, z])));
        }
        let path = OrientationPath::through(&keys).unwrap();
        check_keys(&path, &keys);
    }
}

#[test]
fn keys_without_cubics_of_a_continuous_acceleration_get_one_all_the_same() {
    // Turns of 1.4 to 2.7 rad within steps of very different widths: the iteration for the rates of the first set needs more
    // than thirty rounds, that of the second finds none.
    let many_rounds = [
        (0.28221363939055655, 0.0, 0.0, 0.0),
        (0.7620710368255403, -0.8393596608252141, 1.015024283719748, 0.0),
        (0.1, 0.0, -0.7007707189178541, 0.0),
        (0.34435100888265174, -0.8418366283421512, -1.0534717815994963, 0.0),
        (0.1606519253583305, 1.6329297949724007, 0.7277522507266709, -1.61832366678699),
        (0.6374941686501905, -1.5942247724382494, -0.8501908758021198, 1.6986163601391473),
    ];
    let none = [
        (0.23187461403050227, 1.0740813661015294, 0.8717655908836984, -0.5694277558815863),
        (0.10820824735431697, -1.150260471462613, 1.150903793219585, -1.7527328082184137),
        (0.6487869364758443, 1.6095246164112174, -1.1215886658062957, 1.4990963843418803),
    ];
    for steps in [&many_rounds[..], &none] {
        let mut keys = vec![(0.0, UnitQuaternion::identity())];
        for &(h, x, y, z) in steps {
            let (s, q) = keys[keys.len() - 1];
            keys.push((s + h, q * rotation(vector![x, y, z])));
        }
        let path = OrientationPath::through(&keys).unwrap();
        check_keys(&path, &keys);
        for (s, _) in &keys {
            let (before, after) = (path.jet_left(*s), path.jet(*s));
            assert!((before.rate - after.rate).norm() < 1e-13 * after.rate.norm(), "rate at {s}");
            assert!((before.d_rate - after.d_rate).norm() < 1e-12 * (1.0 + after.d_rate.norm()), "d_rate at {s}");
        }
    }
}

#[test]
fn a_quaternion_that_is_not_a_number_is_refused_by_its_index() {
    let good = UnitQuaternion::identity();
    let bad = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
    let error = OrientationPath::through(&[(0.0, good), (1.0, bad)]).expect_err("not a rotation");
    assert!(matches!(error, GeometryError::QuaternionNotFinite { index: 1, .. }), "{error}");
}
