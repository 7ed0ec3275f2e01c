//! What a cycle of the online scheduler costs, with unchanged limits and with a speed limit that changes in every cycle.
//!
//! Measured on a 2-core AMD EPYC VM with other work on it: medians 19 ns and 490 ns.
#![allow(missing_docs, clippy::unwrap_used)]
use std::hint::black_box;

use arcfeed_feedrate::{AxisLimits, AxisState, FeedScheduler, FeedStatus};
use criterion::{Criterion, criterion_group, criterion_main};

fn cycle(c: &mut Criterion) {
    let limits = AxisLimits::forward(0.2, (-2.0, 1.0), (-50.0, 40.0)).unwrap();
    let begin = FeedScheduler::new(&AxisState::rest(0.0), &AxisState::new(1.0, 0.05, 0.0), &limits).unwrap();
    let mut feed = begin;
    c.bench_function("online cycle, same limits", |b| {
        b.iter(|| {
            feed.set_limits(black_box(&limits)).unwrap();
            let step = feed.step(black_box(1e-3)).unwrap();
            if let FeedStatus::Reached { .. } = step.status {
                feed = begin;
            }
            step
        });
    });
    let (mut feed, mut k) = (begin, 0);
    c.bench_function("online cycle, speed limit changed", |b| {
        b.iter(|| {
            k += 1;
            let v = 0.15 + 0.05 * f64::from(k % 100) / 100.0;
            feed.set_limits(&limits.with_v_max(black_box(v)).unwrap()).unwrap();
            let step = feed.step(black_box(1e-3)).unwrap();
            if let FeedStatus::Reached { .. } = step.status {
                feed = begin;
            }
            step
        });
    });
}

criterion_group!(benches, cycle);
criterion_main!(benches);
