//! A path on its grid with everything that its limits are made from: computed once, asked for rows as often as it takes.

use std::ops::RangeInclusive;
use std::sync::Arc;
use std::time::{Duration, Instant};

use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, PathDerivatives, SpeedCap, Stop,
    TangentialAcceleration, TangentialJerk,
};
use arcfeed_feedrate::{FeedError, FeedProblem, Quantity, SpeedLaw};
use arcfeed_geometry::Segmentation;
use arcfeed_kinematics::Joints;

use super::bounds::{BendLimits, DerivativeBounds};
use super::fractions::LimitFractions;
use super::grid;
use super::jumps::{Jump, jumps};
use super::needs::RowsNeeded;
use super::path_grid::PathGrid;
use super::settings::Settings;
use super::tool_speed::ToolRates;
use super::torque::TorquePath;
use crate::error::{LimitError, PlanError, SpeedError};
use crate::limits::{Feeds, Limits, Section};
use crate::path::{JointJet, JointPath, MotionPath};
use crate::place::PathParameter;

/// Part of the joints' jerk along a curve of the tool that is left for what three places of an interval do not tell of the rest of
/// it: so much less than the grid costs that it does not show, and a second round of planning is seldom needed.
const BETWEEN: f64 = 2e-4;

/// A path that a planner borrows or shares.
#[derive(Debug, Clone)]
pub(crate) enum Held<'p, const N: usize> {
    Borrowed(&'p dyn MotionPath<N>),
    Shared(Arc<dyn MotionPath<N> + 'p>),
}

impl<'p, const N: usize> Held<'p, N> {
    pub fn get(&self) -> &(dyn MotionPath<N> + 'p) {
        match self {
            Self::Borrowed(path) => *path,
            Self::Shared(path) => &**path,
        }
    }
}

/// A path on its grid, followed by the arm, with all that its limits are made from. [`Planner::prepare`](crate::Planner::prepare)
/// makes one.
///
/// Nothing here depends on the planner of the speed: [`PathProblem::rows`] are what any
/// [`FeedPlanner`](arcfeed_feedrate::FeedPlanner) takes, and [`Planner::finish`](crate::Planner::finish) makes a verified trajectory
/// of its law.
#[derive(Debug, Clone)]
pub struct PathProblem<'p, const N: usize = 6> {
    pub(crate) settings: Settings<'p, N>,
    pub(crate) path: Held<'p, N>,
    pub(crate) layout: PathGrid,
    pub(crate) joints: JointPath<N>,
    stops: Vec<usize>,
    /// Programmed feed on every interval, m/s; empty where there is none.
    feeds: Vec<f64>,
    /// Derivatives of the joints by the parameter, joint by joint: just after every grid point, just before it, in the middle of every
    /// interval; first, second, third.
    after: [Vec<f64>; 3],
    before: [Vec<f64>; 3],
    middle: [Vec<f64>; 3],
    /// Joints in the middle of every interval, where they were asked for.
    middles: Vec<JointJet<N>>,
    bounds: DerivativeBounds<N>,
    tool_rates: Option<ToolRates>,
    torque: Option<TorquePath<N>>,
    needs: RowsNeeded,
    times: [Duration; 2],
}

impl<'p, const N: usize> PathProblem<'p, N> {
    /// Lays a grid over `path` and follows it.
    pub(crate) fn new(
        settings: &Settings<'p, N>,
        path: Held<'p, N>,
        needs: RowsNeeded,
        on_breaks: bool,
    ) -> Result<Self, PlanError> {
        let begin = Instant::now();
        let layout = PathGrid::lay(settings, path.get(), on_breaks)?;
        let laid = begin.elapsed();
        let mut problem = Self::on(settings, path, layout, needs, None)?;
        problem.times[0] = laid;
        Ok(problem)
    }

    /// The same on a grid whose interval `k` is divided into `parts(k)`.
    pub(crate) fn refined(&self, parts: impl Fn(usize) -> usize) -> Result<Self, PlanError> {
        self.on_grid(grid::refined(&self.layout.grid, parts))
    }

