//! The planner as a user sees it.

use super::end_speed::explain;
use super::passes::{Aim, Passes};
use super::solution::{JerkLimitedDraft, JerkLimitedPlan};
use crate::error::{FeedError, positive};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::speed_law::SpeedLaw;

/// The part of the tolerance that is aimed at from a law that is close to the optimum.
const NEAR_PART: f64 = 0.06;

/// On grids of fewer intervals than this, a part of that.
const NEAR_PART_FROM: f64 = 4000.0;

/// That of a draft.
const DRAFT_TOLERANCE: f64 = 1e-3;

/// The jerk-limited planner: velocity, acceleration, torque and jerk, kept between the grid points
/// too, in the least time that a quadratic spline on the grid allows.
///
/// Needs [`FeedProblem::between_points`] with at least one jerk row, and four intervals between two
/// stops. Where the path starts or ends in motion the acceleration there is 0. It stops at grid
/// points whose cap is 0. Put the knots of a spline path on the grid.
///
/// Where the second derivatives of a path jump and the jump is spread over some time
/// ([`PathDerivatives::with_steps`](crate::constraint::PathDerivatives::with_steps)), the speed dips as
/// far as the limits on jerk ask for.
///
/// Time and memory grow with the number of rows. A grid of more than 800 intervals is planned on a part
/// of its points first, so that the iterations on all of them are 12 to 30, however many there are. More than 200 000 intervals or five
/// million rows (some 160 000 intervals of a six-axis arm) are refused: such a path is better
/// planned on a coarser grid, which keeps the limits between its points as well, or in windows
/// ([`WindowedJerkLimited`](crate::WindowedJerkLimited)).
///
/// ```
/// use arcfeed_feedrate::constraint::{Feed, TangentialAcceleration, TangentialJerk};
/// use arcfeed_feedrate::{FeedPlanner, FeedProblem, JerkLimited, MotionLaw};
///
/// // A straight path of 0.2 m: the answer is nearly the seven-phase profile, which takes 1.15 s.
/// let grid: Vec<f64> = (0..=200).map(|i| 0.001 * f64::from(i)).collect();
/// let feed = Feed::new(&[0.2; 200])?;
/// let (acceleration, jerk) = (TangentialAcceleration::new(2.0)?, TangentialJerk::new(40.0)?);
/// let problem = FeedProblem::between_points(&grid, &[&feed, &acceleration, &jerk])?;
/// let plan = JerkLimited::default().plan(&problem)?;
/// assert!((plan.duration() - 1.15).abs() < 0.005, "{}", plan.duration());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JerkLimited {
    tolerance: f64,
}

impl Default for JerkLimited {
    /// Stops within 2e-4 of the optimal duration.
    fn default() -> Self {
        Self { tolerance: 2e-4 }
    }
}

impl JerkLimited {
    /// Stops once the duration is within this fraction of the optimum of its problem; 1e-8 at the
    /// least is used.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn new(tolerance: f64) -> Result<Self, FeedError> {
        Ok(Self { tolerance: positive("tolerance", tolerance)?.clamp(1e-8, 1e-2) })
    }

    /// The law, and whether the iterations converged.
    ///
    /// # Errors
    /// As [`FeedPlanner::plan`].
    pub fn plan_noting_convergence(&self, problem: &FeedProblem) -> Result<JerkLimitedPlan, FeedError> {
        self.plan_from(problem, None)
    }

    /// The same, from a law that the plan is expected to be close to, such as the plan on a coarser grid: it takes fewer iterations.
    /// Any law over the same path will do; one that is far too fast is not used.
    ///
    /// # Errors
    /// As [`FeedPlanner::plan`].
    pub fn plan_near(&self, problem: &FeedProblem, law: &SpeedLaw) -> Result<JerkLimitedPlan, FeedError> {
        // An iteration or two more do not cost much then, least of all on a short grid.
        let part = NEAR_PART * (problem.intervals() as f64 / NEAR_PART_FROM).min(1.0);
        Self { tolerance: part * self.tolerance }.plan_from(problem, Some(law))
    }

    /// A law near the optimum of the problem, in half of the time. It may exceed limits between grid points and is good for two
    /// things: its grid costs say where the grid should be finer, and the plan on that grid starts from it
    /// ([`JerkLimited::plan_near`]).
    ///
    /// # Errors
    /// Those of [`FeedPlanner::plan`], without the search for the reason: plan to be told it.
    pub fn draft(problem: &FeedProblem) -> Result<JerkLimitedDraft, FeedError> {
        let passes = Passes { tolerance: DRAFT_TOLERANCE, near: None, aim: Aim::Draft };
        let JerkLimitedPlan { law, grid_costs, .. } = passes.plan(problem).map_err(|why| why.error)?;
        Ok(JerkLimitedDraft { law, grid_costs })
    }

    /// The law, if there is one: from a start of its own, or near another law. Nothing is spent on the reasons where there is none.
    pub(super) fn plan_if_any(&self, problem: &FeedProblem, near: Option<&SpeedLaw>) -> Option<JerkLimitedPlan> {
        let passes = Passes { tolerance: self.tolerance, near, aim: Aim::Motion };
        passes.plan_on_all(problem).ok()
    }

    fn plan_from(&self, problem: &FeedProblem, near: Option<&SpeedLaw>) -> Result<JerkLimitedPlan, FeedError> {
        let passes = Passes { tolerance: self.tolerance, near, aim: Aim::Motion };
        // Some intervals were divided for the plan.
        passes.plan(problem).map_err(|why| explain(&passes, problem, why).on_grid(problem.grid()))
    }
}

impl FeedPlanner for JerkLimited {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        self.plan_noting_convergence(problem).map(|plan| plan.law)
    }
}
