//! Nothing on the way from joints to poses and back allocates, errors included.
#![allow(unsafe_code, reason = "a counting allocator cannot be written without")]

use arcfeed_kinematics::{
    AnalyticInverse, BranchTracker, ForwardKinematics, InverseKinematics, Joints, MIN_SINGULAR_VALUE, ToolDerivatives,
    Twist, joint_derivatives, models, smallest_singular_value,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: everything is passed on to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: as our caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as our caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn nothing_allocates() {
    let arm = models::cr7();
    let tool = ToolDerivatives { first: Twist::repeat(0.1), second: Twist::repeat(0.2), third: Twist::repeat(0.3) };
    let before = COUNT.with(Cell::get);
    for k in 0..100 {
        let q = Joints::from([0.3, -0.2, 1.4, 0.3, 0.02 * f64::from(k), 0.1]);
        let pose = black_box(arm.forward(&q));
        let jacobian = black_box(arm.jacobian(&q));
        black_box(arm.forward_jacobian(&q));
        black_box(arm.jacobian_dot_qd(&q, &q));
        black_box(arm.jerk_bias(&q, &q, &q));
        black_box(smallest_singular_value(&jacobian));
        let _ = black_box(joint_derivatives(&arm, &q, &tool, MIN_SINGULAR_VALUE));
        assert!(!black_box(arm.inverse_all(&pose)).is_ok_and(|all| all.is_empty()));
        assert!(black_box(arm.inverse(&pose, &q)).is_ok());
        assert!(BranchTracker::new(&arm, q).next(&pose).is_ok());
        let mut far = pose;
        far.translation.x += 5.0;
        assert!(black_box(arm.inverse(&far, &q)).is_err());
    }
    assert_eq!(COUNT.with(Cell::get) - before, 0);
    // The counter works.
    black_box(Vec::<f64>::with_capacity(10));
    assert!(COUNT.with(Cell::get) > before);
}
