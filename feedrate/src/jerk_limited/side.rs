//! One side of a row in the iterations.

/// One side of a row: a multiplier, its change, and the inverse of the slack (0 for a bound at
/// infinity).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Side {
    pub multiplier: f64,
    /// While a direction is sought, the predictor's second-order term in units of the multiplier;
    /// then the change to take.
    pub change: f64,
    pub inverse: f64,
}

impl Side {
    pub fn weight(&self) -> f64 {
        self.multiplier * self.inverse
    }

    /// The barrier's force at `mu`: `mu / slack`, a part of the second-order term, and what narrowing the
    /// bound adds.
    pub fn force(&self, mu: f64, part: f64, wider: f64) -> f64 {
        mu * self.inverse + self.multiplier * (part * self.change + self.inverse * wider)
    }
}

/// The lesser of two numbers, neither of which is NaN: cheaper than `f64::min`.
pub(super) fn lesser(x: f64, y: f64) -> f64 {
    if x < y { x } else { y }
}
