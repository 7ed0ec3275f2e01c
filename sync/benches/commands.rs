//! What a cycle of the online generator costs while time is scaled, and what a stop costs, for six axes.
//!
//! Measured on a 2-core AMD EPYC VM with other work on it, medians: 0.27 us a cycle at scale 1, 2.6 us in the mean while the scale
//! changes every 100 cycles, 5.1 us for a stop, the copy of the generator included.
#![allow(missing_docs, clippy::unwrap_used)]
use std::hint::black_box;

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{OnlineGenerator, Synchronisation};
use criterion::{Criterion, criterion_group, criterion_main};

/// On the way from rest to rest, in the middle of different phases of the axes.
fn under_way() -> OnlineGenerator<6> {
    let limits = std::array::from_fn(|k| AxisLimits::symmetric(1.0 + 0.2 * k as f64, 5.0, 80.0).unwrap());
    let mut g = OnlineGenerator::new([AxisState::rest(0.0); 6], limits, 1e-3, Synchronisation::Time).unwrap();
    g.set_target([1.0, -0.8, 0.6, -0.4, 0.3, 0.1].map(AxisState::rest)).unwrap();
    for _ in 0..120 {
        g.step();
    }
    g
}

fn plain(c: &mut Criterion) {
    let begin = under_way();
    let mut g = begin.clone();
    c.bench_function("six axes, one cycle at scale 1", |b| {
        b.iter(|| {
            if !g.is_underway() {
                g = begin.clone();
            }
            black_box(g.step())
        });
    });
}

fn commands(c: &mut Criterion) {
    let begin = under_way();
    let (mut g, mut n) = (begin.clone(), 0);
    c.bench_function("six axes, one cycle while the scale changes every 100 cycles", |b| {
        b.iter(|| {
            n += 1;
            if !g.is_underway() {
                g = begin.clone();
            }
            if n % 100 == 0 {
                g.set_scale(if n % 200 == 0 { 0.3 } else { 1.0 }).unwrap();
            }
            black_box(g.step())
        });
    });
    c.bench_function("six axes, a stop", |b| {
        b.iter(|| {
            let mut g = begin.clone();
            g.stop().unwrap();
            black_box(g.step())
        });
    });
}

criterion_group!(benches, plain, commands);
criterion_main!(benches);
