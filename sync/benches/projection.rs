//! What a cycle of the projection synchronisers costs: six joints and a pose, with an unchanged target and with a new one.
//!
//! Measured on a 2-core AMD EPYC VM with other work on it, medians: six joints 51 ns a cycle, 10 us with a target that moves in every
//! cycle, 1.3 us with one thrown about every 50 cycles; pose 170 ns, 44 us with a target that moves in every cycle.
#![allow(missing_docs, clippy::unwrap_used)]
use std::hint::black_box;

use arcfeed_sync::nalgebra::{Isometry3, SVector, Vector3};
use arcfeed_sync::{
    JointState, PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus, ProjectionSync, symmetric_limits,
};
use criterion::{Criterion, criterion_group, criterion_main};

type V6 = SVector<f64, 6>;

fn joints(c: &mut Criterion) {
    let limits = symmetric_limits(V6::repeat(3.0), V6::repeat(15.0), V6::repeat(300.0)).unwrap();
    let (near, far) = (V6::repeat(0.3), V6::from([1.5, -0.8, 0.7, -1.5, -1.57, 0.6]));
    let mut start = JointState::rest(V6::zeros());
    start.qd = V6::from([0.5, 0.2, -0.3, 1.0, -1.0, 0.1]);
    let begin = ProjectionSync::new(&start, far, &limits).unwrap();
    let mut sync = begin;
    c.bench_function("six joints, same target", |b| {
        b.iter(|| {
            sync.set_target(black_box(far)).unwrap();
            let step = sync.step(black_box(1e-3)).unwrap();
            if let ProjectionStatus::Reached { .. } = step.status {
                sync = begin;
            }
            step
        });
    });
    let (mut sync, mut k) = (begin, 0);
    c.bench_function("six joints, target moved a little", |b| {
        b.iter(|| {
            k = (k + 1) % 1000;
            sync.set_target(far + near * (1e-3 * f64::from(k))).unwrap();
            sync.step(black_box(1e-3)).unwrap()
        });
    });
    let (mut sync, mut k) = (begin, 0);
    c.bench_function("six joints, target thrown about every 50 cycles", |b| {
        b.iter(|| {
            k = (k + 1) % 100;
            sync.set_target(if k < 50 { near } else { far }).unwrap();
            sync.step(black_box(1e-3)).unwrap()
        });
    });
}

fn pose(c: &mut Criterion) {
    let limits = PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0]).unwrap();
    let target = |x: f64| Isometry3::new(Vector3::new(0.4, 0.3 + x, 0.2), Vector3::new(0.2, x, 1.0));
    let begin = PoseProjectionSync::new(&PoseState::rest(Isometry3::identity()), target(0.0), &limits).unwrap();
    let mut sync = begin;
    c.bench_function("pose, same target", |b| {
        b.iter(|| {
            let step = sync.step(black_box(1e-3)).unwrap();
            if let ProjectionStatus::Reached { .. } = step.status {
                sync = begin;
            }
            step
        });
    });
    let (mut sync, mut k) = (begin, 0);
    c.bench_function("pose, target moved a little", |b| {
        b.iter(|| {
            k = (k + 1) % 1000;
            sync.set_target(target(1e-4 * f64::from(k))).unwrap();
            sync.step(black_box(1e-3)).unwrap()
        });
    });
}

criterion_group!(benches, joints, pose);
criterion_main!(benches);
