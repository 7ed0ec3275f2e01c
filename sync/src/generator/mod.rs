//! Motion generated cycle by cycle towards targets and within limits that may change at any cycle.

mod coast;
mod command;
mod commands;
mod course;
mod events;
mod following;
mod planning;
mod ranges;
mod route;
mod time_scale;

use arcfeed_feedrate::{AxisLimits, AxisState, PositionLimits};

use self::command::Command;
use self::following::Following;
use self::time_scale::TimeScale;
use crate::error::SyncError;
use crate::joint_state::JointState;
use crate::mode::{MotionOptions, Synchronisation};
use crate::state_to_state::Trajectory;
use crate::way_points::RouteMemory;

pub use self::events::{Events, Step};

/// Generates the motion of `N` axes one control cycle at a time.
///
/// Set targets and limits whenever they change, for all axes or for one; every [`step`](Self::step)
/// then yields the next state. The new plan starts in the state of the last step, so that position,
/// velocity and acceleration are continuous. (Liu et al. 2024, section 4.2, ask for this by an
/// error projected cycle by cycle; here every plan is the time-optimal one.)
///
/// **A plan is kept while it is valid.** Setting the target that is set already, exactly or up to
/// round-off in the caller's arithmetic, changes nothing. Planning anew from where the plan has got
/// to would give the same motion but for round-off, and between moving states the shortest duration
/// jumps: round-off can fall on the wrong side and the target would be missed every time.
///
/// Setting a target again after it was reached changes nothing either.
///
/// Plans to a target last a whole number of cycles, so that a step ends exactly in the target.
///
/// # After the target
/// An axis at rest stands. An axis whose target has a velocity goes on with it, from its own
/// arrival on. An acceleration of the target is not held: the largest jerk brings it to zero, and
/// the velocity stays what it is then; a target from which that velocity would exceed its limit is
/// refused. [`Events::arrived`] names the axes that arrive in a cycle, [`Events::reached`] says
/// that the last one did.
///
/// With [`Synchronisation::None`] every axis is on its own: it arrives when it can, goes on from
/// there, and neither another target nor other limits of its neighbours change its motion, with one
/// exception: where the scale of time cannot go on with what a neighbour is told, all axes are planned
/// anew from the state commanded last ([`OnlineGenerator::set_scale`]). With every other mode a change
/// plans all axes anew.
///
/// # Ranges
/// With ranges ([`OnlineGenerator::with_ranges`]) no position leaves them. A motion that would leave
/// them between is bent: it touches the end of the range instead of passing it
/// ([`BoundedProblem`](arcfeed_feedrate::BoundedProblem)), and the axes still arrive together. A
/// forced straight line is not bent. Refused are a start or target outside, a state from which no
/// braking stays inside, and a target after which the axis could not stop inside. An axis that goes on brakes before the end of its range and stands there
/// ([`Events::range_ends`]).
///
/// # Interruption
/// [`OnlineGenerator::stop`] brakes every axis in the shortest way, and
/// [`OnlineGenerator::stop_on_path`] all of them on the curve they are on. A jog holds velocities
/// for a time ([`OnlineGenerator::jog`]). The scale of time slows the motion down on its curve
/// ([`OnlineGenerator::set_scale`]), to a hold and back ([`OnlineGenerator::hold`],
/// [`OnlineGenerator::resume`]).
///
/// # Way-points
/// A generator with a place for a route ([`OnlineGenerator::with_way_points`]) goes through
/// way-points without stopping, from any state and at any cycle ([`OnlineGenerator::set_route`]).
/// A stop, a jog or a target leaves it; a hold and a scale of time act on it; its limits are its own.
///
/// No call allocates. A refused setting leaves everything as it was.
///
/// ```
/// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
/// use arcfeed_sync::{OnlineGenerator, Synchronisation};
/// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?; 2];
/// let mut generator = OnlineGenerator::new([AxisState::rest(0.0); 2], limits, 1e-3, Synchronisation::Time)?;
/// generator.set_target([AxisState::rest(0.5), AxisState::rest(-0.2)])?;
/// for _ in 0..300 {
///     generator.step();
/// }
/// // On the way the second axis gets another target and the first one a lower velocity limit.
/// generator.set_axis_target(1, AxisState::new(0.1, 0.05, 0.0))?;
/// generator.set_axis_limits(0, AxisLimits::symmetric(0.5, 5.0, 50.0)?)?;
/// let end = loop {
///     let step = generator.step();
///     if step.events.reached {
///         break step.state;
///     }
/// };
/// assert_eq!((end.q[0], end.qd[0], end.q[1], end.qd[1]), (0.5, 0.0, 0.1, 0.05));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct OnlineGenerator<const N: usize, R = ()> {
    cycle: f64,
    options: MotionOptions,
    limits: [AxisLimits; N],
    ranges: [PositionLimits; N],
    target: [AxisState; N],
    /// The state of the plan: that of the last step, were it played at scale 1.
    planned: [AxisState; N],
    /// The state of the last step.
    state: [AxisState; N],
    command: Command<N>,
    scale: TimeScale,
    following: Following<N>,
    replanned: bool,
    outside_limits: bool,
    /// The motion along the route set last, where there is a place for one.
    route: R,
}

