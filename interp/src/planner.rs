//! From a path to a verified trajectory.

mod rounds;
mod windows;

use std::sync::Arc;
use std::time::{Duration, Instant};

use arcfeed_feedrate::{FeedError, SpeedLaw};
use arcfeed_kinematics::ForwardKinematics;

use crate::diagnosis;
use crate::error::{LimitError, PlanError, positive};
use crate::limits::{FeedSection, Limits};
use crate::lowering::TOLERANCE;
use crate::method::Method;
use crate::path::MotionPath;
use crate::problem::{Held, MOST_INTERVALS, PathProblem, RowsNeeded, Settings};
use crate::trajectory::{PlanInfo, Timings, Trajectory};
use crate::verify::{Requirement, Verification, verify};

/// A motion has at most this many setpoints: 1.4 hours at 1 ms, some 1.5 GB for whoever collects them all.
const MOST_SETPOINTS: f64 = 5e6;
/// Intervals of a grid of equal steps unless set otherwise.
const INTERVALS: usize = 500;

/// Plans motions of one arm along paths of any kind.
///
/// ```
/// use arcfeed_interp::{JointSpline, Limits, Planner};
/// use arcfeed_kinematics::{Joints, models};
///
/// let arm = models::ur5e();
/// let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
/// let path = JointSpline::through(&[Joints::repeat(0.0), Joints::repeat(0.5), Joints::repeat(-0.2)])?;
/// let trajectory = Planner::new(&arm, Limits::new(joints)).plan(&path)?;
/// for setpoint in trajectory.setpoints(1e-3)? {
///     let q = setpoint?.q; // rad, for the controller
/// #   assert!(q.iter().all(|q| q.is_finite()));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A curve of the tool ([`ToolPath`](crate::ToolPath)) and a motion between poses ([`PoseMove`](crate::PoseMove)) are planned by
/// the same call, with limits of the tool and of the drives where they are set. Every trajectory that is returned was verified on
/// dense samples and keeps every limit.
#[derive(Debug, Clone)]
pub struct Planner<'a, const N: usize = 6> {
    settings: Settings<'a, N>,
    method: Method,
}

impl<'a, const N: usize> Planner<'a, N> {
    /// A planner for `arm` under `limits`, from rest to rest, with a chord tolerance of 1 um, a control period of 1 ms, 500 intervals
    /// where no curve of the tool says how many there have to be, and the jerk-limited planner.
    pub fn new(arm: &'a (dyn ForwardKinematics<N> + Sync), limits: Limits<'a, N>) -> Self {
        let settings = Settings {
            arm,
            limits,
            sections: Vec::new(),
            ends: [0.0; 2],
            chord_tolerance: 1e-6,
            period: 1e-3,
            intervals: INTERVALS,
            window: None,
            whole_cycles: false,
        };
        Self { settings, method: Method::JerkLimited }
    }

