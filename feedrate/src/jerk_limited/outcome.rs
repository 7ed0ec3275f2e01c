//! When the iterations end, and what they come to.

/// A motion is mostly changes of speed if it takes longer than that without limits on jerk by one in so many parts.
const MOSTLY: f64 = 5.0;

/// No tolerance is below this: rounding would never let the iterations end.
const FINEST: f64 = 1e-11;

/// A law that may be so many times what was aimed at from its optimum has not converged.
const CONVERGED_WITHIN: f64 = 100.0;

/// Gain of the last step at which the iterations end, in units of the tolerance: the next one gains
/// a small part of that.
const LAST_STEP_GAIN: f64 = 10.0;

/// The part of the tolerance that bounds may still be wider by at the end where they were widened for margins between the knots.
const LEFT_WIDER: f64 = 0.02;

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
    /// The part of it that bounds may be wider by then.
    part_wider: f64,
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
    /// Times that dropped rows and jerk between the knots are looked at when the iterations have converged.
    pub polishes: usize,
}

impl Goal {
    /// On a motion that mostly cruises the same part of what there is to gain is less.
    pub fn at(self, duration: f64) -> f64 {
        let part = MOSTLY * (1.0 - self.shortest / duration);
        (self.tolerance * if part < 1.0 { part.max(1e-4) } else { 1.0 }).max(FINEST)
    }
}

/// What became of an iterate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Polished {
    /// It exceeds nothing.
    Kept,
    /// It is a little slower, inside all bounds.
    Slower,
    /// It is so much slower that the multipliers do not suit any more.
    FarSlower,
    /// It cannot be slowed down, for its speed is given at an end; bounds on jerk are wider until it keeps the new margins.
    Wider,
    /// It cannot be slowed down enough to be inside.
    Lost,
}

impl Outcome {
    /// Before the iterations, with bounds that are wider by some part.
    pub fn at_start(wider: f64, goal: Goal) -> Self {
        let infinite = f64::INFINITY;
        Self { iterations: 0, gap: infinite, ahead: infinite, wider, tolerance: goal.tolerance, part_wider: 1.0 }
    }

    /// Returns true if no more than so many times what was aimed at is left to gain.
    pub fn is_within(&self, times: f64) -> bool {
        let most = times * self.tolerance;
        self.gap < most && self.ahead < LAST_STEP_GAIN * most && self.wider < self.part_wider * self.tolerance
    }

    /// Notes a change of the iterate or of its bounds on jerk, which are wider by `jerk_wider` now.
    pub fn note(&mut self, change: Polished, jerk_wider: f64) {
        match change {
            Polished::FarSlower | Polished::Lost => self.gap = f64::INFINITY,
            Polished::Wider => (self.wider, self.part_wider) = (jerk_wider, LEFT_WIDER),
            Polished::Kept | Polished::Slower => {}
        }
    }

    /// Returns true if the solution is close to the optimum.
    pub fn is_close(&self) -> bool {
        self.gap.max(self.ahead) < CONVERGED_WITHIN * self.tolerance
    }
}
