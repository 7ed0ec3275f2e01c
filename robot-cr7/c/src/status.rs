//! Status codes, and the text of the last error.

use std::cell::UnsafeCell;
use std::ffi::c_char;
use std::fmt::{Display, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

use arcfeed_feedrate::FeedError;
use arcfeed_sync::SyncError;

/// The result of a call. `arcfeed_last_error` explains every value but `ARCFEED_OK`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArcfeedStatus {
    /// Done.
    ArcfeedOk = 0,
    /// A pointer is NULL or not aligned.
    ArcfeedNull = 1,
    /// An argument breaks a rule: a number is NaN, a limit is negative, a count is wrong, a name is unknown.
    ArcfeedInvalid = 2,
    /// The arguments are valid, but there is no such motion or no such joint values. Nothing has changed.
    ArcfeedRefused = 3,
    /// A file cannot be read, or its content is not what it should be.
    ArcfeedFile = 4,
    /// A defect of the library. The value that was worked on must be freed and not used again.
    ArcfeedInternal = 5,
}

use ArcfeedStatus::{ArcfeedInternal, ArcfeedInvalid, ArcfeedOk, ArcfeedRefused};

/// What a call gives inside the library.
pub type Outcome<T = ()> = Result<T, ArcfeedStatus>;

/// Room for the text of an error, the NUL included.
const TEXT: usize = 512;

/// A text that ends in NUL and is cut where the room ends.
struct Text {
    bytes: [u8; TEXT],
    len: usize,
}

impl Write for Text {
    fn write_str(&mut self, s: &str) -> std::fmt::Result {
        let room = TEXT - 1 - self.len;
        let end = (0..=room.min(s.len())).rev().find(|&end| s.is_char_boundary(end)).unwrap_or(0);
        self.bytes[self.len..self.len + end].copy_from_slice(&s.as_bytes()[..end]);
        self.len += end;
        if end < s.len() { Err(std::fmt::Error) } else { Ok(()) }
    }
}

thread_local! {
    static LAST: UnsafeCell<Text> = const { UnsafeCell::new(Text { bytes: [0; TEXT], len: 0 }) };
}

/// The text of the last error of the calling thread; empty if there was none. It names the argument, its value and the
/// rule. The text belongs to the library and changes with the next error of this thread; calls that succeed leave it.
#[unsafe(no_mangle)]
pub extern "C" fn arcfeed_last_error() -> *const c_char {
    LAST.with(|text| text.get().cast::<c_char>().cast_const())
}

/// Keeps the text of an error and gives its status back.
pub fn refuse(status: ArcfeedStatus, why: impl Display) -> ArcfeedStatus {
    // Aside first: `why` may hold the text of the last error itself, which a caller gave as an argument.
    let mut text = Text { bytes: [0; TEXT], len: 0 };
    // A text that is too long is cut.
    let _ = write!(text, "{why}");
    // SAFETY: only this function writes, on its own thread, and nothing else runs meanwhile.
    LAST.with(|last| unsafe { *last.get() = text });
    status
}

/// Runs a call so that no panic leaves it.
pub fn guarded(call: impl FnOnce() -> Outcome) -> ArcfeedStatus {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => ArcfeedOk,
        Ok(Err(status)) => status,
        Err(payload) => {
            // Its drop could panic again.
            std::mem::forget(payload);
            refuse(ArcfeedInternal, "a defect of the library stopped this call; free the value and report it")
        }
    }
}

/// A refusal of the libraries for several axes.
pub fn of_sync(error: SyncError) -> ArcfeedStatus {
    let status = match &error {
        SyncError::State { source, .. } => of_feed(source),
        SyncError::OutsideRange { .. }
        | SyncError::LeavesRange { .. }
        | SyncError::CannotStop { .. }
        | SyncError::NotStraight { .. }
        | SyncError::LineExceeds { .. }
        | SyncError::WayPoint { .. }
        | SyncError::Blend { .. }
        | SyncError::SectionExceeds { .. }
        | SyncError::LimitsOfRoute
        | SyncError::OutOfRange => ArcfeedRefused,
        _ => ArcfeedInvalid,
    };
    refuse(status, error)
}

/// A limit that cannot be one is invalid; a motion that cannot be is refused.
fn of_feed(error: &FeedError) -> ArcfeedStatus {
    match error {
        FeedError::NotFinite { .. }
        | FeedError::NotPositive { .. }
        | FeedError::Negative { .. }
        | FeedError::NotBelowZero { .. } => ArcfeedInvalid,
        _ => ArcfeedRefused,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    fn last() -> String {
        // SAFETY: the text of this thread ends in NUL.
        unsafe { CStr::from_ptr(arcfeed_last_error()) }.to_str().expect("UTF-8").to_owned()
    }

    #[test]
    fn a_panic_stays_inside() {
        assert_eq!(guarded(|| panic!("a defect")), ArcfeedInternal);
        assert!(last().contains("defect"), "{}", last());
    }

    #[test]
    fn a_long_text_is_cut_between_characters() {
        for begin in 0..3 {
            let text = format!("{}{}", "a".repeat(begin), "\u{20ac}".repeat(TEXT));
            assert_eq!(refuse(ArcfeedInvalid, &text), ArcfeedInvalid);
            let kept = last();
            assert!(text.starts_with(&kept) && kept.len() > TEXT - 5 && kept.len() < TEXT, "{}", kept.len());
        }
        refuse(ArcfeedInvalid, "short");
        assert_eq!(last(), "short");
    }

    #[test]
    fn success_keeps_the_text() {
        refuse(ArcfeedInvalid, "before");
        assert_eq!(guarded(|| Ok(())), ArcfeedOk);
        assert_eq!(last(), "before");
    }
}
