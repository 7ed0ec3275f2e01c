//! Commands without a target: stops, a jog, and the scale of time.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, MotionLaw, StateToState};

use super::OnlineGenerator;
use super::command::Command;
use super::following::Following;
use super::time_scale::{HIGHEST, Pace};
use crate::error::SyncError;
use crate::state_to_state::Trajectory;
use crate::way_points::RouteMemory;
#[cfg(not(feature = "std"))]
use num_traits::Float;

impl<const N: usize, R: RouteMemory<N>> OnlineGenerator<N, R> {
    /// Brings every axis to rest in the shortest way of its own, and gives up the targets. The
    /// target of each axis is the place where it will stand, and [`Events::reached`] says when the
    /// last one does.
    ///
    /// An axis that its shortest stop would take out of its range brakes harder, turns at the end of
    /// the range and rests a little before it.
    ///
    /// # Errors
    /// [`SyncError::State`] if the range leaves no stop: the axes go on as before then.
    ///
    /// [`Events::reached`]: crate::Events::reached
    ///
    /// ```
    /// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
    /// use arcfeed_sync::{OnlineGenerator, Synchronisation};
    /// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?; 2];
    /// let mut generator = OnlineGenerator::new([AxisState::rest(0.0); 2], limits, 1e-3, Synchronisation::Time)?;
    /// generator.set_target([AxisState::rest(1.0), AxisState::rest(-0.5)])?;
    /// for _ in 0..400 {
    ///     generator.step();
    /// }
    /// generator.stop()?;
    /// while !generator.step().events.reached {}
    /// assert_eq!(generator.state(), generator.target());
    /// assert!(generator.state()[0].p < 0.6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stop(&mut self) -> Result<(), SyncError> {
        self.stop_within(self.limits)
    }

    /// Brings all axes to rest on the curve of their plan, and gives up the targets.
    ///
    /// One axis, and axes on a straight line, stop in the shortest way on that line. On any other
    /// curve the time of the plan is scaled to a standstill, as [`OnlineGenerator::hold`] does:
    /// every limit is kept, so that the axes brake together at the rate of the one that is nearest
    /// to its limits. A plan that uses its whole jerk while it brakes the acceleration of an axis
    /// cannot be slowed down at once; the scale falls as soon as a limit has a margin. In the worst
    /// case the stop is the end of the plan, where the target is reached.
    ///
    /// The target becomes the place where the axes stand, once they do; [`Events::reached`] says so.
    ///
    /// [`Events::reached`]: crate::Events::reached
    pub fn stop_on_path(&mut self) {
        // A call in every cycle would begin the search for a way to slow down anew each time.
        if matches!(self.command, Command::Stop | Command::PathStop { .. }) {
            return;
        }
        if let Some(plan) = self.stop_on_line() {
            self.begin_stop(plan, self.limits);
            return;
        }
        self.command = Command::PathStop { limits: self.limits };
        self.scale.retarget();
    }

    /// Moves the axes at velocities, each on its own, until `timeout` (s) is over; then they stop as
    /// by [`OnlineGenerator::stop`]. Another call renews the time. Calling it in every cycle with
    /// the same velocities lets the motion stop when the calls fail to come.
    ///
    /// An axis whose range ends ahead brakes so that it stands at that end.
    ///
    /// Where the scale of time cannot go on ([`OnlineGenerator::set_scale`]) it starts at 1 again: after
    /// [`OnlineGenerator::hold`] the axes may become faster once more before they rest.
    ///
    /// # Errors
    /// [`SyncError::Timeout`]; [`SyncError::State`] naming an axis whose velocity is not finite or
    /// outside its limits; [`SyncError::CannotStop`]. Nothing changes then.
    ///
    /// ```
    /// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
    /// use arcfeed_sync::{OnlineGenerator, Synchronisation};
    /// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?];
    /// let mut generator = OnlineGenerator::new([AxisState::rest(0.0)], limits, 1e-3, Synchronisation::Time)?;
    /// for _ in 0..500 {
    ///     generator.jog([0.4], 0.05)?;
    ///     generator.step();
    /// }
    /// assert_eq!(generator.state()[0].v, 0.4);
    /// // No call any more: it brakes after 50 ms.
    /// while !generator.step().events.reached {}
    /// assert_eq!(generator.state()[0].v, 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn jog(&mut self, velocity: [f64; N], timeout: f64) -> Result<(), SyncError> {
        if !(timeout.is_finite() && timeout >= 0.0) {
            return Err(SyncError::Timeout { value: timeout });
        }
        let left = (timeout / self.cycle).ceil();
        match self.command {
            Command::Jog { velocity: old, .. } if old == velocity => self.command = Command::Jog { velocity, left },
            _ => self.begin_jog(velocity, left, self.limits)?,
        }
        Ok(())
    }

    /// Sets the scale of time, from 0 to 1.5: 0.5 plays every plan at half its velocity, on the same
    /// curve.
    ///
    /// The scale changes within the limits of all axes on velocity, acceleration and jerk, which
    /// hold at all times, not only at the cycles. Above 1 it goes as far as the limits allow for the
    /// rest of the plan; a plan in the least time leaves nothing. While an axis uses its whole jerk
    /// against its velocity no change is possible, and the scale waits; so it does until a plan that
    /// begins outside its limits is inside. A new target, other limits and other ranges keep the scale
    /// where the limits permit; otherwise the plan begins at scale 1 in the state commanded last,
    /// and the scale returns to what is set. An axis that goes on after its target goes back to its
    /// velocity then. [`OnlineGenerator::stop`] is not scaled.
    ///
    /// # Errors
    /// [`SyncError::Scale`].
    ///
    /// ```
    /// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
    /// use arcfeed_sync::{OnlineGenerator, Synchronisation};
    /// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?; 2];
    /// let mut generator = OnlineGenerator::new([AxisState::rest(0.0); 2], limits, 1e-3, Synchronisation::Time)?;
    /// generator.set_target([AxisState::rest(1.0), AxisState::rest(-0.5)])?;
    /// generator.set_scale(0.5)?;
    /// while generator.step().state.q[0] < 0.5 {}
    /// assert!(generator.scale() == 0.5 && (generator.state()[0].v - 0.5).abs() < 1e-3);
    /// generator.hold();
    /// for _ in 0..500 {
    ///     generator.step();
    /// }
    /// assert_eq!((generator.scale(), generator.state()[0].v), (0.0, 0.0));
    /// generator.resume();
    /// while !generator.step().events.reached {}
    /// assert_eq!(generator.state()[0].p, 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_scale(&mut self, scale: f64) -> Result<(), SyncError> {
        if !(0.0..=HIGHEST).contains(&scale) {
            return Err(SyncError::Scale { value: scale });
        }
        if scale != self.scale.wanted {
            self.scale.wanted = scale;
            self.scale.retarget();
        }
        Ok(())
    }

    /// Brings the scale of time to 0: the axes rest on their curve until
    /// [`OnlineGenerator::resume`]. Targets and limits may be set meanwhile; their plans begin at
    /// rest.
    pub fn hold(&mut self) {
        if !self.scale.held {
            self.scale.held = true;
            self.scale.retarget();
        }
    }

    /// Ends a hold.
    pub fn resume(&mut self) {
        if self.scale.held {
            self.scale.held = false;
            self.scale.retarget();
        }
    }

    /// The scale of time at the end of the last cycle.
    pub fn scale(&self) -> f64 {
        self.scale.now().0
    }

    /// Returns true from [`OnlineGenerator::hold`] until [`OnlineGenerator::resume`].
    pub const fn is_held(&self) -> bool {
        self.scale.held
    }

    /// How far the plan is played in the next cycle.
    pub(super) fn pace(&mut self) -> Pace {
        if let Command::Jog { velocity, left } = self.command {
            // A stop that is refused is tried again in the next cycle.
            if left > 0.0 {
                self.command = Command::Jog { velocity, left: left - 1.0 };
            } else {
                let _ = self.stop();
            }
        }
        let goal = match self.command {
            Command::Stop => 1.0,
            Command::PathStop { .. } => 0.0,
            _ => self.scale.goal(),
        };
        if self.scale.steady() != Some(goal) {
            if self.planned.iter().all(|s| s.v == 0.0 && s.a == 0.0) {
                self.scale.jump(goal.min(1.0));
            } else {
                let limits = match self.command {
                    Command::PathStop { limits } => limits,
                    _ => self.limits,
                };
                let courses = self.following.courses(self.route.motion(), &limits, self.cycle);
                self.scale.improve(goal, &courses);
            }
        }
        self.scale.advance(self.cycle)
    }

    /// Ends a stop whose axes stand. Returns true if a stop on the path ended in this cycle.
    pub(super) fn end_stop(&mut self) -> bool {
        if self.command == Command::Target {
            return false;
        }
        let rests = self.state.iter().all(|s| s.v == 0.0 && s.a == 0.0);
        match self.command {
            Command::Stop | Command::Route if !self.is_underway() => self.leave_route(),
            Command::PathStop { .. } if rests && (self.scale.steady() == Some(0.0) || !self.is_underway()) => {
                let rest = self.state.map(|s| AxisState::rest(s.p));
                let Ok(standing) = Following::coasting(&rest, &self.limits, &self.ranges) else { return false };
                (self.following, self.target) = (standing, rest);
                (self.planned, self.state) = (rest, rest);
                self.command = Command::Target;
                self.scale.jump(self.scale.goal().min(1.0));
                return true;
            }
            _ => {}
        }
        false
    }

    /// The command that is carried out, with other limits.
    pub(super) fn recommand(&mut self, limits: [AxisLimits; N]) -> Result<(), SyncError> {
        match self.command {
            Command::Stop => self.stop_within(limits),
            Command::Jog { velocity, left } => {
                let velocity = std::array::from_fn(|k| velocity[k].clamp(limits[k].v_min(), limits[k].v_max()));
                self.begin_jog(velocity, left, limits)
            }
            Command::PathStop { .. } if self.following.section.is_some() => Err(SyncError::LimitsOfRoute),
            Command::Route => Err(SyncError::LimitsOfRoute),
            Command::Target | Command::PathStop { .. } => {
                self.limits = limits;
                Ok(())
            }
        }
    }

    fn stop_within(&mut self, limits: [AxisLimits; N]) -> Result<(), SyncError> {
        let mut motions = [StateToState::default(); N];
        for k in 0..N {
            motions[k] = self.stop_of(k, &limits[k]).map_err(|source| SyncError::State { axis: k, source })?;
        }
        self.begin_stop(Trajectory::of(motions), limits);
        Ok(())
    }

    /// The shortest stop of an axis inside its range.
    fn stop_of(&self, k: usize, limits: &AxisLimits) -> Result<StateToState, FeedError> {
        let (state, range) = (&self.state[k], &self.ranges[k]);
        let shortest = StateToState::stop(state, limits)?;
        if range.check(&shortest).is_ok() {
            return Ok(shortest);
        }
        StateToState::stop_within(state, limits, (range.lower(), range.upper()))
    }

    /// The shortest stop on a straight line that stays on the plan.
    fn stop_on_line(&self) -> Option<Trajectory<N>> {
        if !(N == 1 || self.following.plan.is_straight()) {
            return None;
        }
        let end = self.section_end().unwrap_or(&self.target);
        let plan = Trajectory::stop_on_line(&self.state, end, &self.limits)?;
        let stays =
            plan.axes().iter().zip(self.following.plan.axes()).zip(&self.ranges).all(|((stop, plan), range)| {
                let (stop_range, way) = (stop.position_range(), plan.position_range());
                let slack = ROUND_OFF * (way.max.abs() + way.min.abs());
                let on_plan = stop_range.min >= way.min - slack && stop_range.max <= way.max + slack;
                on_plan && range.check(stop).is_ok()
            });
        stays.then_some(plan)
    }

    fn begin_stop(&mut self, plan: Trajectory<N>, limits: [AxisLimits; N]) {
        for (k, motion) in plan.axes().iter().enumerate() {
            self.target[k] = AxisState::rest(self.ranges[k].nearest(motion.at(motion.duration()).p));
        }
        self.scale.jump(1.0);
        self.begin(Following::stopping(plan, self.cycle), limits, Command::Stop);
    }

    pub(super) fn begin_jog(
        &mut self,
        velocity: [f64; N],
        left: f64,
        limits: [AxisLimits; N],
    ) -> Result<(), SyncError> {
        let jogging = |from: &[AxisState; N]| Following::jogging(from, &velocity, &limits, &self.ranges);
        let mut next = jogging(self.planning_state())?;
        if !self.scale_fits(&next, None, &limits) {
            next = jogging(&self.state)?;
            self.scale.jump(1.0);
        }
        self.begin(next, limits, Command::Jog { velocity, left });
        Ok(())
    }

    pub(super) fn begin(&mut self, next: Following<N>, limits: [AxisLimits; N], command: Command<N>) {
        self.limits = limits;
        self.command = command;
        self.replanned = true;
        self.adopt(next);
    }
}

/// Relative difference of positions that counts as round-off.
const ROUND_OFF: f64 = 1e-14;
