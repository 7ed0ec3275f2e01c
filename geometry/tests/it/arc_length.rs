//! Arc length against values computed with 50 digits, against closed forms and against brute force.
#![allow(clippy::unwrap_used)]

use crate::common;

use arcfeed_geometry::nalgebra::{SVector, vector};
use arcfeed_geometry::{ArcLengthCurve, Curve, GeometryError, NurbsCurve, adaptive_gauss_legendre};
use arcfeed_testing::Random;
use common::{OracleCurve, oracle, published};
use proptest::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Values {
    arc_length: f64,
    samples: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    u: f64,
    d1: Vec<f64>,
    arc_length_from_start: f64,
}

/// Arc length from the start at `panels + 1` parameters per knot span, by five Gauss points a panel.
fn brute_force<const D: usize>(curve: &NurbsCurve<D>, panels: usize) -> Vec<(f64, f64)> {
    let (a, b) = ((5.0 - 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0, (5.0 + 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0);
    let (wa, wb) = ((322.0 + 13.0 * 70.0f64.sqrt()) / 900.0, (322.0 - 13.0 * 70.0f64.sqrt()) / 900.0);
    let rule = [(-b, wb), (-a, wa), (0.0, 128.0 / 225.0), (a, wa), (b, wb)];
    let (start, end) = curve.domain();
    let knots: Vec<f64> = curve.knots().as_slice().iter().copied().filter(|&k| k >= start && k <= end).collect();
    let (mut sum, mut lost) = (0.0, 0.0);
    let mut out = vec![(start, 0.0)];
    for pair in knots.windows(2).filter(|p| p[0] < p[1]) {
        for i in 0..panels {
            let at = |i: usize| pair[0] + (pair[1] - pair[0]) * (i as f64 / panels as f64);
            let (middle, half) = (0.5 * (at(i) + at(i + 1)), 0.5 * (at(i + 1) - at(i)));
            let panel: f64 = rule.iter().map(|(x, w)| w * half * curve.jet(middle + half * x).speed()).sum();
            let add = panel - lost;
            let next = sum + add;
            lost = (next - sum) - add;
            sum = next;
            out.push((at(i + 1), sum));
        }
    }
    out
}

fn scaled<const D: usize>(c: &NurbsCurve<D>, scale: f64, offset: SVector<f64, D>) -> NurbsCurve<D> {
    let points = c.control_points().iter().map(|p| p * scale + offset).collect();
    NurbsCurve::new(c.degree(), points, c.weights().to_vec(), c.knots().as_slice().to_vec()).unwrap()
}

fn check_lengths<const D: usize>(c: &OracleCurve<Values>) {
    let curve = c.data.curve::<D>();
    let whole = curve.arc_length(1e-14 * c.values.arc_length).unwrap();
    assert!(
        (whole / c.values.arc_length - 1.0).abs() <= 1e-14,
        "curve {}: {whole} instead of {}",
        c.id,
        c.values.arc_length
    );
    let path = ArcLengthCurve::new(curve.clone(), 1e-15 * c.values.arc_length).unwrap();
    assert!((path.length() / c.values.arc_length - 1.0).abs() <= 1e-14, "curve {}: {}", c.id, path.length());
    for s in &c.values.samples {
        // The rounding of u itself moves the place by this much.
        let speed = s.d1.iter().map(|v| v * v).sum::<f64>().sqrt();
        let allowed = 1e-14 * c.values.arc_length + f64::EPSILON * s.u.abs() * speed;
        let part = curve.arc_length_between(curve.domain().0, s.u, 1e-14 * c.values.arc_length).unwrap();
        let (id, u, exact) = (c.id, s.u, s.arc_length_from_start);
        assert!((part - exact).abs() <= allowed, "curve {id} to {u}: {part} instead of {exact}");
        let by_map = path.arc_length_at(s.u);
        assert!((by_map - exact).abs() <= allowed, "curve {id} at {u}: {by_map} instead of {exact}");
    }
}

#[test]
fn lengths_agree_with_fifty_digits() {
    for c in &oracle::<Values>() {
        if c.dim == 2 { check_lengths::<2>(c) } else { check_lengths::<3>(c) }
    }
}

#[test]
fn length_of_the_butterfly() {
    let exact = 382.860311107345;
    let curve = published("butterfly");
    let length = curve.arc_length(1e-12).unwrap();
    assert!((length - exact).abs() < 1e-12, "{length}");
    let path = ArcLengthCurve::new(curve, 1e-12).unwrap();
    assert!((path.length() - exact).abs() < 1e-12, "{}", path.length());
}

#[test]
fn every_tolerance_is_kept() {
    for c in oracle::<Values>().iter().filter(|c| c.dim == 2) {
        for tolerance in [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
            let length = c.data.curve::<2>().arc_length(tolerance).unwrap();
            let error = (length - c.values.arc_length).abs();
            assert!(error <= tolerance, "curve {}: {error} with {tolerance}", c.id);
        }
    }
    for exponent in 1..=12 {
        let tolerance = 10f64.powi(-exponent);
        let error = (published("butterfly").arc_length(tolerance).unwrap() - 382.860311107345).abs();
        assert!(error <= tolerance, "{error} with {tolerance}");
    }
}

#[test]
fn positions_on_the_butterfly() {
    let curve = published("butterfly");
    let path = ArcLengthCurve::new(curve.clone(), 1e-12).unwrap();
    let mut worst = 0.0f64;
    for (u, s) in brute_force(&curve, 1000) {
        worst = worst.max((path.point(s) - curve.point(u)).norm());
        assert_eq!(path.point(s), path.jet(s).point);
    }
    assert!(worst < 1e-11, "{worst} mm");
}

/// First derivative by the central difference of order 8.
fn difference<const D: usize>(f: impl Fn(f64) -> SVector<f64, D>, x: f64, h: f64) -> SVector<f64, D> {
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut sum = SVector::<f64, D>::zeros();
    for (k, w) in weights.iter().enumerate() {
        let step = (k + 1) as f64 * h;
        sum += (f(x + step) - f(x - step)) * (w / h);
    }
    sum
}

fn check_derivatives<const D: usize>(path: &ArcLengthCurve<D>, name: &str) {
    for pair in path.knots().windows(2) {
        for f in [0.2, 0.5, 0.7] {
            let s = pair[0] + f * (pair[1] - pair[0]);
            let jet = path.jet(s);
            assert!((jet.d1.norm() - 1.0).abs() < 4e-15, "{name}: |d1| = {} at {s}", jet.d1.norm());
            // Steps that are small against the radius and against how fast it changes.
            let scale = jet.d2.norm() + jet.d3.norm().sqrt() + 1.0 / (pair[1] - pair[0]);
            let h = 0.004 / scale;
            assert!(jet.d1.dot(&jet.d2).abs() <= 1e-12 * scale, "{name}: curvature not across the path at {s}");
            for (what, error, size) in [
                ("d1", difference(|s| path.point(s), s, h) - jet.d1, 1.0),
                ("d2", difference(|s| path.jet(s).d1, s, h) - jet.d2, scale),
                ("d3", difference(|s| path.jet(s).d2, s, h) - jet.d3, scale * scale),
            ] {
                // Differences lose the rounding of positions and derivatives, enlarged by 1 / h.
                let rounding = 4e-14 * (path.point(s).norm() + 1.0) / h;
                assert!(
                    error.norm() <= (1e-9 + rounding.max(1e-11 / h * scale)) * size,
                    "{name}: {what} is off by {} of {size} at {s}",
                    error.norm()
                );
            }
        }
    }
}

#[test]
fn derivatives_agree_with_differences() {
    for c in &oracle::<Values>() {
        let name = format!("curve {}", c.id);
        if c.dim == 2 {
            check_derivatives(&ArcLengthCurve::new(c.data.curve::<2>(), 1e-13).unwrap(), &name);
        } else {
            check_derivatives(&ArcLengthCurve::new(c.data.curve::<3>(), 1e-13).unwrap(), &name);
        }
    }
    check_derivatives(&ArcLengthCurve::new(published("butterfly"), 1e-13).unwrap(), "butterfly");
}

#[test]
fn there_and_back() {
    let path = ArcLengthCurve::new(published("butterfly"), 1e-13).unwrap();
    let mut last = f64::NEG_INFINITY;
    for i in 0..=20_000 {
        let s = path.length() * f64::from(i) / 20_000.0;
        let u = path.parameter(s);
        assert!(u > last, "u does not increase at {s}");
        last = u;
        let back = path.arc_length_at(u);
        // The rounding of u, in length.
        let allowed = 1e-13 + f64::EPSILON * path.curve().jet(u).speed();
        assert!((back - s).abs() <= allowed, "{s} came back as {back}");
    }
    assert_eq!(path.parameter(0.0), 0.0);
    assert_eq!(path.parameter(path.length()), 1.0);
    // Outside, and no number at all: the ends.
    for (s, at) in [(-1.0, 0.0), (1e9, 1.0), (f64::INFINITY, 1.0), (f64::NEG_INFINITY, 0.0), (f64::NAN, 0.0)] {
        assert_eq!(path.parameter(s), at, "at s = {s}");
        assert!(path.jet(s).d3.iter().all(|v| v.is_finite()) && path.jet_left(s).d3.iter().all(|v| v.is_finite()));
    }
    assert_eq!(path.arc_length_at(-3.0), 0.0);
    assert_eq!(path.arc_length_at(f64::NAN), 0.0);
    assert_eq!(path.arc_length_at(7.0), path.length());
}

#[test]
fn metres_millimetres_and_micrometres() {
    let mm = published("butterfly");
    let path = ArcLengthCurve::new(mm.clone(), 1e-12).unwrap();
    for scale in [1e-3, 1e3, 1e-12, 1e12] {
        let other = ArcLengthCurve::new(scaled(&mm, scale, vector![0.0, 0.0]), 1e-12 * scale).unwrap();
        assert!((other.length() / scale / path.length() - 1.0).abs() < 1e-15 * 4.0);
        for i in 0..1000 {
            let s = path.length() * f64::from(i) / 1000.0;
            let (a, b) = (path.jet(s), other.jet(s * scale));
            assert!((a.point - b.point / scale).norm() < 4e-12, "at {s} with {scale}");
            assert!((a.d2 - b.d2 * scale).norm() < 1e-8 * (1.0 + a.d2.norm()), "at {s} with {scale}");
        }
    }
}

#[test]
fn far_from_the_origin() {
    // Coordinates of 1e6 mm have 1.2e-10 mm of resolution: lengths and places are as good as that.
    let near = published("butterfly");
    let far = scaled(&near, 1.0, vector![1e6, -1e6]);
    let length = far.arc_length(1e-15).unwrap();
    let path = ArcLengthCurve::new(far.clone(), 1e-15).unwrap();
    // What rounding explains is not chased.
    assert!(path.map_pieces() < 1000, "{}", path.map_pieces());
    assert!((length - 382.860311107345).abs() < 2e-9, "{length}");
    assert!((path.length() - length).abs() < 2e-10, "{} and {length}", path.length());
    for (u, s) in brute_force(&far, 100) {
        assert!((path.point(s) - far.point(u)).norm() < 2e-9, "at {u}: {}", (path.point(s) - far.point(u)).norm());
    }
}

#[test]
fn weights_six_orders_apart() {
    for weights in [[1.0, 1e6, 1.0, 1e6], [1e-6, 1.0, 1e-6, 1.0], [1.0, 1e-6, 1e-6, 1.0], [1e6, 1.0, 1.0, 1.0]] {
        let points = vec![vector![0.0, 0.0], vector![1.0, 3.0], vector![4.0, -2.0], vector![5.0, 1.0]];
        let curve = NurbsCurve::new(3, points, weights.to_vec(), vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]).unwrap();
        let length = curve.arc_length(1e-15).unwrap();
        // Graded panels: the speed peaks at the ends.
        let exact = {
            let speed = |u: f64| curve.jet(u).speed();
            let mut sum = 0.0;
            for k in 0..60 {
                let (a, b) = (0.5f64.powi(k + 2), 0.5f64.powi(k + 1));
                for i in 0..32 {
                    let (p, q) = (a + (b - a) * f64::from(i) / 32.0, a + (b - a) * f64::from(i + 1) / 32.0);
                    sum += arcfeed_geometry::gauss_legendre(&speed, p, q);
                    sum += arcfeed_geometry::gauss_legendre(&speed, 1.0 - q, 1.0 - p);
                }
            }
            sum
        };
        assert!((length - exact).abs() < 1e-8, "{weights:?}: {length} instead of {exact}");
        println!("{weights:?}: {length}, error {:e}", length - exact);
        match ArcLengthCurve::new(curve, 1e-12) {
            Ok(path) => {
                assert!((path.length() - length).abs() < 1e-8, "{weights:?}: {}", path.length());
                assert!(path.map_pieces() < 1000, "{weights:?}: {}", path.map_pieces());
            }
            Err(e) => println!("{weights:?}: {e}"),
        }
    }
}

#[test]
fn tolerances_that_mean_nothing() {
    let curve = published("butterfly");
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(curve.arc_length(tolerance), Err(GeometryError::NotPositive { .. })));
        assert!(matches!(curve.arc_length_between(0.1, 0.2, tolerance), Err(GeometryError::NotPositive { .. })));
        assert!(matches!(ArcLengthCurve::new(curve.clone(), tolerance), Err(GeometryError::NotPositive { .. })));
    }
    for tolerance in [1e-300, f64::MIN_POSITIVE, 5e-324] {
        assert!((curve.arc_length(tolerance).unwrap() - 382.860311107345).abs() < 1e-12);
        let path = ArcLengthCurve::new(curve.clone(), tolerance).unwrap();
        assert!((path.length() - 382.860311107345).abs() < 1e-12);
        assert!(path.map_pieces() < 1000, "{}", path.map_pieces());
    }
}

