//! Paths of many pieces: the builder, its errors, and the one curve.
#![allow(clippy::unwrap_used)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::common::{mixed, polylines};

use arcfeed_geometry::nalgebra::{Unit, Vector3, vector};
use arcfeed_geometry::{
    ArcLengthCurve, ArcTo, Blending, Curve, GeometryError, JoinedPathBuilder, NurbsCurve, OrientationPath, PieceKind,
    PosePath,
};
use arcfeed_testing::{Random, allocations_in};

fn start() -> JoinedPathBuilder {
    JoinedPathBuilder::new(vector![10.0, 0.0, 0.0], 1e-3).unwrap()
}

fn around(end: Vector3<f64>, turns: u32) -> ArcTo {
    ArcTo { turns, ..ArcTo::new(Vector3::zeros(), Vector3::z_axis(), end) }
}

#[test]
fn arcs_of_any_sweep_are_exact() {
    let r = &mut Random::new(11);
    for case in 0..300 {
        let centre = vector![r.signed(), r.signed(), r.signed()] * 50.0;
        let normal = Unit::new_normalize(vector![r.signed(), r.signed(), r.signed()]);
        let u = normal.cross(&vector![r.signed(), r.signed(), r.signed()]).normalize();
        let v = normal.cross(&u);
        let (radius, turns) = (r.log(1e-2, 1e3), r.below(4) as u32);
        let sweep = if case % 5 == 0 { TAU } else { r.log(1e-3, 6.2) };
        let at = |angle: f64| centre + (u * angle.cos() + v * angle.sin()) * radius;
        let end = if sweep == TAU { at(0.0) } else { at(sweep) };
        let mut builder = JoinedPathBuilder::new(at(0.0), 1e-9).unwrap();
        // Any point of the axis will do for a centre.
        let to = ArcTo { centre: centre + normal.as_ref() * r.signed(), normal, end, turns };
        builder.arc(&to, 1).unwrap();
        let path = builder.build().unwrap();
        let whole = sweep + TAU * f64::from(turns);
        assert!((path.length() - radius * whole).abs() < 1e-11 * (radius * whole + 1.0) / sweep.min(1.0));
        let curve = path.to_curve().unwrap();
        assert_eq!((curve.point(0.0), curve.point(path.length())), (at(0.0), end));
        for k in 0..=100 {
            let along = path.domain().1 * f64::from(k) / 100.0;
            let jet = curve.jet(along);
            let off = jet.point - centre;
            assert!((off.norm() - radius).abs() < 1e-12 * (radius + 100.0), "case {case}");
            assert!(off.dot(&normal).abs() < 1e-12 * (radius + 100.0) / sweep.min(1.0));
            // The parameter is the arc length but for 3 % of a span of an eighth of a turn, and its speed near 1.
            assert!((jet.d1.norm() - 1.0).abs() < 0.03);
            assert!((jet.point - at(along / radius)).norm() < 0.01 * radius.min(radius * whole));
        }
    }
}

#[test]
fn a_helix_is_within_its_tolerance() {
    for (tolerance, turns) in [(1e-3, 0), (1e-6, 2), (1e-10, 1)] {
        let mut builder = start();
        builder.helix(&around(vector![0.0, 10.0, 7.0], turns), tolerance, 1).unwrap();
        let path = builder.build().unwrap();
        assert_eq!(path.pieces()[0].kind, PieceKind::Helix);
        let (sweep, curve) = (FRAC_PI_2 + TAU * f64::from(turns), path.to_curve().unwrap());
        let mut largest = 0.0f64;
        for k in 0..=5000 {
            let p = curve.point(path.domain().1 * f64::from(k) / 5000.0);
            let angle = sweep * p.z / 7.0;
            largest = largest.max((p - vector![10.0 * angle.cos(), 10.0 * angle.sin(), p.z]).norm());
        }
        assert!(largest <= tolerance, "{largest:e} of {tolerance:e}");
        // Not needlessly near: the parts are about as wide as the tolerance allows.
        assert!(largest > 0.01 * tolerance, "{largest:e} of {tolerance:e}");
        let length = (10.0 * sweep).hypot(7.0);
        assert!((ArcLengthCurve::new(curve, 1e-9).unwrap().length() - length).abs() < 100.0 * tolerance);
        assert!((path.length() - length).abs() < 100.0 * tolerance);
    }
    // Without a rise it is an arc.
    let mut builder = start();
    builder.helix(&around(vector![0.0, 10.0, 0.0], 0), 1e-6, 1).unwrap();
    assert_eq!(builder.build().unwrap().pieces()[0].kind, PieceKind::Arc);
}

