//! Counts the allocations of one call, on its own thread alone: other tests and the test harness do not matter.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    /// Allocations since counting began; `None` while nothing is counted.
    static COUNT: Cell<Option<usize>> = const { Cell::new(None) };
}

fn count() {
    // At the end of a thread there may be nothing to count with.
    let _ = COUNT.try_with(|c| c.set(c.get().map(|n| n + 1)));
}

// SAFETY: hands every request to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's contract is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's contract is passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's contract is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How many times this thread allocates in `call`.
pub fn allocations_in(call: impl FnOnce()) -> usize {
    COUNT.with(|c| c.set(Some(0)));
    call();
    COUNT.with(Cell::take).unwrap_or(0)
}