#[test]
fn part_of_a_curve() {
    let curve = published("butterfly");
    let (whole, left, right) = (
        curve.arc_length(1e-12).unwrap(),
        curve.arc_length_between(-5.0, 0.37, 1e-12).unwrap(),
        curve.arc_length_between(0.37, 5.0, 1e-12).unwrap(),
    );
    assert!((whole - left - right).abs() < 1e-12);
    assert_eq!(curve.arc_length_between(0.37, -5.0, 1e-12).unwrap(), -left);
    assert_eq!(curve.arc_length_between(0.4, 0.4, 1e-12).unwrap(), 0.0);
    assert!(curve.arc_length_between(f64::NAN, 0.4, 1e-12).unwrap().is_finite());
}

/// The cubic with a cusp at u = 1/2: its speed is 3 |a| sqrt(1 + a^2) with a = 1 - 2 u.
fn cusp() -> NurbsCurve<2> {
    let points = vec![vector![0.0, 0.0], vector![1.0, 1.0], vector![0.0, 1.0], vector![1.0, 0.0]];
    NurbsCurve::bspline(3, points, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]).unwrap()
}

#[test]
fn a_cusp_has_a_length_but_no_arc_length_parameter() {
    let length = cusp().arc_length(1e-14).unwrap();
    assert!((length - (8f64.sqrt() - 1.0)).abs() < 1e-14, "{length}");
    // The cusp away from the places where intervals are halved.
    let part = cusp().arc_length_between(0.0, 0.7, 1e-14).unwrap();
    let exact = 0.5 * (8f64.sqrt() - 1.0) + 0.5 * ((1.0f64 + 0.16).powf(1.5) - 1.0);
    assert!((part - exact).abs() < 4e-14, "{part} instead of {exact}");
    let error = ArcLengthCurve::new(cusp(), 1e-12).err().unwrap();
    let GeometryError::StandsStill { u, speed, .. } = error else { panic!("{error}") };
    assert!((u - 0.5).abs() < 1e-6 && speed < 1e-6, "{error}");
}

