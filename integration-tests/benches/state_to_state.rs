//! Motion between states beside the official ruckig and rsruckig 3 in one run, on the same inputs: the distribution that
//! ruckig's own benchmark draws from, less the few inputs that either of the two refuses.
//!
//! Measured on a 2-core AMD EPYC VM: docs/measured.md has the table. Our worst case is 2.2 times (one axis) and 2.9 times (six axes) our
//! median. One online cycle of six axes, the same target set again and a step: 58 ns.
#![allow(missing_docs)]

use arcfeed_testing::Random;
use std::cell::RefCell;
use std::hint::black_box;
use std::time::Instant;

use arcfeed_sync::feedrate::{AxisLimits, AxisState, StateToState};
use arcfeed_sync::{MotionOptions, OnlineGenerator, Synchronisation, Trajectory};
use criterion::{Criterion, criterion_group, criterion_main};
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler};

type Theirs<const N: usize> = rsruckig::prelude::Trajectory<N>;

fn normal(rng: &mut Random, sigma: f64) -> f64 {
    sigma * (-2.0 * (1.0 - rng.unit()).ln()).sqrt() * (std::f64::consts::TAU * rng.unit()).cos()
}

/// Zero but for a share of the cases.
fn sparse(rng: &mut Random, share: f64) -> f64 {
    let x = normal(rng, 0.8);
    if rng.unit() < share { x } else { 0.0 }
}

struct Case<const N: usize> {
    start: [AxisState; N],
    target: [AxisState; N],
    limits: [AxisLimits; N],
    theirs: InputParameter<N>,
    official: RefCell<ruckig::InputParameter>,
}

fn cases<const N: usize>(seed: u64, count: usize) -> Vec<Case<N>> {
    let mut rng = Random::new(seed);
    let mut otg = Ruckig::<N, ThrowErrorHandler>::new(None, 0.005);
    let mut all = Vec::with_capacity(count);
    while all.len() < count {
        let start: [_; N] = std::array::from_fn(|_| {
            AxisState::new(normal(&mut rng, 4.0), sparse(&mut rng, 0.9), sparse(&mut rng, 0.8))
        });
        let target: [_; N] = std::array::from_fn(|_| {
            AxisState::new(normal(&mut rng, 4.0), sparse(&mut rng, 0.7), sparse(&mut rng, 0.6))
        });
        let limit = |rng: &mut Random, least: f64| 0.1 + 11.9 * rng.unit() + least.abs();
        let bounds: [_; N] =
            std::array::from_fn(|k| [limit(&mut rng, target[k].v), limit(&mut rng, target[k].a), limit(&mut rng, 0.0)]);
        let mut theirs = InputParameter::new(None);
        for k in 0..N {
            theirs.current_position[k] = start[k].p;
            theirs.current_velocity[k] = start[k].v;
            theirs.current_acceleration[k] = start[k].a;
            theirs.target_position[k] = target[k].p;
            theirs.target_velocity[k] = target[k].v;
            theirs.target_acceleration[k] = target[k].a;
            theirs.max_velocity[k] = bounds[k][0];
            theirs.max_acceleration[k] = bounds[k][1];
            theirs.max_jerk[k] = bounds[k][2];
        }
        let official = official_input(&theirs);
        let limits = bounds.map(|[v, a, j]| AxisLimits::symmetric(v, a, j).expect("limits above 0"));
        let mut trajectory = Theirs::new(None);
        let (Ok(_), Ok(ours)) = (
            otg.calculate(&theirs, &mut trajectory),
            Trajectory::new(&start, &target, &limits, &MotionOptions::default()),
        ) else {
            continue;
        };
        // The same problem, or the times mean nothing: starts outside the limits are brought back differently.
        let inside = start.iter().zip(&limits).all(|(s, l)| l.contain(s));
        let gap = (ours.duration() - trajectory.get_duration()).abs();
        assert!(!inside || gap <= 1e-6 * ours.duration(), "{} {}", ours.duration(), trajectory.get_duration());
        all.push(Case { start, target, limits, theirs, official: RefCell::new(official) });
    }
    all
}

/// The same input for the official ruckig.
fn official_input<const N: usize>(theirs: &InputParameter<N>) -> ruckig::InputParameter {
    let mut official = ruckig::InputParameter::new(N);
    let numbers = |x: &rsruckig::prelude::DataArrayOrVec<f64, N>| (0..N).map(|k| x[k]).collect::<Vec<_>>();
    official.current_position = numbers(&theirs.current_position);
    official.current_velocity = numbers(&theirs.current_velocity);
    official.current_acceleration = numbers(&theirs.current_acceleration);
    official.target_position = numbers(&theirs.target_position);
    official.target_velocity = numbers(&theirs.target_velocity);
    official.target_acceleration = numbers(&theirs.target_acceleration);
    official.max_velocity = numbers(&theirs.max_velocity);
    official.max_acceleration = numbers(&theirs.max_acceleration);
    official.max_jerk = numbers(&theirs.max_jerk);
    official
}

/// Least time of each input over some rounds: what the calculation takes, not what else the machine does. Sorted, in ns.
fn least_times<C>(cases: &[C], mut run: impl FnMut(&C)) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; cases.len()];
    for _ in 0..40 {
        for (case, best) in cases.iter().zip(&mut least) {
            let clock = Instant::now();
            run(case);
            *best = best.min(clock.elapsed().as_nanos() as f64);
        }
    }
    // What the clock itself takes.
    let empty = (0..1000).map(|_| Instant::now().elapsed().as_nanos()).min().unwrap_or(0) as f64;
    for t in &mut least {
        *t -= empty;
    }
    least.sort_by(f64::total_cmp);
    least
}

