//! Motion generated cycle by cycle towards targets and within limits that may change at any cycle.

mod coast;
mod events;
mod following;

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw};

use self::coast::Range;
use self::following::Following;
use crate::error::SyncError;
use crate::joint_state::JointState;
use crate::mode::{MotionOptions, Synchronisation};
use crate::state_to_state::{Trajectory, keeps};

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
/// Plans last a whole number of cycles, so that a step ends exactly in the target.
///
/// # After the target
/// An axis at rest stands. An axis whose target has a velocity goes on with it, from its own
/// arrival on. An acceleration of the target is not held: the largest jerk brings it to zero, and
/// the velocity stays what it is then; a target from which that velocity would exceed its limit is
/// refused. [`Events::arrived`] names the axes that arrive in a cycle, [`Events::reached`] says
/// that the last one did.
///
/// With [`Synchronisation::None`] every axis is on its own: it arrives when it can, goes on from
/// there, and neither another target nor other limits of its neighbours change its motion. With
/// every other mode a change plans all axes anew.
///
/// # Ranges
/// With ranges ([`OnlineGenerator::with_ranges`]) no position leaves them. Refused are a start or
/// target outside, a motion that would leave them between, and a target after which the axis could
/// not stop inside. An axis that goes on brakes before the end of its range and stands there
/// ([`Events::range_ends`]).
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
pub struct OnlineGenerator<const N: usize> {
    cycle: f64,
    options: MotionOptions,
    limits: [AxisLimits; N],
    ranges: [Range; N],
    target: [AxisState; N],
    state: [AxisState; N],
    following: Following<N>,
    replanned: bool,
    outside_limits: bool,
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
        let ranges = [Range::ALL; N];
        let following = Following::coasting(&start, &limits, &ranges)?;
        Ok(Self {
            cycle,
            options,
            limits,
            ranges,
            target: start,
            state: start,
            following,
            replanned: false,
            outside_limits: is_outside(&start, &limits),
        })
    }

    /// The range of positions of each axis, lower and upper end; infinite for none.
    ///
    /// # Errors
    /// [`SyncError::Range`]; [`SyncError::OutsideRange`] if a start or target is outside;
    /// [`SyncError::CannotStop`] and [`SyncError::LeavesRange`] if what is under way leaves it.
    ///
    /// ```
    /// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
    /// use arcfeed_sync::{OnlineGenerator, SyncError, Synchronisation};
    /// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?];
    /// let generator = OnlineGenerator::new([AxisState::rest(0.0)], limits, 1e-3, Synchronisation::Time)?;
    /// let mut generator = generator.with_ranges([(-2.0, 2.0)])?;
    /// assert!(matches!(generator.set_target([AxisState::rest(2.5)]), Err(SyncError::OutsideRange { axis: 0, .. })));
    /// // Goes on with 0.5 / s after the target, and stops where the range ends.
    /// generator.set_target([AxisState::new(1.0, 0.5, 0.0)])?;
    /// for _ in 0..10_000 {
    ///     generator.step();
    /// }
    /// assert_eq!(generator.state()[0], AxisState::rest(2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_ranges(mut self, ranges: [(f64, f64); N]) -> Result<Self, SyncError> {
        for (axis, (lower, upper)) in ranges.into_iter().enumerate() {
            // Not a number is no end of a range either.
            if !matches!(lower.partial_cmp(&upper), Some(std::cmp::Ordering::Less)) {
                return Err(SyncError::Range { axis, lower, upper });
            }
            self.ranges[axis] = Range { lower, upper };
        }
        self.check_inside("start", &self.state)?;
        self.check_inside("target", &self.target)?;
        for k in 0..N {
            let (limits, range, axis) = (&self.limits[k], &self.ranges[k], self.following.axes[k]);
            if axis.underway {
                self.following.lead(k, axis.planned, &self.target[k], limits, range)?;
                self.following.axes[k].steps = axis.steps;
            } else {
                self.following.coast(k, &self.state[k], limits, range)?;
            }
        }
        Ok(self)
    }

    /// Sets the state to reach.
    ///
    /// # Errors
    /// As [`Trajectory::new`]. Nothing changes then.
    pub fn set_target(&mut self, target: [AxisState; N]) -> Result<(), SyncError> {
        self.set(target, self.limits)
    }

    /// Sets the state one axis is to reach.
    ///
    /// # Errors
    /// As [`Trajectory::new`], [`SyncError::NoSuchAxis`]. Nothing changes then.
    pub fn set_axis_target(&mut self, axis: usize, target: AxisState) -> Result<(), SyncError> {
        let mut all = self.target;
        *all.get_mut(axis).ok_or(SyncError::NoSuchAxis { axis, count: N })? = target;
        self.set_target(all)
    }

    /// Sets the limits.
    ///
    /// # Errors
    /// As [`Trajectory::new`]: the target must be inside the new limits. Nothing changes then.
    pub fn set_limits(&mut self, limits: [AxisLimits; N]) -> Result<(), SyncError> {
        self.set(self.target, limits)
    }

    /// Sets the limits of one axis.
    ///
    /// # Errors
    /// As [`OnlineGenerator::set_limits`], [`SyncError::NoSuchAxis`]. Nothing changes then.
    pub fn set_axis_limits(&mut self, axis: usize, limits: AxisLimits) -> Result<(), SyncError> {
        let mut all = self.limits;
        *all.get_mut(axis).ok_or(SyncError::NoSuchAxis { axis, count: N })? = limits;
        self.set_limits(all)
    }

    /// Sets target and limits at once: where neither goes with the other's old value.
    ///
    /// # Errors
    /// As [`Trajectory::new`]; [`SyncError::State`] also for a target from which the axis cannot go
    /// on within its velocity limits; with ranges [`SyncError::OutsideRange`],
    /// [`SyncError::LeavesRange`] and [`SyncError::CannotStop`]. Nothing changes then.
    pub fn set(&mut self, target: [AxisState; N], limits: [AxisLimits; N]) -> Result<(), SyncError> {
        let order = Order { target: &target, limits: &limits };
        let mut next = None;
        let mut replanned = false;
        if self.options.synchronisation() == Synchronisation::None {
            for k in 0..N {
                replanned |= self.change([k], &order, &mut next)?;
            }
        } else {
            replanned = self.change(std::array::from_fn::<_, N, _>(|k| k), &order, &mut next)?;
        }
        self.limits = limits;
        self.replanned |= replanned;
        if let Some(next) = next {
            self.following = next;
            self.outside_limits = is_outside(&self.state, &limits);
        }
        for ((old, new), axis) in self.target.iter_mut().zip(&target).zip(&self.following.axes) {
            // Arrival is exact for the latest target, the same one up to round-off included.
            if axis.underway {
                *old = *new;
            }
        }
        Ok(())
    }

    /// Plans the motion of a group of axes that move together for an order, and puts it into `next`
    /// where it is a new plan. Returns true if it is.
    fn change<const M: usize>(
        &self,
        group: [usize; M],
        order: &Order<'_, N>,
        next: &mut Option<Following<N>>,
    ) -> Result<bool, SyncError> {
        let (target, limits) = (order.target, order.limits);
        let same_target = group.iter().all(|&k| self.is_target(k, &target[k]));
        if same_target && group.iter().all(|&k| limits[k] == self.limits[k]) {
            return Ok(false);
        }
        if !same_target {
            self.check_inside("target", target)?;
        }
        let next = next.get_or_insert(self.following);
        if same_target && !group.iter().any(|&k| self.following.axes[k].underway) {
            // Arrived: nothing to plan but the way back inside.
            for &k in &group {
                next.coast(k, &self.state[k], &limits[k], &self.ranges[k])?;
            }
            return Ok(false);
        }
        let (from, to, within) = (group.map(|k| self.state[k]), group.map(|k| target[k]), group.map(|k| limits[k]));
        let plan = Trajectory::<M>::new(&from, &to, &within, &self.options).map_err(|e| e.of_axis(|k| group[k]))?;
        let left = group.iter().fold(0.0, |t: f64, &k| t.max(self.time_left_of(k)));
        if same_target && plan.duration() >= left && group.iter().all(|&k| self.plan_keeps(k, &limits[k])) {
            for &k in &group {
                next.arrange_after(k, &target[k], &limits[k], &self.ranges[k])?;
            }
            return Ok(false);
        }
        next.plan.take(&group, &plan);
        for (&k, motion) in group.iter().zip(plan.axes()) {
            let planned = (motion.duration() / self.cycle).round();
            next.lead(k, planned, &target[k], &limits[k], &self.ranges[k])?;
        }
        Ok(true)
    }

    /// Moves on by one cycle.
    pub fn step(&mut self) -> Step<N> {
        let mut events = Events { replanned: self.replanned, outside_limits: self.outside_limits, ..Events::default() };
        let mut state = JointState::default();
        for k in 0..N {
            let step = self.following.step(k, self.cycle, &self.target[k]);
            (events.arrived[k], events.range_ends[k]) = (step.arrived, step.range_ends);
            let p = self.ranges[k].cut(step.state.p);
            (state.q[k], state.qd[k], state.qdd[k], state.qddd[k]) = (p, step.state.v, step.state.a, step.state.j);
            self.state[k] = AxisState::new(p, step.state.v, step.state.a);
        }
        events.reached = events.arrived.contains(&true) && !self.is_underway();
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

    /// Returns true if an axis has still to reach its target.
    pub fn is_underway(&self) -> bool {
        self.following.axes.iter().any(|a| a.underway)
    }

    /// Time until the last axis has reached its target (s).
    pub fn time_left(&self) -> f64 {
        (0..N).fold(0.0, |t: f64, k| t.max(self.time_left_of(k)))
    }

    fn time_left_of(&self, k: usize) -> f64 {
        let axis = &self.following.axes[k];
        if axis.underway { (axis.planned - axis.steps).max(0.0) * self.cycle } else { 0.0 }
    }

    /// The motion followed at present, each axis since its own was planned.
    pub const fn plan(&self) -> &Trajectory<N> {
        &self.following.plan
    }

    fn check_inside(&self, what: &'static str, states: &[AxisState; N]) -> Result<(), SyncError> {
        for (axis, (range, s)) in self.ranges.iter().zip(states).enumerate() {
            let Range { lower, upper } = *range;
            // The planner says what is not a number.
            if !range.contains(s.p) && !s.p.is_nan() {
                return Err(SyncError::OutsideRange { axis, what, position: s.p, lower, upper });
            }
        }
        Ok(())
    }

    /// Returns true if `new` is the target set already, up to round-off in the caller's arithmetic.
    fn is_target(&self, k: usize, new: &AxisState) -> bool {
        let (old, s, l) = (&self.target[k], &self.state[k], &self.limits[k]);
        let same = |x: f64, y: f64, size: f64| x == y || (x - y).abs() <= ROUND_OFF * size;
        same(old.p, new.p, old.p.abs() + s.p.abs())
            && same(old.v, new.v, l.v_max() - l.v_min())
            && same(old.a, new.a, l.a_max() - l.a_min())
    }

    /// Returns true if what is left of the plan of an axis stays within `limits`.
    fn plan_keeps(&self, k: usize, limits: &AxisLimits) -> bool {
        keeps(&self.following.plan.axes()[k], self.following.axes[k].steps * self.cycle, limits)
    }
}

/// The target that is set.
struct Order<'a, const N: usize> {
    target: &'a [AxisState; N],
    limits: &'a [AxisLimits; N],
}

fn is_outside<const N: usize>(state: &[AxisState; N], limits: &[AxisLimits; N]) -> bool {
    state.iter().zip(limits).any(|(s, l)| !l.contain(s))
}

/// Relative difference that counts as round-off in the caller's arithmetic.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;
