//! What a motion between poses costs, from two poses to a law without its verification: the composite motion of Table 3 of Electronics 2025, 14,
//! 3869 under velocity, acceleration and torque limits (the paper: 5.63 ms, grid not stated).
//!
//! Medians on an idle 2-core AMD EPYC VM:
//!
//! | N | both ends | reachability | certified |
//! |---|---|---|---|
//! | 100 | 0.29 ms | 0.44 ms | 0.89 ms |
//! | 200 | 0.56 ms | 0.85 ms | 1.8 ms |
//! | 500 | 1.4 ms | 2.2 ms | 4.3 ms |
//! | 1000 | 2.7 ms | 4.0 ms | 9.4 ms |
//!
//! Of the 2.5 us a point both ends takes, the inverse kinematics has 1.0, path derivatives 0.5, torque terms 0.5, rows and scan
//! the rest. Jerk-limited at N = 1000: 33 ms.
#![allow(missing_docs)]
use std::hint::black_box;

use arcfeed_feedrate::FeedPlanner;
use arcfeed_interp::{Limits, Method, Planner, PoseMove};
use arcfeed_kinematics::Joints;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

#[path = "../tests/it/common/qb.rs"]
mod qb;

/// The duration of the law by `method`, from the path on.
fn law(planner: &Planner<'_>, path: &PoseMove<'_>, method: Method) -> f64 {
    let problem = planner.prepare(path, method.needs()).expect("in reach");
    let rows = problem.rows(method.needs()).expect("finite");
    method.plan(&rows).expect("a plan").duration()
}

fn to(c: &mut Criterion) {
    let arm = qb::arm();
    let near = Joints::from(qb::TO_NEAR);
    let limits = qb::with_torque(&arm);
    let (from, to) = (*qb::to().start(), *qb::to().goal());
    let mut group = c.benchmark_group("TO");
    for intervals in [100, 200, 500, 1000] {
        for method in [Method::ForwardBackward, Method::Reachability, Method::InterpolatedReachability] {
            group.bench_function(BenchmarkId::new(method.name(), intervals), |b| {
                b.iter(|| {
                    let motion =
                        arcfeed_geometry::PoseMotion::new(black_box(&from), black_box(&to)).expect("two poses");
                    let path = PoseMove::starting_near(&arm, motion, &near).expect("in reach");
                    let planner = Planner::new(&arm, limits).with_intervals(intervals).expect("a grid");
                    law(&planner, &path, method)
                });
            });
        }
    }
    group.finish();
}

/// The jerk-limited planner on the same motion.
fn to_with_jerk(c: &mut Criterion) {
    let arm = qb::arm();
    let path = PoseMove::starting_near(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let limits = Limits::new(qb::joints(&arm, 40.0));
    let limits = limits.with_torque(arm.dynamics().expect("known"), Joints::from(qb::TORQUE)).expect("limits");
    let planner = Planner::new(&arm, limits).with_intervals(1000).expect("a grid");
    c.bench_function("TO/jerk-limited/1000", |b| b.iter(|| law(&planner, &path, Method::JerkLimited)));
}

criterion_group!(benches, to, to_with_jerk);
criterion_main!(benches);
