//! The stack that a call uses.

use core::hint::black_box;
use core::ptr;

/// Bytes that are painted for the calls of a cycle.
const PAINTED: usize = 256 * 1024;
/// Bytes that are painted for calls that plan much at once.
const DEEP: usize = 2 * 1024 * 1024;
/// Bytes directly below the caller that are left alone: the frames of the functions here. They count as used.
const OWN: usize = 512;
/// The paint.
const PAINT: u8 = 0xA7;

/// Bytes of the stack below the caller that `call` used, up to the painted ones.
pub fn used(call: impl FnOnce()) -> usize {
    used_of(PAINTED, call)
}

/// As [`used`], for a call that takes much stack.
pub fn used_deep(call: impl FnOnce()) -> usize {
    used_of(DEEP, call)
}

#[inline(never)]
fn used_of(painted: usize, call: impl FnOnce()) -> usize {
    let mark = 0_u8;
    let top = black_box(&raw const mark).expose_provenance() - OWN;
    paint(top, painted);
    black_box(call)();
    OWN + deepest(top, painted)
}

#[inline(never)]
fn paint(top: usize, painted: usize) {
    for i in 1..=painted {
        // SAFETY: the stack of the thread goes on below this frame, and no value lives there. Volatile, since the compiler
        // sees no reader.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut::<u8>(top - i), PAINT) };
    }
}

/// The distance from `top` to the last byte that is painted no more.
#[inline(never)]
fn deepest(top: usize, painted: usize) -> usize {
    // SAFETY: as in `paint`.
    let is_painted = |i: &usize| unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u8>(top - i)) } == PAINT;
    let below = (1..=painted).rev().take_while(is_painted).count();
    painted - below
}
