//! Sampling a planned motion of the CR7 allocates nothing, from the first setpoint on.
#![allow(unsafe_code, reason = "a counting allocator cannot be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use robot_cr7::{Job, SamplePath, ToolOrientation, plan};

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
fn sampling_a_motion_allocates_nothing() {
    let tangent = ToolOrientation::Tangent { axis: -nalgebra::Vector3::z_axis() };
    for orientation in [Job::default().orientation, tangent] {
        let job = Job { orientation, ..Job::default() };
        let motion = plan(&job, &SamplePath::SixPoint.load().expect("comes with the program")).expect("in reach");
        let before = COUNT.with(Cell::get);
        let mut sampler = motion.sampler().expect("the job's own period");
        let mut count = 0;
        while let Some(setpoint) = sampler.next_setpoint() {
            black_box(setpoint.expect("on the path"));
            count += 1;
        }
        assert_eq!(COUNT.with(Cell::get) - before, 0);
        assert_eq!(count, sampler.samples());
    }
    // The counter works.
    let before = COUNT.with(Cell::get);
    black_box(Vec::<f64>::with_capacity(10));
    assert!(COUNT.with(Cell::get) > before);
}
