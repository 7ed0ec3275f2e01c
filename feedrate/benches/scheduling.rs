//! What speed planning along a path costs: six joints, velocity and acceleration (and jerk), rows included.
//!
//! N intervals of the spline through 20 way-points, medians on an idle 2-core AMD EPYC VM (the last line: single runs on a loaded one):
//!
//! | N | both ends | reachability | certified | jerk-limited |
//! |---|---|---|---|---|
//! | 100 | 11.4 us | 19.2 us | 0.16 ms | 1.5 ms |
//! | 1000 | 111 us | 174 us | 1.5 ms | 19.8 ms |
//! | 10 000 | 1.08 ms | 1.50 ms | 19 ms | 0.21 s |
//! | 100 000 | 34 ms | 37 ms | 0.18 s | 2.4 s |
//! | 1 000 000 | 1.2 s | 1.3 s | 6.5 s | refused |
//!
//! Per interval the work of rows and scans is constant; what makes 100 000 intervals dearer is memory, 39 MB of rows that the system hands
//! out page by page. The jerk-limited planner needs 13 iterations for 10 000 intervals and 16 for 100 000 here, after plans on every eighth point.
#![allow(missing_docs)]
use std::hint::black_box;

use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity};
use arcfeed_feedrate::{
    FeedPlanner, FeedProblem, ForwardBackwardScan, InterpolatedReachability, JerkLimited, Reachability,
};
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};

#[path = "../tests/it/common/spline_paths.rs"]
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
        ("both ends", Rows::Points, &ForwardBackwardScan),
        ("reachability", Rows::Points, &Reachability),
        ("certified", Rows::Between, &InterpolatedReachability),
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
