//! A planned and verified motion: where, how fast, with which joints, and who planned it.

use std::fmt;
use std::time::Duration;

use arcfeed_feedrate::{Cursor, Fallback, FeedProblem, LimitId, LowerBound, Quantity, Row, SpeedLaw};
use arcfeed_geometry::Segmentation;
use arcfeed_kinematics::Joints;

use crate::error::{LimitError, PlanError, SpeedError, positive};
use crate::limits::{Limits, Section};
use crate::method::Method;
use crate::path::{JointJet, JointPath, MotionPath};
use crate::problem::{PathProblem, RowsNeeded};
use crate::setpoint::{Setpoint, SetpointTimes};
use crate::verify::Verification;

/// Who planned a motion, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanInfo {
    /// The planner whose law it is; `None` for a law from elsewhere.
    pub method: Option<Method>,
    /// Why it is not the jerk-limited planner's; `None` where it is, or where another one was asked for.
    pub fallback: Option<Fallback>,
    /// The number of planning rounds until the verification passed.
    pub rounds: usize,
    /// Intervals of the grid.
    pub intervals: usize,
    /// The windows in which the speed was planned; `None` where the whole path was planned at once.
    pub windows: Option<PlanWindows>,
    /// Into how many parts intervals were divided, at the most, for the sake of the limits between their points; 1 for none.
    pub refined: usize,
    /// Limits that the last round planned with less of, and the fraction where it is least: what was exceeded between the points of the
    /// grid.
    pub lowered: Vec<(LimitId, f64)>,
    /// The fraction of every limit that the last round planned with, beside those; 1 unless a limit was far exceeded where the grid sees
    /// too little.
    pub slowed: f64,
    /// The part of the speed that the motion of the last round was slowed down to as a whole, because it exceeded a limit slightly: 1
    /// unless that happened in a late round or on a large grid.
    pub slower: f64,
}

/// The windows in which the speed along a long path was planned.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanWindows {
    /// Intervals of a window.
    pub intervals: usize,
    /// Number of windows.
    pub count: usize,
    /// Values of the parameter at which the motion rests although the path does not ask for it: no motion was found that goes on there.
    pub stops: Vec<f64>,
}

impl fmt::Display for PlanWindows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} windows of {} intervals", self.count, self.intervals)?;
        match self.stops.len() {
            0 => Ok(()),
            stops => write!(f, ", with rest at {stops} places that the path does not ask for"),
        }
    }
}

impl fmt::Display for PlanInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.method {
            Some(method) => write!(f, "{method}")?,
            None => f.write_str("given law")?,
        }
        if let Some(windows) = &self.windows {
            write!(f, " in {windows}")?;
        }
        match &self.fallback {
            Some(reason) => write!(f, " instead of jerk-limited: {reason}"),
            None => Ok(()),
        }
    }
}

/// The times of the parts of planning.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timings {
    /// Cutting the path into chord segments and laying the grid.
    pub grid: Duration,
    /// Inverse kinematics and derivatives along the path.
    pub joint_path: Duration,
    /// Rows and speed.
    pub speed: Duration,
    /// Verification on dense samples.
    pub verification: Duration,
}

impl Timings {
    /// All but the verification.
    pub fn planning(&self) -> Duration {
        self.grid + self.joint_path + self.speed
    }
}

/// The greatest speed at a place of the path, and the limit that sets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitPoint {
    /// Value of the parameter.
    pub s: f64,
    /// Speed, units of the parameter per s; infinite where nothing bounds it.
    pub speed: f64,
    /// Which limit; none where nothing bounds it.
    pub id: Option<LimitId>,
}

/// A motion along a path that was planned and verified: it keeps every limit it was planned for.
///
/// It knows its path and its arm. [`Trajectory::setpoints`] yields what a controller takes.
#[derive(Debug, Clone)]
pub struct Trajectory<'p, const N: usize = 6> {
    problem: PathProblem<'p, N>,
    law: SpeedLaw,
    info: PlanInfo,
    verification: Verification,
    timings: Timings,
}

