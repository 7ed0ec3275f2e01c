//! From a path to a verified trajectory.

use std::sync::Arc;
use std::time::{Duration, Instant};

use arcfeed_feedrate::{ChosenLaw, FeedError, LimitId, SpeedLaw};
use arcfeed_kinematics::ForwardKinematics;

use crate::diagnosis;
use crate::error::{LimitError, PlanError, positive};
use crate::limits::{FeedSection, Limits};
use crate::lowering::{TOLERANCE, exceeded_stretches, fraction, lower_where_exceeded, lowerable};
use crate::method::Method;
use crate::path::MotionPath;
use crate::problem::{Held, LimitFractions, PathProblem, RowsNeeded, Settings, parts_by_cost, resolved};
use crate::trajectory::{PlanInfo, Timings, Trajectory};
use crate::verify::{Requirement, Verification, verify};

/// A motion has at most this many setpoints: 1.4 hours at 1 ms, some 1.5 GB for whoever collects them all.
const MOST_SETPOINTS: f64 = 5e6;
/// Rounds of planning until the verification passes.
const ROUNDS: usize = 12;
/// A limit that is exceeded by more than this, relative to it, asks for a finer grid; by less, for less of the limit: that costs a third of
/// it in time at the most for a jerk, and a finer grid often shows more to hold.
const COARSE: f64 = 1e-2;
/// Intervals on which a limit is exceeded are divided into so many parts, as long as the grid has no more than that many intervals, or
/// no more than so many times as many as before.
const FINER: usize = 4;
const FINEST: usize = 4_000;
const MOST_FINER: usize = 2;
/// Rounds in which the grid is made finer: what two of them do not mend, less of all limits does.
const FINER_ROUNDS: usize = 2;
/// Part of the excess that is left after a round in which a limit was lowered where it was exceeded, for lack of grid points there.
const STUCK: f64 = 0.9;
/// On a grid of more intervals than this, a motion that exceeds a limit by no more than this part is slowed down as a whole: another
/// round would take long.
const LARGE: usize = 6000;
const SLIGHT: f64 = 1e-4;
/// Rounds in which a limit is lowered only where it is exceeded; later ones lower it everywhere.
const LOCAL_ROUNDS: usize = 6;
/// By how much more all limits are lowered than the worst was exceeded, and by what at the most in one round.
const SLOWER: f64 = 0.999;
const MOST_SLOWER: f64 = 1.5;
/// Intervals of a grid of equal steps unless set otherwise.
const INTERVALS: usize = 500;
/// The most intervals that are taken: a million points of six joints fill a gigabyte.
const MOST_INTERVALS: usize = 1_000_000;
/// Another attempt of a planner that did not converge does not take a finer grid than this.
const MOST_AGAIN: usize = 8000;

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
    /// `jerk_limited` says so.
    ///
    /// # Errors
    /// [`PlanError::Unverified`] for a law that breaks a limit, [`LimitError::Law`] for one that does not run over the path.
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
            refined: 1,
            lowered: Vec::new(),
            slowed: 1.0,
        };
        Ok(Trajectory::new(problem, law, info, verification, timings))
    }

    /// Holds the motion by a law, whoever made it, against all limits; see [`verify`](crate::verify).
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

    /// Plans until a verified trajectory exceeds nothing that `exceeded` looks for: limits, and the ratios to them.
    pub(crate) fn plan_until<'p, E: From<PlanError>>(
        &self,
        path: Held<'p, N>,
        mut exceeded: impl FnMut(&Trajectory<'p, N>) -> Result<Vec<(LimitId, f64)>, E>,
    ) -> Result<Trajectory<'p, N>, E>
    where
        'a: 'p,
    {
        let begin = Instant::now();
        let needs = self.method.needs();
        let on_breaks = self.method.is_by_interval();
        let mut problem = PathProblem::new(&self.settings, path, needs, on_breaks)?;
        let mut used = LimitFractions::default();
        if self.method == Method::JerkLimited && problem.path().tool_curve().is_some() {
            problem = resolved(problem)?;
        }
        let mut chosen = self.choose_over_grids(&mut problem)?;
        self.choose_on_finer_grid(&mut problem, &mut chosen);
        let (mut verifying, mut refined) = (Duration::ZERO, 1);
        let (mut rounds, mut margin, mut last_excess) = (0, 1.2 * SLIGHT, f64::INFINITY);
        let verification = loop {
            rounds += 1;
            let started = Instant::now();
            let verification = self.verify(&problem, &chosen.law, self.method.limits_jerk())?;
            verifying += started.elapsed();
            if verification.holds(TOLERANCE) {
                let [grid, joint_path] = problem.times();
                let speed = begin.elapsed().saturating_sub(verifying + grid + joint_path);
                let timings = Timings { grid, joint_path, speed, verification: verifying };
                let info = self.info(&problem, &chosen, (rounds, refined), &used);
                let trajectory = Trajectory::new(problem, chosen.law, info, verification, timings);
                let more = exceeded(&trajectory)?;
                if more.is_empty() || rounds == ROUNDS {
                    return Ok(trajectory);
                }
                more.into_iter().for_each(|(id, ratio)| used.lower(id, fraction(ratio)));
                problem = trajectory.into_problem();
                chosen = self.choose(&problem, &used)?;
                continue;
            }
            let Some(exceeded) = lowerable(&verification, self.method.limits_jerk()) else { break verification };
            if rounds == ROUNDS {
                break verification;
            }
            let excess = verification.worst().ratio - 1.0;
            let rests = self.settings.ends == [0.0; 2];
            if excess <= SLIGHT && problem.intervals() > LARGE && rests && self.method == Method::JerkLimited {
                // Accelerations and jerks fall by more. The margin is for the setpoints of the slower motion, which lie elsewhere.
                let slower = chosen.law.scaled(1.0 - excess - margin);
                margin *= 2.0;
                let slower = slower.map_err(|error| PlanError::from(problem.explained(error)))?;
                chosen.law = slower;
                continue;
            }
            let local = rounds <= LOCAL_ROUNDS && self.method == Method::JerkLimited;
            // What a lower limit does not mend is seen by a finer grid.
            let stuck = excess > STUCK * last_excess;
            last_excess = excess;
            let parts = if (excess > COARSE && rounds <= FINER_ROUNDS) || stuck {
                self.parts_where_exceeded(&problem, &verification, &chosen.law)
            } else {
                None
            };
            if let Some(parts) = parts {
                problem = problem.refined(|k| parts[k])?;
                refined *= FINER;
            } else if excess > COARSE && !local {
                // Far too much of one limit is a place that the grid does not see: a slower motion is slower there as well.
                used.lower_all(SLOWER / (1.0 + excess).min(MOST_SLOWER));
            } else if local {
                lower_where_exceeded(&mut used, &verification, &chosen.law, self.settings.period);
            } else {
                exceeded.into_iter().for_each(|(id, ratio)| used.lower(id, fraction(ratio)));
            }
            // A speed at an end may go with the limits that were asked for and with none below.
            let Ok(again) = self.choose_near(&problem, &used, &chosen.law) else { break verification };
            chosen = again;
        };
        Err(unverified(&problem, &verification, needs > RowsNeeded::Points).into())
    }

    fn choose(&self, problem: &PathProblem<'_, N>, used: &LimitFractions) -> Result<ChosenLaw, PlanError> {
        let rows = problem.rows_within(used, self.method.needs())?;
        Ok(self.method.choose(&rows).map_err(|error| problem.explained(error))?)
    }

    /// Parts into which to divide the intervals on which a law exceeds limits; none where that makes too many.
    fn parts_where_exceeded(
        &self,
        problem: &PathProblem<'_, N>,
        verification: &Verification,
        law: &SpeedLaw,
    ) -> Option<Vec<usize>> {
        let mut parts = vec![1; problem.intervals()];
        for [from, to] in exceeded_stretches(verification, law, self.settings.period) {
            parts[problem.intervals_between(from, to)].fill(FINER);
        }
        let (before, after) = (problem.intervals(), parts.iter().sum::<usize>());
        (before < after && after <= FINEST.max(MOST_FINER * before)).then_some(parts)
    }

    /// The same, from the law of a problem that is almost the same.
    fn choose_near(
        &self,
        problem: &PathProblem<'_, N>,
        used: &LimitFractions,
        law: &SpeedLaw,
    ) -> Result<ChosenLaw, PlanError> {
        let rows = problem.rows_within(used, self.method.needs())?;
        Ok(self.method.choose_near(&rows, law).map_err(|error| problem.explained(error))?)
    }

    /// The law; where the planner did not converge on a grid of equal steps, the fastest of several grids.
    fn choose_over_grids(&self, problem: &mut PathProblem<'_, N>) -> Result<ChosenLaw, PlanError> {
        let full = LimitFractions::default();
        let mut best = self.choose(problem, &full);
        if problem.path().tool_curve().is_some() {
            return best;
        }
        let n = self.settings.intervals;
        for intervals in [n + 1, 2 * n, 2 * n + 1, 4 * n].into_iter().filter(|n| *n <= MOST_AGAIN) {
            let doubtful = match &best {
                Ok(chosen) => !chosen.converged,
                Err(PlanError::Speed(error)) => error.is_not_converged(),
                Err(_) => false,
            };
            if !doubtful {
                break;
            }
            let settings = Settings { intervals, ..problem.settings.clone() };
            let other = PathProblem::new(&settings, problem.path.clone(), self.method.needs(), false)?;
            let again = self.choose(&other, &full);
            let faster = match (&again, &best) {
                (Ok(again), Ok(best)) => again.law.duration() < best.law.duration(),
                (again, best) => again.is_ok() && best.is_err(),
            };
            if faster {
                (*problem, best) = (other, again);
            }
        }
        best
    }

    /// Divides the intervals that cost time by their length, and keeps the law on this grid where it is shorter.
    fn choose_on_finer_grid(&self, problem: &mut PathProblem<'_, N>, chosen: &mut ChosenLaw) {
        let Some(parts) = parts_by_cost(&chosen.grid_costs, chosen.law.duration()) else { return };
        // Where the path cannot be followed on a finer grid, or not be planned on it, there is the law on this one.
        let Ok(finer) = problem.refined(|k| parts[k]) else { return };
        let Ok(again) = self.choose_near(&finer, &LimitFractions::default(), &chosen.law) else { return };
        if again.law.duration() < chosen.law.duration() {
            (*problem, *chosen) = (finer, again);
        }
    }

    fn info(
        &self,
        problem: &PathProblem<'_, N>,
        chosen: &ChosenLaw,
        (rounds, refined): (usize, usize),
        used: &LimitFractions,
    ) -> PlanInfo {
        let method = if chosen.fallback.is_some() { Method::ContinuousAcceleration } else { self.method };
        PlanInfo {
            method: Some(method),
            fallback: chosen.fallback,
            rounds,
            intervals: problem.intervals(),
            refined,
            lowered: used.lowered(),
            slowed: used.everywhere(),
        }
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