    /// The same on another grid, which keeps the knots of the path.
    pub(crate) fn on_grid(&self, grid: Vec<f64>) -> Result<Self, PlanError> {
        let layout = PathGrid { grid, ..self.layout.clone() };
        // Along a curve of the tool the inverse kinematics take their time: not where the joints are known.
        let known = self.path().tool_curve().map(|_| self);
        let mut problem = Self::on(&self.settings, self.path.clone(), layout, self.needs, known)?;
        problem.times = [self.times[0], self.times[1] + problem.times[1]];
        Ok(problem)
    }

    fn on(
        settings: &Settings<'p, N>,
        path: Held<'p, N>,
        layout: PathGrid,
        needs: RowsNeeded,
        known: Option<&Self>,
    ) -> Result<Self, PlanError> {
        suits(settings, path.get())?;
        let begin = Instant::now();
        let limits = settings.limits.joints();
        let mut joints =
            JointPath::follow_knowing(path.get(), &path.get().start(), &layout.grid, known.map(|known| &known.joints))
                .map_err(|e| e.within(limits.lower(), limits.upper()))?;
        joints.check_range(path.get(), limits.range())?;
        // Along a curve of the tool the grid is fine, and points beside its knots would make intervals of no length.
        if settings.limits.torque().is_some() && path.get().tool_curve().is_none() {
            joints.insert_turning_points(path.get())?;
        }
        let found = jumps_of(settings, path.get(), &layout, &joints);
        let beside: Vec<(usize, f64)> = found.iter().map(|jump| (jump.at, jump.reach)).collect();
        joints.insert_beside(path.get(), &beside)?;
        let mut problem = Self::of(settings, path, layout, joints, needs, known);
        problem.times[1] = begin.elapsed();
        Ok(problem)
    }

    /// With the joints known.
    pub(crate) fn of(
        settings: &Settings<'p, N>,
        path: Held<'p, N>,
        mut layout: PathGrid,
        joints: JointPath<N>,
        needs: RowsNeeded,
        known: Option<&Self>,
    ) -> Self {
        layout.grid = joints.grid().collect();
        let stops = grid::stops(&layout.grid, path.get().corners().iter().copied());
        let feeds = feeds(settings, path.get(), &layout);
        let middles = if needs > RowsNeeded::Points { middles(path.get(), &joints, known) } else { Vec::new() };
        let [after, before] = sides(&joints, &stops);
        let flat = |of: fn(&JointJet<N>) -> &Joints<N>| -> Vec<f64> {
            middles.iter().flat_map(|jet| of(jet).iter().copied()).collect()
        };
        let (tool, torque) = (settings.limits.tool(), settings.limits.torque());
        let by_joints = path.get().tool(0.0).is_none();
        let tool_limited = by_joints && (tool.feed().is_some() || tool.angular_speed().is_some());
        Self {
            bounds: DerivativeBounds::of(path.get(), &joints, &jumps_of(settings, path.get(), &layout, &joints)),
            tool_rates: tool_limited.then(|| ToolRates::of(settings.arm, &joints, &middles)),
            torque: torque.map(|torque| TorquePath::of(&joints, &middles, torque)),
            middle: [flat(|jet| &jet.d1), flat(|jet| &jet.d2), flat(|jet| &jet.d3)],
            middles,
            settings: settings.clone(),
            path,
            layout,
            joints,
            stops,
            feeds,
            after,
            before,
            needs,
            times: [Duration::ZERO; 2],
        }
    }

    /// The path.
    pub fn path(&self) -> &(dyn MotionPath<N> + 'p) {
        self.path.get()
    }

    /// Joint values and derivatives on the grid.
    pub fn joint_path(&self) -> &JointPath<N> {
        &self.joints
    }

    /// Number of intervals of the grid.
    pub fn intervals(&self) -> usize {
        self.joints.intervals()
    }