    /// Sets the chord tolerance, m: how far the straight line between two setpoints, and the chord of a segment, may lie
    /// from the path.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_chord_tolerance(mut self, tolerance: f64) -> Result<Self, LimitError> {
        self.settings.chord_tolerance = positive("chord tolerance", tolerance)?;
        Ok(self)
    }

    /// Sets the control period, s.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`].
    pub fn with_period(mut self, period: f64) -> Result<Self, LimitError> {
        self.settings.period = positive("control period", period)?;
        Ok(self)
    }

    /// Makes motions last a whole number of control periods: they are slowed down as a whole by less than a period. It needs rest at both
    /// ends. [`Planner::plan`] and [`Planner::finish`] do so; [`Planner::prepare`] and [`Planner::verify`] take a motion as it is.
    ///
    /// ```
    /// use arcfeed_interp::{JointSpline, Limits, Planner};
    /// use arcfeed_kinematics::{Joints, models};
    ///
    /// let arm = models::ur5e();
    /// let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
    /// let path = JointSpline::through(&[Joints::repeat(0.0), Joints::repeat(0.5)])?;
    /// let planner = Planner::new(&arm, Limits::new(joints)).with_period(4e-3)?;
    /// let shortest = planner.plan(&path)?.duration() / 4e-3;
    /// let cycles = planner.with_whole_cycles().plan(&path)?.duration() / 4e-3;
    /// assert!((cycles - shortest.ceil()).abs() < 1e-9 && shortest.fract() > 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_whole_cycles(mut self) -> Self {
        self.settings.whole_cycles = true;
        self
    }

    /// Sets the planner of the speed.
    pub fn with_method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// Sets about how many intervals the grid has on paths without a curve of the tool; the knots of a spline are among its points. The
    /// jerk-limited planner divides those that cost time by their length.
    ///
    /// # Errors
    /// [`LimitError::Intervals`].
    pub fn with_intervals(mut self, intervals: usize) -> Result<Self, LimitError> {
        if !(4..=MOST_INTERVALS).contains(&intervals) {
            return Err(LimitError::Intervals { intervals, most: MOST_INTERVALS });
        }
        self.settings.intervals = intervals;
        Ok(self)
    }

    /// Gives parts of a curve of the tool a feed of their own; they must not overlap. Whether they lie on the path shows when it is
    /// planned.
    pub fn with_sections(mut self, sections: Vec<FeedSection>) -> Self {
        self.settings.sections = sections;
        self
    }

    /// Sets the speeds along the path at its start and at its end, units of its parameter per s, both with no acceleration along it;
    /// 0 is rest.
    ///
    /// # Errors
    /// [`PlanError::Speed`] for a number that is negative or not finite.
    pub fn with_end_speeds(mut self, v_start: f64, v_end: f64) -> Result<Self, PlanError> {
        for (what, value) in [("start speed", v_start), ("end speed", v_end)] {
            let wrong = match value {
                v if !v.is_finite() => FeedError::NotFinite { what, value },
                v if v < 0.0 => FeedError::Negative { what, value },
                _ => continue,
            };
            return Err(PlanError::Speed(wrong.into()));
        }
        self.settings.ends = [v_start, v_end];
        Ok(self)
    }

    /// The planner of the speed.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The limits.
    pub fn limits(&self) -> &Limits<'a, N> {
        &self.settings.limits
    }

    pub(crate) fn settings(&self) -> &Settings<'a, N> {
        &self.settings
    }

    /// Plans the motion along `path` and verifies it on dense samples. A trajectory that is returned keeps every limit.
    ///
    /// A plan that exceeds a limit between the points of its grid is made again: on a grid that is finer there, or with a little less of
    /// that limit there.
    ///
    /// # Errors
    /// [`PlanError::Path`] where the arm cannot follow, [`PlanError::Limit`] for limits and settings that do not suit the path,
    /// [`PlanError::Speed`] naming place, joint and limit where no motion keeps the limits, [`PlanError::Unverified`] when no plan
    /// passes verification.
    pub fn plan<'p>(&self, path: &'p dyn MotionPath<N>) -> Result<Trajectory<'p, N>, PlanError>
    where
        'a: 'p,
    {
        self.plan_held(Held::Borrowed(path))
    }

    /// The same for a path that the trajectory keeps.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    pub fn plan_shared<'p>(&self, path: Arc<dyn MotionPath<N> + 'p>) -> Result<Trajectory<'p, N>, PlanError>
    where
        'a: 'p,
    {
        self.plan_held(Held::Shared(path))
    }

    /// The path on its grid with the rows that `needs` names: for planners of the caller's own.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    pub fn prepare<'p>(&self, path: &'p dyn MotionPath<N>, needs: RowsNeeded) -> Result<PathProblem<'p, N>, PlanError>
    where
        'a: 'p,
    {
        PathProblem::new(&self.settings, Held::Borrowed(path), needs, self.method.is_by_interval())
    }

    /// A trajectory of a law from elsewhere, which has to run over the whole path; verified, and with a limit on jerk where
    /// `jerk_limited` says so. [`Planner::with_whole_cycles`] slows it down first.
    ///
    /// # Errors
    /// [`PlanError::Unverified`] for a law that breaks a limit, [`LimitError::Law`] for one that does not run over the path,
    /// [`LimitError::Unsuited`] for whole cycles without rest at both ends.
    pub fn finish<'p>(
        &self,
        problem: PathProblem<'p, N>,
        law: SpeedLaw,
        jerk_limited: bool,
    ) -> Result<Trajectory<'p, N>, PlanError>
    where
        'a: 'p,
    {
        let begin = Instant::now();
        problem.runs_over(&law)?;
        let law = self.in_whole_cycles(&problem, law)?;
        let verification = self.verify(&problem, &law, jerk_limited)?;
        let [grid, joint_path] = problem.times();
        let timings = Timings { grid, joint_path, speed: Duration::ZERO, verification: begin.elapsed() };
        if !verification.holds(TOLERANCE) {
            return Err(unverified(&problem, &verification, true));
        }
        let intervals = problem.intervals();
        let info = PlanInfo {
            method: None,
            fallback: None,
            rounds: 1,
            intervals,
            windows: None,
            refined: 1,
            lowered: Vec::new(),
            slowed: 1.0,
            slower: 1.0,
        };
        Ok(Trajectory::new(problem, law, info, verification, timings))
    }

    /// Holds the motion by a law, whoever made it, against all limits; see [`verify`](crate::verify). The law is taken as it is, with
    /// [`Planner::with_whole_cycles`], too.
    ///
    /// # Errors
    /// [`LimitError::Law`] for a law that does not run over the path, [`PlanError::Path`] where a setpoint cannot be computed.
    pub fn verify(
        &self,
        problem: &PathProblem<'_, N>,
        law: &SpeedLaw,
        jerk_limited: bool,
    ) -> Result<Verification, PlanError> {
        problem.runs_over(law)?;
        let longest = MOST_SETPOINTS * self.settings.period;
        if law.duration() > longest {
            return Err(LimitError::TooLong { duration: law.duration(), longest }.into());
        }
        let requirement = Requirement {
            arm: self.settings.arm,
            path: problem.path(),
            limits: &self.settings.limits,
            jerk_limited,
            chord_tolerance: self.settings.chord_tolerance,
            path_tolerance: self.settings.chord_tolerance,
            period: self.settings.period,
            sections: problem.sections(),
            end_speeds: self.settings.ends,
        };
        let mut setpoints = problem.setpoints(law, self.settings.period)?;
        verify(&requirement, law.duration(), &knots(law, self.settings.period), |t| setpoints.at(t))
    }

    fn plan_held<'p>(&self, path: Held<'p, N>) -> Result<Trajectory<'p, N>, PlanError>
    where
        'a: 'p,
    {
        self.plan_until(path, |_| Ok(Vec::new()))
    }
}

/// Times just before every knot of a law and at it: there its acceleration or its jerk may jump.
fn knots(law: &SpeedLaw, period: f64) -> Vec<f64> {
    let before = |t: f64| t - (1e-10 * period).max(4.0 * f64::EPSILON * t);
    law.knots().skip(1).flat_map(|(t, _)| [before(t), t]).collect()
}

fn unverified<const N: usize>(problem: &PathProblem<'_, N>, verification: &Verification, between: bool) -> PlanError {
    let worst = verification.worst();
    PlanError::Unverified {
        limit: worst.id,
        ratio: worst.ratio,
        place: problem.path().place(worst.s),
        t: worst.t,
        cause: diagnosis::cause(problem, worst.s, between),
    }
}
