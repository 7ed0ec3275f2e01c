//! Curves fitted to dense points with rounded coordinates.
#![allow(clippy::unwrap_used)]

use std::f64::consts::{PI, TAU};

use arcfeed_geometry::nalgebra::{SVector, Vector2, Vector3, vector};
use arcfeed_geometry::{Curve, DenseFit, FittedStretch, GeometryError, NurbsCurve, Spacing, StretchShape};
use arcfeed_testing::Random;

use crate::common::dense::{check, corners, program, rounded};

fn fitted<const D: usize>(points: &[SVector<f64, D>], tolerance: f64) -> Vec<FittedStretch<D>> {
    let fitted = NurbsCurve::fit_dense(points.iter().copied(), tolerance).unwrap();
    check(points, &fitted, tolerance).unwrap();
    fitted
}

/// A smooth curve, at equal steps of its parameter, rounded to 1 um.
fn sampled<const D: usize>(n: usize, curve: impl Fn(f64) -> SVector<f64, D>) -> Vec<SVector<f64, D>> {
    (0..=n).map(|i| rounded(curve(i as f64 / n as f64))).collect()
}

/// Largest relative error of the curvature against 1 / radius, and largest third derivative by arc length.
fn roughness<const D: usize>(curve: &NurbsCurve<D>, radius: f64) -> (f64, f64) {
    let (a, b) = curve.domain();
    let mut worst = (0.0f64, 0.0f64);
    for i in 0..=4000 {
        let jet = curve.jet(a + (b - a) * f64::from(i) / 4000.0).by_arc_length();
        worst.0 = worst.0.max((jet.d2.norm() * radius - 1.0).abs());
        worst.1 = worst.1.max(jet.d3.norm());
    }
    worst
}

