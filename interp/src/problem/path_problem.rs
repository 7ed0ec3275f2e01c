//! A path on its grid with everything that its limits are made from: computed once, asked for rows as often as it takes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use arcfeed_feedrate::{FeedError, FeedProblem, SpeedLaw};
use arcfeed_geometry::Segmentation;
use arcfeed_kinematics::Joints;

use super::bounds::DerivativeBounds;
use super::fractions::LimitFractions;
use super::grid;
use super::joint_tables::TablePath;
use super::jumps::{Jump, jumps};
use super::needs::RowsNeeded;
use super::path_grid::PathGrid;
use super::settings::Settings;
use super::tool_speed::ToolRates;
use super::tool_vector::ToolVectors;
use super::torque::TorquePath;
use crate::error::{LimitError, PlanError, SpeedError};
use crate::limits::{Feeds, JointTables, Limits, Section, TableKind};
use crate::path::{JointJet, JointPath, KnownJoints, MotionPath};
use crate::place::PathParameter;

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
    pub(super) stops: Vec<usize>,
    /// Programmed feed on every interval, m/s; empty where there is none.
    pub(super) feeds: Vec<f64>,
    /// Derivatives of the joints by the parameter, joint by joint: just after every grid point, just before it, in the middle of every
    /// interval; first, second, third.
    pub(super) after: [Vec<f64>; 3],
    pub(super) before: [Vec<f64>; 3],
    pub(super) middle: [Vec<f64>; 3],
    /// Joints in the middle of every interval, where middles are needed and the arm can stand there.
    middles: Vec<Option<JointJet<N>>>,
    pub(super) bounds: DerivativeBounds<N>,
    pub(super) tool_rates: Option<ToolRates>,
    pub(super) tool_vectors: Option<ToolVectors>,
    pub(super) tables: Option<TablePath<N>>,
    pub(super) torque: Option<TorquePath<N>>,
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
        let mut problem = Self::on(settings, path, layout, needs, KnownJoints::none)?;
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
        // The inverse kinematics along a curve of the tool take their time.
        let by_inverse = self.path().tool_curve().is_some();
        let known = || if by_inverse { self.joints.known(&self.middles) } else { KnownJoints::none() };
        let mut problem = Self::on(&self.settings, self.path.clone(), layout, self.needs, known)?;
        problem.times = [self.times[0], self.times[1] + problem.times[1]];
        Ok(problem)
    }

    fn on<'k>(
        settings: &Settings<'p, N>,
        path: Held<'p, N>,
        layout: PathGrid,
        needs: RowsNeeded,
        known: impl Fn() -> KnownJoints<'k, N>,
    ) -> Result<Self, PlanError> {
        suits(settings, path.get())?;
        let begin = Instant::now();
        let limits = settings.limits.joints();
        let mut joints = JointPath::follow_knowing(path.get(), &path.get().start(), &layout.grid, &mut known())
            .map_err(|e| e.within(limits.lower(), limits.upper()))?;
        joints.check_range(path.get(), limits.range())?;
        // Along a curve of the tool the grid is fine, and points beside its knots would make intervals of no length.
        if settings.limits.torque().is_some() && path.get().tool_curve().is_none() {
            joints.insert_turning_points(path.get())?;
        }
        let found = jumps_of(settings, path.get(), &layout, &joints);
        let beside: Vec<(usize, f64)> = found.iter().map(|jump| (jump.at, jump.reach)).collect();
        joints.insert_beside(path.get(), &beside)?;
        let mut problem = Self::of(settings, path, layout, joints, needs, known());
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
        mut known: KnownJoints<'_, N>,
    ) -> Self {
        layout.grid = joints.grid().collect();
        let stops = grid::stops(&layout.grid, path.get().corners().iter().copied());
        let feeds = feeds(settings, path.get(), &layout);
        let known_middles =
            if needs > RowsNeeded::Points { joints.middles(path.get(), &mut known) } else { Vec::new() };
        let filled = |(k, jet): (usize, &Option<JointJet<N>>)| jet.unwrap_or_else(|| joints.foretold(k));
        let middles: Vec<JointJet<N>> = known_middles.iter().enumerate().map(filled).collect();
        let [after, before] = sides(&joints, &stops);
        let flat = |of: fn(&JointJet<N>) -> &Joints<N>| -> Vec<f64> {
            let mut values = Vec::with_capacity(N * middles.len());
            middles.iter().for_each(|jet| values.extend_from_slice(of(jet).as_slice()));
            values
        };
        let (tool, torque) = (settings.limits.tool(), settings.limits.torque());
        let by_joints = path.get().tool(0.0).is_none();
        let tool_limited = by_joints && (tool.feed().is_some() || tool.angular_speed().is_some());
        let jumps = jumps_of(settings, path.get(), &layout, &joints);
        let bounds = DerivativeBounds::of(path.get(), &joints, &jumps);
        let by_vectors = tool.acceleration().is_some() || tool.jerk().is_some();
        let tool_vectors = by_vectors.then(|| {
            let fastest = fastest(settings, &joints, &middles, &feeds);
            ToolVectors::of(settings.arm, (&joints, &middles), &jumps, fastest)
        });
        let tables = settings.limits.tables().filter(|tables| !tables.is_empty());
        let feed = if feeds.is_empty() { f64::INFINITY } else { feeds.iter().copied().fold(0.0, f64::max) };
        let tables = tables.map(|tables| TablePath::of(&settings.limits, tables, &joints, &bounds, feed));
        let lines =
            || tables.as_ref().map_or_else(|| std::array::from_fn(|_| Vec::new()), |tables| tables.torque.clone());
        Self {
            tool_rates: tool_limited.then(|| ToolRates::of(settings.arm, &joints, &middles)),
            torque: torque.map(|torque| TorquePath::of(&joints, &middles, torque, lines())),
            bounds,
            tool_vectors,
            tables,
            middle: [flat(|jet| &jet.d1), flat(|jet| &jet.d2), flat(|jet| &jet.d3)],
            middles: known_middles,
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

    /// The error of a planner, with the place.
    pub(crate) fn explained(&self, error: FeedError) -> SpeedError {
        SpeedError::explained(error, &self.layout.grid, |s| self.path.get().place(s))
    }

    /// The setpoint at time `t` (s) when the path is run by `law`, in the state `state`, near the jet `near`.
    pub(crate) fn setpoint(
        &self,
        t: f64,
        state: &arcfeed_feedrate::MotionState,
        near: &JointJet<N>,
    ) -> Result<(crate::setpoint::Setpoint<N>, JointJet<N>), PlanError> {
        let path = self.path.get();
        let (jet, tool) = path.jet_with_tool(state.p, &near.ahead(state.p - near.s))?;
        let pose = tool.map_or_else(|| self.settings.arm.forward(&jet.q), |tool| tool.pose);
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
    let by_torque = |tables: &JointTables<N>| tables.has(TableKind::TorqueBySpeed);
    if settings.limits.torque().is_none() && settings.limits.tables().is_some_and(by_torque) {
        return Err(LimitError::Unsuited {
            limit: "a table of torque by speed",
            problem: "needs the dynamics of the arm",
            remedy: "give them with Limits::with_torque; an infinite torque leaves the limit to the table",
        });
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

/// The greatest speed that feed and joints allow on every interval, units of the parameter per s.
fn fastest<const N: usize>(
    settings: &Settings<'_, N>,
    joints: &JointPath<N>,
    middles: &[JointJet<N>],
    feeds: &[f64],
) -> Vec<f64> {
    let velocity = settings.limits.joints().velocity();
    let by_joints = |jet: &JointJet<N>| velocity.component_div(&jet.d1.abs()).min();
    let one = |k: usize| {
        let (start, end) = joints.interval(k);
        let three = [Some(start), middles.get(k), Some(end)];
        let most = three.into_iter().flatten().map(by_joints).fold(0.0, f64::max);
        feeds.get(k).map_or(most, |feed| most.min(*feed))
    };
    (0..joints.intervals()).map(one).collect()
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
        let (first, second) = match (stops.binary_search(&i).is_ok(), jumps) {
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
