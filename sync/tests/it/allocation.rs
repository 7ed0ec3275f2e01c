//! Neither planning, sampling nor generating cycle by cycle allocates, counted by the allocator.
#![allow(clippy::unwrap_used)]

use std::hint::black_box;

use arcfeed_sync::feedrate::{AxisLimits, AxisProblem, AxisState};
use arcfeed_sync::{MotionOptions, OnlineGenerator, Synchronisation, Trajectory};
use arcfeed_testing::allocations_in;

#[test]
fn nothing_allocates() {
    let limits = [AxisLimits::new((-1.0, 2.0), (-8.0, 5.0), (-80.0, 50.0)).unwrap(); 6];
    let count = allocations_in(|| {
        let mut generator = OnlineGenerator::new([AxisState::rest(0.0); 6], limits, 1e-3, Synchronisation::Time)
            .and_then(|g| g.with_ranges([(-5.0, 5.0); 6]))
            .unwrap();
        let mut sum = 0.0;
        for n in 0..2000 {
            let x = f64::from(n) * 1e-3;
            let state = |k: usize, size: f64| {
                let phase = 5.0 * x + k as f64;
                AxisState::new(phase.sin(), size * phase.cos(), 0.5 * size * phase.sin())
            };
            // Starts inside and outside the limits.
            let start = std::array::from_fn(|k| state(k, 2.5));
            let target = std::array::from_fn(|k| state(k + 6, 0.9));
            for mode in [Synchronisation::None, Synchronisation::Time, Synchronisation::StraightLine] {
                let options = MotionOptions::new(mode).with_cycle(1e-3).unwrap();
                if let Ok(motion) = Trajectory::new(&start, &target, &limits, &options) {
                    let mut sampler = motion.sampler();
                    sum += sampler.at(0.3).q[0] + sampler.at(0.6).q[5];
                }
            }
            let problem = AxisProblem::new(&start[0], &target[0], &limits[0]).unwrap();
            sum += problem.durations().shortest() + f64::from(u8::from(problem.with_duration(0.7).is_ok()));
            if n % 10 == 0 {
                sum += f64::from(u8::from(generator.set_target(target).is_ok()));
            }
            sum += generator.step().state.q[0];
        }
        black_box(sum);
    });
    assert_eq!(count, 0);
}

#[test]
fn the_counter_counts_its_own_thread_only() {
    let other = std::thread::spawn(|| (0..10_000).map(|k| vec![k; 8].len()).sum::<usize>());
    assert_eq!(allocations_in(|| ()), 0);
    assert_eq!(allocations_in(|| drop(black_box(Box::new(1)))), 1);
    assert!(other.join().is_ok());
}
