//! Speed of what a planner and a control cycle call, on the CR7, the KR 6 R700 and the Panda at random joint values.
//!
//! Measured on a 2-core AMD EPYC VM at about 2.3 GHz, medians: (a) of 2000 loops over 512 joint vectors, (b) this file with
//! little else to do, (c) this file while other programs kept both cores busy three times over.
//!
//! | CR7 | (a) | (b) | (c) |
//! |---|---|---|---|
//! | forward (UR5e, KR 6 R700 and Puma 560 the same) | 67 ns | 72 to 79 ns | 111 to 155 ns |
//! | forward_jacobian | 105 ns | | 175 ns |
//! | jacobian_dot_qd | 136 ns | | 255 ns |
//! | inverse_all (up to 8 solutions) | 0.53 us | | 1.16 us |
//! | inverse (nearest, limits, turns) | 0.85 us | | 1.21 us |
//! | joint_derivatives (to third order) | 0.66 us | | 0.98 us |
//! | smallest_singular_value | 3.2 us | | 4.7 us |
//!
//! | KR 6 R700 | (a) |
//! |---|---|
//! | forward_jacobian | 105 ns |
//! | inverse_all (8 solutions) | 0.69 us |
//! | torque (Newton-Euler) | 200 ns |
//! | mass_matrix | 243 ns |
//! | along_path (all torque coefficients) | 585 ns |
//!
//! For comparison, in (a) six calls of the C library's `sincos` take 71 ns.

use arcfeed_kinematics::{
    AnalyticInverse, Dynamics, ForwardKinematics, InverseKinematics, Joints, MIN_SINGULAR_VALUE, ToolDerivatives,
    Twist, joint_derivatives, models, smallest_singular_value,
};
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Isometry3;
use std::hint::black_box;
use std::time::Duration;

/// Joint vectors in +-2.7 rad from a fixed multiplicative sequence, away from singular poses.
fn samples() -> Vec<Joints<6>> {
    let arm = models::cr7();
    let mut state = 20_260_101_u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 5.4 - 2.7
    };
    let mut all = Vec::new();
    while all.len() < 512 {
        let q = Joints::from_fn(|_, _| draw());
        if smallest_singular_value(&arm.jacobian(&q)) > 1e-2 {
            all.push(q);
        }
    }
    all
}

/// The numbers of the samples, round and round.
fn turns(samples: usize) -> impl FnMut() -> usize {
    let mut i = 0;
    move || {
        i = (i + 1) % samples;
        i
    }
}

fn forward(criterion: &mut Criterion) {
    let joints = samples();
    let mut group = criterion.benchmark_group("forward");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(50);
    for name in ["cr7", "ur5e", "kr6_r700", "puma560"] {
        let arm =
            models::description(name).and_then(|arm| arm.build::<6>().ok()).expect("a built-in arm of six joints");
        let mut next = turns(joints.len());
        group.bench_function(name, |b| b.iter(|| arm.forward(black_box(&joints[next()]))));
    }
    group.finish();
}

fn cr7(criterion: &mut Criterion) {
    let joints = samples();
    let arm = models::cr7();
    let poses: Vec<Isometry3<f64>> = joints.iter().map(|q| arm.forward(q)).collect();
    let tool = ToolDerivatives { first: Twist::repeat(0.3), second: Twist::repeat(-0.2), third: Twist::repeat(0.1) };
    let mut next = turns(joints.len());
    let mut group = criterion.benchmark_group("cr7");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(50);
    group.bench_function("forward", |b| b.iter(|| arm.forward(black_box(&joints[next()]))));
    group.bench_function("forward_jacobian", |b| b.iter(|| arm.forward_jacobian(black_box(&joints[next()]))));
    group.bench_function("jacobian_dot_qd", |b| {
        let qd = Joints::repeat(0.5);
        b.iter(|| arm.jacobian_dot_qd(black_box(&joints[next()]), &qd))
    });
    group.bench_function("inverse_all", |b| b.iter(|| arm.inverse_all(black_box(&poses[next()]))));
    group.bench_function("inverse", |b| {
        b.iter(|| {
            let k = next();
            arm.inverse(black_box(&poses[k]), &joints[k])
        })
    });
    group.bench_function("joint_derivatives", |b| {
        b.iter(|| joint_derivatives(&arm, black_box(&joints[next()]), &tool, MIN_SINGULAR_VALUE))
    });
    group.bench_function("smallest_singular_value", |b| {
        let jacobians: Vec<_> = joints.iter().map(|q| arm.jacobian(q)).collect();
        b.iter(|| smallest_singular_value(black_box(&jacobians[next()])))
    });
    group.finish();
}

fn kr6(criterion: &mut Criterion) {
    let joints = samples();
    let mut next = turns(joints.len());
    let described = models::description("kr6_r700").and_then(|arm| arm.build::<6>().ok());
    let arm = described.expect("a built-in arm of six joints");
    let dynamics = arm.dynamics().expect("its links are known");
    let poses: Vec<Isometry3<f64>> = joints.iter().map(|q| arm.forward(q)).collect();
    let mut group = criterion.benchmark_group("kr6");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(50);
    group.bench_function("forward", |b| b.iter(|| arm.forward(black_box(&joints[next()]))));
    group.bench_function("forward_jacobian", |b| b.iter(|| arm.forward_jacobian(black_box(&joints[next()]))));
    group.bench_function("inverse_all", |b| b.iter(|| arm.inverse_all(black_box(&poses[next()]))));
    let (rates, accelerations) = (Joints::repeat(0.5), Joints::repeat(-2.0));
    group.bench_function("torque", |b| b.iter(|| dynamics.torque(black_box(&joints[next()]), &rates, &accelerations)));
    group.bench_function("mass_matrix", |b| b.iter(|| dynamics.mass_matrix(black_box(&joints[next()]))));
    group.bench_function("along_path", |b| {
        b.iter(|| dynamics.along_path(black_box(&joints[next()]), &rates, &accelerations))
    });
    group.finish();
}

fn panda(criterion: &mut Criterion) {
    let joints = samples();
    let mut next = turns(joints.len());
    let panda = models::panda();
    let (lower, upper) = (panda.range().lower(), panda.range().upper());
    let places: Vec<Joints<7>> = joints
        .iter()
        .map(|q| Joints::from_fn(|i, _| lower[i] + (q[i % 6] + 2.7) / 5.4 * (upper[i] - lower[i])))
        .collect();
    let poses: Vec<Isometry3<f64>> = places.iter().map(|q| panda.forward(q)).collect();
    let mut group = criterion.benchmark_group("panda");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(50);
    group.bench_function("inverse from a seed 0.01 rad away", |b| {
        b.iter(|| {
            let k = next();
            panda.inverse(black_box(&poses[k]), &places[k].map(|v| v + 0.01))
        })
    });
    group.finish();
}

criterion_group!(all, forward, cr7, kr6, panda);
criterion_main!(all);
