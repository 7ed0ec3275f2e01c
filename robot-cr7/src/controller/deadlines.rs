//! How late setpoints are sent.

use std::fmt::{self, Display, Formatter};

/// Upper ends of the classes of lateness, s; the last class has none.
const CLASSES: [f64; 3] = [1e-4, 1e-3, 5e-3];

/// Statistics of the times at which setpoints were sent, against those at which they were due. Times in s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deadlines {
    /// Number of setpoints.
    pub count: usize,
    /// Largest lateness.
    pub worst: f64,
    /// Setpoints by lateness: up to 0.1 ms, up to 1 ms, up to 5 ms, and more.
    pub classes: [usize; 4],
    sum: f64,
}

impl Deadlines {
    pub(super) fn see(&mut self, late: f64) {
        self.count += 1;
        self.worst = self.worst.max(late);
        self.sum += late;
        self.classes[CLASSES.iter().filter(|end| late > **end).count()] += 1;
    }

    /// Mean lateness.
    pub fn mean(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sum / self.count as f64 }
    }
}

impl Display for Deadlines {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [best, good, fair, bad] = self.classes;
        write!(
            f,
            "late by {:.2} ms in the mean, {:.2} at most; {best} up to 0.1 ms, {good} up to 1, {fair} up to 5, {bad} more",
            1e3 * self.mean(),
            1e3 * self.worst
        )
    }
}
