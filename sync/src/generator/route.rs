//! Routes through way-points that are set, and the section under way.

use arcfeed_feedrate::AxisState;

use super::OnlineGenerator;
use super::command::Command;
use super::following::{Following, check_sections};
use crate::error::SyncError;
use crate::way_points::{Route, RouteMemory, WayPointPlanner, WayPointTrajectory};

impl<const N: usize> OnlineGenerator<N> {
    /// The same generator with a place for a route: [`MOST_WAY_POINTS`](crate::MOST_WAY_POINTS)
    /// points, some 29 kB for six axes.
    #[must_use]
    pub fn with_way_points(self) -> OnlineGenerator<N, WayPointTrajectory<N>> {
        OnlineGenerator {
            cycle: self.cycle,
            options: self.options,
            limits: self.limits,
            ranges: self.ranges,
            target: self.target,
            planned: self.planned,
            state: self.state,
            command: self.command,
            scale: self.scale,
            following: self.following,
            replanned: self.replanned,
            outside_limits: self.outside_limits,
            route: WayPointTrajectory::standing(&self.target, &self.limits),
        }
    }
}

impl<const N: usize> OnlineGenerator<N, WayPointTrajectory<N>> {
    /// Goes along a route from the present state of motion on: through its way-points without
    /// stopping, to its target.
    ///
    /// `planner` has the memory of the computation, which is bounded by the number of points; one
    /// planner serves any number of generators. The limits of the route take the place of those of
    /// the generator, in each section those of the section, and stay after it. The last section may
    /// end between two cycles: [`Events::reached`] is in the cycle after, when an axis whose target
    /// moves is on from there. [`Events::passed`] counts the points of a cycle.
    ///
    /// A stop, a jog, or another target or route leaves this one at any time. The scale of time,
    /// hold and a stop on the path act on its curve: they look ahead to the end of the section after
    /// the one under way, so that the scale changes in small steps where sections are short, and is
    /// above 1 in the last two sections only. With a target that moves they look ahead to the end of the
    /// route only, and the scale is above 1 in the last section.
    ///
    /// Where the scale of time cannot go on ([`OnlineGenerator::set_scale`]) it starts at 1 again: after
    /// [`OnlineGenerator::hold`] the axes may become faster once more before they rest.
    ///
    /// # Errors
    /// As [`WayPointPlanner::plan`]; with ranges [`SyncError::WayPoint`] for a point outside,
    /// [`SyncError::OutsideRange`], [`SyncError::LeavesRange`] and [`SyncError::CannotStop`].
    /// Nothing changes then.
    ///
    /// [`Events::reached`]: crate::Events::reached
    /// [`Events::passed`]: crate::Events::passed
    ///
    /// ```
    /// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
    /// use arcfeed_sync::{OnlineGenerator, Route, Synchronisation, WayPoint, WayPointPlanner};
    /// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?; 2];
    /// let generator = OnlineGenerator::new([AxisState::rest(0.0); 2], limits, 1e-3, Synchronisation::Time)?;
    /// let mut generator = generator.with_way_points();
    /// let mut planner = WayPointPlanner::new();
    /// generator.jog([0.5, 0.0], 1.0)?;
    /// for _ in 0..300 {
    ///     generator.step();
    /// }
    /// // In motion a route takes the place of the jog, and another one its place.
    /// let points = [WayPoint::new([0.4, 0.1]), WayPoint::new([0.8, 0.5])];
    /// generator.set_route(&Route::new(&points, [1.0, 1.0].map(AxisState::rest), limits), &mut planner)?;
    /// while generator.step().events.passed == 0 {}
    /// let points = [WayPoint::new([0.9, 0.3])];
    /// generator.set_route(&Route::new(&points, [1.0, 0.0].map(AxisState::rest), limits), &mut planner)?;
    /// while !generator.step().events.reached {}
    /// assert_eq!(generator.state()[0].p, 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_route(&mut self, route: &Route<'_, N>, planner: &mut WayPointPlanner<N>) -> Result<(), SyncError> {
        for (index, point) in route.points().iter().enumerate() {
            for (axis, (value, range)) in point.position().into_iter().zip(&self.ranges).enumerate() {
                if !range.contain(value) && value.is_finite() {
                    let (what, rule) = ("position", "inside the range of its axis");
                    return Err(SyncError::WayPoint { index, axis, what, value, rule });
                }
            }
        }
        self.check_inside("target", route.target())?;
        // The route under way stays until this one has a motion.
        let mut motion = WayPointTrajectory::standing(&self.state, route.limits(0));
        planner.plan_into(self.planning_state(), route, &mut motion)?;
        let mut next = Following::along(&motion, self.cycle, &self.ranges)?;
        if !self.scale_fits(&next, Some(&motion), route.limits(0)) {
            // The scale starts at 1 again, from the state commanded last.
            planner.plan_into(&self.state, route, &mut motion)?;
            next = Following::along(&motion, self.cycle, &self.ranges)?;
            self.scale.jump(1.0);
        }
        self.route = motion;
        self.target = *route.target();
        let limits = *self.route.limits(0);
        self.begin(next, limits, Command::Route);
        Ok(())
    }

    /// The motion along the route set last.
    pub const fn route(&self) -> &WayPointTrajectory<N> {
        &self.route
    }

    /// The section of the route that is under way, from 0; `None` if the axes are on none.
    pub const fn section(&self) -> Option<usize> {
        self.following.section
    }
}

impl<const N: usize, R: RouteMemory<N>> OnlineGenerator<N, R> {
    /// Begins the sections of the route whose time comes within so many cycles, with their limits.
    /// Returns the number of points that are passed, or an error where a section has no motion.
    pub(super) fn pass_points(&mut self, cycles: f64) -> Result<usize, SyncError> {
        let (Some(route), Some(was)) = (self.route.motion(), self.following.section) else { return Ok(0) };
        let passed = self.following.pass(route, cycles, self.cycle, &self.ranges);
        if let Some(section) = self.following.section.filter(|now| *now != was) {
            self.limits = *route.limits(section);
        }
        passed
    }

    /// The state in which the section under way ends.
    pub(super) fn section_end(&self) -> Option<&[AxisState; N]> {
        self.following.section.zip(self.route.motion()).map(|(section, route)| &route.states()[section + 1])
    }

    /// Time of the route after the section under way (s).
    pub(super) fn time_after_section(&self) -> f64 {
        let left = self.following.section.zip(self.route.motion());
        left.map_or(0.0, |(section, route)| route.section_durations()[section + 1..].iter().sum())
    }

    /// What is left of the route, checked against the ranges, with what follows its last section.
    pub(super) fn route_within_ranges(&self, mut next: Following<N>) -> Result<Following<N>, SyncError> {
        let Some((section, route)) = next.section.zip(self.route.motion()) else { return Ok(next) };
        let since = next.axes.first().map_or(0.0, |axis| axis.steps * self.cycle);
        check_sections(route, (section, since), &self.ranges)?;
        let mut last = next;
        last.load_last(route, &self.ranges)?;
        if section + 1 == route.section_durations().len() {
            next = last;
        }
        Ok(next)
    }

    /// The axes have no command but their target.
    pub(super) fn leave_route(&mut self) {
        self.command = Command::Target;
        self.following.section = None;
    }
}
