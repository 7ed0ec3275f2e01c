//! The three segmentations of the butterfly at 0.001 mm.
//!
//! Measured on a 2-core AMD EPYC VM shared with other work (fastest of 60 runs): hull 1.0 ms (1911 pieces), C type 1.5 ms
//! (1678), longest within knots 1.9 ms (1174), longest across knots 2.0 ms (1153).
#![allow(missing_docs, clippy::unwrap_used)]

mod published;

use std::hint::black_box;

use arcfeed_geometry::SegmentationMethod;
use criterion::{Criterion, criterion_group, criterion_main};
use published::published;

fn segmentation(c: &mut Criterion) {
    let curve = published("butterfly");
    let mut group = c.benchmark_group("butterfly at 0.001 mm");
    for (name, method) in [
        ("hull", SegmentationMethod::Hull),
        ("C type", SegmentationMethod::CType),
        ("longest within knots", SegmentationMethod::Greedy { across_knots: false }),
        ("longest across knots", SegmentationMethod::Greedy { across_knots: true }),
    ] {
        group.bench_function(name, |b| b.iter(|| black_box(&curve).segment(method, 0.001)));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(500)).measurement_time(std::time::Duration::from_secs(2)).sample_size(20);
    targets = segmentation
}
criterion_main!(benches);