    /// The limits.
    pub fn limits(&self) -> &Limits<'p, N> {
        &self.settings.limits
    }

    /// Parts of the path with a feed of their own, in their order on it.
    pub fn sections(&self) -> &[Section] {
        &self.layout.sections
    }

    /// Chord segments of the curve of the tool; none for other paths.
    pub fn segmentation(&self) -> Option<&Segmentation> {
        self.layout.segmentation.as_ref()
    }

    /// Arc lengths where chord segments begin and end, m.
    pub fn breaks(&self) -> &[f64] {
        &self.layout.breaks
    }

    /// Values of the parameter at the corners inside the path, where the motion stops.
    pub fn stops(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.stops.iter().map(|&i| self.layout.grid[i])
    }

    pub(crate) fn stop_points(&self) -> &[usize] {
        &self.stops
    }

    /// Programmed feed at `s`, m/s; infinite where there is none.
    pub fn feed_at(&self, s: f64) -> f64 {
        let elsewhere = self.settings.limits.tool().feed().unwrap_or(f64::INFINITY);
        Feeds { elsewhere, sections: &self.layout.sections }.at(s)
    }

    /// The highest speed at grid point `i` at which the steps of the joints' accelerations keep the limits on jerk, and the joint that
    /// sets it; infinite away from jumps of the curvature.
    pub(crate) fn step_speed(&self, i: usize) -> (f64, usize) {
        self.bounds.step_speed(i, self.settings.limits.joints().jerk(), self.settings.period)
    }

    /// How far the third derivatives of the joints in the middle of interval `k` are from the mean of both ends, in units of the limits
    /// on jerk.
    pub(crate) fn third_misfit(&self, k: usize) -> f64 {
        let jerk = self.settings.limits.joints().jerk();
        let one = |j: usize| {
            let [a, m, b] = [self.after[2][k * N + j], self.middle[2][k * N + j], self.before[2][(k + 1) * N + j]];
            (m - 0.5 * (a + b)).abs() / jerk[j]
        };
        (0..N).map(one).fold(0.0, f64::max)
    }

    /// Time spent on laying the grid, and on following the path.
    pub(crate) fn times(&self) -> [Duration; 2] {
        self.times
    }

    /// The limits as rows, caps and interval bounds on the grid, for any planner of the feedrate crate that needs no more than
    /// `needs`, which is no more than what the problem was prepared for.
    ///
    /// # Errors
    /// [`SpeedError::Feed`] for numbers that are not finite.
    pub fn rows(&self, needs: RowsNeeded) -> Result<FeedProblem, SpeedError> {
        self.rows_within(&LimitFractions::default(), needs.min(self.needs))
    }

    /// The same with a part of each limit.
    pub(crate) fn rows_within(&self, used: &LimitFractions, needs: RowsNeeded) -> Result<FeedProblem, SpeedError> {
        self.build(used, needs).map_err(|error| self.explained(error))
    }

    /// The error of a planner, with the place.
    pub(crate) fn explained(&self, error: FeedError) -> SpeedError {
        SpeedError::explained(error, &self.layout.grid, |s| self.path.get().place(s))
    }

    fn build(&self, used: &LimitFractions, needs: RowsNeeded) -> Result<FeedProblem, FeedError> {
        let (limits, path) = (&self.settings.limits, self.path.get());
        let (joints, tool, between) = (limits.joints(), limits.tool(), needs > RowsNeeded::Points);
        let [d1, d2, d3] = self.bounds.joints();
        let steps = self.bounds.steps(self.settings.period);
        let [after, before, middle] = [&self.after, &self.before, &self.middle];
        let mut derivatives = PathDerivatives::new(N, &after[0], &after[1])?
            .with_third(&after[2])?
            .with_values_before(&before[0], &before[1], &before[2])?
            .with_bounds([&d1, &d2, &d3])?
            .with_steps(&steps)?;
        if between {
            derivatives = derivatives.with_middles(&middle[0], &middle[1])?.with_third_in_middles(&middle[2])?;
        }
        let velocities = joints.velocity().component_mul(&used.joints(Quantity::JointVelocity));
        let accelerations = joints.acceleration().component_mul(&used.joints(Quantity::JointAcceleration));
        let jerks = joints.jerk().component_mul(&used.joints(Quantity::JointJerk));
        let velocity = JointVelocity::new(derivatives, velocities.as_slice())?;
        let acceleration = JointAcceleration::new(derivatives, accelerations.as_slice())?;
        let margin = if path.tool_curve().is_some() { BETWEEN } else { 0.0 };
        let jerk = JointJerk::new(derivatives, jerks.as_slice())?.with_margin(margin)?;
        let mut constraints: Vec<&dyn PathConstraint> = vec![&velocity, &acceleration];

        let lowered = |limit: Option<f64>, quantity| limit.map(|limit| limit * used.tool(quantity));
        let by_length = path.parameter() == PathParameter::ArcLength;
        let feeds: Vec<f64> = self.feeds.iter().map(|feed| feed * used.tool(Quantity::Feed)).collect();
        let feed = if feeds.is_empty() { None } else { Some(Feed::new(&feeds)?) };
        let bend = self.bend_limits(used);
        let bends = self.bounds.bend_speeds(&self.feeds, |kappa| bend.speed(kappa));
        let bends = SpeedCap::new(&bends[0], Quantity::NormalAcceleration)?.with_intervals(&bends[1])?;
        let angular = lowered(tool.angular_speed(), Quantity::AngularSpeed);
        let turns = angular.map(|limit| self.bounds.turn_speeds(&self.feeds, limit));
        let turns = match &turns {
            Some([points, intervals]) => {
                Some(SpeedCap::new(points, Quantity::AngularSpeed)?.with_intervals(intervals)?)
            }
            None => None,
        };
        let rates = self.tool_rates.as_ref();
        let linear_speed = lowered(tool.feed(), Quantity::Feed).zip(rates).map(|(limit, rates)| rates.linear(limit));
        let angular_speed = angular.zip(rates).map(|(limit, rates)| rates.angular(limit));
        let tangential = lowered(tool.tangential_acceleration(), Quantity::TangentialAcceleration)
            .map(TangentialAcceleration::new)
            .transpose()?;
        let tangential_jerk =
            lowered(tool.tangential_jerk(), Quantity::TangentialJerk).map(TangentialJerk::new).transpose()?;
        let torque = self.torque.as_ref().map(|torque| torque.rows(used));
        let stops: Vec<Stop> = self.stops.iter().map(|&at| Stop { at }).collect();

        constraints.extend(feed.iter().map(|feed| feed as &dyn PathConstraint));
        if path.tool(0.0).is_some() {
            if by_length {
                constraints.push(&bends);
                constraints.extend(tangential.iter().map(|rows| rows as &dyn PathConstraint));
            }
            constraints.extend(turns.iter().map(|turns| turns as &dyn PathConstraint));
        }
        constraints.extend(linear_speed.iter().chain(&angular_speed).map(|rows| rows as &dyn PathConstraint));
        if needs == RowsNeeded::Jerk {
            if by_length {
                constraints.extend(tangential_jerk.iter().map(|rows| rows as &dyn PathConstraint));
            }
            constraints.push(&jerk);
        }
        constraints.extend(torque.iter().map(|torque| torque as &dyn PathConstraint));
        constraints.extend(stops.iter().map(|stop| stop as &dyn PathConstraint));
        let problem = match between {
            true => FeedProblem::between_points(&self.layout.grid, &constraints)?,
            false => FeedProblem::at_points(&self.layout.grid, &constraints)?,
        };
        let mut problem = problem.with_end_speeds(self.settings.ends[0], self.settings.ends[1])?;
        for stretch in used.stretches() {
            problem = problem.with_fraction(
                stretch.limit,
                self.intervals_between(stretch.from, stretch.to),
                stretch.factor,
            )?;
        }
        Ok(problem)
    }

    /// The intervals that a part of the path touches.
    pub(crate) fn intervals_between(&self, from: f64, to: f64) -> RangeInclusive<usize> {
        let (grid, last) = (&self.layout.grid, self.intervals() - 1);
        let at = |s: f64| grid.partition_point(|&g| g <= s).saturating_sub(1).min(last);
        at(from)..=at(to)
    }

    /// The bounds of the speed in bends, with a fraction of each limit.
    pub(crate) fn bend_limits(&self, used: &LimitFractions) -> BendLimits {
        let tool = self.settings.limits.tool();
        let lowered = |limit: Option<f64>, quantity| limit.map(|limit| limit * used.tool(quantity));
        BendLimits {
            chord: self.settings.chord_tolerance * used.tool(Quantity::ChordError),
            period: self.settings.period,
            normal_acceleration: lowered(tool.normal_acceleration(), Quantity::NormalAcceleration),
            normal_jerk: lowered(tool.normal_jerk(), Quantity::NormalJerk),
        }
    }

    /// The setpoint at time `t` (s) when the path is run by `law`, in the state `state`, near the jet `near`.
    pub(crate) fn setpoint(
        &self,
        t: f64,
        state: &arcfeed_feedrate::MotionState,
        near: &JointJet<N>,
    ) -> Result<(crate::setpoint::Setpoint<N>, JointJet<N>), PlanError> {
        let path = self.path.get();
        let jet = path.jet(state.p, &near.ahead(state.p - near.s))?;
        let pose = path.tool(state.p).map_or_else(|| self.settings.arm.forward(&jet.q), |tool| tool.pose);
        Ok((jet.setpoint(t, state, pose), jet))
    }

    /// Checks that a law runs over the whole path.
    pub(crate) fn runs_over(&self, law: &SpeedLaw) -> Result<(), LimitError> {
        let (length, start, end) = (self.path.get().length(), law.start(), law.end().p);
        // Not `> 1e-9`: a NaN has to show.
        if start.abs() <= 1e-9 * length && (end - length).abs() <= 1e-9 * length {
            return Ok(());
        }
        Err(LimitError::Law { start, end, length })
    }
}

