//! From a path and its limits to a speed plan.

use std::time::Instant;

use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity, PathConstraint, PathDerivatives};
use arcfeed_feedrate::{
    BothEndsScan, CertifiedReachability, ContinuousAccelerationScan, Fallback, FeedError, FeedPlanner, FeedProblem,
    JerkLimited, PublishedScan, Quantity, Reachability, SpeedLaw,
};
use arcfeed_kinematics::{Dynamics, ForwardKinematics, Joints};

use super::plan::Schedule;
use super::rows::{PathSamples, ToolSpeed, TorqueRows, Wanted};
use super::{ScheduleLimits, SchedulePath};
use crate::error::PlanError;

/// Intervals of the grid unless set otherwise.
const INTERVALS: usize = 500;
/// The most intervals that are taken: a million points of six joints fill a gigabyte.
const MOST_INTERVALS: usize = 1_000_000;

/// Another attempt does not take a finer grid than this.
const MOST_AGAIN: usize = 8000;
/// A jerk-limited motion this many times slower than the scan is suspected of having been slowed down for a trace of
/// round-off, which another grid does not have.
const CRAWLS: f64 = 3.0;

/// Which planner finds the speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum SpeedPlanner {
    /// [`BothEndsScan`]: every row at the grid points, fastest to compute.
    BothEnds,
    /// [`PublishedScan`], for reproduction only: it breaks the limits it is given.
    Published,
    /// [`Reachability`]: the optimum of the rows at the grid points.
    Reachability,
    /// [`CertifiedReachability`]: between the grid points too.
    #[default]
    Certified,
    /// [`JerkLimited`]: between the grid points, and jerk.
    JerkLimited,
}

impl SpeedPlanner {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::BothEnds, Self::Published, Self::Reachability, Self::Certified, Self::JerkLimited];

    /// Its name, as the command line knows it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BothEnds => "both-ends",
            Self::Published => "published",
            Self::Reachability => "reachability",
            Self::Certified => "certified",
            Self::JerkLimited => "jerk-limited",
        }
    }

    /// The rows it needs.
    pub const fn needs(self) -> RowsNeeded {
        match self {
            Self::Certified => RowsNeeded::Between,
            Self::JerkLimited => RowsNeeded::Jerk,
            _ => RowsNeeded::Points,
        }
    }
}

/// Whether another planner or grid may do better.
fn is_doubtful<P: SchedulePath<N>, const N: usize>(made: &Result<Schedule<'_, P, N>, PlanError>) -> bool {
    match made {
        Ok(schedule) => crawls(schedule),
        Err(PlanError::Feed(error)) => matches!(
            error,
            FeedError::NotConverged { .. } | FeedError::LengthMismatch { .. } | FeedError::TooMany { .. }
        ),
        Err(_) => false,
    }
}

fn crawls<P: SchedulePath<N>, const N: usize>(schedule: &Schedule<'_, P, N>) -> bool {
    let scan = BothEndsScan.plan(schedule.problem());
    scan.is_ok_and(|scan| schedule.duration() > CRAWLS * scan.duration())
}

/// Which rows a planner needs; each kind includes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RowsNeeded {
    /// Those at the grid points.
    Points,
    /// Those between the grid points.
    Between,
    /// Those on jerk.
    Jerk,
}

impl FeedPlanner for SpeedPlanner {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        match self {
            Self::BothEnds => BothEndsScan.plan(problem),
            Self::Published => PublishedScan.plan(problem),
            Self::Reachability => Reachability.plan(problem),
            Self::Certified => CertifiedReachability.plan(problem),
            Self::JerkLimited => JerkLimited::default().plan(problem),
        }
    }
}

/// Plans the speed along paths of one arm under one set of limits.
#[derive(Clone, Copy)]
pub struct Scheduler<'a, const N: usize = 6> {
    pub(super) arm: &'a dyn ForwardKinematics<N>,
    pub(super) dynamics: Option<&'a dyn Dynamics<N>>,
    pub(super) limits: ScheduleLimits<N>,
    intervals: usize,
    speeds: (f64, f64),
}

impl<const N: usize> std::fmt::Debug for Scheduler<'_, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scheduler")
            .field("limits", &self.limits)
            .field("intervals", &self.intervals)
            .field("speeds", &self.speeds)
            .finish_non_exhaustive()
    }
}