/// The third derivative of a circle of 20 mm is 1 / 400 per mm^2.
#[test]
fn circles_keep_their_curvature() {
    for (step, tolerance) in [(0.1, 0.005), (0.1, 0.01), (0.2, 0.005), (0.5, 0.005), (0.5, 0.01)] {
        let n = (TAU * 20.0 / step) as usize;
        let points = sampled(n, |x| vector![20.0 * (TAU * x).cos(), 20.0 * (TAU * x).sin()]);
        let fit = fitted(&points, tolerance);
        assert_eq!(corners(&fit), [0, n]);
        let pieces: usize = fit.iter().map(FittedStretch::pieces).sum();
        let all = fit.iter().map(|s| roughness(&s.curve, 20.0));
        let (error, third) = all.fold((0.0f64, 0.0f64), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let through = NurbsCurve::interpolate(&points, 3, Spacing::Chord).unwrap().curve;
        let (error_through, third_through) = roughness(&through, 20.0);
        println!(
            "{step} {tolerance}: {} pieces, curvature {error:.4} ({error_through:.3}), d3 {third:.5} ({third_through:.2})",
            pieces
        );
        // No more than the arc in four spans, with cubics from and to the point where the circle starts.
        assert!(pieces <= 12);
        assert!(error < 0.05 && third < 0.004);
        // Interpolation has the same points and a curvature without use.
        assert!(error_through > 4.0 * error && third_through > 10.0 * third);
    }
}

#[test]
fn curves_have_few_pieces_and_no_corners() {
    let spiral = sampled(8000, |x| (2.0 + 30.0 * x) * vector![(40.0 * x).cos(), (40.0 * x).sin()]);
    let sine = sampled(3000, |x| vector![200.0 * x, 6.0 * (60.0 * x).sin()]);
    for (points, most) in [(spiral, 120), (sine, 260)] {
        let fit = fitted(&points, 0.005);
        println!("{} points, {} pieces", points.len(), fit[0].pieces());
        assert_eq!(corners(&fit), [0, points.len() - 1]);
        assert!(fit[0].pieces() <= most);
    }
    let helix = sampled(5000, |x| vector![15.0 * (30.0 * x).cos(), 15.0 * (30.0 * x).sin(), 40.0 * x]);
    let knot = sampled(6000, |x| {
        let (t, r) = (TAU * x, 30.0 + 10.0 * (3.0 * TAU * x).cos());
        vector![r * (2.0 * t).cos(), r * (2.0 * t).sin(), 10.0 * (3.0 * t).sin()]
    });
    for (points, most) in [(helix, 80), (knot, 100)] {
        let fit = fitted(&points, 0.005);
        println!("{} points, {} pieces", points.len(), fit[0].pieces());
        assert_eq!(corners(&fit), [0, points.len() - 1]);
        assert!(fit[0].pieces() <= most);
    }
}

/// A closed polygon with `n` points to an edge, turned so that rounding matters.
fn polygon(vertices: &[Vector2<f64>], n: usize) -> Vec<Vector2<f64>> {
    let (s, c) = 0.3f64.sin_cos();
    let turned = |p: Vector2<f64>| rounded(vector![c * p.x - s * p.y, s * p.x + c * p.y]);
    let mut points = Vec::new();
    for (i, &a) in vertices.iter().enumerate() {
        let b = vertices[(i + 1) % vertices.len()];
        points.extend((0..n).map(|j| turned(a + (b - a) * (j as f64 / n as f64))));
    }
    points.push(points[0]);
    points
}

#[test]
fn corners_of_polygons_are_found_exactly() {
    let square = [vector![0.0, 0.0], vector![20.0, 0.0], vector![20.0, 20.0], vector![0.0, 20.0]];
    let star: Vec<_> = (0..10)
        .map(|i| {
            let (a, r) = (PI * f64::from(i) / 5.0, if i % 2 == 0 { 25.0 } else { 9.0 });
            vector![r * a.cos(), r * a.sin()]
        })
        .collect();
    // Steps from 20 mm to 0.01 mm.
    for n in [1, 10, 200, 2000] {
        for vertices in [&square[..], &star[..]] {
            let points = polygon(vertices, n);
            let fit = fitted(&points, 0.005);
            let expected: Vec<_> = (0..=vertices.len()).map(|i| i * n).collect();
            assert_eq!(corners(&fit), expected, "{n}");
            assert!(fit.iter().all(|s| s.shape == StretchShape::Line));
        }
    }
}

/// An arc of 20 tolerances that turns against the corner in which it starts has no corner of its own.
#[test]
fn a_tight_arc_beside_a_corner_is_smooth() {
    for radius in [0.08, 0.1, 0.15] {
        let mut points: Vec<_> = (0..=100).map(|i| vector![0.01 * f64::from(i) - 1.0, 0.0]).collect();
        // To the right by 1.5 rad, and along the arc to the left by 2 rad.
        let n = (2.0 * radius / 0.01) as i32;
        let on_arc = |i: i32| -1.5 + 2.0 * f64::from(i) / f64::from(n);
        let centre = radius * vector![1.5f64.sin(), 1.5f64.cos()];
        points.extend((1..=n).map(|i| centre + radius * vector![on_arc(i).sin(), -on_arc(i).cos()]));
        let end = points[points.len() - 1];
        points.extend((1..=100).map(|i| end + 0.01 * f64::from(i) * vector![0.5f64.cos(), 0.5f64.sin()]));
        let points: Vec<_> = points.into_iter().map(rounded).collect();
        assert_eq!(corners(&fitted(&points, 0.005)), [0, 100, points.len() - 1], "{radius}");
    }
}

/// A pocket: long G1 blocks and dense fillets that join them by the tangent.
#[test]
fn long_chords_are_lines_that_the_curve_continues() {
    let mut points = vec![vector![0.0, 0.0]];
    let (mut at, mut heading) = (vector![0.0, 0.0], 0.0f64);
    for _ in 0..4 {
        at += 40.0 * vector![heading.cos(), heading.sin()];
        points.push(at);
        let centre = at + 3.0 * vector![-heading.sin(), heading.cos()];
        for i in 1..=60 {
            let a = heading + PI / 2.0 * f64::from(i) / 60.0;
            points.push(centre + 3.0 * vector![a.sin(), -a.cos()]);
        }
        (at, heading) = (points[points.len() - 1], heading + PI / 2.0);
    }
    let points: Vec<_> = points.into_iter().map(rounded).collect();
    let fit = fitted(&points, 0.005);
    let pieces: usize = fit.iter().map(FittedStretch::pieces).sum();
    let lines: Vec<_> = fit.iter().flat_map(|s| s.lines.iter().map(|line| (&s.curve, *line))).collect();
    let arcs = fit.iter().filter(|s| s.shape == StretchShape::Arc);
    println!("pocket: {} stretches, {pieces} pieces, {} lines", fit.len(), lines.len());
    assert_eq!((lines.len(), arcs.count()), (4, 4));
    assert!(fit[1..].iter().all(|s| s.continues) && pieces <= 34);
    for (curve, (from, to)) in lines {
        assert!(to - from > 37.0);
        for i in 0..=10 {
            let jet = curve.jet(from + (to - from) * f64::from(i) / 10.0);
            assert!(jet.d2.norm() < 1e-9 && (jet.speed() - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn random_programs_are_fitted() {
    let (mut points, mut pieces, mut arcs) = (0, [0, 0], 0);
    for seed in 1..=400 {
        let program = program(seed);
        let mut of_one = [0, 0];
        for (fit, count) in [true, false].into_iter().zip(&mut of_one) {
            let start = DenseFit::new(program.tolerance).unwrap();
            let mut fit = if fit { start } else { start.with_cubics_only() };
            program.points.iter().for_each(|p| fit.push(*p).unwrap());
            fit.finish().unwrap();
            let fit: Vec<_> = std::iter::from_fn(|| fit.next_stretch()).collect();
            check(&program.points, &fit, program.tolerance).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
            assert_eq!(corners(&fit), program.corners, "seed {seed}");
            *count = fit.iter().map(FittedStretch::pieces).sum::<usize>();
            arcs += fit.iter().filter(|s| s.shape == StretchShape::Arc).count();
        }
        assert!(of_one[0] <= of_one[1], "seed {seed}: {of_one:?} pieces");
        points += program.points.len();
        pieces = [pieces[0] + of_one[0], pieces[1] + of_one[1]];
    }
    println!("{points} points, {pieces:?} pieces, {arcs} arcs");
    assert!(pieces[0] * 15 < points && pieces[0] * 100 < pieces[1] * 97 && arcs > 40);
}

/// Points every 0.1 mm along a square with rounded corners, turned and rounded to 1 um.
fn rounded_square(radius: f64) -> Vec<Vector2<f64>> {
    let (s, c) = 0.3f64.sin_cos();
    let half = 30.0;
    let mut points: Vec<Vector2<f64>> = vec![vector![0.0, -half]];
    let line = |points: &mut Vec<Vector2<f64>>, to: Vector2<f64>| {
        let from = points[points.len() - 1];
        let n = ((to - from).norm() / 0.1).ceil() as i32;
        points.extend((1..=n).map(|i| from.lerp(&to, f64::from(i) / f64::from(n))));
    };
    for i in 0..4 {
        let (sine, cosine) = (PI / 2.0 * f64::from(i)).sin_cos();
        let turned = |x: f64, y: f64| vector![x * cosine - y * sine, x * sine + y * cosine];
        let (from, centre) = (turned(half - radius, -half), turned(half - radius, -half + radius));
        let to = turned(half, -half + radius);
        line(&mut points, from);
        let n = (PI / 2.0 * radius / 0.1).ceil();
        let on_arc = |i: i32| {
            let (sine, cosine) = (PI / 2.0 * f64::from(i) / n).sin_cos();
            centre + (from - centre) * cosine + (to - centre) * sine
        };
        points.extend((1..=n as i32).map(on_arc));
    }
    line(&mut points, vector![0.0, -half]);
    points.iter().map(|p| rounded(vector![c * p.x - s * p.y, s * p.x + c * p.y])).collect()
}

/// Five lines, four arcs, and three cubics for each joint between them.
#[test]
fn lines_and_arcs_are_recognised() {
    for (radius, tolerance) in [(1.0, 0.005), (5.0, 0.002), (5.0, 0.005), (5.0, 0.02), (20.0, 0.002), (20.0, 0.005)] {
        let points = rounded_square(radius);
        let fit = fitted(&points, tolerance);
        let arcs: Vec<_> = fit.iter().filter(|s| s.shape == StretchShape::Arc).collect();
        let pieces: usize = fit.iter().map(FittedStretch::pieces).sum();
        println!("radius {radius}, tolerance {tolerance}: {} arcs, {pieces} pieces", arcs.len());
        assert_eq!((arcs.len(), corners(&fit).len()), (4, 2));
        assert!(pieces <= 33);
        for arc in arcs {
            let curvature = arc.curve.jet(arc.curve.domain().0).curvature();
            assert!((curvature * radius - 1.0).abs() < 0.01, "{curvature}");
        }
        assert_eq!(fit.iter().map(|s| s.lines.len()).sum::<usize>(), 5);
    }
    // In space: a ring in a tilted plane, and a line from its end.
    let (u, v) = (Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.0, 1.0, 0.0));
    let mut points: Vec<_> =
        (0..=900).map(|i| u * 10.0 * (0.005 * f64::from(i)).cos() + v * 10.0 * (0.005 * f64::from(i)).sin()).collect();
    let along = (points[900] - points[899]).normalize();
    points.extend((1..=400).map(|i| points[900] + along * (0.05 * f64::from(i))).collect::<Vec<_>>());
    let points: Vec<_> = points.into_iter().map(rounded).collect();
    let fit = fitted(&points, 0.002);
    println!("{:?}", fit.iter().map(|s| (s.shape, s.pieces())).collect::<Vec<_>>());
    assert_eq!(fit.iter().filter(|s| s.shape == StretchShape::Arc).count(), 1);
    assert!(fit.iter().map(FittedStretch::pieces).sum::<usize>() <= 10);
}

/// A path on a wavy torus, every 0.1 mm.
fn torus(i: usize) -> Vector3<f64> {
    let s = i as f64 * 0.1;
    let (angle, radius) = (s / 200.0, 200.0 + 10.0 * (s / 37.0).sin());
    rounded(vector![radius * angle.cos(), radius * angle.sin(), 5.0 * (s / 25.0).sin()])
}

#[test]
fn the_work_grows_in_proportion_to_the_points() {
    for n in [100_000, 1_000_000] {
        let mut fit = DenseFit::new(0.005).unwrap();
        (0..n).for_each(|i| fit.push(torus(i)).unwrap());
        fit.finish().unwrap();
        let pieces: usize = std::iter::from_fn(|| fit.next_stretch()).map(|s| s.pieces()).sum();
        println!("{n} points: {} parts read, {pieces} pieces", fit.parts_read());
        assert!(fit.parts_read() < 30 * n as u64);
        assert!(pieces < n / 50);
    }
}

#[test]
fn curves_come_out_while_points_arrive() {
    // Waves of 0.6 mm: so many pieces that the curve comes out in parts.
    let wave = |i: usize| rounded(vector![0.02 * i as f64, 0.05 * (i as f64 * 0.2).sin()]);
    let points: Vec<_> = (0..200_000).map(wave).collect();
    let mut fit = DenseFit::new(0.002).unwrap();
    let mut stretches = Vec::new();
    for &point in &points {
        fit.push(point).unwrap();
        stretches.extend(std::iter::from_fn(|| fit.next_stretch()));
    }
    let before = stretches.len();
    fit.finish().unwrap();
    stretches.extend(std::iter::from_fn(|| fit.next_stretch()));
    println!("{before} of {} stretches before the end", stretches.len());
    assert!(before > 2);
    assert!(stretches[1..].iter().all(|s| s.continues));
    check(&points, &stretches, 0.002).unwrap();
}

/// Chords of 100 m that turn by 15 degrees, within 0.2 um: the spans at the joints are too narrow for one curve.
#[test]
fn a_curve_with_very_unequal_spans_comes_out_in_parts() {
    let mut points = vec![vector![0.0, 0.0]];
    for i in 0..4 {
        let heading = 0.26 * f64::from(i);
        points.push(points[points.len() - 1] + 1e5 * vector![heading.cos(), heading.sin()]);
    }
    let fit = fitted(&points, 5e-4);
    assert!(fit.len() > 1 && fit[1..].iter().all(|s| s.continues && s.shape == StretchShape::Curve));
}

#[test]
fn hostile_points_are_refused_or_fitted() {
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(DenseFit::<2>::new(tolerance), Err(GeometryError::NotPositive { .. })));
        assert!(DenseFit::<2>::new(0.1).unwrap().with_corner_angle(tolerance).is_err());
    }
    let mut fit = DenseFit::new(0.005).unwrap();
    assert!(matches!(fit.finish(), Err(GeometryError::TooFewDataPoints { points: 0, .. })));
    fit.push(vector![1.0, 2.0]).unwrap();
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        let r = fit.push(vector![0.0, bad]);
        assert!(matches!(r, Err(GeometryError::PointNotFinite { index: 1, axis: 1, .. })));
    }
    assert!(matches!(fit.push(vector![1e7, 0.0]), Err(GeometryError::ToleranceTooSmall { .. })));
    fit.push(vector![1.0, 2.0]).unwrap();
    assert!(matches!(fit.finish(), Err(GeometryError::TooFewDataPoints { .. })));

    let one = vector![1.0, 2.0];
    let line = fitted(&[one, vector![3.0, 5.0]], 0.005);
    assert_eq!((line.len(), line[0].shape, line[0].first, line[0].last), (1, StretchShape::Line, 0, 1));
    // Duplicates are counted.
    let twice = [one, one, vector![3.0, 5.0], vector![3.0, 5.0], vector![9.0, 5.0]];
    let fit = NurbsCurve::fit_dense(twice, 0.005).unwrap();
    assert_eq!((corners(&fit), fit.len()), (vec![0, 2, 4], 2));
    // There and back, and there again.
    let reversal: Vec<_> = [0, 1, 2, 3, 4, 3, 2, 1, 2, 3].map(|i| vector![f64::from(i), 0.0]).to_vec();
    let fit = fitted(&reversal, 0.005);
    assert_eq!(corners(&fit), [0, 4, 7, 9]);
    // The same with steps far below the tolerance.
    let fine: Vec<_> = (0..4000).map(|i| vector![0.001 * f64::from(2000 - (i - 2000i32).abs()), 0.0]).collect();
    assert_eq!(corners(&fitted(&fine, 0.005)), [0, 2000, 3999]);
    // Collinear points at uneven steps.
    let collinear: Vec<_> = (0..500).map(|i| f64::from(i * i) * vector![1e-3, 2e-3, -1e-3]).collect();
    let fit = fitted(&collinear, 0.005);
    assert_eq!((fit.len(), fit[0].shape), (1, StretchShape::Line));
}

/// A zigzag that turns by 165 degrees every 20 tolerances, with no corners allowed below 170 degrees: narrow turns.
#[test]
fn a_curve_turns_within_the_tolerance_where_corners_are_not_allowed() {
    let (s, c) = (165f64 / 2.0).to_radians().sin_cos();
    let mut points = vec![vector![0.0, 0.0]];
    for i in 0..40 {
        points.push(points[i] + 0.1 * vector![c, if i % 2 == 0 { s } else { -s }]);
    }
    let mut fit = DenseFit::new(0.005).unwrap().with_corner_angle(170f64.to_radians()).unwrap();
    points.iter().for_each(|p| fit.push(*p).unwrap());
    fit.finish().unwrap();
    let stretches: Vec<_> = std::iter::from_fn(|| fit.next_stretch()).collect();
    check(&points, &stretches, 0.005).unwrap();
    assert_eq!((stretches.len(), stretches[0].shape), (1, StretchShape::Curve));
    // The default has a corner at every vertex.
    assert_eq!(fitted(&points, 0.005).len(), 40);
}

/// A circle with noise about the size of the tolerance, in small steps: bends everywhere, and still no endless work.
#[test]
fn noise_beyond_the_tolerance_costs_bounded_work() {
    for (noise, step) in [(0.004, 0.02), (0.01, 0.02), (0.01, 0.001), (0.1, 0.02)] {
        let mut random = Random::new(7);
        let points: Vec<_> = (0..3000)
            .map(|i| {
                let a = f64::from(i) * step / 20.0;
                rounded(vector![20.0 * a.cos() + noise * random.signed(), 20.0 * a.sin() + noise * random.signed()])
            })
            .fold(Vec::new(), |mut points, p| {
                if points.last() != Some(&p) {
                    points.push(p);
                }
                points
            });
        let mut fit = DenseFit::new(0.005).unwrap();
        points.iter().for_each(|p| fit.push(*p).unwrap());
        fit.finish().unwrap();
        let stretches: Vec<_> = std::iter::from_fn(|| fit.next_stretch()).collect();
        let pieces: usize = stretches.iter().map(FittedStretch::pieces).sum();
        println!(
            "noise {noise}, step {step}: {} stretches, {pieces} pieces, {} parts",
            stretches.len(),
            fit.parts_read()
        );
        check(&points, &stretches, 0.005).unwrap();
        assert!(fit.parts_read() < 40 * points.len() as u64);
    }
}

/// Points without any order: corners and lines wherever no curve keeps the tolerance, and always a result.
#[test]
fn scattered_points_are_fitted() {
    for seed in 1..=300 {
        let mut random = Random::new(seed);
        let (size, tolerance) = (random.log(1e-3, 10.0), random.log(1e-4, 1.0));
        let n = 2 + random.below(60);
        let grid = random.log(1e-6, 1e-1);
        let points: Vec<_> = (0..n)
            .map(|_| Vector3::from_fn(|_, _| (random.signed() * size / grid).round() * grid))
            .fold(Vec::new(), |mut points, p| {
                if points.last() != Some(&p) {
                    points.push(p);
                }
                points
            });
        let result = NurbsCurve::fit_dense(points.iter().copied(), tolerance);
        if points.len() < 2 {
            assert!(matches!(result, Err(GeometryError::TooFewDataPoints { .. })));
            continue;
        }
        let fit = result.unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        check(&points, &fit, tolerance).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    }
}
