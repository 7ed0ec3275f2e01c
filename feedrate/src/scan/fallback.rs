//! The jerk-limited planner, and the scan where that finds nothing.

use std::fmt;

use super::on_problem::ContinuousAccelerationScan;
use crate::error::FeedError;
use crate::jerk_limited::{JerkLimited, JerkLimitedPlan};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::speed_law::SpeedLaw;

/// [`JerkLimited`]; [`ContinuousAccelerationScan`] where that finds no law, or where the grid is
/// coarse and the scan's law is shorter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JerkLimitedOrScan {
    /// The planner that comes first.
    pub jerk_limited: JerkLimited,
}

/// Why a law is the scan's and not the jerk-limited planner's.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Fallback {
    /// Its law was slower than the scan's.
    Slower {
        /// Duration of its law (s).
        duration: f64,
    },
    /// It found none.
    Failed(FeedError),
}

impl fmt::Display for Fallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slower { duration } => write!(f, "its plan takes {duration:.6} s, no less than the scan's"),
            Self::Failed(error) => error.fmt(f),
        }
    }
}

/// The law of [`JerkLimitedOrScan`], and how it was come by.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenLaw {
    /// The law.
    pub law: SpeedLaw,
    /// Why it is not the jerk-limited planner's; `None` where it is.
    pub fallback: Option<Fallback>,
    /// True if the jerk-limited planner did its part: where it did not converge, another grid may
    /// give a faster law.
    pub converged: bool,
    /// The time that each interval of the grid costs by its length, s; empty where the law is not the jerk-limited planner's.
    pub grid_costs: Vec<f64>,
}

impl JerkLimitedOrScan {
    /// On grids of no more intervals than this the scan is run beside the jerk-limited planner: the
    /// quadratic spline of [`JerkLimited`] may lose to a profile of seven phases there, and the scan
    /// takes a millisecond or two.
    pub const COARSE_INTERVALS: usize = 500;

    /// The law, and why it is not the jerk-limited planner's where it is not.
    ///
    /// # Errors
    /// Those of the jerk-limited planner where neither finds a law; a limit that is broken at rest
    /// is named first.
    pub fn choose(&self, problem: &FeedProblem) -> Result<ChosenLaw, FeedError> {
        self.choose_from(problem, None)
    }

    /// The same, from a law that the result is expected to be close to; see [`JerkLimited::plan_near`].
    ///
    /// # Errors
    /// As [`JerkLimitedOrScan::choose`].
    pub fn choose_near(&self, problem: &FeedProblem, law: &SpeedLaw) -> Result<ChosenLaw, FeedError> {
        self.choose_from(problem, Some(law))
    }

    fn choose_from(&self, problem: &FeedProblem, near: Option<&SpeedLaw>) -> Result<ChosenLaw, FeedError> {
        let scan = || ContinuousAccelerationScan.plan(problem);
        let planned = match near {
            Some(law) => self.jerk_limited.plan_near(problem, law),
            None => self.jerk_limited.plan_noting_convergence(problem),
        };
        match planned {
            Ok(JerkLimitedPlan { law, converged, grid_costs }) => {
                let scanned =
                    if problem.intervals() > Self::COARSE_INTERVALS && converged { None } else { scan().ok() };
                Ok(match scanned {
                    Some(scanned) if law.duration() >= scanned.duration() => {
                        let fallback = Some(Fallback::Slower { duration: law.duration() });
                        ChosenLaw { law: scanned, fallback, converged, grid_costs: Vec::new() }
                    }
                    _ => ChosenLaw { law, fallback: None, converged, grid_costs },
                })
            }
            Err(error) => match scan() {
                Ok(law) => {
                    let fallback = Some(Fallback::Failed(error));
                    Ok(ChosenLaw { law, fallback, converged: false, grid_costs: Vec::new() })
                }
                Err(still @ FeedError::StaticallyInfeasible { .. }) => Err(still),
                // The scan knows what is in the way.
                Err(scanned) if matches!(error, FeedError::NotConverged { .. }) => Err(scanned),
                Err(_) => Err(error),
            },
        }
    }
}

impl FeedPlanner for JerkLimitedOrScan {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        self.choose(problem).map(|chosen| chosen.law)
    }
}