impl<'p, const N: usize> Trajectory<'p, N> {
    pub(crate) fn new(
        problem: PathProblem<'p, N>,
        law: SpeedLaw,
        info: PlanInfo,
        verification: Verification,
        timings: Timings,
    ) -> Self {
        Self { problem, law, info, verification, timings }
    }

    pub(crate) fn into_problem(self) -> PathProblem<'p, N> {
        self.problem
    }

    /// The path.
    pub fn path(&self) -> &(dyn MotionPath<N> + 'p) {
        self.problem.path()
    }

    /// The path on its grid with its limits.
    pub fn problem(&self) -> &PathProblem<'p, N> {
        &self.problem
    }

    /// Joint values and derivatives on the planning grid.
    pub fn joint_path(&self) -> &JointPath<N> {
        self.problem.joint_path()
    }

    /// The limits it keeps.
    pub fn limits(&self) -> &Limits<'p, N> {
        self.problem.limits()
    }

    /// The chord segments of a curve of the tool, by its own parameter; none for other paths.
    pub fn segmentation(&self) -> Option<&Segmentation> {
        self.problem.segmentation()
    }

    /// Arc lengths where the chord segments begin and end, m.
    pub fn breaks(&self) -> &[f64] {
        self.problem.breaks()
    }

    /// Values of the parameter at the corners inside the path, where the motion stops.
    pub fn stops(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.problem.stops()
    }

    /// Sections with a feed of their own, in their order on the path.
    pub fn sections(&self) -> &[Section] {
        self.problem.sections()
    }

    /// The motion law s(t).
    pub fn law(&self) -> &SpeedLaw {
        &self.law
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.law.duration()
    }

    /// Which planner made the motion law, and how.
    pub fn info(&self) -> &PlanInfo {
        &self.info
    }

    /// Speeds at the start and at the end of the path that were asked for, units of the parameter per s.
    pub fn end_speeds(&self) -> [f64; 2] {
        self.problem.settings.ends
    }

    /// Chord tolerance that was planned for, m.
    pub fn chord_tolerance(&self) -> f64 {
        self.problem.settings.chord_tolerance
    }

    /// Control period that was planned for, s.
    pub fn period(&self) -> f64 {
        self.problem.settings.period
    }

    /// The verification that it passed.
    pub fn verification(&self) -> &Verification {
        &self.verification
    }

    /// A duration that no motion along the path beats that keeps the same limits, of those on the grid of the plan.
    ///
    /// Takes a few to forty times as long as the plan; see [`LowerBound`] for what it covers. Chord error, sections and speeds at the ends
    /// are part of it. Of limits by tables and on the magnitude of the tool's acceleration and jerk, what their rows state counts: that is
    /// all of a table that is concave in the speed (for jerk: in the squared speed), else less, and 96.6 % of a magnitude at the least.
    ///
    /// # Errors
    /// [`SpeedError::Feed`] where the planner is not one that limits jerk, or no bound is found.
    pub fn lower_bound(&self) -> Result<LowerBound, SpeedError> {
        let rows = self.problem.rows(RowsNeeded::Jerk)?;
        LowerBound::new(&rows, &self.law).map_err(|error| self.problem.explained(error))
    }

    /// The times of the parts of planning.
    pub fn timings(&self) -> Timings {
        self.timings
    }

    /// Setpoints at the control `period`, s, and one exactly at the end.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`] when the period is not a finite number above 0.
    pub fn setpoints(&self, period: f64) -> Result<Setpoints<'_, 'p, N>, LimitError> {
        Setpoints::new(&self.problem, &self.law, period)
    }

    /// Torques of the drives at a setpoint, N m; `None` where no torque is limited. At a stop friction is taken in the direction of
    /// the motion before or after it, where in truth it may be anything between that and its opposite.
    pub fn torque(&self, at: &Setpoint<N>) -> Option<Joints<N>> {
        self.problem.torque_at(at)
    }

    /// The highest speed that caps allow at every grid point: feed, bends, stops, and with a limit on jerk the steps of acceleration at
    /// jumps of the curvature. Rows are not looked at.
    ///
    /// # Errors
    /// [`SpeedError::Feed`] for numbers that are not finite; after a successful plan that does not happen.
    pub fn limit_curve(&self) -> Result<Vec<LimitPoint>, SpeedError> {
        let rows = self.problem.rows(RowsNeeded::Points)?;
        let with_jerk = self.info.method.is_some_and(Method::limits_jerk);
        let one = |i: usize| {
            let (point, (speed, joint)) = (cap(&rows, i), self.problem.step_speed(i));
            let id = Some(LimitId::joint(Quantity::JointJerk, joint));
            if with_jerk && speed < point.speed { LimitPoint { speed, id, ..point } } else { point }
        };
        Ok((0..rows.grid().len()).map(one).collect())
    }

    /// The initial velocity limit (Electronics 2025, 14, 3869, eq. 16) at every grid point: the greatest speed up to which
    /// all limits hold while it stays constant. The scans keep below it; reachability may pass it where it accelerates.
    ///
    /// # Errors
    /// As [`Trajectory::limit_curve`].
    pub fn initial_velocity_limit(&self) -> Result<Vec<LimitPoint>, SpeedError> {
        self.problem.initial_velocity_limit()
    }

    /// The maximum velocity curve at every grid point: the greatest speed, from the planned one upwards, for which some
    /// acceleration keeps all limits.
    ///
    /// # Errors
    /// As [`Trajectory::limit_curve`].
    pub fn maximum_velocity_curve(&self) -> Result<Vec<LimitPoint>, SpeedError> {
        self.problem.maximum_velocity_curve(&self.law)
    }
}

