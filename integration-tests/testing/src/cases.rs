//! Which random cases a test plays.

use std::ops::Range;

/// The seeds of a random test: 0 up to `count`. The variable `ARCFEED_CASES` plays more of them, `100` a hundred times as many, or others,
/// `480..481` the case of seed 480 alone: `ARCFEED_CASES=100 cargo test --release -p arcfeed-interp --test it live_tool`.
///
/// # Panics
///
/// Panics where `ARCFEED_CASES` is neither a whole number above 0 nor a range of seeds.
pub fn cases(count: u64) -> Range<u64> {
    let Ok(text) = std::env::var("ARCFEED_CASES") else { return 0..count };
    asked(&text, count).unwrap_or_else(|| {
        panic!(
            "ARCFEED_CASES is {text:?}: how many times as many cases are played, as 100, or which seeds, as 480..481"
        )
    })
}

fn asked(text: &str, count: u64) -> Option<Range<u64>> {
    if let Some((from, to)) = text.split_once("..") {
        let (from, to) = (from.parse().ok()?, to.parse().ok()?);
        return (from < to).then_some(from..to);
    }
    let times: u64 = text.parse().ok()?;
    (times > 0).then_some(0..count.saturating_mul(times))
}

#[cfg(test)]
mod tests {
    use super::asked;

    #[test]
    fn seeds_are_a_number_of_times_or_a_range() {
        assert_eq!(asked("3", 8), Some(0..24));
        assert_eq!(asked("480..481", 8), Some(480..481));
        assert_eq!(asked("18446744073709551615", 8), Some(0..u64::MAX));
        for wrong in ["", "0", "-1", "x", "5..5", "7..", "..7", "1.5"] {
            assert_eq!(asked(wrong, 8), None, "{wrong}");
        }
    }
}