/// The tool of the planner's arm may be this far from where the path begins, m and rad.
const SAME_ARM: f64 = 1e-6;

/// Checks that planner and path have the same arm, and that the limits of the tool make sense on this kind of path.
pub(crate) fn suits<const N: usize>(settings: &Settings<'_, N>, path: &dyn MotionPath<N>) -> Result<(), LimitError> {
    if let Some(tool) = path.tool(0.0) {
        let stands = settings.arm.forward(&path.start());
        let apart = (stands.translation.vector - tool.pose.translation.vector).norm()
            + stands.rotation.angle_to(&tool.pose.rotation);
        if apart > SAME_ARM || apart.is_nan() {
            return Err(LimitError::Unsuited {
                limit: "the arm of the planner",
                problem: "does not stand where the path begins: the path belongs to another arm or another tool",
                remedy: "make the path with the same arm, tool included",
            });
        }
    }
    if path.parameter() != PathParameter::JointDistance {
        return Ok(());
    }
    let tool = settings.limits.tool();
    let without_meaning = [
        ("tangential acceleration", tool.tangential_acceleration()),
        ("tangential jerk", tool.tangential_jerk()),
        ("normal acceleration", tool.normal_acceleration()),
        ("normal jerk", tool.normal_jerk()),
    ];
    match without_meaning.into_iter().find(|(_, limit)| limit.is_some()) {
        Some((limit, _)) => Err(LimitError::Unsuited {
            limit,
            problem: "of the tool is not limited on a path through joint way-points",
            remedy: "limit the joints, the feed or the angular speed",
        }),
        None => Ok(()),
    }
}

