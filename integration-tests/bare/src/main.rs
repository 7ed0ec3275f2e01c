//! A control loop without standard library and heap.
//!
//! It links the C library for its start, for printing and for `memcpy`, and nothing that allocates. It prints the sizes of
//! the states and the stack that each call used: the stack below the caller is painted before and read after.
#![no_std]
#![no_main]

mod cases;
mod routes;
mod stack;

use core::ffi::{c_char, c_int};
use core::fmt::Write;

unsafe extern "C" {
    fn putchar(character: c_int) -> c_int;
    fn abort() -> !;
}

/// Standard output of the C library.
struct Out;

impl Write for Out {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            // SAFETY: any number is a character to print.
            unsafe { putchar(c_int::from(byte)) };
        }
        Ok(())
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    let _ = writeln!(Out, "{info}");
    // SAFETY: ends the program.
    unsafe { abort() }
}

/// Runs the cases: 0 if all end where they should.
#[unsafe(no_mangle)]
pub extern "C" fn main(_count: c_int, _arguments: *const *const c_char) -> c_int {
    match cases::run(&mut Out) {
        Ok(true) => 0,
        _ => 1,
    }
}
