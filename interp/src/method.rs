//! The planners of speed, by name.

use std::fmt;

use arcfeed_feedrate::{
    ChosenLaw, ContinuousAccelerationScan, FeedError, FeedPlanner, FeedProblem, ForwardBackwardScan,
    InterpolatedReachability, JerkLimitedOrScan, PerSegmentScan, Reachability, SpeedLaw,
};

use crate::problem::RowsNeeded;

/// Which planner finds the speed along a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Method {
    /// The least time under all limits at once, jerk included, by an interior-point method. Where the curvature of the path jumps, or the
    /// turning of the tool, the joints' accelerations step by what the jerk limit allows within a control period. Where it finds no
    /// law, or a longer one than the continuous-acceleration scan, the law of that scan.
    #[default]
    JerkLimited,
    /// One jerk-limited profile between the speed minima, each limit shared out between speed, acceleration and jerk
    /// by fixed parts: a third of the computing time, a longer motion.
    ContinuousAcceleration,
    /// One S-profile per interval with zero acceleration at each boundary (Liu et al. 2023, algorithm 2), looking
    /// `window` intervals ahead, or to the end of the path.
    PerSegment {
        /// Look-ahead in intervals; `None` for the whole path.
        window: Option<usize>,
    },
    /// Every limit but those on jerk at the grid points, forward and backward: fastest to compute.
    ForwardBackward,
    /// The optimum of the limits at the grid points, jerk left out.
    Reachability,
    /// The same between the grid points too, on paths that are piecewise cubic.
    InterpolatedReachability,
}

impl Method {
    /// All of them, the scan per segment without a window.
    pub const ALL: [Self; 6] = [
        Self::JerkLimited,
        Self::ContinuousAcceleration,
        Self::PerSegment { window: None },
        Self::ForwardBackward,
        Self::Reachability,
        Self::InterpolatedReachability,
    ];

    /// Its name in job files, on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::JerkLimited => "jerk-limited",
            Self::ContinuousAcceleration => "continuous-acceleration",
            Self::PerSegment { .. } => "per-segment",
            Self::ForwardBackward => "forward-backward",
            Self::Reachability => "reachability",
            Self::InterpolatedReachability => "interpolated-reachability",
        }
    }

    /// The planner of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// The rows it needs.
    pub const fn needs(self) -> RowsNeeded {
        match self {
            Self::JerkLimited | Self::ContinuousAcceleration | Self::PerSegment { .. } => RowsNeeded::Jerk,
            Self::InterpolatedReachability => RowsNeeded::Between,
            Self::ForwardBackward | Self::Reachability => RowsNeeded::Points,
        }
    }

    /// True if it keeps limits on jerk.
    pub fn limits_jerk(self) -> bool {
        self.needs() == RowsNeeded::Jerk
    }

    /// True if it plans interval by interval, so that chord segments of a curve begin and end on its grid.
    pub(crate) const fn is_by_interval(self) -> bool {
        matches!(self, Self::ContinuousAcceleration | Self::PerSegment { .. })
    }

    /// The law for a problem, from one that it is expected to be close to.
    pub(crate) fn choose_near(self, problem: &FeedProblem, law: &SpeedLaw) -> Result<ChosenLaw, FeedError> {
        match self {
            Self::JerkLimited => JerkLimitedOrScan::default().choose_near(problem, law),
            _ => self.choose(problem),
        }
    }

    /// The law for a problem.
    pub(crate) fn choose(self, problem: &FeedProblem) -> Result<ChosenLaw, FeedError> {
        let law = match self {
            Self::JerkLimited => return JerkLimitedOrScan::default().choose(problem),
            Self::ContinuousAcceleration => ContinuousAccelerationScan.plan(problem),
            Self::PerSegment { window } => PerSegmentScan { window }.plan(problem),
            Self::ForwardBackward => ForwardBackwardScan.plan(problem),
            Self::Reachability => Reachability.plan(problem),
            Self::InterpolatedReachability => InterpolatedReachability.plan(problem),
        }?;
        Ok(ChosenLaw { law, fallback: None, converged: true, grid_costs: Vec::new() })
    }
}

impl FeedPlanner for Method {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        self.choose(problem).map(|chosen| chosen.law)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
