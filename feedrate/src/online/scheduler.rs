//! The scheduler: one step a cycle, limits and end changeable in between.

use super::plan::{Plan, entry_speed};
use crate::error::{FeedError, finite, not_negative};
use crate::limits::AxisLimits;
use crate::state::{AxisState, MotionState};

/// The extent to which new limits could be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adoption {
    /// From here on, or from where the state has been brought inside, everything keeps the new
    /// limits. A speed limit below the speed asked for at the end is exceeded by the last change of
    /// speed alone.
    Full,
    /// The end is too close for all of them. In force are [`FeedScheduler::limits`]: the new speed
    /// limit (raised to what the end takes if it cannot be met before), and the wider of old and
    /// new in acceleration and jerk.
    Partial,
    /// The end is too close for any change: the motion goes on as before.
    Nothing,
}

/// Status of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FeedStatus {
    /// On the way, or braking for a hold.
    Moving,
    /// At rest before the end, because `v_max` is 0.
    Holding,
    /// At the end, in exactly the state asked for.
    Reached {
        /// Part of the last period that was not needed (s): what a following motion starts with.
        unused: f64,
    },
}

/// State and status after a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedStep {
    /// Position, speed, acceleration, and the jerk that acts from here on.
    pub state: MotionState,
    /// Status of the motion.
    pub status: FeedStatus,
}

/// Motion of one scalar to the end of a path under limits that may change in any cycle (Liu et al.
/// 2024, section 3, corrected).
///
/// Once a cycle [`FeedScheduler::step`] yields the state. Between two cycles every limit may
/// change, including an override of the speed or a hold (`v_max = 0` in [`AxisLimits::forward`]).
/// The lower limit on the speed is not used: the motion runs forward only.
///
/// **Guarantees**: the end state is exact. Jerk is inside the bounds in force in every cycle. Speed
/// and acceleration are inside theirs, or on the shortest way back. The motion never runs
/// backwards, unless the start state forces it to (already running back, or braking too hard to
/// stop braking in time; round-off where the end lies exactly at the braking distance is below 1e-9
/// of the highest speed). Stepping allocates nothing, and takes the same few operations in every
/// cycle; a changed limit costs at most three exact plans.
///
/// # Departures from print
/// The paper chooses the jerk of every cycle by tests on the current state (eqs. 3 to 13), sums it
/// up (eq. 2) and takes off the error of the sum at the end. As printed this runs away; with eqs. 3
/// to 16 corrected it ends up to 0.030 mm beside the end in the motion of Table 3, and the correction
/// at the end is a jump. Here the same motion (largest jerk to the speed limit, cruise, and the
/// braking or accelerating polynomial to the end, eqs. 6 to 16) is one exact plan, kept for as long
/// as it is valid and sampled once a cycle. So
///
/// * `s`, `v` and `a` at the end are exactly the ones asked for, whatever the cycle;
/// * jerk never leaves its bounds, not in the cycle in which a limit changes and not at the end;
/// * a limit lowered under the current state is returned to with bounded jerk, without passing the
///   limit and coming back;
/// * the choice between braking and accelerating at the end (in print by `max(Sdec, Sacc)`, which
///   can be imaginary) follows from the sign of the change of speed.
///
/// ```
/// use arcfeed_feedrate::{AxisLimits, AxisState, FeedScheduler, FeedStatus};
/// let full = AxisLimits::forward(0.1, (-2.0, 1.0), (-50.0, 40.0))?;
/// let mut feed = FeedScheduler::new(&AxisState::rest(0.0), &AxisState::new(0.2, 0.02, 0.0), &full)?;
/// let mut cycle = 0;
/// let last = loop {
///     match cycle {
///         500 => drop(feed.set_limits(&full.with_v_max(0.0)?)?), // hold
///         900 => drop(feed.set_limits(&full.with_v_max(0.05)?)?), // go on at half speed
///         _ => {}
///     }
///     let step = feed.step(1e-3)?;
///     if let FeedStatus::Reached { .. } = step.status {
///         break step.state;
///     }
///     cycle += 1;
/// };
/// assert_eq!((last.p, last.v, last.a), (0.2, 0.02, 0.0));
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct FeedScheduler {
    plan: Plan,
    /// Time since the plan was made.
    t: f64,
    target: AxisState,
    /// Last ones asked for.
    wanted: AxisLimits,
    /// The ones the plan keeps.
    in_force: AxisLimits,
}

impl FeedScheduler {
    /// From `start` to arrive in `end`, as soon as possible.
    ///
    /// The start may be outside the limits; its speed may even be negative.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] or [`FeedError::Negative`] naming the field (`end.v` must not be
    /// negative); [`FeedError::AboveLimit`] or [`FeedError::BelowLimit`] if the end's acceleration
    /// is outside the limits, or such that its speed would have been negative just before;
    /// [`FeedError::EndTooClose`] if no motion arrives without running backwards.
    pub fn new(start: &AxisState, end: &AxisState, limits: &AxisLimits) -> Result<Self, FeedError> {
        finite("start.p", start.p)?;
        finite("start.v", start.v)?;
        finite("start.a", start.a)?;
        check_target(end, limits)?;
        let plan = Plan::new(start, end, limits, limits.j_max())?;
        Ok(Self { plan, t: 0.0, target: *end, wanted: *limits, in_force: *limits })
    }

