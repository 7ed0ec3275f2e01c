//! Long paths: the speed is planned in windows of the grid.

use arcfeed_feedrate::{ChosenLaw, ContinuousAccelerationScan, Fallback, FeedError, FeedPlanner, SpeedLaw};

use super::Planner;
use crate::error::{LimitError, PlanError};
use crate::method::Method;
use crate::place::PathParameter;
use crate::problem::{LimitFractions, PathProblem};
use crate::trajectory::PlanWindows;

/// Grids of more intervals than this are planned in windows: at once they take half a gigabyte.
const MOST_AT_ONCE: usize = 50_000;
/// Intervals of a window.
const WINDOW: usize = 10_000;
/// Where windows find no motion, grids of no more than so many of them are planned at once, and of no more intervals than this: in two
/// gigabytes at the most.
const WINDOWS_AT_ONCE: usize = 20;
const MOST_AFTER_WINDOWS: usize = 200_000;
/// Longer ones are scanned in parts of so many windows, and of no more than [`MOST_AT_ONCE`] intervals.
const WINDOWS_SCANNED: usize = 5;
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

impl Chosen {
    /// Intervals of its windows.
    pub fn window(&self) -> Option<usize> {
        self.windows.as_ref().map(|windows| windows.intervals)
    }
}

impl<const N: usize> Planner<'_, N> {
    /// Has the jerk-limited planner plan grids of more than so many intervals in windows of that many: 64 at the least and 100 000 at
    /// the most.
    ///
    /// Without it grids of more than 50 000 intervals are planned in windows of 10 000, or of more where the motion passes half a window
    /// in less than twice the time in which joints and tool brake from its greatest speeds. Planned at once, a grid takes some ten kilobytes per interval of six joints; in
    /// windows that holds for the intervals of one window, and the others take some three.
    ///
    /// A window is planned to rest at its end, and about the first half of it is kept
    /// ([`WindowedJerkLimited`](arcfeed_feedrate::WindowedJerkLimited)). The motion is as fast as the whole as long as it can brake to
    /// rest within half a window. Standing still must be possible at the end of a window.
    ///
    /// Where no motion is found in windows, grids of up to twenty windows, but of no more than 200 000 intervals, are planned at once
    /// like shorter ones. Longer ones take the motion of the continuous-acceleration scan, with rest after five windows, but after no more
    /// than 50 000 intervals, without a stop of the path.
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

    /// Intervals whose rows may exist at a time. Those of a short window take so little memory that more of them may.
    pub(super) fn most_rows_at_once(&self) -> usize {
        self.settings.window.map_or(MOST_AT_ONCE, |window| window.max(WINDOW))
    }

    /// The law of a long path, in windows of the length that an earlier round found, where it did.
    pub(super) fn choose_in_windows(
        &self,
        problem: &PathProblem<'_, N>,
        used: &LimitFractions,
        known: Option<usize>,
    ) -> Result<Chosen, PlanError> {
        let mut window = known.or(self.settings.window).unwrap_or(WINDOW);
        let (mut plan, longest) = match problem.planned_in_windows(used, window) {
            Ok(planned) => planned,
            Err(error) => return self.choose_without_windows(problem, used, error),
        };
        while let Some(longer) = self.longer_window(problem, &plan.law, [window, longest]) {
            // Where longer windows have no motion, or no shorter one, there is this one.
            let Ok((again, _)) = problem.planned_in_windows(used, longer) else { break };
            if again.law.duration() >= plan.law.duration() {
                break;
            }
            (plan, window) = (again, longer);
        }
        let windows = PlanWindows { intervals: window, count: plan.windows, stops: plan.stops };
        // A single one is the whole path at once.
        let windows = (windows.count > 1).then_some(windows);
        Ok(Chosen { law: plan.law, fallback: None, converged: plan.converged, windows })
    }

    /// The law of a long path for which windows have none, because of `error`: that of the whole path at once, or else the scan's, part by
    /// part.
    fn choose_without_windows(
        &self,
        problem: &PathProblem<'_, N>,
        used: &LimitFractions,
        error: FeedError,
    ) -> Result<Chosen, PlanError> {
        let window = self.settings.window.unwrap_or(WINDOW);
        if problem.intervals() <= MOST_AFTER_WINDOWS.min(WINDOWS_AT_ONCE * window) {
            return self.choose_at_once(problem, used);
        }
        let mut parts = Vec::new();
        let scanned = problem.for_parts(used, MOST_AT_ONCE.min(WINDOWS_SCANNED * window), |_, rows| {
            parts.push(ContinuousAccelerationScan.plan(&rows)?);
            Ok(())
        });
        match scanned {
            Ok(()) => {
                let law = SpeedLaw::chain(0.0, parts);
                Ok(Chosen { law, fallback: Some(Fallback::Failed(error)), converged: false, windows: None })
            }
            Err(still @ FeedError::StaticallyInfeasible { .. }) => Err(problem.explained(still).into()),
            // The scan knows what is in the way.
            Err(scanned) if matches!(error, FeedError::NotConverged { .. }) => Err(problem.explained(scanned).into()),
            Err(_) => Err(problem.explained(error).into()),
        }
    }

    /// A longer window, up to the longest one that is planned, where the motion passes half of `window` in less than twice the time in
    /// which it brakes; none for windows that were asked for.
    fn longer_window(
        &self,
        problem: &PathProblem<'_, N>,
        law: &SpeedLaw,
        [window, longest]: [usize; 2],
    ) -> Option<usize> {
        // Windows half as long again as this one hold the whole path.
        let is_whole = problem.intervals() <= window + window / 2;
        if self.settings.window.is_some() || is_whole || window >= longest {
            return None;
        }
        let longer = 2.0 * self.braking_time(problem, law) / shortest_half(problem, law, window);
        (longer > 1.0).then(|| ((window as f64 * longer.max(1.5)) as usize).min(longest))
    }

    /// The time in which joints and tool brake to rest from the greatest speeds of a law, s.
    fn braking_time(&self, problem: &PathProblem<'_, N>, law: &SpeedLaw) -> f64 {
        let (joints, tool) = (self.settings.limits.joints(), self.settings.limits.tool());
        let speeds = problem.greatest_speeds(law);
        let of_joint = |j: usize| braking_time(speeds[j], joints.acceleration()[j], joints.jerk()[j]);
        let of_tool = || {
            let is_length = problem.path().parameter() == PathParameter::ArcLength;
            let (a, j) = (tool.tangential_acceleration()?, tool.tangential_jerk().unwrap_or(f64::INFINITY));
            let v = law.knots().map(|(_, state)| state.v).fold(0.0, f64::max);
            is_length.then(|| braking_time(v, a, j))
        };
        (0..N).map(of_joint).chain(of_tool()).fold(0.0, f64::max)
    }
}

