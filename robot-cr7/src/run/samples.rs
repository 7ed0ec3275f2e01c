//! The number of samples of a motion, and the most that are written and held.

use thiserror::Error;

use crate::text::number;

/// The most samples that are written to a trajectory: 2.8 h at 1 ms, about 6 GB for six joints.
pub const MOST_SAMPLES: usize = 10_000_000;
/// The most control cycles of a simulation, all of which are held in memory: 33 min at 1 ms, 1 GB for six joints.
pub const MOST_CYCLES: usize = 2_000_000;

/// A motion that has more samples than are written.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "the motion takes {} s, which are {:.1e} samples at sampling.period_ms = {}, and {MOST_SAMPLES} are written at most: {}raise {levers}",
    number(*duration),
    duration / period,
    number(period * 1e3),
    coarser(*duration)
)]
pub struct TooManySamples {
    /// Duration, s.
    pub duration: f64,
    /// Control period, s.
    pub period: f64,
    /// The keys that make the motion faster, in words that follow "raise".
    pub levers: &'static str,
}

/// Longest control period, s.
const LONGEST_PERIOD: f64 = 1.0;

fn coarser(duration: f64) -> String {
    let least = 1.01 * duration / MOST_SAMPLES as f64;
    if least <= LONGEST_PERIOD {
        format!("raise sampling.period_ms to {} or ", number(1e3 * least))
    } else {
        String::new()
    }
}

/// Checks that a motion of `duration` has no more samples at `period` (s) than are written.
///
/// # Errors
/// [`TooManySamples`], with `levers` as the way out.
pub fn few_enough(duration: f64, period: f64, levers: &'static str) -> Result<(), TooManySamples> {
    if duration / period < MOST_SAMPLES as f64 {
        return Ok(());
    }
    Err(TooManySamples { duration, period, levers })
}

/// Times of the samples of a motion: one a control period, and one exactly at the end; a motion that takes no time has one.
///
/// The motion has to be one that [`few_enough`] lets pass.
pub fn sample_times(duration: f64, period: f64) -> impl ExactSizeIterator<Item = f64> {
    let cycles = if duration > 0.0 { (duration / period * (1.0 - 1e-12)).floor() as usize + 1 } else { 0 };
    (0..cycles + 1).map(move |i| if i == cycles { duration } else { i as f64 * period })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_is_sampled_once_and_exactly() {
        for (duration, period) in [(0.0, 1e-3), (1e-3, 1e-3), (0.3, 0.1), (1.0004, 1e-3), (0.1 * 7.0, 0.1)] {
            let times: Vec<f64> = sample_times(duration, period).collect();
            assert_eq!((times[0], times[times.len() - 1]), (0.0, duration));
            assert!(duration > 0.0 || times.len() == 1);
            let steps = times.windows(2).map(|w| w[1] - w[0]);
            assert!(steps.clone().all(|dt| dt <= period * (1.0 + 1e-9)), "{duration} {period}");
            assert!(duration == 0.0 || steps.clone().all(|dt| dt > 1e-9 * period), "{duration} {period}");
        }
    }

    #[test]
    fn a_motion_with_too_many_samples_names_the_keys_and_the_bound() {
        assert!(few_enough(9_999.0, 1e-3, "").is_ok());
        let text = few_enough(2e4, 1e-3, "the limits in [joints]").expect_err("too many").to_string();
        for part in ["20000 s", "2.0e7 samples", "sampling.period_ms = 1,", "10000000", "to 2.02 or raise the limits"] {
            assert!(text.contains(part), "\"{part}\" is missing in: {text}");
        }
        for duration in [1e10, f64::INFINITY, f64::NAN] {
            let text = few_enough(duration, 1e-3, "feed").expect_err("too many").to_string();
            assert!(text.ends_with("at most: raise feed"), "{text}");
        }
    }
}
