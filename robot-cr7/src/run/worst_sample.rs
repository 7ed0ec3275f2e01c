//! The sample of a motion that comes closest to a limit.

use super::limit_line::{LimitLine, LimitUnit};

/// The worst sample so far. What is not a number stays.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct WorstSample {
    ratio: f64,
    value: f64,
    limit: f64,
    t: f64,
}

impl WorstSample {
    /// A value at the time `t` (s) against its limit.
    pub fn see(&mut self, t: f64, value: f64, limit: f64) {
        self.see_ratio(t, value, limit, value.abs() / limit);
    }

    /// The same where the part of the limit that is used is not the ratio of both.
    pub fn see_ratio(&mut self, t: f64, value: f64, limit: f64, ratio: f64) {
        if (ratio >= self.ratio || ratio.is_nan()) && !self.ratio.is_nan() {
            *self = Self { ratio, value, limit, t };
        }
    }

    /// As a line of a report, of a joint from 1 on or of the tool.
    pub fn line(self, name: &str, joint: Option<usize>, unit: LimitUnit) -> LimitLine {
        let Self { ratio, value, limit, t } = self;
        LimitLine { name: name.to_owned(), joint, unit, value, limit, ratio, at_s_m: None, at_t_s: t, lines: None }
    }
}
