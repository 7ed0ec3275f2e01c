//! When the iterations end, and what they come to.

/// A motion is mostly changes of speed if it takes longer than that without limits on jerk by one in so many parts.
const MOSTLY: f64 = 5.0;

/// A law that may be so many times what was aimed at from its optimum has not converged.
const CONVERGED_WITHIN: f64 = 100.0;

/// The outcome of the iterations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outcome {
    pub iterations: usize,
    /// Possible gain, relative to the duration: by the multipliers, and by what the last step would
    /// have gained in full.
    pub gap: f64,
    pub ahead: f64,
    /// Relative widening of the bounds; 0 when all are kept.
    pub wider: f64,
    /// The gap that was aimed at in the end.
    pub tolerance: f64,
}

/// When the iterations end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    /// Possible gain, relative to the duration, of a motion most of which is spent on changes of speed.
    pub tolerance: f64,
    /// A duration that is not reached: that without limits on jerk.
    pub shortest: f64,
    /// Relative gap that the multipliers start with.
    pub start_gap: f64,
    /// Relative gap below which rows far from their bounds are dropped.
    pub drop_below: f64,
}

impl Goal {
    /// On a motion that mostly cruises the same part of what there is to gain is less.
    pub fn at(self, duration: f64) -> f64 {
        let part = MOSTLY * (1.0 - self.shortest / duration);
        self.tolerance * if part < 1.0 { part.max(1e-4) } else { 1.0 }
    }
}

impl Outcome {
    /// Returns true if the solution is close to the optimum.
    pub fn is_close(&self) -> bool {
        self.gap.max(self.ahead) < CONVERGED_WITHIN * self.tolerance
    }
}
