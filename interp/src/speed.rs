//! The motion law of a plan, whichever planner made it.

use arcfeed_feedrate::{Cursor, GridCursor, GridPlan, MotionLaw, MotionState, SpeedPlan};

/// s(t) along the path: constant-jerk phases of a scan, or the jerk-limited law on a grid.
#[derive(Debug, Clone, PartialEq)]
pub enum SpeedLaw {
    /// Phases of constant jerk.
    Phases(SpeedPlan),
    /// Acceleration continuous, its slope by `s` constant on every interval of the grid.
    Grid(GridPlan),
}

impl SpeedLaw {
    /// The state at position `s`, clamped to the path.
    pub fn at_position(&self, s: f64) -> MotionState {
        match self {
            Self::Phases(plan) => plan.at_position(s),
            Self::Grid(plan) => plan.at_position(s),
        }
    }

    /// Speed at position `s`.
    pub fn v_at_s(&self, s: f64) -> f64 {
        self.at_position(s).v
    }

    /// A sampler that remembers its place: amortised constant time for increasing `t`, no allocation.
    pub fn cursor(&self) -> SpeedCursor<'_> {
        match self {
            Self::Phases(plan) => SpeedCursor::Phases(plan.cursor()),
            Self::Grid(plan) => SpeedCursor::Grid(plan.cursor()),
        }
    }
}

impl MotionLaw for SpeedLaw {
    fn duration(&self) -> f64 {
        match self {
            Self::Phases(plan) => plan.duration(),
            Self::Grid(plan) => plan.duration(),
        }
    }

    fn at(&self, t: f64) -> MotionState {
        match self {
            Self::Phases(plan) => plan.at(t),
            Self::Grid(plan) => plan.at(t),
        }
    }
}

/// A place in a [`SpeedLaw`]; see [`SpeedLaw::cursor`].
#[derive(Debug, Clone)]
pub enum SpeedCursor<'a> {
    /// In phases.
    Phases(Cursor<'a>),
    /// On a grid.
    Grid(GridCursor<'a>),
}

impl SpeedCursor<'_> {
    /// The state at time `t` (s), the same as [`MotionLaw::at`].
    #[inline]
    pub fn at(&mut self, t: f64) -> MotionState {
        match self {
            Self::Phases(cursor) => cursor.at(t),
            Self::Grid(cursor) => cursor.at(t),
        }
    }
}
