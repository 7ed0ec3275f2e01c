//! Edits do not move the curve; shapes are exact.
#![allow(clippy::unwrap_used)]

use crate::common;

use std::f64::consts::{PI, TAU};

use arcfeed_geometry::nalgebra::{Isometry3, UnitQuaternion, Vector3, vector};
use arcfeed_geometry::{Curve, GeometryError, KnotVector, NurbsCurve};
use common::de_boor;
use common::random::{cases, curve, unclamped};
use proptest::prelude::*;

/// Largest distance between two curves over `[a, b]`, relative to the size of the first; the parameter of the second is
/// `map` of the first's. What rounding of the parameter moves the point by is left out.
fn moved<const D: usize>(
    before: &NurbsCurve<D>,
    after: &NurbsCurve<D>,
    (a, b): (f64, f64),
    map: impl Fn(f64) -> f64,
) -> f64 {
    let size = before.control_points().iter().fold(0.0f64, |m, p| m.max(p.norm()));
    let mut worst = 0.0f64;
    for i in 0..=100 {
        let u = a + (b - a) * f64::from(i) / 100.0;
        let jet = before.jet(u);
        let rounding = 4.0 * f64::EPSILON * a.abs().max(b.abs()) * jet.speed().max(before.jet_left(u).speed());
        let distance = (de_boor(before, u, false) - de_boor(after, map(u), false)).norm();
        worst = worst.max((distance - rounding) / size);
    }
    worst
}

const SAME: f64 = 1e-14;