impl<'p, const N: usize> PathProblem<'p, N> {
    /// As [`Trajectory::initial_velocity_limit`].
    ///
    /// # Errors
    /// As [`PathProblem::rows`].
    pub fn initial_velocity_limit(&self) -> Result<Vec<LimitPoint>, SpeedError> {
        let rows = self.rows(RowsNeeded::Points)?;
        let one = |i: usize| {
            rows.rows(i).iter().fold(cap(&rows, i), |limit, row| {
                let speed = greatest_constant(row);
                if speed < limit.speed { LimitPoint { speed, id: Some(row.source), ..limit } } else { limit }
            })
        };
        Ok((0..rows.grid().len()).map(one).collect())
    }

    /// As [`Trajectory::maximum_velocity_curve`], for the law `law`.
    ///
    /// # Errors
    /// As [`PathProblem::rows`].
    pub fn maximum_velocity_curve(&self, law: &SpeedLaw) -> Result<Vec<LimitPoint>, SpeedError> {
        let rows = self.rows(RowsNeeded::Points)?;
        let one = |i: usize| {
            let top = cap(&rows, i);
            let planned = law.at_position(top.s).v;
            let mut high = if top.speed.is_finite() { top.speed } else { 1e6 * planned.max(1e-3) };
            let blocked = |v: f64| first_conflict(rows.rows(i), v * v);
            let Some(mut id) = blocked(high) else { return top };
            let mut low = planned.min(high);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                match blocked(middle) {
                    Some(row) => (high, id) = (middle, row),
                    None => low = middle,
                }
            }
            LimitPoint { speed: low, id: Some(id), ..top }
        };
        Ok((0..rows.grid().len()).map(one).collect())
    }

    /// Setpoints of the motion by `law`, whoever made it, at the control `period` (s), for pictures and comparisons: nothing has
    /// checked that it keeps a limit. [`Planner::finish`](crate::Planner::finish) makes a verified trajectory of a law.
    ///
    /// # Errors
    /// As [`Trajectory::setpoints`].
    pub fn setpoints<'t>(&'t self, law: &'t SpeedLaw, period: f64) -> Result<Setpoints<'t, 'p, N>, LimitError> {
        Setpoints::new(self, law, period)
    }

    /// As [`Trajectory::torque`].
    pub fn torque_at(&self, at: &Setpoint<N>) -> Option<Joints<N>> {
        let torque = self.settings.limits.torque()?;
        // Joint velocities that have a direction and no size.
        let creeping = || self.joints.near(at.s).d1 * f64::MIN_POSITIVE.sqrt();
        let qd = if at.feed > 0.0 { at.qd } else { creeping() };
        Some(torque.torque(&at.q, &qd, &at.qdd))
    }
}

