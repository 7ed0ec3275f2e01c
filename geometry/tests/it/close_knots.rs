//! Knots that nearly coincide.
#![allow(clippy::unwrap_used)]

use crate::close_knots_cases as close_knots;

use arcfeed_geometry::nalgebra::{Vector2, vector};
use arcfeed_geometry::{ArcLengthCurve, Curve, GeometryError, NurbsCurve};
use close_knots::Case;

fn wave(degree: usize, y: &[f64]) -> Vec<Vector2<f64>> {
    assert!(y.len() > degree);
    y.iter().enumerate().map(|(i, &y)| vector![80.0 * i as f64 / (y_count(degree) - 1) as f64 - 40.0, y]).collect()
}

fn y_count(degree: usize) -> usize {
    degree + 4
}

/// The cubic was refused because "the curve stands still", the quintic took 7.6e12 s: a span of one ulp between two knots
/// has no digits of its own.
#[test]
fn two_knots_one_ulp_apart_are_one() {
    let cubic = (3, [0.0, 18.271, 14.863, -6.18, -19.89, -10.0, 11.756].to_vec());
    let quintic = (5, [0.0, 15.208, 19.754, 10.45, -6.18, -18.478, -17.82, -4.669, 11.756].to_vec());
    for (degree, y) in [cubic, quintic] {
        let points = wave(degree, &y);
        let with = |second: f64| {
            let knots = [vec![0.0; degree + 1], vec![0.3, second, 0.6], vec![1.0; degree + 1]].concat();
            NurbsCurve::bspline(degree, points.clone(), knots).unwrap()
        };
        let double = with(0.3);
        for apart in [f64::EPSILON / 4.0, 1e-15, 1e-12, 0.99e-9] {
            let near = with(0.3 + apart);
            assert_eq!(near, double, "{apart:e} apart");
        }
        let path = ArcLengthCurve::new(with(0.3f64.next_up()), 1e-12).unwrap();
        assert!(path.corners(1e-6).is_empty());
        // Above the tolerance the knots stay as they are, and the curve hardly moves.
        let apart = with(0.3 + 1e-8);
        assert_eq!(apart.knots().multiplicity(0.3), 1);
        assert!((apart.point(0.4) - double.point(0.4)).norm() < 1e-6);
        assert!(ArcLengthCurve::new(apart, 1e-12).unwrap().corners(1e-6).is_empty());
    }
}

#[test]
fn an_end_is_its_control_point_to_the_last_bit() {
    let points: Vec<_> = (0..9).map(|i| vector![0.1 + 1.7 * f64::from(i), (f64::from(i) * 1.3).sin() / 3.0]).collect();
    let weights: Vec<f64> = (0..9).map(|i| 1.0 + 0.37 * f64::from(i % 4)).collect();
    for degree in 1..=8 {
        let inner = (1..9 - degree).map(|i| 0.1 + 0.7 * i as f64 / 8.0);
        let knots: Vec<f64> = [vec![0.0; degree + 1], inner.collect(), vec![0.9; degree + 1]].concat();
        let curve = NurbsCurve::new(degree, points.clone(), weights.clone(), knots).unwrap();
        for (u, s, point) in [(0.0, -1.0, points[0]), (0.9, 1e9, points[8])] {
            assert_eq!(curve.point(u), point, "degree {degree}");
            assert_eq!(curve.jet(u).point, point);
            assert_eq!(curve.jet_left(u).point, point);
            let path = ArcLengthCurve::new(curve.clone(), 1e-12).unwrap();
            assert_eq!(path.point(s), point);
            assert_eq!(path.jet(s).point, point);
        }
    }
}

/// Merging would tear the curve where more than `degree` knots crowd: it has a piece of some length between them.
#[test]
fn crowded_knots_are_kept_or_named() {
    let points = vec![vector![0.0, 0.0], vector![1.0, 0.0], vector![1.0, 1.0], vector![2.0, 1.0]];
    let line = |second: f64| NurbsCurve::bspline(1, points.clone(), vec![0.0, 0.0, 0.5, second, 1.0, 1.0]);
    let path = ArcLengthCurve::new(line(0.5 + 1e-11).unwrap(), 1e-12).unwrap();
    assert!((path.length() - 3.0).abs() < 1e-12);
    assert_eq!(path.corners(1e-6).len(), 2);
    let error = line(0.5f64.next_up()).unwrap_err();
    assert!(matches!(error, GeometryError::KnotsTooClose { index: 2, .. }), "{error}");
    assert!(error.to_string().contains("spread them"), "{error}");
}

/// A knot inserted next to one that is there joins it.
#[test]
fn a_knot_inserted_beside_another_joins_it() {
    let points: Vec<_> = (0..6).map(|i| vector![f64::from(i), f64::from(i * i % 5)]).collect();
    let curve = NurbsCurve::bspline(3, points, vec![0.0, 0.0, 0.0, 0.0, 0.4, 0.7, 1.0, 1.0, 1.0, 1.0]).unwrap();
    let finer = curve.with_knot(0.4 + 1e-12, 2).unwrap();
    assert_eq!(finer.knots().multiplicity(0.4), 3);
    assert!((finer.point(0.5) - curve.point(0.5)).norm() < 1e-14);
    assert!(matches!(curve.with_knot(0.4 + 1e-12, 3), Err(GeometryError::KnotFull { present: 1, .. })));
    assert!(curve.split(1e-12).is_err());
}

#[test]
fn random_curves_with_close_knots_match_twice_the_precision() {
    let mut good = 0;
    for seed in 0..400 {
        let result =
            if seed % 2 == 0 { Case::<2>::random(seed).check(seed) } else { Case::<3>::random(seed).check(seed) };
        match result {
            Ok(whole) => good += usize::from(whole),
            Err(what) => panic!("`soak_close_knots 1 {seed}`: {what}"),
        }
    }
    assert!(good > 250, "{good} of 400: too few to say anything");
}