#[test]
fn coincident_control_points() {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0];
    let p = |x: f64, y: f64| vector![x, y];
    // All of them: no length.
    let point = NurbsCurve::bspline(3, vec![p(3.0, 4.0); 5], knots.clone()).unwrap();
    assert!(point.arc_length(1e-12).unwrap() < 1e-14);
    assert!(matches!(ArcLengthCurve::new(point, 1e-12), Err(GeometryError::ZeroLength { .. })));
    let at_origin = NurbsCurve::bspline(3, vec![p(0.0, 0.0); 5], knots.clone()).unwrap();
    assert!(matches!(ArcLengthCurve::new(at_origin, 1e-12), Err(GeometryError::ZeroLength { .. })));
    // Two at an end: the speed vanishes there, and the error says where.
    let start =
        NurbsCurve::bspline(3, vec![p(0.0, 0.0), p(0.0, 0.0), p(1.0, 1.0), p(2.0, 0.0), p(3.0, 1.0)], knots.clone())
            .unwrap();
    let error = ArcLengthCurve::new(start, 1e-12).err().unwrap();
    assert!(matches!(error, GeometryError::StandsStill { u, .. } if u < 1e-6), "{error}");
    // A whole span that stands still.
    let inside = NurbsCurve::bspline(
        1,
        vec![p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.0), p(2.0, 0.0)],
        vec![0.0, 0.0, 1.0, 2.0, 3.0, 3.0],
    )
    .unwrap();
    assert_eq!(inside.arc_length(1e-12).unwrap(), 2.0);
    let error = ArcLengthCurve::new(inside, 1e-12).err().unwrap();
    assert!(matches!(error, GeometryError::StandsStill { u, .. } if (1.0..=2.0).contains(&u)), "{error}");
}

