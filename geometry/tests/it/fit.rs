//! Interpolation and least-squares fits of points.
#![allow(clippy::unwrap_used)]

use crate::common;

use arcfeed_geometry::nalgebra::{SVector, vector};
use arcfeed_geometry::{Curve, Fit, GeometryError, NurbsCurve, Spacing};
use common::random::cases;
use common::{de_boor, published};
use proptest::prelude::*;

const SPACINGS: [Spacing; 2] = [Spacing::Chord, Spacing::Centripetal];

/// The true distance of each point from the curve, by dense sampling around its parameter, against what the fit says.
fn check<const D: usize>(points: &[SVector<f64, D>], fit: &Fit<D>, tolerance: f64) {
    assert!(fit.max_deviation <= tolerance);
    assert_eq!(fit.parameters.len(), points.len());
    assert!(fit.parameters.windows(2).all(|w| w[0] < w[1]));
    assert_eq!(fit.curve.domain(), (0.0, 1.0));
    let size = points.iter().fold(0.0f64, |m, p| m.max(p.amax()));
    for (i, (p, &u)) in points.iter().zip(&fit.parameters).enumerate() {
        // The nearest point may lie some way along from the parameter that the spacing gave.
        let reach = |j: usize, side: f64| (fit.parameters[j] + side * 0.01).clamp(0.0, 1.0);
        let (before, after) = (reach(i.saturating_sub(1), -1.0), reach((i + 1).min(points.len() - 1), 1.0));
        let nearest = (0..=400)
            .map(|j| before + (after - before) * f64::from(j) / 400.0)
            .chain([u])
            .map(|u| (fit.curve.point(u) - p).norm())
            .fold(f64::INFINITY, f64::min);
        // The samples miss the nearest point by a part of their distance from each other.
        let gap = (after - before) / 400.0 * fit.curve.jet(u).speed();
        assert!(nearest <= fit.max_deviation + gap + 1e-13 * size, "point {i}: {nearest} of {}", fit.max_deviation);
    }
}

#[test]
fn interpolation_passes_through_the_points() {
    let butterfly = published("butterfly");
    let points: Vec<_> = (0..=200).map(|i| butterfly.point(f64::from(i) / 200.0)).collect();
    for spacing in SPACINGS {
        for degree in 1..=5 {
            let fit = NurbsCurve::interpolate(&points, degree, spacing).unwrap();
            for (p, &u) in points.iter().zip(&fit.parameters) {
                assert!((de_boor(&fit.curve, u, false) - p).norm() < 1e-12);
            }
            assert!(fit.max_deviation < 1e-12);
            // The published curve closes exactly, and so does the fit.
            assert_eq!(fit.curve.control_points()[0], points[0]);
            assert!(fit.curve.is_closed(1e-13));
        }
    }
}

#[test]
fn interpolation_reproduces_a_polynomial() {
    // By chord lengths a straight line has even speed, however its points are spread.
    let line: Vec<_> = [0.0, 0.1, 0.5, 2.0, 3.5, 4.0].iter().map(|&x| vector![x, 2.0 * x, -x]).collect();
    let fit = NurbsCurve::interpolate(&line, 3, Spacing::Chord).unwrap();
    for i in 0..=100 {
        let u = f64::from(i) / 100.0;
        assert!((fit.curve.point(u) - vector![4.0, 8.0, -4.0] * u).norm() < 1e-13);
    }
}

#[test]
fn approximation_keeps_the_tolerance_with_few_points() {
    let butterfly = published("butterfly");
    let points: Vec<_> = (0..5000).map(|i| butterfly.point(f64::from(i) / 4999.0)).collect();
    for tolerance in [1.0, 0.01, 1e-4] {
        let fit = NurbsCurve::approximate(&points, 3, Spacing::Chord, tolerance).unwrap();
        println!("{tolerance}: {} control points, {}", fit.curve.control_points().len(), fit.max_deviation);
        check(&points, &fit, tolerance);
        assert!(fit.curve.control_points().len() < 2000);
    }
    // In space, closed, noisy: below the noise only interpolation is left, and it is found.
    let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.5;
    let helix: Vec<_> = (0..1000u32)
        .map(|i| {
            let a = f64::from(i) * 0.02;
            vector![a.cos() + 1e-3 * noise(i), a.sin() + 1e-3 * noise(i + 7777), 0.1 * a]
        })
        .collect();
    for tolerance in [0.01, 1e-6] {
        check(&helix, &NurbsCurve::approximate(&helix, 4, Spacing::Centripetal, tolerance).unwrap(), tolerance);
    }
}

