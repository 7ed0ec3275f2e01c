//! Motion generated cycle by cycle towards targets and within limits that may change at any cycle.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};

use crate::error::SyncError;
use crate::mode::{MotionOptions, Synchronisation};
use crate::point_to_point::JointState;
use crate::sampler::Window;
use crate::state_to_state::Trajectory;

/// What one cycle brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<const N: usize> {
    /// The state to command at the end of this cycle.
    pub state: JointState<N>,
    /// What happened.
    pub events: Events,
}

/// What happened in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Events {
    /// All axes arrived in this cycle, exactly.
    pub reached: bool,
    /// A new plan took effect because the target or the limits changed.
    pub replanned: bool,
    /// Limits were set below the state of an axis: it is brought back inside, with its jerk limited, while this holds.
    pub outside_limits: bool,
}

/// Generates the motion of `N` axes one control cycle at a time.
///
/// Set targets and limits whenever they change, for all axes or for one; every [`step`](Self::step) then yields the next state.
/// The new plan starts in the state of the last step, so that position, velocity and acceleration are continuous. (Liu et al. 2024,
/// section 4.2, ask for this by an error projected cycle by cycle; here every plan is the time-optimal one.)
///
/// **A plan is kept while it is valid.** Setting the target that is set already, exactly or up to round-off in the caller's
/// arithmetic, changes nothing. Planning anew from where the plan has got to would give the same motion but for
/// round-off, and between moving states the shortest duration jumps: round-off can fall on the wrong side
/// and the target would be missed every time.
///
/// Setting a target again after it was reached changes nothing either.
///
/// Plans last a whole number of cycles, so that a step ends exactly in the target. After it an axis stands, or
/// goes on with the velocity it has once its acceleration is back at zero.
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
    target: [AxisState; N],
    state: [AxisState; N],
    plan: Trajectory<N>,
    window: Window<N>,
    /// Cycles since the plan began, and in the whole plan.
    steps: f64,
    steps_planned: f64,
    /// The plan leads to the target; otherwise it goes on after it.
    underway: bool,
    events: Events,
}

impl<const N: usize> OnlineGenerator<N> {
    /// At `start`, which is the target, too, until one is set; `cycle` in s. A start that moves goes on moving.
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
        let mut generator = Self {
            cycle,
            options,
            limits,
            target: start,
            state: start,
            plan: Trajectory::coasting(&start, &limits)?,
            window: Window::default(),
            steps: 0.0,
            steps_planned: 0.0,
            underway: false,
            events: Events::default(),
        };
        generator.events.outside_limits = generator.is_outside();
        Ok(generator)
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
    /// As [`Trajectory::new`]. Nothing changes then.
    pub fn set(&mut self, target: [AxisState; N], limits: [AxisLimits; N]) -> Result<(), SyncError> {
        let same_target = self.is_target(&target);
        let same_limits = limits == self.limits;
        if same_target && same_limits {
            // Arrival is exact for the latest one.
            if self.underway {
                self.target = target;
            }
            return Ok(());
        }
        if !self.underway && same_target {
            // Arrived: nothing to plan but the way back inside.
            let plan = Trajectory::coasting(&self.state, &limits)?;
            self.limits = limits;
            self.follow(plan, false);
            return Ok(());
        }
        let plan = Trajectory::new(&self.state, &target, &limits, &self.options)?;
        let left = (self.steps_planned - self.steps) * self.cycle;
        let keep = same_target && plan.duration() >= left && self.plan_keeps(&limits);
        (self.target, self.limits) = (target, limits);
        if !keep {
            self.follow(plan, true);
        }
        Ok(())
    }

    /// Moves on by one cycle.
    pub fn step(&mut self) -> Step<N> {
        let mut events = self.events;
        if self.underway && self.steps_planned == 0.0 && self.coast() {
            events.reached = true;
        }
        self.steps += 1.0;
        let mut state = self.window.sample(&self.plan, self.steps * self.cycle);
        if self.underway && self.steps >= self.steps_planned {
            events.reached = true;
            for (k, t) in self.target.iter().enumerate() {
                (state.q[k], state.qd[k], state.qdd[k], state.qddd[k]) = (t.p, t.v, t.a, 0.0);
            }
        }
        for (k, s) in self.state.iter_mut().enumerate() {
            *s = AxisState::new(state.q[k], state.qd[k], state.qdd[k]);
        }
        if events.reached
            && let Ok(plan) = Trajectory::coasting(&self.state, &self.limits)
        {
            self.follow(plan, false);
        }
        self.events = Events::default();
        self.events.outside_limits = events.outside_limits && self.is_outside();
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

    /// Whether the target has still to be reached.
    pub const fn is_underway(&self) -> bool {
        self.underway
    }

    /// How long it will take to reach the target (s).
    pub fn time_left(&self) -> f64 {
        if self.underway { (self.steps_planned - self.steps).max(0.0) * self.cycle } else { 0.0 }
    }

    /// The motion followed at present; [`OnlineGenerator::step`] is in it since the last change.
    pub const fn plan(&self) -> &Trajectory<N> {
        &self.plan
    }

    /// Goes on after the target.
    fn coast(&mut self) -> bool {
        let Ok(plan) = Trajectory::coasting(&self.state, &self.limits) else { return false };
        self.follow(plan, false);
        true
    }

    fn follow(&mut self, plan: Trajectory<N>, underway: bool) {
        self.steps = 0.0;
        self.steps_planned = (plan.duration() / self.cycle).round();
        self.plan = plan;
        self.window = Window::default();
        self.underway = underway;
        self.events.replanned |= underway;
        self.events.outside_limits = self.is_outside();
    }

    /// Whether `target` is the one set already, up to round-off in the caller's arithmetic.
    fn is_target(&self, target: &[AxisState; N]) -> bool {
        self.target.iter().zip(target).zip(&self.limits).zip(&self.state).all(|(((old, new), l), s)| {
            let same = |x: f64, y: f64, size: f64| x == y || (x - y).abs() <= ROUND_OFF * size;
            same(old.p, new.p, old.p.abs() + s.p.abs())
                && same(old.v, new.v, l.v_max() - l.v_min())
                && same(old.a, new.a, l.a_max() - l.a_min())
        })
    }

    /// Whether what is left of the plan stays within `limits`.
    fn plan_keeps(&self, limits: &[AxisLimits; N]) -> bool {
        let now = self.steps * self.cycle;
        self.plan.axes().iter().zip(limits).all(|(axis, l)| keeps(axis, now, l))
    }

    fn is_outside(&self) -> bool {
        self.state.iter().zip(&self.limits).any(|(s, l)| !l.contain(s))
    }
}

/// Whether a motion stays within the limits from `now` on.
fn keeps(motion: &StateToState, now: f64, l: &AxisLimits) -> bool {
    motion.phases().filter(|(phase, dt)| phase.t + dt > now).all(|(phase, dt)| {
        let from = (now - phase.t).max(0.0);
        let top = -phase.a / phase.j;
        let top = if top > from && top < dt { top } else { from };
        let jerk = phase.j >= l.j_min() * ROUNDED && phase.j <= l.j_max() * ROUNDED;
        jerk && [from, top, dt].into_iter().all(|t| {
            let s = phase.after(t);
            l.contain_now(&AxisState::new(s.p, s.v, s.a))
        })
    }) && motion.duration() >= now
}

/// What differs by less, relative to the size of the numbers, differs by round-off in the caller's arithmetic.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;
const ROUNDED: f64 = 1.0 + ROUND_OFF;