#[test]
fn an_end_within_the_tolerance_is_met_exactly_and_one_beyond_is_refused() {
    let end = vector![0.0, 10.0005, 0.0002];
    let mut builder = start();
    builder.arc(&around(end, 0), 4).unwrap();
    let path = builder.build().unwrap();
    let curve = path.to_curve().unwrap();
    assert_eq!(curve.point(path.domain().1), end);
    for k in 0..=100 {
        let p = curve.point(path.domain().1 * f64::from(k) / 100.0);
        assert!((p.xy().norm() - 10.0).abs() < 1e-3 && p.z.abs() < 1e-3);
    }
    for end in [vector![0.0, 10.1, 0.0], vector![0.0, 10.0, 0.1], vector![10.0, 0.0, 0.1], vector![10.002, 0.0, 0.0]] {
        let error = start().arc(&around(end, 0), 4).unwrap_err();
        assert!(matches!(error, GeometryError::ArcEnd { line: 4, .. }), "{error}");
    }
    // A short arc with coarse coordinates is no full turn and no error.
    let mut short = start();
    short.arc(&around(vector![9.9998, 0.05, 0.0], 0), 5).unwrap();
    assert!((short.build().unwrap().length() - 0.05).abs() < 1e-4);
}

#[test]
fn bad_input_is_an_error_and_leaves_the_builder_as_it_was() {
    let mut builder = start();
    builder.line_to(vector![20.0, 0.0, 0.0], 1).unwrap();
    let good = builder.clone().build().unwrap();
    for x in [f64::NAN, f64::INFINITY, -1e300, 1e300] {
        let bad = vector![x, 0.0, 0.0];
        assert!(JoinedPathBuilder::new(bad, 1e-3).is_err());
        assert!(matches!(builder.line_to(bad, 2), Err(GeometryError::PointNotFinite { index: 2, .. })));
        assert!(builder.arc(&around(bad, 0), 2).is_err());
        assert!(builder.helix(&around(bad, 0), 1e-3, 2).is_err());
        let centre = ArcTo::new(bad, Vector3::z_axis(), vector![1.0, 1.0, 0.0]);
        assert!(builder.arc(&centre, 2).is_err());
        let normal = ArcTo::new(Vector3::zeros(), Unit::new_unchecked(bad), vector![0.0, 20.0, 0.0]);
        assert!(matches!(builder.arc(&normal, 2), Err(GeometryError::ArcNormal { line: 2, .. })));
        assert!(builder.helix(&around(vector![0.0, 20.0, 1.0], 0), if x < 0.0 { x } else { f64::NAN }, 2).is_err());
    }
    for tolerance in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        assert!(JoinedPathBuilder::new(vector![0.0, 0.0, 0.0], tolerance).is_err());
        assert!(builder.helix(&around(vector![0.0, 20.0, 1.0], 0), tolerance, 2).is_err());
    }
    for nearly in [0.0, 1e-300, 1e-15] {
        let end = vector![20.0 + nearly, nearly, 0.0];
        assert!(matches!(builder.line_to(end, 2), Err(GeometryError::PieceTooShort { line: 2, .. })));
    }
    let end = vector![0.0, 20.0, 0.0];
    let pointless = ArcTo::new(builder.position(), Vector3::z_axis(), end);
    assert!(matches!(builder.arc(&pointless, 2), Err(GeometryError::ArcRadius { line: 2, .. })));
    assert!(matches!(builder.arc(&around(end, 10_001), 2), Err(GeometryError::TooManyTurns { line: 2, .. })));
    let tight = builder.helix(&around(vector![0.0, 20.0, 1.0], 0), 1e-300, 2);
    assert!(matches!(tight, Err(GeometryError::ToleranceTooSmall { .. })));
    let away = NurbsCurve::line(vector![20.1, 0.0, 0.0], vector![30.0, 0.0, 0.0]).unwrap();
    assert!(matches!(builder.curve(&away, 2), Err(GeometryError::CurveStart { line: 2, .. })));
    let still = vec![vector![20.0, 0.0, 0.0], vector![20.0, 0.0, 0.0], vector![30.0, 0.0, 0.0]];
    let still = NurbsCurve::bspline(2, still, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]).unwrap();
    assert!(matches!(builder.curve_within(&still, 0.0, 2), Err(GeometryError::NotPositive { .. })));
    assert_eq!(start().build().unwrap_err(), GeometryError::EmptyPath);
    assert_eq!(builder.build().unwrap(), good);
    for (tolerance, radius) in [(f64::NAN, 1.0), (-1.0, 1.0), (f64::INFINITY, 1.0), (1.0, 0.0), (1.0, f64::NAN)] {
        let path = polylines::joined(&[vector![0.0, 0.0, 0.0], vector![1.0, 0.0, 0.0], vector![1.0, 1.0, 0.0]]);
        let error = path.blended(&Blending { radius, ..Blending::within(tolerance) }).unwrap_err();
        assert!(matches!(error, GeometryError::Blending { joint: 0, .. }));
    }
}