/// Points so unevenly spread that the equations are singular to rounding: an error, not a curve far from its points.
#[test]
fn singular_equations_are_refused() {
    let mut x = 0.0;
    let points: Vec<_> = (0..30)
        .map(|i| {
            x += 10f64.powi(i * 7 % 13 - 6);
            vector![x, f64::from(i % 2)]
        })
        .collect();
    let refused = NurbsCurve::interpolate(&points, 13, Spacing::Chord);
    assert!(matches!(refused, Err(GeometryError::SingularFit { .. })), "{refused:?}");
    assert!(NurbsCurve::interpolate(&points, 2, Spacing::Centripetal).unwrap().max_deviation < 1e-6);
}

#[test]
fn hostile_points_are_refused() {
    let good = [vector![0.0, 0.0], vector![1.0, 0.0], vector![2.0, 1.0], vector![3.0, 0.0]];
    let fits = |points: &[SVector<f64, 2>], degree| {
        [
            NurbsCurve::interpolate(points, degree, Spacing::Chord).map(|_| ()),
            NurbsCurve::approximate(points, degree, Spacing::Centripetal, 0.1).map(|_| ()),
        ]
    };
    for r in fits(&good, 0) {
        assert!(matches!(r, Err(GeometryError::DegreeZero)));
    }
    for r in fits(&good, 4).into_iter().chain(fits(&[], 1)) {
        assert!(matches!(r, Err(GeometryError::TooFewDataPoints { .. })));
    }
    for r in fits(&good, 16) {
        assert!(matches!(r, Err(GeometryError::FitDegree { degree: 16, .. })));
    }
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        for r in fits(&[good[0], good[1], vector![2.0, bad], good[3]], 3) {
            assert!(matches!(r, Err(GeometryError::PointNotFinite { index: 2, axis: 1, .. })));
        }
    }
    for r in fits(&[good[0], good[1], good[1], good[3]], 2) {
        assert!(matches!(r, Err(GeometryError::DuplicatePoints { index: 1, .. })));
    }
    // Distinct, but not by anything the parameter can resolve.
    for r in fits(&[vector![0.0, 0.0], vector![1e-30, 0.0], vector![1e30, 0.0], vector![2e30, 0.0]], 1) {
        assert!(matches!(r, Err(GeometryError::DuplicatePoints { .. })) || r.is_ok());
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let r = NurbsCurve::approximate(&good, 2, Spacing::Chord, tolerance);
        assert!(matches!(r, Err(GeometryError::NotPositive { .. })));
    }
    let big = good.map(|p| p * 1e6);
    assert!(matches!(
        NurbsCurve::approximate(&big, 3, Spacing::Chord, 1e-30),
        Err(GeometryError::FitTolerance { .. }) | Ok(Fit { max_deviation: 0.0, .. })
    ));
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn random_points_are_fitted(
        points in proptest::collection::vec(proptest::array::uniform3(-10.0f64..10.0), 6..120),
        degree in 1usize..=5,
        exponent in -6.0f64..1.0,
        closed in any::<bool>(),
    ) {
        let mut points: Vec<_> = points.into_iter().map(SVector::from).collect();
        if closed {
            points.push(points[0]);
        }
        let tolerance = 10f64.powf(exponent);
        for spacing in SPACINGS {
            check(&points, &NurbsCurve::approximate(&points, degree, spacing, tolerance).unwrap(), tolerance);
        }
    }
}
