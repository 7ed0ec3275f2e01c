//! The limits of a path as constraints of the feedrate crate.

use std::ops::{Range, RangeInclusive};

use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, PathDerivatives, Place, RowSink, SpeedCap,
    TangentialAcceleration, TangentialJerk,
};
use arcfeed_feedrate::{
    FeedError, FeedProblem, IntervalBound, JerkLimited, LimitId, Quantity, SpeedLaw, WindowedJerkLimited, WindowedPlan,
};
use arcfeed_kinematics::Joints;

use super::bounds::BendLimits;
use super::fractions::LimitFractions;
use super::joint_tables::{JointDerivatives, TabledAcceleration, TabledJerk};
use super::needs::RowsNeeded;
use super::path_problem::PathProblem;
use crate::error::SpeedError;
use crate::place::PathParameter;

/// Part of the jerk of joints and tool along a curve of the tool that is left for what three places of an interval do not tell of the
/// rest of it: so much less than the grid costs that it does not show, and a second round of planning is seldom needed.
const BETWEEN: f64 = 2e-4;

type Constraints<'c> = Vec<Box<dyn PathConstraint + 'c>>;

/// The stops of a path, in order: one constraint for all of them, as a raster has thousands.
struct Stops<'c>(&'c [usize]);

impl PathConstraint for Stops<'_> {
    fn points(&self) -> Option<usize> {
        None
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        if let Place::Point(i) = place
            && self.0.binary_search(&i).is_ok()
        {
            out.cap(0.0, LimitId::path(Quantity::Corner));
        }
    }

    /// None: where the motion rests needs none.
    fn interval_bounds(&self, _k: usize, _h: f64, _out: &mut Vec<IntervalBound>) {}
}

/// What constraints borrow: numbers along the path with a part of each limit.
struct Numbers<const N: usize> {
    bounds: [Vec<f64>; 3],
    steps: Vec<f64>,
    velocities: Joints<N>,
    accelerations: Joints<N>,
    jerks: Joints<N>,
    feeds: Vec<f64>,
    bends: [Vec<f64>; 2],
    turns: Option<[Vec<f64>; 2]>,
}