impl<'a, const N: usize> Scheduler<'a, N> {
    /// A scheduler for `arm` from rest to rest, on a grid of 500 intervals.
    ///
    /// # Errors
    /// As [`ScheduleLimits::validate`].
    pub fn new(arm: &'a dyn ForwardKinematics<N>, limits: ScheduleLimits<N>) -> Result<Self, PlanError> {
        limits.validate()?;
        Ok(Self { arm, dynamics: None, limits, intervals: INTERVALS, speeds: (0.0, 0.0) })
    }

    /// With the dynamics that limits on torque are about, payload and friction included.
    pub fn with_dynamics(self, dynamics: &'a dyn Dynamics<N>) -> Self {
        Self { dynamics: Some(dynamics), ..self }
    }

    /// With another grid: about so many intervals, the knots of a spline among its points.
    ///
    /// # Errors
    /// [`PlanError::Intervals`].
    pub fn with_intervals(self, intervals: usize) -> Result<Self, PlanError> {
        if !(4..=MOST_INTERVALS).contains(&intervals) {
            return Err(PlanError::Intervals { intervals, most: MOST_INTERVALS });
        }
        Ok(Self { intervals, ..self })
    }

    /// With speeds at start and end, in units of the path's parameter per s.
    ///
    /// # Errors
    /// [`PlanError::Feed`] for what is no speed.
    pub fn with_end_speeds(self, start: f64, end: f64) -> Result<Self, PlanError> {
        for (what, value) in [("start speed", start), ("end speed", end)] {
            if !value.is_finite() {
                return Err(FeedError::NotFinite { what, value }.into());
            }
            if value < 0.0 {
                return Err(FeedError::Negative { what, value }.into());
            }
        }
        Ok(Self { speeds: (start, end), ..self })
    }

    /// The limits.
    pub fn limits(&self) -> &ScheduleLimits<N> {
        &self.limits
    }

