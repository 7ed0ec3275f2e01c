//! The plan in force: phases of constant jerk to the end of the path, or to a halt on the way.

use super::change::{Change, Leg};
use crate::error::FeedError;
use crate::limits::AxisLimits;
use crate::scurve::phases::Phase;
use crate::state::{AxisState, MotionState};
use crate::state_to_state::StateToState;

/// Two changes of speed with four phases each, and a cruise; a state-to-state motion has as many.
const PHASES: usize = 9;

/// Excess over a limit that counts as round-off, and backward speed that does, relative.
const SLACK: f64 = 1e-12;
const BACKWARD: f64 = 1e-9;

#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    phases: [Phase; PHASES],
    lasting: [f64; PHASES],
    count: usize,
    pub duration: f64,
    pub end: MotionState,
    /// Whether the last state is the end of the path; otherwise a halt before it.
    pub arrives: bool,
}

impl Plan {
    /// The shortest forward motion from `start` to `end`, or to a halt if `v_max` is 0.
    ///
    /// Where the end takes more speed than `v_max` (its own speed is higher), the last change of speed exceeds `v_max` by that.
    ///
    /// It may run backwards only if braking could not be taken off in time with the jerk `release` either.
    pub fn new(start: &AxisState, end: &AxisState, limits: &AxisLimits, release: f64) -> Result<Self, FeedError> {
        if limits.v_max() == 0.0 || limits.v_max() < entry_speed(limits, end) {
            return Self::below_end_speed(start, end, limits, release);
        }
        // The solver needs a lower bound of the velocity; a motion that reaches it is refused afterwards.
        let axis = AxisLimits { v: (-limits.v_max(), limits.v_max()), ..*limits };
        let motion = StateToState::new(start, end, &axis).map_err(|e| refused(e, start, end, limits))?;
        let mut plan = Self::empty(end);
        for (phase, dt) in motion.phases() {
            plan.push(phase, dt);
        }
        plan.checked(start, end, limits, release)
    }

    fn empty(end: &AxisState) -> Self {
        Self {
            phases: [Phase::default(); PHASES],
            lasting: [0.0; PHASES],
            count: 0,
            duration: 0.0,
            end: MotionState { p: end.p, v: end.v, a: end.a, j: 0.0 },
            arrives: true,
        }
    }

    /// To `v_max` first, as late as possible from there to the end.
    fn below_end_speed(
        start: &AxisState,
        end: &AxisState,
        limits: &AxisLimits,
        release: f64,
    ) -> Result<Self, FeedError> {
        let slow = limits.v_max();
        let first = Change::new((start.v, start.a), (slow, 0.0), limits);
        let last = Change::new((slow, 0.0), (end.v, end.a), limits);
        let free = end.p - start.p - first.length - last.length;
        if free < 0.0 {
            return Err(too_close(start, end, limits));
        }
        let mut plan = Self::empty(end);
        plan.legs(start, &first.legs);
        let reached = AxisState::new(start.p + first.length, slow, 0.0);
        if slow > 0.0 {
            plan.legs(&reached, &[(free / slow, 0.0)]);
            plan.legs(&AxisState::new(end.p - last.length, slow, 0.0), &last.legs);
        } else {
            plan.end = MotionState { p: reached.p, v: 0.0, a: 0.0, j: 0.0 };
            plan.arrives = false;
        }
        plan.checked(start, end, limits, release)
    }

    fn legs(&mut self, from: &AxisState, legs: &[Leg]) {
        let mut at = Phase { t: 0.0, s: from.p, v: from.v, a: from.a, j: 0.0 };
        for &(dt, j) in legs {
            at.j = j;
            self.push(at, dt);
            let next = at.after(dt);
            (at.s, at.v, at.a) = (next.p, next.v, next.a);
        }
    }

    fn push(&mut self, phase: Phase, dt: f64) {
        if dt > 0.0 && self.count < PHASES {
            self.phases[self.count] = Phase { t: self.duration, ..phase };
            self.lasting[self.count] = dt;
            self.count += 1;
            self.duration += dt;
        }
    }

