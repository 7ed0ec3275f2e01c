//! Sampling allocates nothing, counted by the allocator.
use crate::common;

use std::hint::black_box;

use arcfeed_feedrate::{AxisLimits, MotionLaw, SProfile, SpeedChange, plan_continuous};
use arcfeed_testing::allocations_in;

#[test]
fn sampling_allocates_nothing() {
    let segments = common::curve_like(300, 1);
    let plan = plan_continuous(&segments, 0.0, 0.0).unwrap();
    let limits = AxisLimits::symmetric(0.1, 1.0, 50.0).unwrap();
    let count = allocations_in(|| {
        let mut cursor = plan.cursor();
        let mut sum = 0.0;
        for k in 0..20_000 {
            let t = plan.duration() * f64::from(k) / 19_999.0;
            assert!(cursor.at(t) == plan.at(t));
            sum += plan.v_at_s(plan.end().p * f64::from(k) / 19_999.0);
        }
        let profile = SProfile::new(0.05, 0.0, 0.02, &limits);
        let brake = SpeedChange::brake(0.05, 0.3, &limits);
        if let (Ok(profile), Ok(brake)) = (&profile, &brake) {
            sum += profile.at(0.1).v + brake.at(0.1).v;
        }
        black_box(sum);
    });
    assert_eq!(count, 0);
}
