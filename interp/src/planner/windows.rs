//! Long paths: the speed is planned in windows of the grid.

use arcfeed_feedrate::{ChosenLaw, Fallback, SpeedLaw};

use super::Planner;
use crate::error::{LimitError, PlanError};
use crate::method::Method;
use crate::problem::{LimitFractions, PathProblem};
use crate::trajectory::PlanWindows;

/// Grids of more intervals than this are planned in windows: at once they take half a gigabyte.
pub(super) const MOST_AT_ONCE: usize = 50_000;
/// Intervals of a window.
const WINDOW: usize = 10_000;
/// The fewest and the most intervals of a window.
const FEWEST: usize = 64;
const LONGEST: usize = 100_000;

/// The law of a planner, and how it was come by.
#[derive(Debug, Clone)]
pub(super) struct Chosen {
    pub law: SpeedLaw,
    /// Why it is not the jerk-limited planner's.
    pub fallback: Option<Fallback>,
    /// Whether another grid cannot help.
    pub converged: bool,
    /// The windows it was planned in; none for the whole path at once.
    pub windows: Option<PlanWindows>,
}

impl From<ChosenLaw> for Chosen {
    fn from(of: ChosenLaw) -> Self {
        Self { law: of.law, fallback: of.fallback, converged: of.converged, windows: None }
    }
}

impl<const N: usize> Planner<'_, N> {
    /// Has the jerk-limited planner plan grids of more than so many intervals in windows of that many: 64 at the least and 100 000 at
    /// the most.
    ///
    /// Without it grids of more than 50 000 intervals are planned in windows of 10 000, or of more where the motion passes half a window
    /// in less than twice the time in which it brakes. Planned at once, a grid takes some ten kilobytes per interval of six joints; in
    /// windows that holds for the intervals of one window, and the others take some three.
    ///
    /// A window is planned to rest at its end, and about the first half of it is kept
    /// ([`WindowedJerkLimited`](arcfeed_feedrate::WindowedJerkLimited)). The motion is as fast as the whole as long as it can brake to
    /// rest within half a window.
    ///
    /// ```
    /// use arcfeed_interp::{JointSpline, Limits, Planner};
    /// use arcfeed_kinematics::{Joints, models};
    ///
    /// let arm = models::ur5e();
    /// let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
    /// let points: Vec<_> = (0..12).map(|i| Joints::repeat(0.3 * f64::from(i % 3))).collect();
    /// let path = JointSpline::through(&points)?;
    /// let planner = Planner::new(&arm, Limits::new(joints)).with_intervals(2000)?;
    /// let (whole, windows) = (planner.plan(&path)?, planner.with_window(600)?.plan(&path)?);
    /// assert!(whole.info().windows.is_none() && windows.info().windows.as_ref().is_some_and(|w| w.count > 3));
    /// assert!(windows.duration() < 1.005 * whole.duration());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`LimitError::Window`].
    pub fn with_window(mut self, intervals: usize) -> Result<Self, LimitError> {
        if !(FEWEST..=LONGEST).contains(&intervals) {
            return Err(LimitError::Window { intervals, fewest: FEWEST, most: LONGEST });
        }
        self.settings.window = Some(intervals);
        Ok(self)
    }

    /// Whether a grid is planned in windows.
    pub(super) fn plans_in_windows(&self, intervals: usize) -> bool {
        self.method == Method::JerkLimited && intervals > self.settings.window.unwrap_or(MOST_AT_ONCE)
    }

    /// The law of a long path.
    pub(super) fn choose_in_windows(
        &self,
        problem: &PathProblem<'_, N>,
        used: &LimitFractions,
    ) -> Result<Chosen, PlanError> {
        let mut window = self.settings.window.unwrap_or(WINDOW);
        loop {
            let plan = problem.planned_in_windows(used, window)?;
            let longer = 2.0 * self.braking_time() / self.shortest_half(problem, &plan.law, window);
            let may_be_longer = self.settings.window.is_none() && window < LONGEST.min(problem.intervals());
            if may_be_longer && longer > 1.0 {
                window = ((window as f64 * longer.max(1.5)) as usize).min(LONGEST);
                continue;
            }
            let windows = PlanWindows { intervals: window, count: plan.windows, stops: plan.stops };
            return Ok(Chosen { law: plan.law, fallback: None, converged: true, windows: Some(windows) });
        }
    }

    /// The shortest time in which a law passes half a window, s.
    fn shortest_half(&self, problem: &PathProblem<'_, N>, law: &SpeedLaw, window: usize) -> f64 {
        let times = problem.layout.grid.iter().step_by(window / 2).map(|&s| law.time_at_position(s));
        let times: Vec<f64> = times.collect();
        times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
    }

    /// The time in which joints and tool brake from their greatest speeds to rest, s.
    fn braking_time(&self) -> f64 {
        let (joints, tool) = (self.settings.limits.joints(), self.settings.limits.tool());
        let of_joint = |j: usize| {
            let [v, a, jerk] = [joints.velocity()[j], joints.acceleration()[j], joints.jerk()[j]];
            v / a + a / jerk
        };
        let of_tool = || {
            let (v, a) = (tool.feed()?, tool.tangential_acceleration()?);
            Some(v / a + a / tool.tangential_jerk()?)
        };
        (0..N).map(of_joint).chain(of_tool()).filter(|time| time.is_finite()).fold(0.0, f64::max)
    }
}