#[test]
fn corners_of_a_polyline() {
    let line =
        NurbsCurve::polyline(vec![vector![0.0, 0.0], vector![2.0, 0.0], vector![2.0, 1.0], vector![3.0, 2.0]]).unwrap();
    let path = ArcLengthCurve::new(line, 1e-12).unwrap();
    assert!((path.length() - 3.0 - 2f64.sqrt()).abs() < 1e-15);
    let corners = path.corners(1e-6);
    assert_eq!(corners.len(), 2);
    assert!((corners[0].s - 2.0).abs() < 1e-15 && (corners[0].angle - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert!((corners[1].s - 3.0).abs() < 1e-15 && (corners[1].angle - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
    assert_eq!(path.corners(1.0).len(), 1);
    assert_eq!(path.jet_left(corners[0].s).d1, vector![1.0, 0.0]);
    assert_eq!(path.jet(corners[0].s).d1, vector![0.0, 1.0]);
    assert_eq!(path.knots().len(), 4);
    // The butterfly is smooth.
    assert!(ArcLengthCurve::new(published("butterfly"), 1e-12).unwrap().corners(1e-9).is_empty());
}

#[test]
fn quadrature_of_functions_that_are_not_smooth() {
    let root = adaptive_gauss_legendre(&|x: f64| x.sqrt(), 0.0, 1.0, 1e-14, 0.0);
    assert!((root - 2.0 / 3.0).abs() < 1e-14, "{root}");
    let kink = adaptive_gauss_legendre(&|x: f64| (x - 0.3).abs(), 0.0, 1.0, 1e-14, 0.0);
    assert!((kink - 0.29).abs() < 1e-14, "{kink}");
    // A small kink beside a large smooth part.
    let small = adaptive_gauss_legendre(&|x: f64| x.exp() + 1e-6 * (x - 0.3).abs(), 0.0, 1.0, 1e-15, 0.0);
    assert!((small - (1f64.exp() - 1.0 + 0.29e-6)).abs() < 1e-15, "{small}");
    let peak = adaptive_gauss_legendre(&|x: f64| 1.0 / (1e-8 + (x - 0.4321).powi(2)), 0.0, 1.0, 1e-9, 0.0);
    let exact = 1e4 * ((0.5679e4f64).atan() + (0.4321e4f64).atan());
    assert!((peak - exact).abs() < 1e-9, "{peak} instead of {exact}");
    let pole = adaptive_gauss_legendre(&|x: f64| 1.0 / x.sqrt(), 0.0, 1.0, 1e-9, 0.0);
    assert!((pole - 2.0).abs() < 1e-6, "{pole}");
    assert!(adaptive_gauss_legendre(&|x: f64| 1.0 / x, 0.0, 1.0, 1e-12, 0.0).is_finite());
    assert!(adaptive_gauss_legendre(&|_| f64::NAN, 0.0, 1.0, 1e-12, 0.0).is_nan());
}

/// Cubics with random knots and weights; some points coincide, some lie on a line.
fn random_cubic() -> impl Strategy<Value = NurbsCurve<2>> {
    (4usize..12)
        .prop_flat_map(|n| {
            let coordinate = prop_oneof![3 => -100.0f64..100.0, 1 => Just(0.0)];
            let points = proptest::collection::vec((coordinate.clone(), coordinate), n);
            let weights = prop_oneof![Just(vec![1.0; n]), proptest::collection::vec(0.05f64..20.0, n)];
            let steps = proptest::collection::vec(prop_oneof![4 => 0.05f64..1.0, 1 => Just(0.0)], n - 3);
            (points, weights, steps).prop_map(move |(points, weights, mut steps)| {
                steps[n - 4] += 0.1;
                let mut knots = vec![0.0; 4];
                for step in &steps {
                    knots.push(knots[knots.len() - 1] + step);
                }
                knots.extend([knots[knots.len() - 1]; 3]);
                NurbsCurve::new(3, points.iter().map(|&(x, y)| vector![x, y]).collect(), weights, knots)
            })
        })
        .prop_filter_map("a knot stands too often", Result::ok)
}

/// Cubic Bezier curves with a light end are fast in a narrow stretch beside it, where no node of a quadrature lies.
#[test]
fn a_curve_that_is_fast_beside_an_end_is_measured() {
    let mut random = Random::new(20_261_232);
    let mut mapped = 0;
    for case in 0..200 {
        // The first inner point is near the line of the others, so that the speed is smooth but for the stretch.
        let end = vector![random.between(1.0, 100.0), random.between(-100.0, 100.0)];
        let slope = vector![0.0, random.between(1.0, 100.0)];
        let points = vec![end, vector![0.0, 0.0], -slope, -slope * random.between(0.9, 1.1)];
        let weights = vec![random.log(1e-3, 0.1), 10.0, 10.0, 10.0 * random.between(0.9, 1.1)];
        let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let curve = NurbsCurve::new(3, points, weights, knots).unwrap();
        let length = curve.arc_length(1e-10).unwrap();
        // In parts that are short where the curve is fast: u / (1 - u) runs through a geometric sequence.
        let place = |i: i32| 1.0 / (1.0 + (-0.2 * f64::from(i)).exp());
        let part = |u0: f64, u1: f64| curve.arc_length_between(u0, u1, 1e-12).unwrap();
        let inner: f64 = (-100..20).map(|i| part(place(i), place(i + 1))).sum();
        let parts = part(0.0, place(-100)) + inner + part(place(20), 1.0);
        assert!((length - parts).abs() < 1e-10, "case {case}: {length} and {parts}; {curve:?}");
        // And by the map of arc lengths, which has no quadrature in it; near-cusps have none.
        if let Ok(path) = ArcLengthCurve::new(curve.clone(), 1e-11) {
            assert!(
                (length - path.length()).abs() < 1e-10,
                "case {case}: {length}, by the map {}; {curve:?}",
                path.length()
            );
            mapped += 1;
        }
    }
    assert!(mapped > 100, "{mapped} of 200");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_curves(curve in random_cubic()) {
        let path = match ArcLengthCurve::new(curve.clone(), 1e-11) {
            Ok(path) => path,
            Err(GeometryError::StandsStill { u, mean, .. }) => {
                // Only curves that do so, or nearly, are refused; control points on a line often turn back.
                let speed = curve.jet(u).speed();
                prop_assert!(speed < 1e-4 * mean, "refused, but {speed} of {mean} at {u}");
                return Ok(());
            }
            Err(GeometryError::ZeroLength { .. }) => return Ok(()),
            Err(other) => panic!("{other}"),
        };
        let length = curve.arc_length(1e-11).unwrap();
        prop_assert!((path.length() - length).abs() < 1e-10, "{} and {length}", path.length());
        for (u, s) in brute_force(&curve, 8000).into_iter().step_by(137) {
            // Five points a panel are not enough for the sharpest bends: places are compared where they are.
            let place = path.point(path.arc_length_at(u));
            prop_assert!((place - curve.point(u)).norm() < 1e-10, "at {u}: {place} and {}", curve.point(u));
            let own = curve.arc_length_between(curve.domain().0, u, 1e-11).unwrap();
            prop_assert!((path.arc_length_at(u) - own).abs() < 1e-10);
            prop_assert!((own - s).abs() < 1e-6 * length, "at {u}: {own} and {s}");
        }
    }
}
