//! The settings of a plan.

use arcfeed_kinematics::ForwardKinematics;

use crate::error::LimitError;
use crate::limits::{FeedSection, Limits};

/// The most intervals of a grid: those of a million points of six joints fill some three gigabytes.
pub(crate) const MOST_INTERVALS: usize = 1_000_000;

/// Arm, limits and settings of a planner.
#[derive(Clone)]
pub(crate) struct Settings<'a, const N: usize> {
    pub arm: &'a (dyn ForwardKinematics<N> + Sync),
    pub limits: Limits<'a, N>,
    pub sections: Vec<FeedSection>,
    /// Speeds at the start and at the end, units of the parameter per s.
    pub ends: [f64; 2],
    /// Chord tolerance, m.
    pub chord_tolerance: f64,
    /// Control period, s.
    pub period: f64,
    /// Intervals of the grid, where no curve of the tool says how many there have to be.
    pub intervals: usize,
    /// Intervals of a window in which the jerk-limited planner plans longer grids, where it is set.
    pub window: Option<usize>,
    /// Whether motions last a whole number of control periods.
    pub whole_cycles: bool,
}

impl<const N: usize> std::fmt::Debug for Settings<'_, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Settings")
            .field("limits", &self.limits)
            .field("sections", &self.sections)
            .field("ends", &self.ends)
            .field("chord_tolerance", &self.chord_tolerance)
            .field("period", &self.period)
            .field("intervals", &self.intervals)
            .field("window", &self.window)
            .field("whole_cycles", &self.whole_cycles)
            .finish_non_exhaustive()
    }
}

impl<const N: usize> Settings<'_, N> {
    /// The feed along a curve of the tool, m/s.
    ///
    /// # Errors
    /// [`LimitError::Unsuited`] without one.
    pub fn feed(&self) -> Result<f64, LimitError> {
        self.limits.tool().feed().ok_or(LimitError::Unsuited {
            limit: "a feed",
            problem: "is needed along a curve of the tool",
            remedy: "give one with ToolLimits::with_feed",
        })
    }

    /// A speed that is not reached on a path of `length` (m) by accelerating over all of it, m/s. A higher feed limits
    /// nothing, and its size must not spoil the measures that are taken relative to it.
    pub fn reachable(&self, length: f64) -> f64 {
        let fastest_end = self.ends[0].max(self.ends[1]);
        let acceleration = self.limits.tool().tangential_acceleration().unwrap_or(f64::INFINITY);
        2.0 * fastest_end.hypot((2.0 * acceleration * length).sqrt())
    }
}