/// Programmed feed on every interval, m/s; empty where none counts.
fn feeds<const N: usize>(settings: &Settings<'_, N>, path: &dyn MotionPath<N>, layout: &PathGrid) -> Vec<f64> {
    let Some(elsewhere) = settings.limits.tool().feed().filter(|_| path.parameter() == PathParameter::ArcLength) else {
        return Vec::new();
    };
    let reachable = settings.reachable(path.length());
    let feeds = Feeds { elsewhere, sections: &layout.sections };
    layout.grid.windows(2).map(|pair| feeds.at(0.5 * (pair[0] + pair[1])).min(reachable)).collect()
}

/// The jumps of the second derivatives in motion.
fn jumps_of<const N: usize>(
    settings: &Settings<'_, N>,
    path: &dyn MotionPath<N>,
    layout: &PathGrid,
    joints: &JointPath<N>,
) -> Vec<Jump<N>> {
    let (period, limits) = (settings.period, settings.limits.joints());
    let grid: Vec<f64> = joints.grid().collect();
    let stops = grid::stops(&grid, path.corners().iter().copied());
    let elsewhere = settings.limits.tool().feed().filter(|_| path.parameter() == PathParameter::ArcLength);
    let feeds = Feeds { elsewhere: elsewhere.unwrap_or(f64::INFINITY), sections: &layout.sections };
    let fastest = feeds.highest();
    jumps(joints, &stops, &(limits.jerk() * period), (fastest, period))
}

