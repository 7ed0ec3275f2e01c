//! A scheduled motion: its law, its setpoints, the limit curve it runs under.

use std::time::Duration;

use arcfeed_feedrate::{Cursor, Fallback, FeedProblem, MotionState, Row, RowSource, SpeedLaw};
use arcfeed_kinematics::{Dynamics, ForwardKinematics, Joints};

use super::scheduler::Scheduler;
use super::{ScheduleLimits, SchedulePath};
use crate::error::PlanError;
use crate::joint_path::JointJet;
use crate::limits::positive;
use crate::trajectory::Setpoint;

/// A motion along a path `P`, planned and ready to be sampled.
#[derive(Debug, Clone)]
pub struct Schedule<'p, P: ?Sized, const N: usize = 6> {
    scheduler: Scheduler<'p, N>,
    path: &'p P,
    nodes: Vec<JointJet<N>>,
    problem: FeedProblem,
    plan: SpeedLaw,
    times: [Duration; 2],
    fallback: Option<Fallback>,
}

/// The greatest speed at a place of the path, and the limit that sets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitPoint {
    /// Value of the parameter.
    pub s: f64,
    /// Speed, units of the parameter per s; infinite where nothing bounds it.
    pub speed: f64,
    /// Which limit; none where nothing bounds it.
    pub source: Option<RowSource>,
}

impl<'p, P: SchedulePath<N> + ?Sized, const N: usize> Schedule<'p, P, N> {
    pub(super) fn new(
        scheduler: Scheduler<'p, N>,
        path: &'p P,
        nodes: Vec<JointJet<N>>,
        problem: FeedProblem,
        plan: SpeedLaw,
        times: [Duration; 2],
    ) -> Self {
        Self { scheduler, path, nodes, problem, plan, times, fallback: None }
    }

    /// As the joined scan's motion in place of the jerk-limited planner's.
    pub(super) fn instead(self, why: Fallback) -> Self {
        Self { fallback: Some(why), ..self }
    }

    /// Why the motion is the joined scan's though the jerk-limited planner was asked for; `None` where the planner that was
    /// asked for made it.
    pub fn fallback(&self) -> Option<Fallback> {
        self.fallback
    }

    /// The path.
    pub fn path(&self) -> &'p P {
        self.path
    }

    /// The limits it was planned under.
    pub fn limits(&self) -> &ScheduleLimits<N> {
        &self.scheduler.limits
    }

    /// The motion law s(t), with the planner's own interpolation.
    pub fn law(&self) -> &SpeedLaw {
        &self.plan
    }

    /// The rows that the planner was given.
    pub fn problem(&self) -> &FeedProblem {
        &self.problem
    }

    /// Joint values and derivatives at the grid points.
    pub fn nodes(&self) -> &[JointJet<N>] {
        &self.nodes
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.plan.duration()
    }

    /// Time spent on following the path (inverse kinematics, dynamics), and on rows and speed.
    pub fn timings(&self) -> [Duration; 2] {
        self.times
    }

    /// The initial velocity limit (Electronics 2025, 14, 3869, eq. 16) at every grid point: the greatest speed up to which
    /// all limits hold while it stays constant. The scans keep below it; reachability may pass it where it accelerates.
    pub fn initial_velocity_limit(&self) -> impl ExactSizeIterator<Item = LimitPoint> + '_ {
        (0..self.nodes.len()).map(|i| {
            let (x_max, cap) = self.problem.cap(i);
            let mut limit = (x_max.sqrt(), x_max.is_finite().then_some(cap));
            for row in self.problem.rows(i) {
                let speed = greatest_constant(row);
                if speed < limit.0 {
                    limit = (speed, Some(row.source));
                }
            }
            LimitPoint { s: self.nodes[i].s, speed: limit.0, source: limit.1 }
        })
    }

    /// The maximum velocity curve at every grid point: the greatest speed, from the planned one upwards, for which some
    /// acceleration keeps all limits.
    pub fn maximum_velocity_curve(&self) -> impl ExactSizeIterator<Item = LimitPoint> + '_ {
        (0..self.nodes.len()).map(|i| {
            let s = self.nodes[i].s;
            let (x_max, cap) = self.problem.cap(i);
            let rows = self.problem.rows(i);
            let blocked = |v: f64| first_conflict(rows, v * v);
            let planned = self.plan.at_position(s).v;
            let top = x_max.sqrt();
            let mut high = if top.is_finite() { top } else { 1e6 * planned.max(1e-3) };
            let Some(mut source) = blocked(high) else {
                return LimitPoint { s, speed: top, source: x_max.is_finite().then_some(cap) };
            };
            let mut low = planned.min(high);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                match blocked(middle) {
                    Some(row) => (high, source) = (middle, row),
                    None => low = middle,
                }
            }
            LimitPoint { s, speed: low, source: Some(source) }
        })
    }

    /// Setpoints at the control `period`, s; one exactly at the end.
    ///
    /// # Errors
    /// [`PlanError::Limit`] when the period is not a finite number above 0.
    pub fn sampler(&self, period: f64) -> Result<ScheduleSampler<'_, 'p, P, N>, PlanError> {
        positive("control period", period)?;
        let cycles = (self.duration() / period * (1.0 - 1e-12)).floor();
        Ok(ScheduleSampler {
            schedule: self,
            cursor: self.plan.cursor(),
            last: self.nodes[0],
            period,
            cycle: 0,
            // More than can be counted is more than can be sampled.
            cycles: cycles as usize + 1,
        })
    }

    /// Torques of the drives at a setpoint, N m; none without dynamics. At a stop friction is taken in the direction of the
    /// motion before or after it, where in truth it may be anything between that and its opposite.
    pub fn torque(&self, at: &Setpoint<N>) -> Option<Joints<N>> {
        let dynamics = self.dynamics()?;
        if at.feed > 0.0 {
            return Some(dynamics.torque(&at.q, &at.qd, &at.qdd));
        }
        let i = self.nodes.partition_point(|jet| jet.s < at.s).min(self.nodes.len() - 1);
        Some(dynamics.torque(&at.q, &creeping(&self.nodes[i].d1), &at.qdd))
    }

    pub(super) fn dynamics(&self) -> Option<&'p dyn Dynamics<N>> {
        self.scheduler.dynamics
    }

    pub(super) fn arm(&self) -> &'p dyn ForwardKinematics<N> {
        self.scheduler.arm
    }
}

