//! What speed planning along a path costs: six joints, velocity and acceleration (and jerk), rows included.
//!
//! Medians on a 2-core AMD EPYC VM that other work loaded twice over (factor 1.5 to 2.5 above an idle core), N intervals of
//! the spline through 20 way-points:
//!
//! | N | rows alone | both ends | reachability | certified | jerk-limited |
//! |---|---|---|---|---|---|
//! | 100 | 9.1 us | 28 us | 47 us | 0.12 ms | 4.6 ms |
//! | 500 | 41 us | 98 us | 0.23 ms | 0.54 ms | 13 ms |
//! | 1000 | 60 us | 0.18 ms | 0.33 ms | 0.86 ms | 22 ms |
//! | 10 000 | 0.61 ms | 1.9 ms | 3.3 ms | 14 ms | 0.50 s |
//! | 100 000 | 29 ms | 41 ms | 59 ms | 0.14 s | |
//!
//! The jerk-limited planner takes more iterations on 10 000 intervals than on 1000. Best of 3000 runs at N = 1000, later and under the
//! same load: both ends 111 us, reachability 289 us, certified 1.8 ms (then of second order), jerk-limited 19 ms.
#![allow(missing_docs)]
use std::hint::black_box;

use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity};
use arcfeed_feedrate::{BothEndsScan, CertifiedReachability, FeedPlanner, FeedProblem, JerkLimited, Reachability};
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};

#[path = "../tests/common/spline_paths.rs"]
mod spline_paths;
use spline_paths::{A_MAX, JOINTS, Samples, Spline, V_A, paths};

/// Rows at the points, and those between them with or without jerk.
#[derive(Clone, Copy, PartialEq)]
enum Rows {
    Points,
    Between,
    Jerk,
}

fn problem(grid: &[f64], samples: &Samples, jerk: &[f64; JOINTS], rows: Rows) -> FeedProblem {
    let path = samples.path();
    let velocity = JointVelocity::new(path, &V_A).expect("valid limits");
    let acceleration = JointAcceleration::new(path, &A_MAX).expect("valid limits");
    let jerk = JointJerk::new(path, jerk).expect("valid limits");
    match rows {
        Rows::Points => FeedProblem::at_points(grid, &[&velocity, &acceleration]),
        Rows::Between => FeedProblem::between_points(grid, &[&velocity, &acceleration]),
        Rows::Jerk => FeedProblem::between_points(grid, &[&velocity, &acceleration, &jerk]),
    }
    .expect("a valid grid")
}

/// Rows and plan together.
fn plan(planner: &dyn FeedPlanner, grid: &[f64], samples: &Samples, rows: Rows) -> f64 {
    let jerk = A_MAX.map(|a| 10.0 * a);
    planner.plan(&problem(grid, samples, &jerk, rows)).expect("a feasible problem").duration()
}

fn planners(c: &mut Criterion) {
    let path = &paths()[0].spline;
    let jerk = A_MAX.map(|a| 10.0 * a);
    let jerk_limited = JerkLimited::default();
    let all: [(&str, Rows, &dyn FeedPlanner); 4] = [
        ("both ends", Rows::Points, &BothEndsScan),
        ("reachability", Rows::Points, &Reachability),
        ("certified", Rows::Between, &CertifiedReachability),
        ("jerk-limited", Rows::Jerk, &jerk_limited),
    ];
    for n in [100, 500, 1000] {
        let grid = Spline::uniform(n);
        let samples = path.samples(&grid);
        c.bench_function(&format!("rows/{n}"), |b| {
            b.iter(|| problem(black_box(&grid), &samples, &jerk, Rows::Points));
        });
        for (name, rows, planner) in all {
            let mut group = c.benchmark_group(name);
            group.sample_size(if rows == Rows::Jerk { 10 } else { 60 });
            group.bench_function(n.to_string(), |b| b.iter(|| plan(planner, black_box(&grid), &samples, rows)));
            group.finish();
        }
    }
    // Cost by the number of intervals.
    let mut group = c.benchmark_group("growth");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    for n in [100, 1000, 10_000, 100_000] {
        let grid = Spline::uniform(n);
        let samples = path.samples(&grid);
        group.throughput(Throughput::Elements(n as u64));
        for (name, rows, planner) in all {
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| plan(planner, black_box(&grid), &samples, rows));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, planners);
criterion_main!(benches);