/// The time in which something brakes from the speed `v` to rest with no more than the acceleration `a` and the jerk `j`, s.
fn braking_time(v: f64, a: f64, j: f64) -> f64 {
    // Below that speed the acceleration is not reached.
    if v * j < a * a { 2.0 * (v / j).sqrt() } else { v / a + a / j }
}

/// The shortest time in which a law passes half a window, s.
fn shortest_half<const N: usize>(problem: &PathProblem<'_, N>, law: &SpeedLaw, window: usize) -> f64 {
    let times: Vec<f64> = problem.layout.grid.iter().step_by(window / 2).map(|&s| law.time_at_position(s)).collect();
    times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use arcfeed_feedrate::{Fallback, FeedError};
    use arcfeed_kinematics::{Joints, models};

    use crate::problem::LimitFractions;
    use crate::{JointSpline, Limits, MotionPath, Planner, RowsNeeded};

    /// Grids of up to twenty windows are planned at once, longer ones by the scan, with a rest after each five windows.
    #[test]
    fn where_windows_find_no_motion_there_is_one_at_once_or_of_the_scan() {
        let arm = models::ur5e();
        let joints = [2.5, 8.0, 80.0].map(Joints::repeat);
        let joints = arm.range().with_rates(joints[0], joints[1], joints[2]).expect("above 0");
        let points: Vec<Joints<6>> = (0..12).map(|i| Joints::repeat(0.4 * f64::from(i % 3))).collect();
        let path = JointSpline::through(&points).expect("points that differ");
        let planner = Planner::new(&arm, Limits::new(joints)).with_intervals(2000).expect("allowed");
        for (window, scanned) in [(64, true), (128, false)] {
            let planner = planner.clone().with_window(window).expect("allowed");
            let problem = planner.prepare(&path, RowsNeeded::Jerk).expect("in the range");
            let error = FeedError::NotConverged { what: "windows", iterations: 1, residual: 1.0 };
            let full = LimitFractions::default();
            let chosen = planner.choose_without_windows(&problem, &full, error).expect("there is a motion");
            let rests = chosen.law.knots().filter(|(_, state)| state.v == 0.0).count();
            let parts = problem.intervals().div_ceil(5 * window);
            assert_eq!(rests, if scanned { parts } else { 1 }, "{window}: {parts} parts");
            assert_eq!(
                matches!(chosen.fallback, Some(Fallback::Failed(_))),
                scanned,
                "{window}: {:?}",
                chosen.fallback
            );
            assert!((chosen.law.end().p - path.length()).abs() < 1e-9 && chosen.windows.is_none(), "{window}");
        }
    }
}
