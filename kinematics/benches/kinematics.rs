//! Speed of what a planner and a control cycle call, on the CR7 at random joint values.

use arcfeed_kinematics::{
    AnalyticInverse, ForwardKinematics, InverseKinematics, Joints, MIN_SINGULAR_VALUE, ToolDerivatives, Twist,
    joint_derivatives, models, smallest_singular_value,
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

fn benches(criterion: &mut Criterion) {
    let arm = models::cr7();
    let joints = samples();
    let poses: Vec<Isometry3<f64>> = joints.iter().map(|q| arm.forward(q)).collect();
    let tool = ToolDerivatives { first: Twist::repeat(0.3), second: Twist::repeat(-0.2), third: Twist::repeat(0.1) };
    let mut i = 0;
    let mut next = || {
        i = (i + 1) % joints.len();
        i
    };
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

criterion_group!(all, benches);
criterion_main!(all);