#[test]
fn tiny_and_huge_coordinates_do_not_panic() {
    let r = &mut Random::new(5);
    for _ in 0..2000 {
        let scale = *[1e-300, 1e-160, 1e-90, 1e-20, 1.0, 1e20, 1e90, 1e99].get(r.below(8)).unwrap();
        let mut point = |spread: f64| vector![r.signed(), r.signed(), r.signed()] * (scale * spread);
        let corner = [point(1.0), point(1e-3), point(1.0), point(10.0)];
        let Ok(mut builder) = JoinedPathBuilder::new(corner[0], scale.max(1e-200)) else { continue };
        for (i, p) in corner[1..].iter().enumerate() {
            let _ = builder.line_to(*p, i);
            let _ = builder.arc(&ArcTo::new(corner[i], Vector3::z_axis(), corner[3 - i]), i);
            let _ = builder.helix(&ArcTo::new(corner[i], Vector3::x_axis(), *p), scale * 1e-6, i);
        }
        let Ok(path) = builder.build() else { continue };
        for tolerance in [1e-300, scale * 1e-3, scale * 1e3, 1e99] {
            let Ok(blended) = path.blended(&Blending::within(tolerance)) else { continue };
            if let Ok(curve) = blended.path.to_curve() {
                let (start, end) = curve.domain();
                assert!((0..=20).all(|k| curve.point(start + (end - start) * f64::from(k) / 20.0).norm().is_finite()));
            }
        }
    }
}

#[test]
fn one_curve_serves_arc_length_corners_poses_and_sources() {
    let mut builder = start();
    builder.line_to(vector![20.0, 0.0, 0.0], 100).unwrap();
    builder.arc(&around(vector![-20.0, 0.0, 0.0], 1), 200).unwrap();
    builder.helix(&around(vector![20.0, 0.0, 5.0], 0), 1e-6, 300).unwrap();
    let cubic = [vector![20.0, 0.0, 5.0], vector![21.0, 5.0, 5.0], vector![25.0, 5.0, 0.0], vector![30.0, 0.0, 0.0]];
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    builder.curve(&NurbsCurve::bspline(3, cubic.to_vec(), knots).unwrap(), 400).unwrap();
    let path = builder.build().unwrap();
    let curve = ArcLengthCurve::new(path.to_curve().unwrap(), 1e-9).unwrap();
    assert!((curve.length() - path.length()).abs() < 1e-7);
    // Line to arc, arc to helix, helix to curve.
    let joints = path.joints();
    let corners = curve.corners(1e-3);
    assert_eq!((joints.len(), corners.len()), (3, 3));
    for (joint, corner) in joints.iter().zip(&corners) {
        assert!((curve.arc_length_at(joint.parameter) - corner.s).abs() < 1e-9);
        assert!((joint.angle - corner.angle).abs() < 1e-9);
    }
    assert!((joints[0].angle - FRAC_PI_2).abs() < 1e-12);
    assert!(joints[0].curvature[0] == 0.0 && (joints[0].curvature[1] - 0.05).abs() < 1e-12);
    let bounds = [0.0, 10.0, 10.0 + 20.0 * 3.0 * PI, 10.0 + 20.0 * 3.0 * PI + (20.0 * PI).hypot(5.0), curve.length()];
    for (i, pair) in bounds.windows(2).enumerate() {
        for part in [0.001, 0.5, 0.999] {
            let s = pair[0] + part * (pair[1] - pair[0]);
            assert_eq!(path.source_at(curve.parameter(s)), 100 * (i + 1), "at {s}");
        }
    }
    assert_eq!((path.source_at(-1.0), path.source_at(f64::INFINITY), path.source_at(f64::NAN)), (100, 400, 100));
    let keys = vec![arcfeed_geometry::nalgebra::UnitQuaternion::identity(); 5];
    let orientation = path.orientation(&curve, &keys, 1e-3).unwrap();
    assert!(matches!(orientation, OrientationPath::Constant(_)));
    assert_eq!(PosePath::new(curve, orientation).corners(1e-3).len(), 3);
}

