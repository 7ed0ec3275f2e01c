//! The plan in force: phases of constant jerk to the end of the path, or to a halt on the way.

use crate::error::FeedError;
use crate::limits::AxisLimits;
use crate::scurve::change::SpeedChange;
use crate::scurve::phase::Phase;
use crate::scurve::phases::Phases;
#[cfg(feature = "std")]
use crate::scurve::profile::SProfile;
use crate::state::{AxisState, MotionState};
use crate::state_to_state::StateToState;

/// Two changes of speed with four phases each, and a cruise; a state-to-state motion has as many.
const PHASES: usize = 9;

/// Excess over a limit that counts as round-off, and backward speed that does, relative.
const SLACK: f64 = 1e-12;
const BACKWARD_ROUND_OFF: f64 = 1e-9;

#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub phases: Phases<PHASES>,
    /// True if the last state is the end of the path; otherwise it is a halt before the end.
    pub arrives: bool,
}

impl Plan {
    /// The shortest forward motion from `start` to `end`, or to a halt if `v_max` is 0.
    ///
    /// If the end takes more speed than `v_max` (its own speed is higher), the last change of speed
    /// exceeds `v_max` by that.
    ///
    /// It may run backwards only if braking could not be taken off in time with the jerk `release`
    /// either.
    pub fn new(start: &AxisState, end: &AxisState, limits: &AxisLimits, release: f64) -> Result<Self, FeedError> {
        if limits.v_max() == 0.0 || limits.v_max() < entry_speed(limits, end) {
            return Self::below_end_speed(start, end, limits, release);
        }
        // The solver needs a lower bound of the velocity; a motion that reaches it is refused
        // afterwards.
        let axis = AxisLimits { v: (-limits.v_max(), limits.v_max()), ..*limits };
        let motion = StateToState::new(start, end, &axis).map_err(|e| refused(e, start, end, limits))?;
        let mut plan = Self::empty(end);
        for (phase, dt) in motion.phases() {
            plan.phases.push(phase, dt);
        }
        plan.checked(start, end, limits, release)
    }

    /// An S-profile, which arrives at its end.
    #[cfg(feature = "std")]
    pub fn of(profile: &SProfile) -> Self {
        let end = AxisState::new(profile.length(), profile.v_end(), 0.0);
        let mut plan = Self::empty(&end);
        for (phase, dt) in profile.phases() {
            plan.phases.push(phase, dt);
        }
        plan
    }

    fn empty(end: &AxisState) -> Self {
        let end = MotionState { p: end.p, v: end.v, a: end.a, j: 0.0 };
        Self { phases: Phases::at_rest(end), arrives: true }
    }

    /// To `v_max` first, as late as possible from there to the end.
    fn below_end_speed(
        start: &AxisState,
        end: &AxisState,
        limits: &AxisLimits,
        release: f64,
    ) -> Result<Self, FeedError> {
        let slow = limits.v_max();
        let first = SpeedChange::between((start.v, start.a), (slow, 0.0), limits);
        let last = SpeedChange::between((slow, 0.0), (end.v, end.a), limits);
        let free = end.p - start.p - first.length() - last.length();
        if free < 0.0 {
            return Err(too_close(start, end, limits));
        }
        let mut plan = Self::empty(end);
        plan.push_change(start.p, &first);
        let reached = start.p + first.length();
        if slow > 0.0 {
            plan.phases.push(Phase { t: 0.0, s: reached, v: slow, a: 0.0, j: 0.0 }, free / slow);
            plan.push_change(end.p - last.length(), &last);
        } else {
            plan.phases.end = MotionState { p: reached, v: 0.0, a: 0.0, j: 0.0 };
            plan.arrives = false;
        }
        plan.checked(start, end, limits, release)
    }

    /// Appends a change of speed that begins at position `from`.
    fn push_change(&mut self, from: f64, change: &SpeedChange) {
        for (phase, dt) in change.phases() {
            self.phases.push(Phase { s: from + phase.s, ..phase }, dt);
        }
    }

    fn checked(self, start: &AxisState, end: &AxisState, limits: &AxisLimits, release: f64) -> Result<Self, FeedError> {
        let ends_finite = self.phases.iter().all(|(phase, dt)| phase.after(dt).p.is_finite());
        if !(self.phases.is_finite() && ends_finite) {
            return Err(FeedError::OutOfRange { what: "duration of the motion" });
        }
        // Speed left after taking a braking acceleration off at once: nothing can avoid that.
        let brake = start.a.min(0.0);
        let forced = (start.v - 0.5 * brake * (brake / release)).min(start.v).min(0.0);
        let (lowest, highest) = self.extremes(0.0, speeds);
        if lowest < forced - BACKWARD_ROUND_OFF * highest.max(-forced) {
            Err(too_close(start, end, limits))
        } else {
            Ok(self)
        }
    }

    /// Lowest and highest of some values over what is left of every phase after time `t`.
    fn extremes<const K: usize>(&self, t: f64, values: impl Fn(&Phase, f64) -> [f64; K]) -> (f64, f64) {
        let all = self.phases.remaining(t).flat_map(|(phase, dt)| values(&phase, dt));
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    }

    /// Returns true if what is left after time `t` keeps the limits.
    pub fn keeps(&self, limits: &AxisLimits, t: f64) -> bool {
        let within = |range: (f64, f64), bounds: (f64, f64)| {
            let slack = SLACK * bounds.1.max(-bounds.0);
            range.0 >= bounds.0 - slack && range.1 <= bounds.1 + slack
        };
        self.extremes(t, speeds).1 <= limits.v_max() * (1.0 + SLACK)
            && within(self.extremes(t, |p, dt| [p.a, p.a + p.j * dt]), limits.a)
            && within(self.extremes(t, |p, _| [p.j]), limits.j)
    }
}

/// Speeds among which the extremes of a phase are.
fn speeds(phase: &Phase, dt: f64) -> [f64; 3] {
    let between = phase.turn(dt).map_or(phase.v, |turn| phase.after(turn).v);
    [phase.v, phase.after(dt).v, between]
}

/// Highest speed that arriving in `end` takes.
pub(super) fn entry_speed(limits: &AxisLimits, end: &AxisState) -> f64 {
    end.v + 0.5 * end.a.min(0.0) * (end.a / -limits.j_min())
}

fn too_close(start: &AxisState, end: &AxisState, limits: &AxisLimits) -> FeedError {
    let needed = SpeedChange::between((start.v, start.a), (end.v, end.a), limits).length();
    FeedError::EndTooClose { remaining: end.p - start.p, needed, v: end.v, a: end.a }
}

/// The solver's refusals as the scheduler reports them. All but numbers out of range have been
/// checked before.
fn refused(e: FeedError, start: &AxisState, end: &AxisState, limits: &AxisLimits) -> FeedError {
    match e {
        FeedError::NotFinite { .. } => e,
        FeedError::TargetUnreachable { .. } => too_close(start, end, limits),
        _ => FeedError::OutOfRange { what: "duration of the motion" },
    }
}
