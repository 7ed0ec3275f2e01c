//! Neither a cycle nor a change of limits allocates, counted by the allocator.
#![allow(clippy::unwrap_used)]

use std::hint::black_box;

use arcfeed_feedrate::{AxisLimits, AxisState, FeedScheduler};
use arcfeed_testing::allocations_in;

#[test]
fn stepping_and_changing_limits_allocate_nothing() {
    let limits = AxisLimits::forward(0.2, (-2.0, 1.0), (-50.0, 40.0)).unwrap();
    let count = allocations_in(|| {
        let mut feed = FeedScheduler::new(&AxisState::rest(0.0), &AxisState::new(1.0, 0.05, 0.0), &limits).unwrap();
        for k in 0..20_000 {
            let v = 0.1 + 0.1 * (1e-3 * f64::from(k)).sin();
            black_box(feed.set_limits(&limits.with_v_max(if k % 2000 < 200 { 0.0 } else { v }).unwrap())).unwrap();
            black_box(feed.step(1e-3)).unwrap();
        }
        assert_eq!(feed.state().p, 1.0);
        assert!(feed.set_end(&AxisState::rest(0.5)).is_err());
    });
    assert_eq!(count, 0);
}