#[test]
fn a_curve_is_divided_where_it_jumps() {
    // A quadratic spline: its curvature jumps at the first knot, its tangent at the second.
    let points: Vec<Vector3<f64>> = [(0.0, 0.0), (1.0, 2.0), (3.0, 3.0), (4.0, 0.0), (5.0, 3.0), (7.0, 0.0)]
        .map(|(x, y)| vector![10.0 + x, y, 0.0])
        .to_vec();
    let knots = vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0];
    let curve = NurbsCurve::bspline(2, points, knots).unwrap();
    let mut builder = start();
    builder.curve(&curve, 7).unwrap();
    let path = builder.build().unwrap();
    assert_eq!(path.pieces().len(), 3);
    let joints = path.joints();
    assert!(joints[0].angle < 1e-12 && joints[0].curvature_jump > 0.1 && joints[1].angle > 1.0);
    // The same shape: every point is on the curve.
    let one = path.to_curve().unwrap();
    for k in 0..=200 {
        let near = one.point(path.domain().1 * f64::from(k) / 200.0);
        let off = |u: f64| (curve.point(u) - near).norm();
        let from = (0..=300).map(|i| f64::from(i) / 100.0).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap();
        let fine = (-100..=100).map(|i| off(from + 1e-4 * f64::from(i))).fold(f64::INFINITY, f64::min);
        assert!(fine < 5e-4, "{fine}");
    }
    let blended = path.blended(&Blending::within(0.01)).unwrap();
    assert!(ArcLengthCurve::new(blended.path.to_curve().unwrap(), 1e-9).unwrap().corners(1e-8).is_empty());
}

#[test]
fn the_effort_is_linear() {
    let counts = [500usize, 5_000, 50_000].map(|n| {
        let mut size = 0;
        let count = allocations_in(|| {
            let mut builder = JoinedPathBuilder::new(Vector3::zeros(), 1e-6).unwrap();
            for i in 0..n {
                let x = i as f64;
                builder.line_to(vector![x + 1.0, (1.3 * x).sin(), (0.7 * x).cos()], i).unwrap();
            }
            let path = builder.build().unwrap();
            let blended = path.blended(&Blending::within(0.05)).unwrap();
            size = path.to_curve().unwrap().control_points().len()
                + blended.path.to_curve().unwrap().control_points().len();
        });
        assert!(size <= 1 + n + 5 * 2 * n, "{size} control points for {n} pieces");
        count as f64 / n as f64
    });
    assert!(counts.iter().all(|c| (c - counts[2]).abs() < 0.1 * counts[2] + 0.2), "{counts:?}");
}

#[test]
fn mixed_paths_are_continuous_where_they_are_not_cut() {
    // The generator of the blend tests makes what it says: every kind of piece, smooth joints and corners.
    let (mut kinds, mut smooth, mut corners) = ([0; 4], 0, 0);
    for seed in 0..200 {
        let path = mixed::path(&mut Random::new(seed));
        for piece in path.pieces() {
            kinds[piece.kind as usize] += 1;
        }
        smooth += path.joints().iter().filter(|j| j.angle < 1e-9).count();
        corners += path.joints().iter().filter(|j| j.angle > 1e-3).count();
    }
    assert!(kinds.iter().all(|&k| k > 100) && smooth > 100 && corners > 100, "{kinds:?} {smooth} {corners}");
}
