//! Sampling allocates nothing, counted by the allocator.
#![allow(unsafe_code)]
mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use arcfeed_feedrate::{MotionLaw, MotionLimits, SProfile, SpeedChange, plan_joined};

struct Counting;
static COUNT: AtomicUsize = AtomicUsize::new(0);

// SAFETY: hands every request to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::SeqCst);
        // SAFETY: the caller's contract is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's contract is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// One test, so that no other thread allocates meanwhile.
#[test]
fn sampling_allocates_nothing() {
    let segments = common::curve_like(300, 1);
    let plan = plan_joined(&segments, 0.0, 0.0).unwrap();
    let limits = MotionLimits::new(0.1, 1.0, 50.0).unwrap();
    let before = COUNT.load(Ordering::SeqCst);
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
    assert_eq!(COUNT.load(Ordering::SeqCst) - before, 0);
}
