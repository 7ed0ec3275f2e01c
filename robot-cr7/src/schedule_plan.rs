//! Speed along a path, planned until the limits hold between the grid points, too.

use arcfeed_feedrate::{Quantity, RowSource};
use arcfeed_interp::{
    LimitUse, PlanError, Schedule, ScheduleCheck, ScheduleLimits, ScheduleParameter, SchedulePath, Scheduler,
    SpeedPlanner,
};
use arcfeed_kinematics::{Arm, ArmDynamics};

use crate::report::{LimitLine, LimitUnit, number};
use crate::verdict::TOLERANCE;

/// Dense samples of the check in every interval of the grid, at the least.
const LEAST_DENSITY: usize = 20;
/// And so many in a control period.
const PER_PERIOD: f64 = 8.0;
/// But no more than this in all, unless the least density takes them.
const MOST_CHECKED: f64 = 1e6;

/// Rounds of planning.
const ROUNDS: usize = 12;
/// A limit that is exceeded by more than this, relative to it, asks for a finer grid; by less, for a lower limit.
const COARSE: f64 = 1e-4;
/// A finer grid has this many times the intervals, and no more than that many.
const FINER: usize = 4;
const FINEST: usize = 4_000;
/// By how much more a limit is lowered than it was exceeded.
const MARGIN: f64 = 2e-7;

/// What is planned, but for the path.
pub(crate) struct SpeedTask<'a, const N: usize> {
    pub arm: &'a Arm<N>,
    pub dynamics: Option<&'a ArmDynamics<N>>,
    pub limits: ScheduleLimits<N>,
    pub intervals: usize,
    /// At start and end, in units of the parameter per s.
    pub speeds: [f64; 2],
    pub planner: SpeedPlanner,
    /// Control period, s.
    pub period: f64,
}

/// A schedule with its check.
pub(crate) struct CheckedSchedule<'p, P, const N: usize> {
    pub schedule: Schedule<'p, P, N>,
    /// Against the limits it was planned with.
    pub check: ScheduleCheck,
    /// Against the limits that were asked for.
    pub limits: Vec<LimitLine>,
    /// What was done to make them hold.
    pub notes: Vec<String>,
}

impl<'a, const N: usize> SpeedTask<'a, N> {
    /// The schedule along `path`. Rows at grid points say nothing of what lies between them: where a limit is exceeded there,
    /// the motion is planned again, on finer grids and then with the limit lowered by the excess. What exceeds a limit after
    /// the last round is returned all the same, with its check.
    pub fn plan<'p, P>(&self, path: &'p P) -> Result<CheckedSchedule<'p, P, N>, PlanError>
    where
        'a: 'p,
        P: SchedulePath<N>,
    {
        let (mut intervals, mut limits) = (self.intervals, self.limits);
        let mut last = self.round(path, intervals, limits)?;
        for round in 2..=ROUNDS {
            let excess = last.limits.iter().map(|line| line.ratio).fold(0.0, f64::max) - 1.0;
            // The published scan stands for comparison, as it is.
            if excess <= 0.5 * TOLERANCE || self.planner == SpeedPlanner::Published {
                break;
            }
            if excess > COARSE && intervals * FINER <= FINEST {
                intervals *= FINER;
            } else {
                for used in &last.check.uses {
                    let ratio = used.value.abs() / limit_of(&self.limits, used.source);
                    if ratio > 1.0 + 0.5 * TOLERANCE {
                        lower(&mut limits, used.source, 1.0 / (ratio + MARGIN));
                    }
                }
            }
            // A speed at an end may go with the limits that were asked for and with none below.
            let Ok(next) = self.round(path, intervals, limits) else { break };
            last = next;
            last.notes = self.notes(round, intervals, &limits);
        }
        Ok(last)
    }

    fn round<'p, P>(
        &self,
        path: &'p P,
        intervals: usize,
        limits: ScheduleLimits<N>,
    ) -> Result<CheckedSchedule<'p, P, N>, PlanError>
    where
        'a: 'p,
        P: SchedulePath<N>,
    {
        let [start, end] = self.speeds;
        let mut scheduler = Scheduler::new(self.arm, limits)?.with_intervals(intervals)?.with_end_speeds(start, end)?;
        if let Some(dynamics) = self.dynamics {
            scheduler = scheduler.with_dynamics(dynamics);
        }
        let schedule = scheduler.plan(path, self.planner)?;
        let check = schedule.check(density(schedule.duration() / self.period, schedule.problem().intervals()))?;
        let limits = limit_lines(&check, &self.limits, path.parameter());
        Ok(CheckedSchedule { schedule, check, limits, notes: Vec::new() })
    }

    fn notes(&self, rounds: usize, intervals: usize, planned: &ScheduleLimits<N>) -> Vec<String> {
        let mut words = format!("planned {rounds} times, so that the limits hold between the grid points");
        if intervals != self.intervals {
            words += &format!("; intervals raised from {} to {intervals}", self.intervals);
        }
        let kinds = [Quantity::JointVelocity, Quantity::JointAcceleration, Quantity::JointJerk, Quantity::JointTorque];
        let joints = kinds.into_iter().flat_map(|kind| (0..N).map(move |j| RowSource::joint(kind, j)));
        let tool = [Quantity::LinearSpeed, Quantity::AngularSpeed].map(RowSource::path);
        for source in joints.chain(tool) {
            let share = limit_of(planned, source) / limit_of(&self.limits, source);
            if share < 1.0 {
                words += &format!("; {source} lowered by {} %", number(100.0 * (1.0 - share)));
            }
        }
        vec![words]
    }
}

