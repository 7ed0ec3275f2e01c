//! What one S-profile, one scan and one sample cost.
//!
//! Medians on a 2-core AMD EPYC VM with other work on it:
//!
//! | what | time |
//! |---|---|
//! | one S-profile, random cases | 161 ns |
//! | one change of speed | 47 ns |
//! | per segment, 300 / 3000 segments | 54 us / 0.56 ms |
//! | joined, 300 / 3000 segments | 0.34 ms / 3.0 ms |
//! | window of 10, 300 / 3000 segments | 0.25 ms / 3.0 ms |
//! | `at(t)` of a plan with some 3700 phases | 48 ns |
//! | cursor, per sample | 7 ns |
#![allow(missing_docs)]
use std::hint::black_box;

use arcfeed_feedrate::{
    Adjust, AxisLimits, MotionLaw, SProfile, Segment, SpeedChange, plan_continuous, plan_per_segment, plan_windowed,
};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};

#[path = "../tests/it/common/mod.rs"]
mod common;
use arcfeed_testing::Random;
use common::curve_like;

fn profiles(c: &mut Criterion) {
    let mut rng = Random::new(1);
    let cases: Vec<(f64, f64, f64, AxisLimits)> = (0..1024)
        .filter_map(|_| {
            let v = rng.log(0.01, 1.0);
            let limits = AxisLimits::symmetric(v, rng.log(0.1, 10.0), rng.log(1.0, 1000.0)).ok()?;
            Some((rng.log(1e-5, 1.0), v * rng.unit(), v * rng.unit(), limits))
        })
        .collect();
    let mut i = 0;
    c.bench_function("one S-profile, random cases", |b| {
        b.iter(|| {
            i = (i + 1) & 1023;
            let (length, v0, v1, limits) = &cases[i];
            SProfile::adaptive(black_box(*length), *v0, *v1, limits, Adjust::End)
        });
    });
    c.bench_function("one change of speed", |b| {
        b.iter(|| {
            i = (i + 1) & 1023;
            let (_, v0, v1, limits) = &cases[i];
            SpeedChange::new(black_box(*v0), 0.5 * limits.a_max(), *v1, limits)
        });
    });
}

fn scans(c: &mut Criterion) {
    for n in [300, 3000] {
        let segments: Vec<Segment> = curve_like(n, 1);
        c.bench_function(&format!("per segment, {n}"), |b| b.iter(|| plan_per_segment(black_box(&segments), 0.0, 0.0)));
        c.bench_function(&format!("joined, {n}"), |b| b.iter(|| plan_continuous(black_box(&segments), 0.0, 0.0)));
        c.bench_function(&format!("window of 10, {n}"), |b| b.iter(|| plan_windowed(black_box(&segments), 0.0, 10)));
    }
}

fn sampling(c: &mut Criterion) {
    let Ok(plan) = plan_continuous(&curve_like(3000, 1), 0.0, 0.0) else { return };
    let step = 1e-3;
    let mut t = 0.0;
    c.bench_function("at(t), 1 ms apart", |b| {
        b.iter(|| {
            t = if t > plan.duration() { 0.0 } else { t + step };
            plan.at(black_box(t))
        });
    });
    c.bench_function("cursor, 1000 samples 1 ms apart", |b| {
        b.iter_batched(
            || plan.cursor(),
            |mut cursor| (0..1000).map(|k| cursor.at(step * f64::from(k)).p).sum::<f64>(),
            BatchSize::SmallInput,
        );
    });
}

criterion_group!(benches, profiles, scans, sampling);
criterion_main!(benches);
