//! Neither planning nor sampling a state-to-state motion allocates, counted by the allocator.
#![allow(unsafe_code, clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};

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
fn planning_and_sampling_allocate_nothing() {
    let limits = AxisLimits::new((-1.0, 2.0), (-8.0, 5.0), (-80.0, 50.0)).unwrap();
    let before = COUNT.load(Ordering::SeqCst);
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
    assert_eq!(COUNT.load(Ordering::SeqCst) - before, 0);
}