/// Samples in every interval of a grid, for a motion of so many control periods.
fn density(periods: f64, intervals: usize) -> usize {
    let wanted = (PER_PERIOD * periods).min(MOST_CHECKED) / intervals.max(1) as f64;
    (wanted.ceil() as usize).max(LEAST_DENSITY)
}

/// The limit of one kind; infinite where there is none.
fn limit_of<const N: usize>(limits: &ScheduleLimits<N>, source: RowSource) -> f64 {
    let joint = |values: Option<arcfeed_kinematics::Joints<N>>| {
        values.zip(source.joint).and_then(|(values, j)| values.get(usize::from(j)).copied())
    };
    let limit = match source.quantity {
        Quantity::JointVelocity => joint(limits.velocity),
        Quantity::JointAcceleration => joint(limits.acceleration),
        Quantity::JointJerk => joint(limits.jerk),
        Quantity::JointTorque => joint(limits.torque),
        Quantity::LinearSpeed => limits.linear_speed,
        Quantity::AngularSpeed => limits.angular_speed,
        _ => None,
    };
    limit.unwrap_or(f64::INFINITY)
}

/// Lowers the limit of one kind by a factor.
fn lower<const N: usize>(limits: &mut ScheduleLimits<N>, source: RowSource, factor: f64) {
    let joints = match source.quantity {
        Quantity::JointVelocity => &mut limits.velocity,
        Quantity::JointAcceleration => &mut limits.acceleration,
        Quantity::JointJerk => &mut limits.jerk,
        Quantity::JointTorque => &mut limits.torque,
        Quantity::LinearSpeed => return limits.linear_speed.iter_mut().for_each(|limit| *limit *= factor),
        _ => return limits.angular_speed.iter_mut().for_each(|limit| *limit *= factor),
    };
    if let (Some(values), Some(j)) = (joints, source.joint)
        && let Some(limit) = values.get_mut(usize::from(j))
    {
        *limit *= factor;
    }
}

/// The uses of a check as lines, each against the limit that was asked for.
fn limit_lines<const N: usize>(
    check: &ScheduleCheck,
    asked: &ScheduleLimits<N>,
    parameter: ScheduleParameter,
) -> Vec<LimitLine> {
    let line = |u: &LimitUse| {
        let (name, unit) = match u.source.quantity {
            Quantity::JointVelocity => ("joint velocity", LimitUnit::RadianPerSecond),
            Quantity::JointAcceleration => ("joint acceleration", LimitUnit::RadianPerSecond2),
            Quantity::JointJerk => ("joint jerk", LimitUnit::RadianPerSecond3),
            Quantity::JointTorque => ("joint torque", LimitUnit::NewtonMetre),
            Quantity::LinearSpeed => ("linear speed of the tool", LimitUnit::MetrePerSecond),
            _ => ("angular speed of the tool", LimitUnit::RadianPerSecond),
        };
        LimitLine {
            name: name.to_owned(),
            joint: u.source.joint.map(|j| usize::from(j) + 1),
            unit,
            value: u.value,
            limit: limit_of(asked, u.source),
            ratio: u.value.abs() / limit_of(asked, u.source),
            at_s_m: (parameter == ScheduleParameter::ArcLength).then_some(u.s),
            at_t_s: u.t,
        }
    };
    check.uses.iter().map(line).collect()
}