fn report(name: &str, times: &[(&str, Vec<f64>)]) {
    let at = |v: &[f64], share: f64| v[((v.len() - 1) as f64 * share) as usize];
    for (what, share) in [("median", 0.5), ("p99", 0.99), ("worst", 1.0)] {
        let ours = at(&times[0].1, share);
        let columns: Vec<String> = times
            .iter()
            .map(|(library, t)| format!("{library} {:.0} ({:.2})", at(t, share), ours / at(t, share)))
            .collect();
        println!("{name}, {what:6}, ns (ours over theirs): {}", columns.join(" | "));
    }
    println!("{name}: worst over own median {:.2}", at(&times[0].1, 1.0) / at(&times[0].1, 0.5));
}

fn one_axis(c: &mut Criterion) {
    let mut motion = StateToState::default();
    beside_others::<1>(c, "one axis", 1, |case| {
        let case = black_box(case);
        let _ = motion.recompute(&case.start[0], &case.target[0], &case.limits[0]);
        black_box(&motion);
    });
}

fn six_axes(c: &mut Criterion) {
    let options = MotionOptions::new(Synchronisation::Time);
    beside_others::<6>(c, "six axes", 2, |case| {
        let case = black_box(case);
        let _ = black_box(Trajectory::new(&case.start, &case.target, &case.limits, &options));
    });
}

/// One calculation of ours, of the official ruckig and of rsruckig on the same cases.
fn beside_others<const N: usize>(c: &mut Criterion, name: &str, seed: u64, mut ours: impl FnMut(&Case<N>)) {
    let all = cases::<N>(seed, 4096);
    let mut otg = Ruckig::<N, ThrowErrorHandler>::new(None, 0.005);
    let mut trajectory = Theirs::new(None);
    let a = least_times(&all, &mut ours);
    let b = least_times(&all, |case| {
        let _ = black_box(otg.calculate(black_box(&case.theirs), &mut trajectory));
    });
    let mut official = ruckig::Ruckig::new_direct_and_offline(N);
    let mut motion = ruckig::Trajectory::new_direct(N);
    let o = least_times(&all, |case| {
        let _ = black_box(official.calculate(&mut case.official.borrow_mut(), &mut motion));
    });
    report(name, &[("arcfeed", a), ("ruckig", o), ("rsruckig", b)]);
    let mut group = c.benchmark_group(name);
    let mut i = 0;
    group.bench_function("arcfeed", |bench| {
        bench.iter(|| {
            i = (i + 1) & 4095;
            ours(&all[i]);
        });
    });
    group.bench_function("rsruckig", |bench| {
        bench.iter(|| {
            i = (i + 1) & 4095;
            otg.calculate(black_box(&all[i].theirs), &mut trajectory)
        });
    });
    group.finish();
}

fn sampling(c: &mut Criterion) {
    let all = cases::<6>(3, 64);
    let mut group = c.benchmark_group("six axes, one sample, 1 ms apart");
    let motions: Vec<_> = all
        .iter()
        .filter_map(|c| Trajectory::new(&c.start, &c.target, &c.limits, &MotionOptions::default()).ok())
        .collect();
    let mut samplers: Vec<_> = motions.iter().map(Trajectory::sampler).collect();
    let (mut k, mut t) = (0, 0.0);
    group.bench_function("arcfeed", |bench| {
        bench.iter(|| {
            t += 1e-3;
            if t > motions[k].duration() {
                (t, k) = (0.0, (k + 1) & 63);
            }
            samplers[k].at(black_box(t))
        });
    });
    let mut otg = Ruckig::<6, ThrowErrorHandler>::new(None, 0.005);
    let motions: Vec<_> = all
        .iter()
        .map(|c| {
            let mut trajectory = Theirs::new(None);
            let _ = otg.calculate(&c.theirs, &mut trajectory);
            trajectory
        })
        .collect();
    let (mut k, mut t) = (0, 0.0);
    let [mut p, mut v, mut a, mut j] = [0; 4].map(|_| rsruckig::prelude::DataArrayOrVec::<f64, 6>::new(None, 0.0));
    group.bench_function("rsruckig", |bench| {
        bench.iter(|| {
            t += 1e-3;
            if t > motions[k].get_duration() {
                (t, k) = (0.0, (k + 1) & 63);
            }
            motions[k].at_time(
                black_box(t),
                &mut Some(&mut p),
                &mut Some(&mut v),
                &mut Some(&mut a),
                &mut Some(&mut j),
                &mut Some(0),
            );
            black_box((&p, &v, &a, &j));
        });
    });
    group.finish();
}

/// The same target set every cycle, then a step.
fn online_cycle(c: &mut Criterion) {
    let case = &cases::<6>(4, 1)[0];
    let fresh = || {
        let mut g = OnlineGenerator::new(case.start, case.limits, 1e-3, Synchronisation::Time).expect("a valid start");
        g.set_target(case.target).expect("a valid target");
        g
    };
    let mut generator = fresh();
    c.bench_function("six axes, one online cycle with an unchanged target", |bench| {
        bench.iter(|| {
            if !generator.is_underway() {
                generator = fresh();
            }
            let _ = generator.set_target(black_box(case.target));
            generator.step()
        });
    });
}

criterion_group!(benches, one_axis, six_axes, sampling, online_cycle);
criterion_main!(benches);
