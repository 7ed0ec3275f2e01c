//! The stack that a call uses.

use core::hint::black_box;
use core::ptr;

/// Bytes that are painted.
const PAINTED: usize = 256 * 1024;
/// Bytes directly below the caller that are left alone: the frames of the functions here. They count as used.
const OWN: usize = 512;
/// The paint.
const PAINT: u8 = 0xA7;

/// Bytes of the stack below the caller that `call` used, up to the painted ones.
#[inline(never)]
pub fn used(call: impl FnOnce()) -> usize {
    let mark = 0_u8;
    let top = black_box(&raw const mark).expose_provenance() - OWN;
    paint(top);
    black_box(call)();
    OWN + deepest(top)
}

#[inline(never)]
fn paint(top: usize) {
    for i in 1..=PAINTED {
        // SAFETY: the stack of the thread goes on below this frame, and no value lives there. Volatile, since the compiler
        // sees no reader.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut::<u8>(top - i), PAINT) };
    }
}

/// The distance from `top` to the last byte that is painted no more.
#[inline(never)]
fn deepest(top: usize) -> usize {
    // SAFETY: as in `paint`.
    let is_painted = |i: &usize| unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u8>(top - i)) } == PAINT;
    let below = (1..=PAINTED).rev().take_while(is_painted).count();
    PAINTED - below
}