fn check_edits<const D: usize>(c: &NurbsCurve<D>, x: f64, y: f64) -> Result<(), TestCaseError> {
    let (a, b) = c.domain();
    let (u, v) = (a + x * (b - a), a + y * (b - a));
    let once = c.with_knot(u, 1).unwrap();
    prop_assert_eq!(once.control_points().len(), c.control_points().len() + 1);
    prop_assert_eq!(once.is_rational(), c.is_rational());
    prop_assert!(moved(c, &once, (a, b), |u| u) < SAME);
    let refined = c.refined(&[v, u]).unwrap();
    prop_assert!(moved(c, &refined, (a, b), |u| u) < SAME);

    let (left, right) = c.split(u).unwrap();
    prop_assert_eq!((left.domain(), right.domain()), ((a, u), (u, b)));
    prop_assert!(moved(c, &left, (a, u), |u| u) < SAME);
    prop_assert!(moved(c, &right, (u, b), |u| u) < SAME);
    // At a knot that stands there already.
    let inner = c.knots().as_slice().iter().copied().find(|&k| a < k && k < b);
    if let Some(k) = inner {
        let (left, right) = c.split(k).unwrap();
        prop_assert!(moved(c, &left, (a, k), |u| u) < SAME);
        prop_assert!(moved(c, &right, (k, b), |u| u) < SAME);
    }

    let elevated = c.elevated().unwrap();
    prop_assert_eq!(elevated.degree(), c.degree() + 1);
    prop_assert_eq!(elevated.is_rational(), c.is_rational());
    prop_assert!(moved(c, &elevated, (a, b), |u| u) < SAME);
    // The smoothness is written down as it was: multiplicities grow by one.
    for (_, k, multiplicity) in elevated.knots().runs() {
        if a < k && k < b {
            prop_assert_eq!(multiplicity, c.knots().multiplicity(k) + 1);
        }
    }
    prop_assert!(moved(c, &elevated.elevated().unwrap(), (a, b), |u| u) < SAME);

    let back = c.reversed().unwrap();
    prop_assert_eq!(back.domain(), (a, b));
    prop_assert!(moved(c, &back, (a, b), |u| a + (b - u)) < SAME);

    let clamped = c.clamped().unwrap();
    prop_assert!(clamped.knots().is_clamped());
    prop_assert!(moved(c, &clamped, (a, b), |u| u) < SAME);

    let size = c.control_points().iter().fold(0.0f64, |m, p| m.max(p.norm()));
    for piece in c.decompose() {
        let (m, n) = piece.interval();
        for i in 0..=8 {
            let u = m + (n - m) * i as f64 / 8.0;
            prop_assert!((piece.point(u) - de_boor(c, u, i == 8)).norm() < SAME * size);
        }
        let part = piece.restricted(m + 0.25 * (n - m), m + 0.5 * (n - m));
        let u = m + 0.3 * (n - m);
        let rounding = 4.0 * f64::EPSILON * a.abs().max(b.abs()) * c.jet(u).speed();
        prop_assert!((part.point(u) - de_boor(c, u, false)).norm() < SAME * size + rounding);
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn edits_do_not_move_plane_curves(c in curve::<2>(), x in 0.01f64..0.99, y in 0.01f64..0.99) {
        check_edits(&c, x, y)?;
    }

    #[test]
    fn edits_do_not_move_space_curves(c in curve::<3>(), x in 0.01f64..0.99, y in 0.01f64..0.99) {
        check_edits(&c, x, y)?;
    }

    #[test]
    fn edits_do_not_move_unclamped_curves(c in unclamped::<2>(), x in 0.01f64..0.99, y in 0.01f64..0.99) {
        check_edits(&c, x, y)?;
        let (a, b) = c.domain();
        let ends = c.refined(&[a, b]);
        if let Ok(ends) = ends {
            prop_assert!(moved(&c, &ends, (a, b), |u| u) < SAME);
        }
    }

    /// The prepared pieces against de Boor's algorithm. What they lose grows with the ratio of the weights.
    #[test]
    fn evaluation_is_accurate(c in curve::<3>(), x in 0.0f64..1.0) {
        let (a, b) = c.domain();
        let u = a + x * (b - a);
        let size = c.control_points().iter().fold(0.0f64, |m, p| m.max(p.norm()));
        let (low, high) = c.weights().iter().fold((f64::MAX, 0.0f64), |(l, h), &w| (l.min(w), h.max(w)));
        let rounding = 4.0 * f64::EPSILON * a.abs().max(b.abs()) * c.jet(u).speed();
        let error = (c.point(u) - de_boor(&c, u, false)).norm();
        prop_assert!(error < 2e-15 * size * (high / low) + rounding, "{error}");
    }

    #[test]
    fn arcs_lie_on_their_circle(radius in 1e-3f64..1e3, start in -7.0f64..7.0, sweep in -TAU..TAU) {
        prop_assume!(sweep.abs() > 1e-6);
        let centre = vector![3.0, -2.0];
        let arc = NurbsCurve::<2>::arc(centre, radius, start, sweep).unwrap();
        let at = |angle: f64| centre + vector![angle.cos(), angle.sin()] * radius;
        prop_assert!((arc.point(0.0) - at(start)).norm() < 1e-14 * (radius + 5.0));
        prop_assert!((arc.point(1.0) - at(start + sweep)).norm() < 1e-14 * (radius + 5.0));
        prop_assert!((arc.point(0.5) - at(start + 0.5 * sweep)).norm() < 1e-14 * (radius + 5.0));
        for i in 0..=50 {
            let p = arc.point(i as f64 / 50.0);
            prop_assert!(((p - centre).norm() - radius).abs() < 1e-14 * (radius + 5.0));
        }
        prop_assert_eq!(arc.jet(0.3).signed_curvature() > 0.0, sweep > 0.0);
    }
}

#[test]
fn circle_in_space_and_rigid_motion() {
    let frame =
        Isometry3::from_parts(Vector3::new(0.4, -0.2, 0.9).into(), UnitQuaternion::from_euler_angles(0.3, -0.8, 2.0));
    let circle = NurbsCurve::<3>::circle(&frame, 0.25).unwrap();
    assert!(circle.is_closed(1e-15));
    assert_eq!(circle.control_points()[0], circle.control_points()[8]);
    let moved = NurbsCurve::<2>::circle(vector![0.0, 0.0], 0.25).unwrap().lifted().transformed(&frame).unwrap();
    let normal = frame.rotation * Vector3::z();
    for i in 0..=64 {
        let u = f64::from(i) / 64.0;
        let away = circle.point(u) - frame.translation.vector;
        assert!((away.norm() - 0.25).abs() < 1e-15 && away.dot(&normal).abs() < 1e-15);
        assert!((moved.point(u) - circle.point(u)).norm() < 1e-15);
    }
}

#[test]
fn lines_and_polylines_run_by_length() {
    let line = NurbsCurve::line(vector![1.0, 2.0, 3.0], vector![3.0, 4.0, 4.0]).unwrap();
    assert_eq!(line.domain(), (0.0, 3.0));
    let jet = line.jet(1.5);
    assert_eq!(jet.point, vector![2.0, 3.0, 3.5]);
    assert_eq!((jet.speed(), jet.curvature()), (1.0, 0.0));
    assert_eq!(line.scaled(0.001).unwrap().point(3.0), vector![0.003, 0.004, 0.004]);
}

#[test]
fn hostile_edits_are_refused() {
    let c = NurbsCurve::<2>::circle(vector![0.0, 0.0], 1.0).unwrap();
    for u in [f64::NAN, -0.1, 1.1, f64::INFINITY] {
        assert!(matches!(c.with_knot(u, 1), Err(GeometryError::OutsideDomain { .. })));
        assert!(matches!(c.refined(&[0.3, u]), Err(GeometryError::OutsideDomain { .. })));
        assert!(matches!(c.split(u), Err(GeometryError::OutsideDomain { .. })));
    }
    for u in [0.0, 1.0] {
        assert!(matches!(c.split(u), Err(GeometryError::OutsideDomain { .. })));
        assert!(matches!(c.with_knot(u, 1), Err(GeometryError::KnotFull { .. })));
    }
    assert!(matches!(c.with_knot(0.25, 1), Err(GeometryError::KnotFull { present: 2, .. })));
    assert!(matches!(c.with_knot(0.3, usize::MAX), Err(GeometryError::KnotFull { .. })));
    assert!(matches!(c.refined(&[0.3, 0.3, 0.3]), Err(GeometryError::KnotFull { times: 3, .. })));
    for f in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(c.scaled(f), Err(GeometryError::NotPositive { .. })));
        assert!(matches!(NurbsCurve::<2>::circle(vector![0.0, 0.0], f), Err(GeometryError::NotPositive { .. })));
    }
    assert!(matches!(c.scaled(1e100), Err(GeometryError::PointNotFinite { .. })));
    for (start, sweep) in [(f64::NAN, 1.0), (0.0, f64::NAN), (0.0, 0.0), (0.0, 6.3), (f64::INFINITY, PI)] {
        let arc = NurbsCurve::<2>::arc(vector![0.0, 0.0], 1.0, start, sweep);
        assert!(matches!(arc, Err(GeometryError::ArcAngle { .. })), "{start} {sweep}");
    }
    assert!(NurbsCurve::<2>::circle(vector![f64::NAN, 0.0], 1.0).is_err());
    assert!(matches!(
        NurbsCurve::polyline(vec![vector![0.0, 0.0], vector![1.0, 0.0], vector![1.0, 0.0]]),
        Err(GeometryError::DuplicatePoints { index: 1, .. })
    ));
    assert!(NurbsCurve::polyline(vec![vector![0.0, 0.0], vector![1e30, 0.0], vector![1e30, 1e-30]]).is_err());
    assert!(NurbsCurve::polyline(vec![vector![0.0, 0.0]]).is_err());
    assert!(NurbsCurve::<2>::polyline(vec![]).is_err());
    assert!(NurbsCurve::line(vector![0.0, f64::NAN], vector![1.0, 0.0]).is_err());
    let tilted = Isometry3::translation(f64::NAN, 0.0, 0.0);
    assert!(c.lifted().transformed(&tilted).is_err());
}

#[test]
fn a_degree_beyond_all_use_is_refused_before_anything_overflows() {
    for degree in [501, usize::MAX / 2, usize::MAX] {
        let error = KnotVector::new(degree, vec![0.0, 1.0]).expect_err("too high");
        assert!(matches!(error, GeometryError::DegreeTooHigh { .. }), "{error}");
        assert!(NurbsCurve::<2>::bspline(degree, vec![], vec![]).is_err());
        assert!(KnotVector::clamped_uniform(degree, 4).is_err());
    }
}
