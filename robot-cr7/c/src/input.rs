//! Reading of arguments: pointers that are not NULL, numbers that are finite, counts that fit.

use std::ffi::{CStr, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::status::ArcfeedStatus::{ArcfeedInvalid, ArcfeedNull};
use crate::status::{Outcome, refuse};

/// The greatest number of axes or joints.
pub const ARCFEED_MAX_AXES: usize = 8;

/// A value for each axis; those past the number of axes repeat the first one.
pub type All<T> = [T; ARCFEED_MAX_AXES];

fn check<T>(what: impl Display, pointer: *const T) -> Outcome {
    if pointer.is_null() {
        return Err(refuse(ArcfeedNull, format_args!("{what} is NULL; it must point to a value")));
    }
    if !pointer.is_aligned() {
        return Err(refuse(ArcfeedNull, format_args!("{what} is not aligned; it must point to a value of its type")));
    }
    Ok(())
}

/// The value at a pointer.
///
/// # Safety
/// The pointer is NULL, not aligned, or points to a value.
pub unsafe fn read<T: Copy>(what: &str, pointer: *const T) -> Outcome<T> {
    check(what, pointer)?;
    // SAFETY: checked above, and promised by the caller.
    Ok(unsafe { *pointer })
}

/// The values of all axes, converted.
///
/// # Safety
/// The pointer is NULL, not aligned, or points to `count` values.
pub unsafe fn read_all<T: Copy, U: Copy>(
    what: impl Display,
    pointer: *const T,
    count: usize,
    convert: impl Fn(&Item, T) -> Outcome<U>,
) -> Outcome<All<U>> {
    check(&what, pointer)?;
    check_count(count)?;
    // SAFETY: checked above, and promised by the caller.
    let value = |index: usize| convert(&Item { what: &what, index }, unsafe { *pointer.add(index) });
    let mut all = [value(0)?; ARCFEED_MAX_AXES];
    for (index, place) in all.iter_mut().enumerate().take(count).skip(1) {
        *place = value(index)?;
    }
    Ok(all)
}

/// The place to write to.
///
/// # Safety
/// The pointer is NULL, not aligned, or points to a value that nothing else uses during the call.
pub unsafe fn place<'a, T>(what: &str, pointer: *mut T) -> Outcome<&'a mut T> {
    check(what, pointer.cast_const())?;
    // SAFETY: checked above, and promised by the caller.
    Ok(unsafe { &mut *pointer })
}

/// A value of the library that the caller holds.
///
/// # Safety
/// The pointer is NULL, or came from the function that makes such values and has not been freed.
pub unsafe fn held<'a, T>(what: &str, pointer: *const T) -> Outcome<&'a T> {
    check(what, pointer)?;
    // SAFETY: checked above, and promised by the caller.
    Ok(unsafe { &*pointer })
}

/// Writes one value. The memory may hold none yet: no reference to it is made.
///
/// # Safety
/// The pointer is NULL, not aligned, or points to memory that nothing else uses during the call.
pub unsafe fn put<T: Copy>(what: &str, pointer: *mut T, value: T) -> Outcome {
    check(what, pointer.cast_const())?;
    // SAFETY: checked above, and promised by the caller.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Writes the values of all axes.
///
/// # Safety
/// The pointer is NULL, not aligned, or has room for as many values.
pub unsafe fn write_all<T>(what: &str, pointer: *mut T, values: impl Iterator<Item = T>) -> Outcome {
    check(what, pointer.cast_const())?;
    for (k, value) in values.enumerate() {
        // SAFETY: checked above, and promised by the caller.
        unsafe { pointer.add(k).write(value) };
    }
    Ok(())
}

/// Hands a new value to the caller.
///
/// # Safety
/// The pointer is NULL, not aligned, or points to a place for a pointer.
pub unsafe fn hand_out<T>(what: &str, out: *mut *mut T, value: T) -> Outcome {
    let place = unsafe { place(what, out) }?;
    *place = Box::into_raw(Box::new(value));
    Ok(())
}

/// Drops a value that was handed out. NULL is nothing to drop.
///
/// # Safety
/// The pointer is NULL, or came from [`hand_out`] and is not used again.
pub unsafe fn take_back<T>(pointer: *mut T) {
    if !pointer.is_null() {
        // SAFETY: promised by the caller.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(unsafe { Box::from_raw(pointer) })));
    }
}

/// Text that ends in NUL.
///
/// # Safety
/// The pointer is NULL or points to such a text, which stays as it is.
pub unsafe fn text<'a>(what: &str, pointer: *const c_char) -> Outcome<&'a str> {
    check(what, pointer)?;
    // SAFETY: checked above, and promised by the caller.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| refuse(ArcfeedInvalid, format_args!("{what} is not UTF-8")))
}

/// As [`text`], and NULL for none.
///
/// # Safety
/// As [`text`].
pub unsafe fn optional_text<'a>(what: &str, pointer: *const c_char) -> Outcome<Option<&'a str>> {
    if pointer.is_null() { Ok(None) } else { unsafe { text(what, pointer) }.map(Some) }
}

/// An entry of an array, by its name in C.
pub struct Item<'a> {
    what: &'a dyn Display,
    index: usize,
}

impl Display for Item<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}[{}]", self.what, self.index)
    }
}

/// A field of an argument that must be finite.
pub fn finite(of: &impl Display, field: &str, value: f64) -> Outcome<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(refuse(ArcfeedInvalid, format_args!("{of}{field} is {value}; it must be finite")))
}

/// As [`finite`], and not negative.
pub fn not_negative(of: &impl Display, field: &str, value: f64) -> Outcome<f64> {
    if finite(of, field, value)? >= 0.0 {
        return Ok(value);
    }
    Err(refuse(ArcfeedInvalid, format_args!("{of}{field} is {value}; it must not be negative")))
}

/// A number of axes.
pub fn check_count(count: usize) -> Outcome {
    if (1..=ARCFEED_MAX_AXES).contains(&count) {
        return Ok(());
    }
    Err(refuse(ArcfeedInvalid, format_args!("axes is {count}; it must be from 1 to {ARCFEED_MAX_AXES}")))
}

/// The number of axes that a caller gives for a value that has its own.
pub fn same_count(given: usize, own: usize) -> Outcome {
    if given == own {
        return Ok(());
    }
    Err(refuse(ArcfeedInvalid, format_args!("axes is {given}; this one has {own}")))
}

/// Calls the function for the number of axes: `by_count!(count, make(arguments))` is `make::<N>(arguments)`.
macro_rules! by_count {
    ($count:expr, $make:ident ( $($argument:expr),* $(,)? )) => {
        match $count {
            1 => $make::<1>($($argument),*),
            2 => $make::<2>($($argument),*),
            3 => $make::<3>($($argument),*),
            4 => $make::<4>($($argument),*),
            5 => $make::<5>($($argument),*),
            6 => $make::<6>($($argument),*),
            7 => $make::<7>($($argument),*),
            8 => $make::<8>($($argument),*),
            count => Err($crate::input::check_count(count).err().unwrap_or($crate::status::ArcfeedStatus::ArcfeedInternal)),
        }
    };
}
pub(crate) use by_count;
