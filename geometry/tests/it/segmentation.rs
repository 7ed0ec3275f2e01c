//! Segment counts on the published curves, and the one promise of every segmentation: no piece exceeds its tolerance.
#![allow(clippy::unwrap_used)]

use crate::common;

use arcfeed_geometry::nalgebra::{Isometry3, vector};
use arcfeed_geometry::{ChordMeter, GeometryError, KnotVector, NurbsCurve, Segmentation, SegmentationMethod};
use common::random::{cases, curve};
use common::{dense_deviation, distance_from_segment, published};
use proptest::prelude::*;

const WITHIN: SegmentationMethod = SegmentationMethod::Greedy { across_knots: false };
const ACROSS: SegmentationMethod = SegmentationMethod::Greedy { across_knots: true };
const METHODS: [SegmentationMethod; 4] = [SegmentationMethod::Hull, SegmentationMethod::CType, WITHIN, ACROSS];

/// Every piece, measured densely and independently, keeps the tolerance and the deviation it reports.
fn check<const D: usize>(curve: &NurbsCurve<D>, s: &Segmentation, samples: usize) {
    assert_eq!(s.breaks()[0], curve.knots().domain().0);
    assert_eq!(*s.breaks().last().unwrap(), curve.knots().domain().1);
    let size = curve.control_points().iter().fold(0.0f64, |m, p| m.max(p.amax()));
    // Of the measurement here: the curve is evaluated to about 5e-15 of its size.
    let rounding = 1e-14 * size;
    for (u0, u1, reported) in s.pieces() {
        assert!(u0 < u1);
        let dense = dense_deviation(curve, u0, u1, samples);
        assert!(dense <= s.tolerance() + rounding, "[{u0}, {u1}] deviates by {dense}");
        assert!(dense <= reported + rounding, "[{u0}, {u1}] deviates by {dense}, reported {reported}");
        assert!(reported <= dense * (1.0 + 1e-5) + 10.0 * rounding, "[{u0}, {u1}]: {dense}, reported {reported}");
    }
}

#[test]
fn counts_on_published_curves() {
    for (name, tolerance, halving, within, across) in [
        ("seven_points", 0.1, [21, 18], 11, 10),
        ("butterfly", 0.05, [284, 248], 184, 156),
        ("six_points", 0.001, [170, 163], 114, 112),
        ("butterfly", 0.001, [1911, 1678], 1174, 1153),
        ("fan", 0.001, [2133, 1909], 1375, 1338),
    ] {
        let curve = published(name);
        let s = METHODS.map(|m| curve.segment(m, tolerance).unwrap());
        println!("{name} {tolerance}: {:?}", s.each_ref().map(|s| s.len()));
        s.iter().for_each(|s| check(&curve, s, 200));
        assert!(s[0].len() <= halving[0] && s[1].len() <= halving[1]);
        assert!(s[2].len() <= within, "{name}: {}", s[2].len());
        assert!(s[3].len() <= across, "{name}: {}", s[3].len());
    }
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn random_plane_curves_keep_the_tolerance(c in curve::<2>(), exponent in -3.0f64..1.5) {
        for method in METHODS {
            check(&c, &c.segment(method, 10f64.powf(exponent)).unwrap(), 100);
        }
    }

    #[test]
    fn random_space_curves_keep_the_tolerance(c in curve::<3>(), exponent in -3.0f64..1.5) {
        for method in METHODS {
            check(&c, &c.segment(method, 10f64.powf(exponent)).unwrap(), 100);
        }
    }

    /// The measurement against dense samples, on whole pieces with all their loops and inflections.
    #[test]
    fn deviations_enclose_the_true_one(c in curve::<3>()) {
        let mut meter = ChordMeter::new();
        for piece in c.decompose() {
            let (a, b) = piece.interval();
            // Points of the piece itself: at its end the curve's own may belong to the next one.
            let (p, q) = (piece.point(a), piece.point(b));
            let dense = (0..=2000)
                .map(|i| distance_from_segment(&piece.point(a + (b - a) * f64::from(i) / 2000.0), &p, &q))
                .fold(0.0, f64::max);
            let d = meter.measure(&piece, 1e-9).unwrap();
            prop_assert!(d.lower <= d.upper);
            prop_assert!(dense <= d.upper + 1e-13, "{dense} above {d:?}");
            prop_assert!(d.upper - d.lower <= 1e-9 * d.upper + 1e-12, "{d:?}");
            prop_assert!(d.lower <= dense * (1.0 + 1e-4) + 1e-13, "{dense} below {d:?}");
            prop_assert!((distance_from_segment(&piece.point(d.at), &p, &q) - d.lower).abs() < 1e-11);
            if dense > 1e-9 {
                prop_assert!(meter.exceeds(&piece, dense * 0.999).unwrap());
                prop_assert!(!meter.exceeds(&piece, dense * 1.001).unwrap());
            }
        }
    }
}

#[test]
fn the_unit_makes_no_difference() {
    let mm = published("butterfly");
    let m = mm.scaled(0.001).unwrap();
    for method in METHODS {
        let (a, b) = (mm.segment(method, 0.01).unwrap(), m.segment(method, 1e-5).unwrap());
        assert_eq!(a.len(), b.len());
        check(&m, &b, 100);
    }
}