    /// Advances by `period` (s).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] or [`FeedError::Negative`] for the period; the motion then stays
    /// where it is.
    #[inline]
    pub fn step(&mut self, period: f64) -> Result<FeedStep, FeedError> {
        let period = not_negative("period", finite("period", period)?)?;
        let was = self.t;
        self.t = (was + period).min(self.plan.phases.duration);
        let status = match (self.t >= self.plan.phases.duration, self.plan.arrives) {
            (false, _) => FeedStatus::Moving,
            (true, true) => FeedStatus::Reached { unused: (was + period - self.plan.phases.duration).max(0.0) },
            (true, false) => FeedStatus::Holding,
        };
        Ok(FeedStep { state: self.state(), status })
    }

    /// Follows new limits from here on, as far as the end allows.
    ///
    /// The plan is kept if it keeps the new limits and no other arrives sooner; asking again for
    /// the limits in force costs nothing.
    ///
    /// # Errors
    /// [`FeedError::AboveLimit`] or [`FeedError::BelowLimit`] if the end's acceleration is outside;
    /// the motion then goes on as before.
    pub fn set_limits(&mut self, limits: &AxisLimits) -> Result<Adoption, FeedError> {
        if *limits == self.in_force {
            self.wanted = *limits;
            return Ok(Adoption::Full);
        }
        check_end(&self.target, limits)?;
        self.wanted = *limits;
        if self.has_arrived() {
            self.in_force = *limits;
            return Ok(Adoption::Full);
        }
        let from = self.current();
        let kept = self.plan.arrives && self.plan.keeps(limits, self.t);
        let wide = widened(limits, &self.in_force);
        let release = wide.j_max();
        if let Ok(plan) = Plan::new(&from, &self.target, limits, release) {
            self.in_force = *limits;
            // Halfway through braking for the end, round-off must not replace the plan by a detour.
            if !(kept
                && plan.arrives
                && plan.phases.duration >= (self.plan.phases.duration - self.t) * (1.0 - SHORTER_BY))
            {
                self.adopt(plan);
            }
            return Ok(Adoption::Full);
        }
        if kept {
            self.in_force = *limits;
            return Ok(Adoption::Full);
        }
        let raised = AxisLimits { v: (wide.v.0, wide.v.1.max(entry_speed(&wide, &self.target))), ..wide };
        for softer in [wide, raised] {
            if let Ok(plan) = Plan::new(&from, &self.target, &softer, release) {
                self.in_force = softer;
                self.adopt(plan);
                return Ok(Adoption::Partial);
            }
        }
        Ok(Adoption::Nothing)
    }

    /// Moves the end, or asks for another speed or acceleration there, under the limits last asked
    /// for.
    ///
    /// # Errors
    /// As [`FeedScheduler::new`]; the motion then goes on to the old end.
    pub fn set_end(&mut self, end: &AxisState) -> Result<(), FeedError> {
        if *end == self.target {
            return Ok(());
        }
        check_target(end, &self.wanted)?;
        let plan = Plan::new(&self.current(), end, &self.wanted, self.wanted.j_max().max(self.in_force.j_max()))?;
        self.target = *end;
        self.in_force = self.wanted;
        self.adopt(plan);
        Ok(())
    }

    /// The state now.
    #[inline]
    pub fn state(&self) -> MotionState {
        self.plan.phases.at(self.t)
    }

    /// Limits the present motion keeps, or is on its way back to.
    pub const fn limits(&self) -> &AxisLimits {
        &self.in_force
    }

    /// The end asked for.
    pub const fn end(&self) -> &AxisState {
        &self.target
    }

    /// Time to the end if nothing changes (s); infinite during a hold.
    pub fn remaining(&self) -> f64 {
        if self.plan.arrives { self.plan.phases.duration - self.t } else { f64::INFINITY }
    }

    fn has_arrived(&self) -> bool {
        self.plan.arrives && self.t >= self.plan.phases.duration
    }

    fn current(&self) -> AxisState {
        let now = self.state();
        AxisState::new(now.p, now.v, now.a)
    }

    fn adopt(&mut self, plan: Plan) {
        self.plan = plan;
        self.t = 0.0;
    }
}

/// A new plan must be shorter by this much, relative, to replace one that is still valid.
const SHORTER_BY: f64 = 1e-12;

fn check_target(end: &AxisState, limits: &AxisLimits) -> Result<(), FeedError> {
    finite("end.p", end.p)?;
    finite("end.v", end.v)?;
    finite("end.a", end.a)?;
    check_end(end, limits)
}

/// Returns an error unless the end speed and acceleration are possible: inside the acceleration
/// limits, and neither entered nor left from below zero.
fn check_end(end: &AxisState, limits: &AxisLimits) -> Result<(), FeedError> {
    not_negative("end.v", end.v)?;
    if end.a > limits.a_max() {
        return Err(FeedError::AboveLimit { what: "end.a", value: end.a, limit: limits.a_max() });
    }
    if end.a < limits.a_min() {
        return Err(FeedError::BelowLimit { what: "end.a", value: end.a, limit: limits.a_min() });
    }
    let gained = 0.5 * end.a.max(0.0) * (end.a / limits.j_max());
    if gained > end.v * (1.0 + 1e-13) {
        return Err(FeedError::BelowLimit { what: "end.v", value: end.v, limit: gained });
    }
    Ok(())
}

/// The wider of both limits in acceleration and jerk, with the speed of the first.
fn widened(limits: &AxisLimits, other: &AxisLimits) -> AxisLimits {
    let union = |x: (f64, f64), y: (f64, f64)| (x.0.min(y.0), x.1.max(y.1));
    AxisLimits { v: limits.v, a: union(limits.a, other.a), j: union(limits.j, other.j) }
}
