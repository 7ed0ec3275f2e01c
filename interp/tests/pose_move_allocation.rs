//! Sampling a motion without a curve of the tool allocates nothing.
#![allow(unsafe_code, reason = "a counting allocator cannot be written without")]

#[path = "common/qb.rs"]
mod qb;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use arcfeed_interp::{JointSpline, Method, MotionPath, Planner, PoseMove};
use arcfeed_kinematics::Joints;

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

fn samples_without_allocating(path: &dyn MotionPath<6>) {
    let arm = qb::arm();
    let planner = Planner::new(&arm, qb::with_torque(&arm)).with_method(Method::InterpolatedReachability);
    let plan = planner.with_intervals(100).expect("a grid").plan(path).expect("a plan");
    let before = COUNT.with(Cell::get);
    let mut sum = 0.0;
    let mut sampler = plan.setpoints(1e-3).expect("a period");
    for setpoint in sampler.by_ref() {
        let setpoint = black_box(setpoint).expect("on the path");
        sum += setpoint.q.sum() + plan.torque(&setpoint).expect("known").sum();
    }
    assert!(sampler.next().is_none());
    assert_eq!(COUNT.with(Cell::get) - before, 0);
    assert!(sum.is_finite());
    // The counter works.
    black_box(Vec::<f64>::with_capacity(10));
    assert!(COUNT.with(Cell::get) > before);
}

#[test]
fn sampling_allocates_nothing() {
    let arm = qb::arm();
    let motion = PoseMove::starting_near(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let (from, to) = (motion.start(), motion.start() + Joints::repeat(0.2));
    samples_without_allocating(&motion);
    samples_without_allocating(&JointSpline::through(&[from, to]).expect("two points"));
}