/// A plane curve is cut the same way wherever in space it lies.
#[test]
fn plane_curves_in_space_are_cut_like_plane_curves() {
    let flat = published("butterfly");
    let turn = Isometry3::new(vector![10.0, 20.0, -30.0], vector![0.3, 1.2, -0.7]);
    let tilted = flat.lifted().transformed(&turn).unwrap();
    for method in METHODS {
        let (a, b) = (flat.segment(method, 0.01).unwrap(), tilted.segment(method, 0.01).unwrap());
        assert_eq!(a.len(), b.len());
        check(&tilted, &b, 50);
    }
}

#[test]
fn straight_closed_and_cornered_curves() {
    let polyline =
        NurbsCurve::polyline(vec![vector![0.0, 0.0], vector![1.0, 0.0], vector![2.0, 0.0], vector![2.0, 1.0]]).unwrap();
    for method in METHODS {
        let s = polyline.segment(method, 1e-6).unwrap();
        assert_eq!(s.len(), if method == ACROSS { 2 } else { 3 });
        check(&polyline, &s, 50);
    }
    // A closed piece: its chord has no length.
    let loop_points = vec![vector![0.0, 0.0], vector![3.0, 3.0], vector![-3.0, 3.0], vector![0.0, 0.0]];
    let closed = NurbsCurve::bspline(3, loop_points, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]).unwrap();
    for method in METHODS {
        for tolerance in [1e-4, 0.1, 1.0] {
            check(&closed, &closed.segment(method, tolerance).unwrap(), 300);
        }
        // All of it within a circle of radius 3 about its start.
        assert_eq!(closed.segment(method, 5.0).unwrap().len(), 1);
    }
    // There and back on one line: the far end is off the chord although all points are on its line.
    let back = NurbsCurve::bspline(
        2,
        vec![vector![0.0, 0.0], vector![4.0, 0.0], vector![1.0, 0.0]],
        vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
    )
    .unwrap();
    for method in METHODS {
        check(&back, &back.segment(method, 0.01).unwrap(), 300);
        assert!(back.segment(method, 0.01).unwrap().len() >= 2);
    }
    // All points in one place.
    let still = NurbsCurve::bspline(1, vec![vector![1.0, 1.0]; 2], vec![0.0, 0.0, 1.0, 1.0]).unwrap();
    for method in METHODS {
        assert_eq!(still.segment(method, 0.01).unwrap().len(), 1);
    }
}

/// The longest piece is not the last before the first infeasible end: after an inflection the deviation comes back.
#[test]
fn longest_looks_beyond_the_first_infeasible_end() {
    // y = x^3 on [-1, 1.2]: from -1 the deviation peaks at 0.5 with the end at x = 0.5 and falls to 0.385 at x = 1.
    let power = |x: f64| vector![x, x * x * x];
    let (a, b) = (-1.0, 1.2);
    let third = (b - a) / 3.0;
    let slope = |x: f64| vector![1.0, 3.0 * x * x];
    let points = vec![power(a), power(a) + slope(a) * third, power(b) - slope(b) * third, power(b)];
    let s_shape = NurbsCurve::bspline(3, points, vec![a, a, a, a, b, b, b, b]).unwrap();
    // Normal to the chord the peak is 0.43 and the valley 0.27.
    let s = s_shape.segment(WITHIN, 0.33).unwrap();
    check(&s_shape, &s, 500);
    let peak = dense_deviation(&s_shape, -1.0, 0.5, 500);
    assert!(peak > 0.33 && s.breaks()[1] > 1.0, "peak {peak}, first break {}", s.breaks()[1]);
}

#[test]
fn hostile_tolerances_give_errors() {
    let curve = published("butterfly");
    for method in METHODS {
        for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(curve.segment(method, tolerance), Err(GeometryError::NotPositive { .. })));
        }
        for tolerance in [1e-300, f64::MIN_POSITIVE, 1e-11] {
            assert!(matches!(curve.segment(method, tolerance), Err(GeometryError::ToleranceTooSmall { .. })));
        }
        // Huge is fine, and halving still ends at the knots.
        assert!(curve.segment(method, 1e9).unwrap().len() <= 200);
    }
    // So many pieces that their number is refused at once, not found out by making them.
    let zigzag: Vec<_> = (0..2000).map(|i| vector![f64::from(i), if i % 2 == 0 { 0.0 } else { 1e3 }]).collect();
    let knots = KnotVector::clamped_uniform(3, zigzag.len()).unwrap();
    let zigzag = NurbsCurve::bspline(3, zigzag, knots.as_slice().to_vec()).unwrap();
    for method in METHODS {
        assert!(matches!(zigzag.segment(method, 3e-9), Err(GeometryError::TooManySegments { .. })));
    }
    // A domain in which the parameter has a handful of values only.
    let points = vec![vector![0.0, 0.0], vector![50.0, 100.0], vector![100.0, 0.0]];
    let (a, b) = (1.0, 1.0 + 8.0 * f64::EPSILON);
    let coarse = NurbsCurve::bspline(2, points, vec![a, a, a, b, b, b]).unwrap();
    for method in METHODS {
        let result = coarse.segment(method, 1e-3);
        assert!(matches!(result, Err(GeometryError::ParameterTooCoarse { .. })), "{method:?}: {result:?}");
    }
    let piece = &curve.decompose()[0];
    let mut meter = ChordMeter::new();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(meter.measure(piece, bad).is_err() && meter.exceeds(piece, bad).is_err());
    }
}