impl<const N: usize> PathProblem<'_, N> {
    /// The rows with a part of each limit.
    pub(crate) fn rows_within(&self, used: &LimitFractions, needs: RowsNeeded) -> Result<FeedProblem, SpeedError> {
        self.build(used, needs).map_err(|error| self.explained(error))
    }

    /// Hands the rows of one part of the grid after the other, and where it begins, to `each`: parts of `most` intervals at the most,
    /// with a part of each limit, from rest to rest but for the ends of the path. A part ends at a stop of the path where it holds one.
    pub(crate) fn for_parts(
        &self,
        used: &LimitFractions,
        most: usize,
        mut each: impl FnMut(usize, FeedProblem) -> Result<(), FeedError>,
    ) -> Result<(), FeedError> {
        let numbers = self.numbers(used);
        let constraints = self.constraints(&numbers, used, RowsNeeded::Jerk)?;
        let mut from = 0;
        while from < self.intervals() {
            let longest = (from + most).min(self.intervals());
            let stop = self.stops[..self.stops.partition_point(|&stop| stop <= longest)].last().copied();
            let to =
                if longest == self.intervals() { longest } else { stop.filter(|&stop| stop > from).unwrap_or(longest) };
            each(from, self.part(&constraints, used, from..to)?)?;
            from = to;
        }
        Ok(())
    }

    /// The law of the jerk-limited planner in windows of so many intervals, with a part of each limit, and the longest window that is
    /// planned with so many rows in each interval.
    pub(crate) fn planned_in_windows(
        &self,
        used: &LimitFractions,
        window: usize,
    ) -> Result<(WindowedPlan, usize), FeedError> {
        let numbers = self.numbers(used);
        let constraints = self.constraints(&numbers, used, RowsNeeded::Jerk)?;
        let windows = WindowedJerkLimited::new(JerkLimited::default(), window)?;
        let mut longest = usize::MAX;
        let plan = windows.plan(self.intervals(), |intervals| {
            let rows = self.part(&constraints, used, intervals)?;
            longest = longest.min(WindowedJerkLimited::longest(&rows));
            Ok(rows)
        })?;
        Ok((plan, longest))
    }

    /// The greatest speeds of the joints on the grid when the path is run by `law`, rad/s or m/s.
    pub(crate) fn greatest_speeds(&self, law: &SpeedLaw) -> Joints<N> {
        let [after, before] = [&self.after[0], &self.before[0]];
        let mut greatest = Joints::zeros();
        for (i, &s) in self.layout.grid.iter().enumerate() {
            let v = law.v_at_s(s);
            for j in 0..N {
                greatest[j] = greatest[j].max(v * after[i * N + j].abs().max(before[i * N + j].abs()));
            }
        }
        greatest
    }

    fn build(&self, used: &LimitFractions, needs: RowsNeeded) -> Result<FeedProblem, FeedError> {
        let numbers = self.numbers(used);
        let constraints = self.constraints(&numbers, used, needs)?;
        if needs > RowsNeeded::Points {
            return self.part(&constraints, used, 0..self.intervals());
        }
        let all: Vec<&dyn PathConstraint> = constraints.iter().map(|one| &**one).collect();
        let problem = FeedProblem::at_points(&self.layout.grid, &all)?;
        self.with_ends_and_fractions(problem, used, 0..self.intervals())
    }

    /// The rows of some intervals, between their points too.
    fn part(
        &self,
        constraints: &Constraints<'_>,
        used: &LimitFractions,
        intervals: Range<usize>,
    ) -> Result<FeedProblem, FeedError> {
        let all: Vec<&dyn PathConstraint> = constraints.iter().map(|one| &**one).collect();
        let problem = FeedProblem::between_points_of(&self.layout.grid, intervals.clone(), &all)?;
        self.with_ends_and_fractions(problem, used, intervals)
    }

    /// The rows of some intervals with the speeds at the ends of the path, and with less of the limits that are lowered there.
    fn with_ends_and_fractions(
        &self,
        problem: FeedProblem,
        used: &LimitFractions,
        intervals: Range<usize>,
    ) -> Result<FeedProblem, FeedError> {
        let [start, end] = self.settings.ends;
        let start = if intervals.start == 0 { start } else { 0.0 };
        let end = if intervals.end == self.intervals() { end } else { 0.0 };
        let mut problem = problem.with_end_speeds(start, end)?;
        for stretch in used.stretches() {
            let lowered = self.intervals_between(stretch.from, stretch.to);
            let (first, last) = (*lowered.start().max(&intervals.start), (*lowered.end()).min(intervals.end - 1));
            if first <= last {
                let within = first - intervals.start..=last - intervals.start;
                problem = problem.with_fraction(stretch.limit, within, stretch.factor)?;
            }
        }
        Ok(problem)
    }

    /// All limits, and the stops.
    fn constraints<'c>(
        &'c self,
        numbers: &'c Numbers<N>,
        used: &LimitFractions,
        needs: RowsNeeded,
    ) -> Result<Constraints<'c>, FeedError> {
        let derivatives = self.derivatives(numbers, needs > RowsNeeded::Points)?;
        let mut constraints = self.speed_and_acceleration_of_joints(numbers, derivatives, used)?;
        self.speed_and_acceleration_of_tool(numbers, used, &mut constraints)?;
        if needs == RowsNeeded::Jerk {
            self.jerk(numbers, derivatives, used, &mut constraints)?;
        }
        constraints.extend(self.torque.iter().map(|torque| Box::new(torque.rows(used)) as _));
        constraints.push(Box::new(Stops(&self.stops)));
        Ok(constraints)
    }

    fn numbers(&self, used: &LimitFractions) -> Numbers<N> {
        let (joints, tool) = (self.settings.limits.joints(), self.settings.limits.tool());
        let bend = self.bend_limits(used);
        let angular = tool.angular_speed().map(|limit| limit * used.tool(Quantity::AngularSpeed));
        Numbers {
            bounds: self.bounds.joints(),
            steps: self.bounds.steps(self.settings.period),
            velocities: joints.velocity().component_mul(&used.joints(Quantity::JointVelocity)),
            accelerations: joints.acceleration().component_mul(&used.joints(Quantity::JointAcceleration)),
            jerks: joints.jerk().component_mul(&used.joints(Quantity::JointJerk)),
            feeds: self.feeds.iter().map(|feed| feed * used.tool(Quantity::Feed)).collect(),
            bends: self.bounds.bend_speeds(&self.feeds, |kappa| bend.speed(kappa)),
            turns: angular.map(|limit| self.bounds.turn_speeds(&self.feeds, limit)),
        }
    }

    fn derivatives<'c>(&'c self, numbers: &'c Numbers<N>, between: bool) -> Result<PathDerivatives<'c>, FeedError> {
        let [after, before, middle] = [&self.after, &self.before, &self.middle];
        let [d1, d2, d3] = &numbers.bounds;
        let derivatives = PathDerivatives::new(N, &after[0], &after[1])?
            .with_third(&after[2])?
            .with_values_before(&before[0], &before[1], &before[2])?
            .with_bounds([d1, d2, d3])?
            .with_steps(&numbers.steps)?;
        if between {
            derivatives.with_middles(&middle[0], &middle[1])?.with_third_in_middles(&middle[2])
        } else {
            Ok(derivatives)
        }
    }

    /// The derivatives for limits by tables.
    fn along<'c>(&'c self, numbers: &'c Numbers<N>) -> JointDerivatives<'c> {
        let [after, before, middle] = [&self.after, &self.before, &self.middle];
        JointDerivatives { after, before, middle, bounds: &numbers.bounds, steps: &numbers.steps }
    }

    fn speed_and_acceleration_of_joints<'c>(
        &'c self,
        numbers: &'c Numbers<N>,
        derivatives: PathDerivatives<'c>,
        used: &LimitFractions,
    ) -> Result<Constraints<'c>, FeedError> {
        let mut constraints: Constraints<'c> =
            vec![Box::new(JointVelocity::new(derivatives, numbers.velocities.as_slice())?)];
        match &self.tables {
            Some(tables) => {
                let limits = self.settings.limits.joints().acceleration();
                constraints.push(Box::new(TabledAcceleration::new(tables, self.along(numbers), limits, used)));
            }
            None => {
                constraints.push(Box::new(JointAcceleration::new(derivatives, numbers.accelerations.as_slice())?));
            }
        }
        Ok(constraints)
    }

    fn speed_and_acceleration_of_tool<'c>(
        &'c self,
        numbers: &'c Numbers<N>,
        used: &LimitFractions,
        constraints: &mut Constraints<'c>,
    ) -> Result<(), FeedError> {
        let tool = self.settings.limits.tool();
        let lowered = |limit: Option<f64>, quantity| limit.map(|limit| limit * used.tool(quantity));
        if !numbers.feeds.is_empty() {
            constraints.push(Box::new(Feed::new(&numbers.feeds)?));
        }
        if self.path.get().tool(0.0).is_some() {
            if self.path.get().parameter() == PathParameter::ArcLength {
                let [points, intervals] = &numbers.bends;
                let bends = SpeedCap::new(points, Quantity::NormalAcceleration)?.with_intervals(intervals)?;
                constraints.push(Box::new(bends));
                if let Some(limit) = lowered(tool.tangential_acceleration(), Quantity::TangentialAcceleration) {
                    constraints.push(Box::new(TangentialAcceleration::new(limit)?));
                }
            }
            if let Some([points, intervals]) = &numbers.turns {
                let turns = SpeedCap::new(points, Quantity::AngularSpeed)?.with_intervals(intervals)?;
                constraints.push(Box::new(turns));
            }
        }
        if let Some(rates) = &self.tool_rates {
            let linear = lowered(tool.feed(), Quantity::Feed).map(|limit| rates.linear(limit));
            let angular = lowered(tool.angular_speed(), Quantity::AngularSpeed).map(|limit| rates.angular(limit));
            constraints.extend(linear.into_iter().chain(angular).map(|rows| Box::new(rows) as _));
        }
        let acceleration = lowered(tool.acceleration(), Quantity::ToolAcceleration);
        if let Some((limit, vectors)) = acceleration.zip(self.tool_vectors.as_ref()) {
            constraints.push(Box::new(vectors.acceleration(limit)));
        }
        Ok(())
    }

    fn jerk<'c>(
        &'c self,
        numbers: &'c Numbers<N>,
        derivatives: PathDerivatives<'c>,
        used: &LimitFractions,
        constraints: &mut Constraints<'c>,
    ) -> Result<(), FeedError> {
        let (tool, path) = (self.settings.limits.tool(), self.path.get());
        let lowered = |limit: Option<f64>, quantity| limit.map(|limit| limit * used.tool(quantity));
        let margin = if path.tool_curve().is_some() { BETWEEN } else { 0.0 };
        if let Some(limit) = lowered(tool.tangential_jerk(), Quantity::TangentialJerk)
            && path.parameter() == PathParameter::ArcLength
        {
            constraints.push(Box::new(TangentialJerk::new(limit)?));
        }
        match &self.tables {
            Some(tables) => {
                let limits = self.settings.limits.joints().jerk();
                constraints.push(Box::new(TabledJerk::new(tables, self.along(numbers), limits, used, margin)));
            }
            None => {
                let jerk = JointJerk::new(derivatives, numbers.jerks.as_slice())?.with_margin(margin)?;
                constraints.push(Box::new(jerk));
            }
        }
        let jerk = lowered(tool.jerk(), Quantity::ToolJerk);
        if let Some((limit, vectors)) = jerk.zip(self.tool_vectors.as_ref()) {
            constraints.push(Box::new(vectors.jerk(limit, margin, self.settings.period)));
        }
        Ok(())
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
}
