//! Neither a cycle nor a change of limits allocates, counted by the allocator.
#![allow(unsafe_code, clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use arcfeed_feedrate::{AxisState, FeedLimits, FeedScheduler};

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
fn stepping_and_changing_limits_allocate_nothing() {
    let limits = FeedLimits::new(0.2, (-2.0, 1.0), (-50.0, 40.0)).unwrap();
    let before = COUNT.load(Ordering::SeqCst);
    let mut feed = FeedScheduler::new(&AxisState::rest(0.0), &AxisState::new(1.0, 0.05, 0.0), &limits).unwrap();
    for k in 0..20_000 {
        let v = 0.1 + 0.1 * (1e-3 * f64::from(k)).sin();
        black_box(feed.set_limits(&limits.with_v_max(if k % 2000 < 200 { 0.0 } else { v }).unwrap())).unwrap();
        black_box(feed.step(1e-3)).unwrap();
    }
    assert_eq!(feed.state().p, 1.0);
    assert!(feed.set_end(&AxisState::rest(0.5)).is_err());
    assert_eq!(COUNT.load(Ordering::SeqCst) - before, 0);
}
