//! Sampling allocates nothing, from the first setpoint on.
#![allow(unsafe_code, reason = "a counting allocator cannot be written without")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use common::{analytic, arm, by_length, down, knotted, line_and_arc, plan_path, tool_down};

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

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: as our caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn sampling_allocates_nothing() {
    use arcfeed_geometry::{OrientationPath, PosePath};
    use nalgebra::{UnitQuaternion, Vector3};

    let arm = arm();
    let slerp = {
        let curve = by_length(analytic());
        let last = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.5) * down();
        let turning = OrientationPath::slerp(curve.length(), down(), last).expect("a length above 0");
        PosePath::new(curve, turning)
    };
    for path in [tool_down(knotted()), slerp, tool_down(line_and_arc(0.05, 0.04))] {
        let plan = plan_path(&arm, path, common::TOOL).expect("in reach");
        // The sampler itself, its first setpoint, all the others, the `None` at the end.
        let before = COUNT.with(Cell::get);
        let mut sampler = plan.sampler(&arm, 1e-3).expect("a valid period");
        let mut sum = 0.0;
        while let Some(setpoint) = sampler.next_setpoint() {
            sum += black_box(setpoint).expect("on the path").q.sum();
        }
        assert!(sampler.next_setpoint().is_none());
        for i in (0..100).rev() {
            sum += black_box(sampler.at(plan.duration() * f64::from(i) / 99.0)).expect("on the path").q.sum();
        }
        assert_eq!(COUNT.with(Cell::get) - before, 0);
        assert!(sum.is_finite());
    }
    // The counter works.
    let before = COUNT.with(Cell::get);
    black_box(Vec::<f64>::with_capacity(10));
    assert!(COUNT.with(Cell::get) > before);
}