impl<const N: usize> OnlineGenerator<N> {
    /// At `start`, which is the target, too, until one is set; `cycle` in s. A start that moves
    /// goes on moving.
    ///
    /// # Errors
    /// [`SyncError::Cycle`]; [`SyncError::State`] naming the axis whose start is not finite.
    pub fn new(
        start: [AxisState; N],
        limits: [AxisLimits; N],
        cycle: f64,
        synchronisation: Synchronisation,
    ) -> Result<Self, SyncError> {
        let options = MotionOptions::new(synchronisation).with_cycle(cycle)?;
        let ranges = [PositionLimits::ALL; N];
        let following = Following::coasting(&start, &limits, &ranges)?;
        Ok(Self {
            cycle,
            options,
            limits,
            ranges,
            target: start,
            planned: start,
            state: start,
            command: Command::Target,
            scale: TimeScale::default(),
            following,
            replanned: false,
            outside_limits: is_outside(&start, &limits),
            route: (),
        })
    }
}

impl<const N: usize, R: RouteMemory<N>> OnlineGenerator<N, R> {
    /// Moves on by one cycle.
    pub fn step(&mut self) -> Step<N> {
        let mut pace = self.pace();
        let passed = self.pass_points(pace.cycles(self.cycle)).unwrap_or_else(|_| {
            // No section fails that did not when the route was set. If one does, the axes do not go on.
            let _ = self.stop();
            pace = self.pace();
            0
        });
        let cycles = pace.cycles(self.cycle);
        let mut events = Events { replanned: self.replanned, outside_limits: self.outside_limits, ..Events::default() };
        events.passed = passed;
        let mut state = JointState::default();
        for k in 0..N {
            let step = self.following.step(k, (pace.elapsed, cycles), self.cycle, &self.target[k]);
            (events.arrived[k], events.range_ends[k]) = (step.arrived, step.range_ends);
            // An axis that coasts for ages ends at the last number.
            let p = self.ranges[k].nearest(step.state.p).clamp(f64::MIN, f64::MAX);
            let now = pace.apply(&step.state);
            (state.q[k], state.qd[k], state.qdd[k], state.qddd[k]) = (p, now.v, now.a, now.j);
            self.planned[k] = AxisState::new(p, step.state.v, step.state.a);
            self.state[k] = AxisState::new(p, now.v, now.a);
        }
        events.reached = events.arrived.contains(&true) && !self.is_underway();
        events.reached |= self.end_stop();
        self.replanned = false;
        self.outside_limits = events.outside_limits && is_outside(&self.state, &self.limits);
        Step { state, events }
    }

    /// The state of the last step.
    pub const fn state(&self) -> &[AxisState; N] {
        &self.state
    }

    /// The state to reach.
    pub const fn target(&self) -> &[AxisState; N] {
        &self.target
    }

    /// The limits in effect.
    pub const fn limits(&self) -> &[AxisLimits; N] {
        &self.limits
    }

    /// Returns true if an axis has still to reach its target, at the end of the route if there is one.
    pub fn is_underway(&self) -> bool {
        self.following.axes.iter().any(|a| a.underway)
    }

    /// Time until the last axis has reached its target (s), at scale 1.
    pub fn time_left(&self) -> f64 {
        (0..N).fold(0.0, |t: f64, k| t.max(self.time_left_of(k)))
    }

    fn time_left_of(&self, k: usize) -> f64 {
        let axis = &self.following.axes[k];
        let left = (axis.planned - axis.steps).max(0.0) * self.cycle + self.time_after_section();
        if axis.underway { left.min(f64::MAX) } else { 0.0 }
    }

    /// The motion followed at present, each axis since its own was planned; on a route that of the
    /// section under way.
    pub const fn plan(&self) -> &Trajectory<N> {
        &self.following.plan
    }
}

fn is_outside<const N: usize>(state: &[AxisState; N], limits: &[AxisLimits; N]) -> bool {
    state.iter().zip(limits).any(|(s, l)| !l.contain(s))
}
