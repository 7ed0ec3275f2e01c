//! Arc length of the butterfly and evaluation by arc length.
//!
//! Medians measured on a 2-core AMD EPYC VM, other work running (`cargo bench -p arcfeed-geometry --bench arc_length`):
//!
//! | what | time | error |
//! |---|---|---|
//! | arc length to 1e-12 mm | 50 us | below 1e-12 mm |
//! | arc length to 1e-6 mm | 24 us | below 1e-6 mm |
//! | build `ArcLengthCurve` to 1e-15 m | 0.7 ms | |
//! | s to u | 20 ns | |
//! | s to point and three derivatives, plane | 45 ns | below 1e-11 mm |
//! | s to point and three derivatives, space | 60 to 70 ns | |
//! | u to s | 0.2 us | below 1e-12 mm |
#![allow(missing_docs, clippy::unwrap_used)]

mod published;

use std::hint::black_box;

use arcfeed_geometry::{ArcLengthCurve, Curve, NurbsCurve};
use criterion::{Criterion, criterion_group, criterion_main};
use published::published;

fn benches(c: &mut Criterion) {
    let mm = published("butterfly");
    let points = mm.control_points().iter().map(|p| p * 1e-3).collect();
    let m = NurbsCurve::new(3, points, mm.weights().to_vec(), mm.knots().as_slice().to_vec()).unwrap();
    let spatial = m.lifted();

    c.bench_function("arc length to 1e-12 mm", |b| b.iter(|| black_box(&mm).arc_length(1e-12)));
    c.bench_function("arc length to 1e-6 mm", |b| b.iter(|| black_box(&mm).arc_length(1e-6)));
    c.bench_function("build by arc length, 1e-15 m", |b| {
        b.iter(|| ArcLengthCurve::new(black_box(spatial.clone()), 1e-15))
    });
    let (a, b) = mm.domain();
    let by_length = ArcLengthCurve::new(mm, 1e-12).unwrap();
    let spatial = ArcLengthCurve::new(spatial, 1e-15).unwrap();
    let fractions: Vec<f64> = (0..1024).map(|i| (f64::from(i) * 0.618_033_988_749_894_9).fract()).collect();
    let mut i = 0;
    let mut next = || {
        i = (i + 1) & 1023;
        fractions[i]
    };
    let length = by_length.length();
    c.bench_function("s to u at random s", |b| b.iter(|| by_length.parameter(black_box(next() * length))));
    c.bench_function("s to point and three derivatives, plane, random s", |b| {
        b.iter(|| by_length.jet(black_box(next() * length)))
    });
    let length = spatial.length();
    c.bench_function("s to point and three derivatives, space, random s", |b| {
        b.iter(|| spatial.jet(black_box(next() * length)))
    });
    c.bench_function("u to s at random u", |bench| {
        bench.iter(|| by_length.arc_length_at(black_box(a + next() * (b - a))))
    });
}

criterion_group! {
    name = all;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1)).sample_size(20);
    targets = benches
}
criterion_main!(all);