    fn checked(self, start: &AxisState, end: &AxisState, limits: &AxisLimits, release: f64) -> Result<Self, FeedError> {
        // Finite numbers times zero are zero.
        let finite = |p: &Phase, dt: f64| 0.0 * (p.s + p.v + p.a + p.after(dt).p) == 0.0;
        let in_range = self.phases[..self.count].iter().zip(&self.lasting).all(|(p, &dt)| finite(p, dt));
        if !(in_range && self.duration.is_finite() && self.end.p.is_finite()) {
            return Err(FeedError::OutOfRange { what: "duration of the motion" });
        }
        // Speed left after taking a braking acceleration off at once: nothing can avoid that.
        let brake = start.a.min(0.0);
        let forced = (start.v - 0.5 * brake * (brake / release)).min(start.v).min(0.0);
        let (lowest, highest) = self.extremes(0.0, speeds);
        if lowest < forced - BACKWARD * highest.max(-forced) { Err(too_close(start, end, limits)) } else { Ok(self) }
    }

    /// Lowest and highest of some values over what is left of every phase after time `t`.
    fn extremes<const K: usize>(&self, t: f64, values: impl Fn(&Phase, f64) -> [f64; K]) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for (phase, &dt) in self.phases[..self.count].iter().zip(&self.lasting) {
            let gone = t - phase.t;
            if gone >= dt {
                continue;
            }
            let rest = if gone > 0.0 {
                let now = phase.after(gone);
                Phase { t, s: now.p, v: now.v, a: now.a, j: now.j }
            } else {
                *phase
            };
            for x in values(&rest, dt - gone.max(0.0)) {
                range = (range.0.min(x), range.1.max(x));
            }
        }
        range
    }

    /// Whether what is left after time `t` keeps the limits.
    pub fn keeps(&self, limits: &AxisLimits, t: f64) -> bool {
        let within = |range: (f64, f64), bounds: (f64, f64)| {
            let slack = SLACK * bounds.1.max(-bounds.0);
            range.0 >= bounds.0 - slack && range.1 <= bounds.1 + slack
        };
        self.extremes(t, speeds).1 <= limits.v_max() * (1.0 + SLACK)
            && within(self.extremes(t, |p, dt| [p.a, p.a + p.j * dt]), limits.a)
            && within(self.extremes(t, |p, _| [p.j]), limits.j)
    }

    /// The state at time `t >= 0`.
    #[inline]
    pub fn at(&self, t: f64) -> MotionState {
        if t >= self.duration {
            return self.end;
        }
        let i = (1..self.count).take_while(|&i| self.phases[i].t <= t).count();
        let phase = &self.phases[i];
        phase.after((t - phase.t).min(self.lasting[i]))
    }
}

/// Speeds among which the extremes of a phase are.
fn speeds(phase: &Phase, dt: f64) -> [f64; 3] {
    let turn = -phase.a / phase.j;
    let between = if turn > 0.0 && turn < dt { phase.after(turn).v } else { phase.v };
    [phase.v, phase.after(dt).v, between]
}

/// Highest speed that arriving in `end` takes.
pub(super) fn entry_speed(limits: &AxisLimits, end: &AxisState) -> f64 {
    end.v + 0.5 * end.a.min(0.0) * (end.a / -limits.j_min())
}

fn too_close(start: &AxisState, end: &AxisState, limits: &AxisLimits) -> FeedError {
    let needed = Change::new((start.v, start.a), (end.v, end.a), limits).length;
    FeedError::EndTooClose { remaining: end.p - start.p, needed, v: end.v, a: end.a }
}

/// The solver's refusals as the scheduler reports them. All but numbers out of range have been checked before.
fn refused(e: FeedError, start: &AxisState, end: &AxisState, limits: &AxisLimits) -> FeedError {
    match e {
        FeedError::NotFinite { .. } => e,
        FeedError::TargetUnreachable { .. } => too_close(start, end, limits),
        _ => FeedError::OutOfRange { what: "duration of the motion" },
    }
}
