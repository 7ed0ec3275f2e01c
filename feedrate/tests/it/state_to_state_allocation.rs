//! Neither planning nor sampling a state-to-state motion allocates, counted by the allocator.
#![allow(clippy::unwrap_used)]

use std::hint::black_box;

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_testing::allocations_in;

#[test]
fn planning_and_sampling_allocate_nothing() {
    let limits = AxisLimits::new((-1.0, 2.0), (-8.0, 5.0), (-80.0, 50.0)).unwrap();
    let count = allocations_in(|| {
        let mut sum = 0.0;
        for k in 0..2000 {
            // Starts inside and outside the limits.
            let x = f64::from(k) * 1e-3;
            let start = AxisState::new(x, 3.0 * (9.0 * x).sin(), 9.0 * (7.0 * x).cos());
            let target = AxisState::new(1.0, 0.9 * (5.0 * x).sin(), 0.0);
            if let Ok(motion) = StateToState::new(&start, &target, &limits) {
                sum += motion.at(0.5 * motion.duration()).p + motion.position_range().max;
            }
        }
        black_box(sum);
    });
    assert_eq!(count, 0);
}