    /// The fastest motion along `path` that `planner` finds. Where the jerk-limited planner finds none, or takes many
    /// times as long as the scan without jerk does, it gets other grids, of up to four times the intervals; where that does not
    /// help, the joined scan makes the motion, and [`Schedule::fallback`] says so.
    ///
    /// # Errors
    /// [`PlanError::OnPath`] where the arm cannot follow, [`PlanError::Feed`] naming place, joint and row where no motion
    /// keeps the limits, [`PlanError::Missing`].
    pub fn plan<'p, P>(&self, path: &'p P, planner: SpeedPlanner) -> Result<Schedule<'p, P, N>, PlanError>
    where
        'a: 'p,
        P: SchedulePath<N>,
    {
        if planner != SpeedPlanner::JerkLimited {
            return self.plan_with(path, &planner, planner.needs());
        }
        let n = self.intervals;
        let mut best: Result<Schedule<'p, P, N>, PlanError> = self.plan_with(path, &planner, planner.needs());
        for intervals in [n + 1, 2 * n, 2 * n + 1, 4 * n].into_iter().filter(|n| *n <= MOST_AGAIN) {
            if !is_doubtful(&best) {
                break;
            }
            let other = Self { intervals, ..*self }.plan_with(path, &planner, planner.needs());
            let faster = match (&other, &best) {
                (Ok(other), Ok(best)) => other.duration() < best.duration(),
                (other, best) => other.is_ok() && best.is_err(),
            };
            if faster {
                best = other;
            }
        }
        if is_doubtful(&best) { self.joined(path, best) } else { best }
    }

    /// The joined scan's motion, where it is faster than the jerk-limited planner's or that planner has none.
    fn joined<'p, P>(
        &self,
        path: &'p P,
        limited: Result<Schedule<'p, P, N>, PlanError>,
    ) -> Result<Schedule<'p, P, N>, PlanError>
    where
        'a: 'p,
        P: SchedulePath<N>,
    {
        match (self.plan_with(path, &ContinuousAccelerationScan, RowsNeeded::Jerk), limited) {
            (Ok(joined), Ok(limited)) if joined.duration() < limited.duration() => {
                Ok(joined.instead(Fallback::Slower { duration: limited.duration() }))
            }
            (Ok(joined), Err(PlanError::Feed(error))) => Ok(joined.instead(Fallback::Failed(error))),
            (_, limited) => limited,
        }
    }

    /// As [`Scheduler::plan`], with a planner of the caller's own and the rows it needs.
    ///
    /// # Errors
    /// As [`Scheduler::plan`].
    pub fn plan_with<'p, P>(
        &self,
        path: &'p P,
        planner: &dyn FeedPlanner,
        needed: RowsNeeded,
    ) -> Result<Schedule<'p, P, N>, PlanError>
    where
        'a: 'p,
        P: SchedulePath<N>,
    {
        let begin = Instant::now();
        let samples = self.samples(path, needed)?;
        let following = begin.elapsed();
        let problem = self.problem_on(&samples, needed)?;
        let plan = planner.plan(&problem)?;
        let planning = begin.elapsed() - following;
        Ok(Schedule::new(*self, path, samples.points, problem, plan, [following, planning]))
    }

    /// The rows along `path`, for a planner of the caller's own.
    ///
    /// # Errors
    /// As [`Scheduler::plan`].
    pub fn problem(&self, path: &impl SchedulePath<N>, needed: RowsNeeded) -> Result<FeedProblem, PlanError> {
        self.problem_on(&self.samples(path, needed)?, needed)
    }

    fn samples(&self, path: &impl SchedulePath<N>, needed: RowsNeeded) -> Result<PathSamples<N>, PlanError> {
        if needed == RowsNeeded::Jerk && self.limits.jerk.is_none() {
            return Err(PlanError::Missing {
                needed: "a jerk limit of the joints",
                purpose: "a planner that limits jerk",
                remedy: "give one, or take another planner",
            });
        }
        let dynamics = match (self.limits.torque, self.dynamics) {
            (Some(_), None) => {
                return Err(PlanError::Missing {
                    needed: "the dynamics of the arm",
                    purpose: "limits on torque",
                    remedy: "give masses and inertias of the links, or drop the limits on torque",
                });
            }
            (limits, dynamics) => limits.and(dynamics),
        };
        let tool = self.limits.linear_speed.or(self.limits.angular_speed).map(|_| self.arm);
        PathSamples::follow(path, self.intervals, Wanted { dynamics, tool, middles: needed > RowsNeeded::Points })
    }

    fn problem_on(&self, samples: &PathSamples<N>, needed: RowsNeeded) -> Result<FeedProblem, PlanError> {
        let limits = &self.limits;
        let between = needed > RowsNeeded::Points;
        let [first, second, third] = &samples.after;
        let mut path = PathDerivatives::new(N, first, second)?;
        if between {
            path = path
                .with_third(third)?
                .with_values_before(&[], &[], &samples.third_before)?
                .with_middles(&samples.middle[0], &samples.middle[1])?;
        }
        let slice = |limits: &'_ Option<Joints<N>>| limits.unwrap_or(Joints::repeat(f64::INFINITY));
        let (velocities, accelerations, jerks) =
            (slice(&limits.velocity), slice(&limits.acceleration), slice(&limits.jerk));
        let velocity = JointVelocity::new(path, velocities.as_slice())?;
        let acceleration = JointAcceleration::new(path, accelerations.as_slice())?;
        let mut constraints: Vec<&dyn PathConstraint> = Vec::with_capacity(6);
        if limits.velocity.is_some() {
            constraints.push(&velocity);
        }
        if limits.acceleration.is_some() {
            constraints.push(&acceleration);
        }
        let torque = limits.torque.map(|limits| TorqueRows { samples, limits });
        constraints.extend(torque.as_ref().map(|rows| rows as &dyn PathConstraint));
        let tool = |limit: Option<f64>, quantity| limit.map(|limit| ToolSpeed { samples, limit, quantity });
        let (linear, angular) =
            (tool(limits.linear_speed, Quantity::LinearSpeed), tool(limits.angular_speed, Quantity::AngularSpeed));
        constraints.extend(linear.iter().chain(&angular).map(|rows| rows as &dyn PathConstraint));
        let jerk = match needed {
            RowsNeeded::Jerk => Some(JointJerk::new(path, jerks.as_slice())?),
            _ => None,
        };
        constraints.extend(jerk.as_ref().map(|rows| rows as &dyn PathConstraint));
        let problem = if between {
            FeedProblem::between_points(&samples.s, &constraints)?
        } else {
            FeedProblem::at_points(&samples.s, &constraints)?
        };
        Ok(problem.with_end_speeds(self.speeds.0, self.speeds.1)?)
    }
}
