//! An allocator that counts, for tests of code that must not allocate.
#![allow(unsafe_code, reason = "an allocator cannot be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting what each thread asks for: to be named `#[global_allocator]` by a program that wants to know.
#[derive(Debug)]
pub struct Counting;

impl Counting {
    /// How often this thread has asked for memory.
    pub fn count() -> usize {
        COUNT.with(Cell::get)
    }
}

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

/// How often this thread asks for memory during `call`, in a program whose global allocator is [`Counting`].
pub fn allocations_in(call: impl FnOnce()) -> usize {
    let before = Counting::count();
    call();
    Counting::count() - before
}