/// The cap at grid point `i`.
fn cap(rows: &FeedProblem, i: usize) -> LimitPoint {
    let (x_max, id) = rows.cap(i);
    LimitPoint { s: rows.grid()[i], speed: x_max.sqrt(), id: x_max.is_finite().then_some(id) }
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
fn first_conflict(rows: &[Row], x: f64) -> Option<LimitId> {
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

/// Yields the setpoints of a motion, one per control period and one exactly at the end.
///
/// `s(t)` is the law itself, the path at `s` is exact, and joints that come from an inverse are the solution nearest to where the
/// planning grid saw them, so that nothing accumulates. Sampling allocates nothing.
#[derive(Debug, Clone)]
pub struct Setpoints<'t, 'p, const N: usize = 6> {
    problem: &'t PathProblem<'p, N>,
    cursor: Cursor<'t>,
    times: SetpointTimes,
    near: JointJet<N>,
}

impl<'t, 'p, const N: usize> Setpoints<'t, 'p, N> {
    fn new(problem: &'t PathProblem<'p, N>, law: &'t SpeedLaw, period: f64) -> Result<Self, LimitError> {
        positive("control period", period)?;
        let times = SetpointTimes::new(law.duration(), period);
        Ok(Self { problem, cursor: law.cursor(), times, near: problem.joint_path().nodes()[0] })
    }

    /// Number of setpoints in all, both ends included.
    pub fn samples(&self) -> usize {
        self.times.samples()
    }

    /// The setpoint at any time `t`, s (taken to the nearest end of the motion).
    ///
    /// # Errors
    /// [`PlanError::Path`] where the arm cannot stand; after a successful plan that does not happen on its path.
    #[inline]
    pub fn at(&mut self, t: f64) -> Result<Setpoint<N>, PlanError> {
        let state = self.cursor.at(t);
        // A jump in time goes back to the grid for a place to look from.
        // So does one after which the series of the last place is of no use.
        let (h, near) = ((state.p - self.near.s).abs(), &self.near);
        let moved = h * (near.d1.amax() + h * (near.d2.amax() / 2.0 + h * near.d3.amax() / 6.0));
        let far = moved > 0.1;
        let near = if far { self.problem.joint_path().near(state.p) } else { self.near };
        let (setpoint, jet) = self.problem.setpoint(t, &state, &near)?;
        self.near = jet;
        Ok(setpoint)
    }
}

impl<const N: usize> Iterator for Setpoints<'_, '_, N> {
    type Item = Result<Setpoint<N>, PlanError>;

    fn next(&mut self) -> Option<Self::Item> {
        let t = self.times.next()?;
        Some(self.at(t))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.times.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// b v^2 + c v + d is at a limit at the speed, and inside below it.
    #[test]
    fn the_greatest_constant_speed_is_where_a_row_meets_its_limit() {
        let row =
            |b: f64, c: f64, d: f64| Row { a: 1.0, b, c, d, lo: -2.0, hi: 3.0, source: LimitId::path(Quantity::Other) };
        for (b, c, d, expected) in [
            (0.0, 4.0, 1.0, 0.5),
            (0.0, -5.0, 1.0, 0.6),
            (2.0, 0.0, 1.0, 1.0),
            (-3.0, 0.0, 1.0, 1.0),
            (1.0, 1.0, 1.0, 1.0),
            (1.0, -1.0, 1.0, 2.0),
            (0.0, 0.0, 1.0, f64::INFINITY),
            (1.0, 1.0, 3.5, 0.0),
        ] {
            let got = greatest_constant(&row(b, c, d));
            assert!(got == expected || (got - expected).abs() < 1e-15, "{b} {c} {d}: {got}");
        }
    }
}
