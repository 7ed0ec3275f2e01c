//! Motion through way-points, one control cycle at a time.

use arcfeed_feedrate::{AxisState, StateToState};

use super::planner::WayPointPlanner;
use super::route::Route;
use super::trajectory::WayPointTrajectory;
use crate::error::SyncError;
use crate::joint_state::JointState;
use crate::state_to_state::Trajectory;

/// The state after a cycle, and what happened in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WayPointStep<const N: usize> {
    /// Position, velocity, acceleration and jerk of the axes at the end of the cycle.
    pub state: JointState<N>,
    /// Number of way-points of the route that have been passed.
    pub passed: usize,
    /// The end of the motion was reached in this cycle: the target, or the rest after a stop.
    pub reached: bool,
}

/// Generates a motion through way-points one control cycle at a time, along a route that may be
/// replaced in any cycle.
///
/// A new route begins in the state of the last step, so that position, velocity and acceleration
/// are continuous. Its computation takes place in [`WayPointGenerator::set_route`] and is bounded by
/// the number of points and rounds; [`WayPointGenerator::step`] costs microseconds where a section
/// begins, and much less else. Nothing allocates. Between cycles the limits hold as in them.
///
/// After the end the axes go on with the velocity of the target.
///
/// ```
/// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
/// use arcfeed_sync::{Route, WayPoint, WayPointGenerator};
/// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?; 2];
/// let points = [WayPoint::new([0.4, 0.1]), WayPoint::new([0.8, 0.5])];
/// let route = Route::new(&points, [1.0, 1.0].map(AxisState::rest), limits);
/// let mut generator = WayPointGenerator::new([AxisState::rest(0.0); 2], &route, 1e-3)?;
/// while generator.step().passed == 0 {}
/// // On the way another route is set.
/// let points = [WayPoint::new([0.9, 0.3])];
/// generator.set_route(&Route::new(&points, [1.0, 0.0].map(AxisState::rest), limits))?;
/// while !generator.step().reached {}
/// assert_eq!(generator.state()[0].p, 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct WayPointGenerator<const N: usize> {
    planner: WayPointPlanner<N>,
    motion: WayPointTrajectory<N>,
    cycle: f64,
    /// The section under way, and the time since it began (s).
    section: usize,
    current: Trajectory<N>,
    since: f64,
    state: [AxisState; N],
    /// No section follows the current motion.
    last: bool,
    reached: bool,
}

impl<const N: usize> WayPointGenerator<N> {
    /// From `start` along `route`, with a control cycle (s).
    ///
    /// # Errors
    /// [`SyncError::Cycle`], and as [`WayPointPlanner::plan`].
    pub fn new(start: [AxisState; N], route: &Route<'_, N>, cycle: f64) -> Result<Self, SyncError> {
        if !(cycle.is_finite() && cycle > 0.0) {
            return Err(SyncError::Cycle { value: cycle });
        }
        let mut planner = WayPointPlanner::new();
        let motion = planner.plan(&start, route)?;
        let current = motion.section(0)?;
        Ok(Self {
            planner,
            last: motion.section_durations().len() == 1,
            motion,
            cycle,
            section: 0,
            current,
            since: 0.0,
            state: start,
            reached: false,
        })
    }

    /// Goes along another route from the state of the last step on.
    ///
    /// # Errors
    /// As [`WayPointPlanner::plan`]. The motion goes on as it is then.
    pub fn set_route(&mut self, route: &Route<'_, N>) -> Result<(), SyncError> {
        let motion = self.planner.plan(&self.state, route)?;
        self.current = motion.section(0)?;
        self.last = motion.section_durations().len() == 1;
        self.motion = motion;
        (self.section, self.since, self.reached) = (0, 0.0, false);
        Ok(())
    }

    /// Brings every axis to rest in the shortest way of its own, within the limits of the
    /// section under way, and gives up the route.
    ///
    /// # Errors
    /// [`SyncError::State`] naming an axis whose stop has no finite numbers. The motion goes on as
    /// it is then.
    pub fn stop(&mut self) -> Result<(), SyncError> {
        let limits = &self.motion.limits[self.section];
        let mut motions = [StateToState::default(); N];
        for (axis, motion) in motions.iter_mut().enumerate() {
            *motion = StateToState::stop(&self.state[axis], &limits[axis])
                .map_err(|source| SyncError::State { axis, source })?;
        }
        self.current = Trajectory::of(motions);
        (self.last, self.since, self.reached) = (true, 0.0, false);
        Ok(())
    }

    /// Moves on by one cycle.
    pub fn step(&mut self) -> WayPointStep<N> {
        self.since += self.cycle;
        while !self.last && self.since >= self.current.duration() {
            // Computed before with the same result: what cannot fail would keep the motion as it is.
            let Ok(next) = self.motion.section(self.section + 1) else { break };
            self.since -= self.current.duration();
            self.current = next;
            self.section += 1;
            self.last = self.section + 1 == self.motion.section_durations().len();
        }
        let mut state = self.current.at(self.since);
        // An axis that goes on for ages after the end stays at the last number.
        state.q.apply(|q| *q = q.clamp(f64::MIN, f64::MAX));
        self.state = std::array::from_fn(|k| AxisState::new(state.q[k], state.qd[k], state.qdd[k]));
        let there = self.last && self.since >= self.current.duration();
        let reached = there && !self.reached;
        self.reached = there;
        WayPointStep { state, passed: self.section, reached }
    }

    /// The state of the last step.
    pub const fn state(&self) -> &[AxisState; N] {
        &self.state
    }

    /// The motion along the route set last.
    pub const fn motion(&self) -> &WayPointTrajectory<N> {
        &self.motion
    }
}
