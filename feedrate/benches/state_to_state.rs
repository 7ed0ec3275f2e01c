//! What one calculation of a time-optimal state-to-state motion of one axis costs, and one sample of it.
//!
//! Measured on a 2-core AMD EPYC VM with other work on both cores: criterion's medians 596 ns and 8.6 ns at a load of 4, 419 ns
//! and 6.8 ns at a load of 2. The least of many repetitions of each input, beside another library, is measured in the
//! benchmark of the same name in `integration-tests`: median 340 ns, 99th percentile 460 ns, largest 770 ns.
//!
//! Inside a range: 1.3 us where one calculation tells, 0.34 us for the test of a state. A cycle of tracking a sinusoid with jumps:
//! 16 us in the mean.
#![allow(missing_docs, clippy::unwrap_used)]
use std::hint::black_box;

use arcfeed_feedrate::{AxisLimits, AxisState, BoundedProblem, MotionLaw, PositionLimits, StateToState, TargetTracker};
use criterion::{Criterion, criterion_group, criterion_main};

#[path = "../tests/it/common/mod.rs"]
mod common;
use arcfeed_testing::Random;

/// The distribution ruckig's own benchmark draws from: normal positions, velocities and accelerations, each of the latter two
/// zero in a part of the cases; limits uniform and wide enough for the states.
fn cases(seed: u64, count: usize) -> Vec<(AxisState, AxisState, AxisLimits)> {
    let mut rng = Random::new(seed);
    let normal = |rng: &mut Random, sigma: f64| {
        sigma * (-2.0 * (1.0 - rng.unit()).ln()).sqrt() * (std::f64::consts::TAU * rng.unit()).cos()
    };
    let sparse = |rng: &mut Random| {
        let x = normal(rng, 0.8);
        if rng.unit() < 0.6 { 0.0 } else { x }
    };
    let mut all = Vec::with_capacity(count);
    while all.len() < count {
        let start = AxisState::new(normal(&mut rng, 4.0), sparse(&mut rng), sparse(&mut rng));
        let target = AxisState::new(normal(&mut rng, 4.0), sparse(&mut rng), sparse(&mut rng));
        let least = |x: f64, y: f64| x.abs().max(y.abs());
        let v = 0.1 + 11.9 * rng.unit() + least(start.v, target.v);
        let a = 0.1 + 11.9 * rng.unit() + least(start.a, target.a);
        let j = 0.1 + 11.9 * rng.unit();
        let Ok(limits) = AxisLimits::symmetric(v, a, j) else { continue };
        if StateToState::new(&start, &target, &limits).is_ok() {
            all.push((start, target, limits));
        }
    }
    all
}

fn calculation(c: &mut Criterion) {
    let all = cases(1, 4096);
    let mut i = 0;
    c.bench_function("state to state, one calculation", |b| {
        b.iter(|| {
            i = (i + 1) & 4095;
            let (start, target, limits) = &all[i];
            StateToState::new(black_box(start), black_box(target), black_box(limits))
        });
    });
}

fn sampling(c: &mut Criterion) {
    let motions: Vec<StateToState> =
        cases(2, 64).iter().filter_map(|(s, t, l)| StateToState::new(s, t, l).ok()).collect();
    let (mut k, mut t) = (0, 0.0);
    c.bench_function("state to state, one sample, 1 ms apart", |b| {
        b.iter(|| {
            t += 1e-3;
            if t > motions[k].duration() {
                t = 0.0;
                k = (k + 1) & 63;
            }
            motions[k].at(black_box(t))
        });
    });
}

/// Ranges that the shortest motion leaves, and targets that move.
fn bounded_and_tracking(c: &mut Criterion) {
    let limits = AxisLimits::symmetric(1.0, 2.0, 20.0).unwrap();
    let positions = PositionLimits::new(-1.0, 0.2).unwrap();
    let (start, target) = (AxisState::new(0.0, 0.8, 0.0), AxisState::rest(-0.5));
    c.bench_function("state to state inside a range, one calculation", |b| {
        b.iter(|| BoundedProblem::new(black_box(&start), black_box(&target), &limits, &positions));
    });
    let (state, mut n) = (AxisState::new(0.1, 0.4, 1.0), 0);
    c.bench_function("braking inside a range, one test", |b| {
        b.iter(|| positions.can_stay(black_box(&state), &limits));
    });
    let mut tracker = TargetTracker::new(&AxisState::rest(0.0), &limits, 1e-3).unwrap();
    c.bench_function("tracking a sinusoid that jumps every second, one cycle", |b| {
        b.iter(|| {
            n += 1;
            let (t, jump) = (f64::from(n % 100_000) * 1e-3, f64::from(n / 1000 % 2));
            let target = AxisState::new(0.1 * (3.0 * t).sin() + jump, 0.3 * (3.0 * t).cos(), -0.9 * (3.0 * t).sin());
            tracker.step(black_box(&target))
        });
    });
}

criterion_group!(benches, calculation, sampling, bounded_and_tracking);
criterion_main!(benches);
