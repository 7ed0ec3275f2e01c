//! What a motion through way-points costs.
//!
//! Measured on one core of a 2-core VM with real-time priority, medians: 170 us for six axes and ten points, 8 us for one axis and one
//! point, 38 us for three axes and three points.
#![allow(missing_docs, clippy::unwrap_used)]
use std::hint::black_box;

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{Route, WayPoint, WayPointPlanner};
use criterion::{Criterion, criterion_group, criterion_main};

/// Through points of smooth curves, with other velocities from axis to axis.
fn plan<const N: usize>(c: &mut Criterion, count: usize) {
    let limits = std::array::from_fn(|k| AxisLimits::symmetric(1.0 + 0.2 * k as f64, 5.0, 80.0).unwrap());
    let place = |i: usize| std::array::from_fn::<_, N, _>(|k| (0.3 * (k + 1) as f64 * i as f64 + k as f64).sin());
    let points: Vec<_> = (1..=count).map(|i| WayPoint::new(place(i))).collect();
    let route = Route::new(&points, place(count + 1).map(AxisState::rest), limits);
    let start = place(0).map(AxisState::rest);
    let mut planner = Box::new(WayPointPlanner::<N>::new());
    c.bench_function(&format!("{N} axes, {count} way-points"), |b| {
        b.iter(|| planner.plan(black_box(&start), black_box(&route)).unwrap().duration());
    });
}

fn plans(c: &mut Criterion) {
    plan::<1>(c, 1);
    plan::<3>(c, 3);
    plan::<6>(c, 10);
    plan::<6>(c, 64);
}

criterion_group!(benches, plans);
criterion_main!(benches);
