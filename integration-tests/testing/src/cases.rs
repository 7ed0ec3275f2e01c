//! How many random cases a test plays.

use std::ops::Range;

/// The seeds of a random test: 0 up to `count`, or up to `count` times what the variable `ARCFEED_CASES` says, so that the same test
/// plays a hundred times as many in a long run: `ARCFEED_CASES=100 cargo test --release`.
///
/// # Panics
///
/// Panics where `ARCFEED_CASES` is set and is not a whole number above 0.
pub fn cases(count: u64) -> Range<u64> {
    0..count
        * std::env::var("ARCFEED_CASES").map_or(1, |text| match text.parse() {
            Ok(times) if times > 0 => times,
            _ => panic!("ARCFEED_CASES is {text:?}: how many times as many cases are played, a whole number above 0"),
        })
}
