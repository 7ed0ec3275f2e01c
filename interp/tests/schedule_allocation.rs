//! Sampling a schedule allocates nothing.
#![allow(unsafe_code, reason = "a counting allocator cannot be written without")]

#[path = "common/qb.rs"]
mod qb;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use arcfeed_interp::{ArmMotion, JointSpline, SchedulePath, Scheduler, SpeedPlanner};
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

fn samples_without_allocating<P: SchedulePath<6>>(path: &P) {
    let arm = qb::arm();
    let scheduler = Scheduler::new(&arm, qb::with_torque()).expect("limits");
    let scheduler = scheduler.with_dynamics(arm.dynamics().expect("known")).with_intervals(100).expect("a grid");
    let schedule = scheduler.plan(path, SpeedPlanner::Certified).expect("a plan");
    let before = COUNT.with(Cell::get);
    let mut sum = 0.0;
    let mut sampler = schedule.sampler(1e-3).expect("a period");
    for setpoint in sampler.by_ref() {
        let setpoint = black_box(setpoint).expect("on the path");
        sum += setpoint.q.sum() + schedule.torque(&setpoint).expect("known").sum();
    }
    assert!(sampler.next().is_none());
    assert_eq!(COUNT.with(Cell::get) - before, 0);
    assert!(sum.is_finite());
    // The counter works.
    black_box(Vec::<f64>::with_capacity(10));
    assert!(COUNT.with(Cell::get) > before);
}

#[test]
fn sampling_a_schedule_allocates_nothing() {
    let arm = qb::arm();
    let motion = ArmMotion::new(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let (from, to) = (motion.start(), motion.start() + Joints::repeat(0.2));
    samples_without_allocating(&motion);
    samples_without_allocating(&JointSpline::through(&[from, to]).expect("two points"));
}
