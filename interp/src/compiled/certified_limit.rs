//! One limit of a motion, and what the motion certainly does not exceed.

use std::fmt;

use arcfeed_feedrate::LimitId;

use super::certificate::CertifiedBound;
use crate::limits::TableKind;

/// A limit, the largest value found in a motion, and the value that the motion does not exceed at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CertifiedLimit {
    /// Which limit.
    pub id: LimitId,
    /// The table that states it; `None` for a constant limit.
    pub table: Option<TableKind>,
    /// The size of the largest value found, SI; with a table the largest ratio of the value to its limit.
    pub attained: f64,
    /// The time at which it is attained, s.
    pub t: f64,
    /// The size that is not exceeded at any time, SI; with a table the ratio.
    pub bound: f64,
    /// The limit, SI; with a table 1. A position is measured from the middle of the range of its joint, against half of it.
    pub limit: f64,
}

impl From<CertifiedBound> for CertifiedLimit {
    fn from(of: CertifiedBound) -> Self {
        let CertifiedBound { id, attained, t, bound, limit } = of;
        Self { id, table: None, attained: attained.abs(), t, bound, limit }
    }
}

impl CertifiedLimit {
    /// What is not exceeded, divided by the limit.
    pub fn ratio(&self) -> f64 {
        self.bound / self.limit
    }

    /// True where the limit is kept but for `tolerance`, relative; false for a NaN.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.ratio() <= 1.0 + tolerance
    }
}

impl fmt::Display for CertifiedLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = 100.0 * self.ratio();
        match self.table {
            Some(_) => {
                write!(f, "{} may reach {part:.5} % of the limit of its table near t = {:.6} s", self.id, self.t)
            }
            None => write!(
                f,
                "{} may reach {:.6e} near t = {:.6} s, {part:.5} % of its limit {:.6e}",
                self.id, self.bound, self.t, self.limit
            ),
        }
    }
}