/// Joint velocities that have a direction and no size.
pub(super) fn creeping<const N: usize>(d1: &Joints<N>) -> Joints<N> {
    d1 * f64::MIN_POSITIVE.sqrt()
}

/// The greatest speed up to which a row holds at constant speed; 0 where it does not hold at rest.
fn greatest_constant(row: &Row) -> f64 {
    let root = |limit: f64| {
        // b v^2 + c v = r from v = 0 on, without cancellation.
        let r = limit - row.d;
        if row.b == 0.0 {
            return r / row.c;
        }
        let square = row.c * row.c + 4.0 * row.b * r;
        if square < 0.0 {
            return f64::INFINITY;
        }
        let q = -0.5 * (row.c + square.sqrt().copysign(row.c));
        [q / row.b, -r / q].into_iter().filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min)
    };
    if row.excess(0.0, 0.0) > 0.0 {
        return 0.0;
    }
    [row.lo, row.hi].into_iter().filter(|l| l.is_finite()).map(root).filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min)
}

/// A row that no acceleration keeps at the squared speed `x` together with the others.
fn first_conflict(rows: &[Row], x: f64) -> Option<RowSource> {
    let (mut least, mut most) = ((f64::NEG_INFINITY, None), (f64::INFINITY, None));
    for row in rows {
        let rest = row.value(0.0, x);
        if row.a == 0.0 {
            if row.excess(0.0, x) > 0.0 {
                return Some(row.source);
            }
            continue;
        }
        let (a, b) = ((row.lo - rest) / row.a, (row.hi - rest) / row.a);
        if a.min(b) > least.0 {
            least = (a.min(b), Some(row.source));
        }
        if a.max(b) < most.0 {
            most = (a.max(b), Some(row.source));
        }
    }
    if least.0 <= most.0 { None } else { least.1.or(most.1) }
}

/// Yields the setpoints of a schedule, one per control period and one exactly at the end. Allocates nothing.
///
/// In a [`Setpoint`] of a schedule `s`, `feed` and `acceleration` are in the unit of the path's parameter.
#[derive(Debug, Clone)]
pub struct ScheduleSampler<'s, 'p, P: ?Sized, const N: usize> {
    schedule: &'s Schedule<'p, P, N>,
    cursor: Cursor<'s>,
    last: JointJet<N>,
    period: f64,
    cycle: usize,
    cycles: usize,
}

impl<P: SchedulePath<N> + ?Sized, const N: usize> ScheduleSampler<'_, '_, P, N> {
    /// Number of setpoints in all, both ends included.
    pub fn samples(&self) -> usize {
        self.cycles.saturating_add(1)
    }

    /// The setpoint at any time `t`, s (taken to the nearest end of the motion). Times far from the last one may lead
    /// the inverse kinematics to another branch: go in steps.
    ///
    /// # Errors
    /// [`PlanError::OnPath`] where the arm cannot stand.
    pub fn at(&mut self, t: f64) -> Result<Setpoint<N>, PlanError> {
        let state = self.cursor.at(t);
        let jet = self.schedule.path.jet(state.p, &self.last.ahead(state.p - self.last.s))?;
        self.last = jet;
        Ok(setpoint(t, &state, &jet, self.schedule.arm()))
    }
}

/// What the joints do in the state of motion `state` on the path.
pub(super) fn setpoint<const N: usize>(
    t: f64,
    state: &MotionState,
    jet: &JointJet<N>,
    arm: &dyn ForwardKinematics<N>,
) -> Setpoint<N> {
    let (v, a, j) = (state.v, state.a, state.j);
    Setpoint {
        t,
        s: state.p,
        feed: v,
        acceleration: a,
        q: jet.q,
        qd: jet.d1 * v,
        qdd: jet.d1 * a + jet.d2 * (v * v),
        jerk: jet.d1 * j + jet.d2 * (3.0 * v * a) + jet.d3 * (v * v * v),
        pose: arm.forward(&jet.q),
    }
}

impl<P: SchedulePath<N> + ?Sized, const N: usize> Iterator for ScheduleSampler<'_, '_, P, N> {
    type Item = Result<Setpoint<N>, PlanError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.cycle > self.cycles {
            return None;
        }
        let end = self.cycle == self.cycles;
        let t = if end { self.schedule.duration() } else { self.cycle as f64 * self.period };
        self.cycle += 1;
        Some(self.at(t))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let rest = self.samples().saturating_sub(self.cycle);
        (rest, Some(rest))
    }
}
