//! An allocator that counts, for tests of code that must not allocate.
#![allow(unsafe_code, reason = "an allocator cannot be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
    /// Bytes held, and the most of them so far. What another thread gives back counts there.
    static HELD: Cell<[isize; 2]> = const { Cell::new([0; 2]) };
}

/// Notes a change of the bytes held.
fn hold(bytes: isize) {
    HELD.with(|held| {
        let [now, most] = held.get();
        held.set([now + bytes, most.max(now + bytes)]);
    });
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
        hold(layout.size().cast_signed());
        // SAFETY: as our caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        hold(-layout.size().cast_signed());
        // SAFETY: as our caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // Old and new memory may exist at the same time.
        hold(size.cast_signed());
        hold(-layout.size().cast_signed());
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

/// The most bytes that this thread holds during `call` beyond those it held before, in a program whose global allocator is [`Counting`].
pub fn most_bytes_in(call: impl FnOnce()) -> usize {
    let before = HELD.with(|held| {
        let [now, _] = held.get();
        held.set([now; 2]);
        now
    });
    call();
    let [_, most] = HELD.with(Cell::get);
    usize::try_from(most - before).unwrap_or(0)
}
