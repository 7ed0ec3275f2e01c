//! Curves beside curvo 0.3 in one run, on the butterfly in the plane (cubic, 51 control points, rational, mm).
//!
//! Measured on a 2-core AMD EPYC VM while other programs kept both cores busy, medians of one run:
//!
//! | | arcfeed | curvo 0.3.3 |
//! |---|---|---|
//! | point and derivatives at random u | 22.8 ns (three derivatives) | 271 ns (two) |
//! | arc length | 31.5 us, to 1e-12 mm | 171 us, 4e-5 mm off |
//! | parameter at a random arc length | 17.9 ns, to 1e-12 mm, from a map built in 0.70 ms | 162 us, to 1e-6 mm |

use std::hint::black_box;
use std::time::Duration;

use arcfeed_geometry::{ArcLengthCurve, Curve, NurbsCurve};
use criterion::{Criterion, criterion_group, criterion_main};
use curvo::prelude::NurbsCurve2D;
use nalgebra::{Point3, Vector2};
use robot_cr7::butterfly;

/// The same butterfly for both, in mm, which suits the tolerances that curvo has built in.
fn curves() -> (NurbsCurve<2>, NurbsCurve2D<f64>) {
    let metres = butterfly().expect("comes with the program").plane_curve().expect("a plane curve");
    let points: Vec<Vector2<f64>> = metres.control_points().iter().map(|p| p * 1e3).collect();
    let (weights, knots) = (metres.weights().to_vec(), metres.knots().as_slice().to_vec());
    let homogeneous = points.iter().zip(&weights).map(|(p, &w)| Point3::new(p.x * w, p.y * w, w)).collect();
    let theirs = NurbsCurve2D::try_new(metres.degree(), homogeneous, knots.clone()).expect("a valid curve");
    let ours = NurbsCurve::new(metres.degree(), points, weights, knots).expect("a valid curve");
    // The same curve, or the times mean nothing.
    for i in 0..=1000 {
        let u = f64::from(i) / 1000.0;
        let (a, b) = (ours.jet(u), theirs.rational_derivatives(u, 2));
        assert!((a.point - b[0]).norm() < 1e-10 && (a.d2 - b[2]).norm() < 1e-8 * (1.0 + b[2].norm()), "at u = {u}");
    }
    (ours, theirs)
}

/// Evenly spread over [0, 1) in an order without pattern (golden ratio steps).
fn parameters() -> impl FnMut() -> f64 {
    let us: Vec<f64> = (0..1024).map(|i| (f64::from(i) * 0.618_033_988_749_894_9).fract()).collect();
    let mut i = 0;
    move || {
        i = (i + 1) & 1023;
        us[i]
    }
}

fn evaluation(c: &mut Criterion) {
    let (ours, theirs) = curves();
    let mut group = c.benchmark_group("point and derivatives at random u");
    let mut next = parameters();
    group.bench_function("arcfeed, three derivatives", |b| b.iter(|| ours.jet(black_box(next()))));
    let mut next = parameters();
    group.bench_function("curvo, two derivatives", |b| b.iter(|| theirs.rational_derivatives(black_box(next()), 2)));
    group.finish();
}

fn arc_length(c: &mut Criterion) {
    let (ours, theirs) = curves();
    let exact = ours.arc_length(1e-12).expect("a tolerance above 0");
    let curvo = theirs.try_length().expect("a length");
    println!("arc length: arcfeed {exact} mm, curvo {curvo} mm, {:.1e} mm apart", (exact - curvo).abs());
    let mut group = c.benchmark_group("arc length of the butterfly");
    group.bench_function("arcfeed, to 1e-12 mm", |b| b.iter(|| black_box(&ours).arc_length(1e-12)));
    group.bench_function("curvo", |b| b.iter(|| black_box(&theirs).try_length()));
    group.finish();

    let by_length = ArcLengthCurve::new(ours, 1e-12).expect("a curve of some length");
    let mut group = c.benchmark_group("parameter at a random arc length");
    let mut next = parameters();
    group.bench_function("arcfeed, to 1e-12 mm", |b| b.iter(|| by_length.parameter(black_box(next() * exact))));
    let mut next = parameters();
    group.bench_function("curvo, to 1e-6 mm", |b| {
        b.iter(|| theirs.try_parameter_at_length(black_box(next() * exact), Some(1e-6)));
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .sample_size(20);
    targets = evaluation, arc_length
}
criterion_main!(benches);
