//! Neither a cycle nor a new target allocates, counted by the allocator.
#![allow(unsafe_code, clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use arcfeed_sync::nalgebra::{Isometry3, Vector3};
use arcfeed_sync::{AxisLimits, JointState, PoseLimits, PoseProjectionSync, PoseState, ProjectionSync};

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
fn stepping_and_retargeting_allocate_nothing() {
    let limits = AxisLimits::new(Vector3::repeat(2.0), Vector3::repeat(10.0), Vector3::repeat(200.0)).unwrap();
    let tool = PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0]).unwrap();
    let mut fast = JointState::rest(Vector3::zeros());
    fast.qd.x = 3.0;
    let before = COUNT.load(Ordering::SeqCst);
    let mut joints = ProjectionSync::new(&fast, Vector3::repeat(1.0), &limits).unwrap();
    let mut pose =
        PoseProjectionSync::new(&PoseState::rest(Isometry3::identity()), Isometry3::identity(), &tool).unwrap();
    for k in 0..2000 {
        if k % 7 == 0 {
            let x = (f64::from(k) * 0.01).sin();
            joints.set_target(Vector3::new(x, 1.0, -x)).unwrap();
            pose.set_target(Isometry3::new(Vector3::new(x, 0.1, 0.0), Vector3::new(0.0, x, 1.0))).unwrap();
        }
        black_box(joints.step(1e-3)).unwrap();
        black_box(pose.step(1e-3)).unwrap();
    }
    assert_eq!(COUNT.load(Ordering::SeqCst) - before, 0);
}