/// Joint derivatives just after and just before every grid point.
fn sides<const N: usize>(joints: &JointPath<N>, stops: &[usize]) -> [[Vec<f64>; 3]; 2] {
    let points = joints.nodes().len();
    let empty = || std::array::from_fn(|_| Vec::with_capacity(points * N));
    let (mut after, mut before): ([Vec<f64>; 3], [Vec<f64>; 3]) = (empty(), empty());
    for i in 0..points {
        let (left, right) = joints.sides(i);
        // At a smooth knot both sides are the same but for rounding, which must not count as a corner or a jump.
        let jumps = (left.d2 - right.d2).amax() > 1e-7 * (1.0 + left.d2.amax());
        let (first, second) = match (stops.contains(&i), jumps) {
            (true, _) => (&left.d1, &left.d2),
            (false, true) => (&right.d1, &left.d2),
            (false, false) => (&right.d1, &right.d2),
        };
        for (list, values) in after.iter_mut().zip([&right.d1, &right.d2, &right.d3]) {
            list.extend_from_slice(values.as_slice());
        }
        for (list, values) in before.iter_mut().zip([first, second, &left.d3]) {
            list.extend_from_slice(values.as_slice());
        }
    }
    [after, before]
}

/// Joint values and derivatives in the middle of every interval; `known` are those of some of the intervals.
fn middles<const N: usize>(
    path: &dyn MotionPath<N>,
    joints: &JointPath<N>,
    known: Option<&PathProblem<'_, N>>,
) -> Vec<JointJet<N>> {
    let mut next = 0;
    let mut known = |from: f64, to: f64| {
        let known = known?;
        let nodes = known.joints.nodes();
        while next + 1 < nodes.len() && nodes[next].s < from {
            next += 1;
        }
        let same = nodes.get(next)?.s == from && nodes.get(next + 1)?.s == to;
        if same { known.middles.get(next).copied() } else { None }
    };
    let one = |k: usize| {
        let (a, b) = joints.interval(k);
        if let Some(jet) = known(a.s, b.s) {
            return jet;
        }
        let h = 0.5 * (b.s - a.s);
        let q = (a.ahead(h) + b.ahead(-h)) / 2.0;
        path.jet(a.s + h, &q).unwrap_or_else(|_| {
            // The arm stands at both ends; where the solution in between is lost, what they foretell will do.
            let first = |jet: &JointJet<N>, h: f64| jet.d1 + (jet.d2 + jet.d3 * (h / 2.0)) * h;
            let d2 = (a.d2 + a.d3 * h + b.d2 - b.d3 * h) / 2.0;
            JointJet { s: a.s + h, q, d1: (first(a, h) + first(b, -h)) / 2.0, d2, d3: (a.d3 + b.d3) / 2.0 }
        })
    };
    (0..joints.intervals()).map(one).collect()
}
