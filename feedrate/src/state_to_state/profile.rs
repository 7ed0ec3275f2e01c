//! The motion itself: phases, sampling, position extrema.

use super::scale::Units;
use crate::error::FeedError;
use crate::scurve::phase::Phase;
use crate::scurve::phases::Phases;
use crate::state::AxisState;
use crate::state::{MotionLaw, MotionState};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// At most three phases to bring acceleration and velocity inside their limits, and thirteen of the
/// mean of two motions with seven each.
pub(super) const PHASES: usize = 16;

/// A motion of one axis between two states, the shortest one or one of a given duration. The
/// default one stands still at 0.
///
/// The shortest motion minimises `T` subject to `p''' = j`, the states at both ends, and the limits
/// on velocity, acceleration and jerk (Liu et al. 2024, section 4.1, corrected). The solution is
/// exact: a closed form where both halves reach their acceleration limits or the motion cruises,
/// otherwise the root of one smooth function of one variable. No tolerance is absolute, so that the
/// result scales exactly with powers of two in the units of length and time.
///
/// * A start outside the limits is brought back with bounded jerk. An acceleration beyond its limit
///   is taken back with the largest jerk first. A velocity beyond its limit, or bound to get there,
///   is either settled at a velocity inside without undershooting it, or braked as hard as possible
///   until it is at the limit and continued in the shortest way from there; the shorter of the two
///   is taken. A third way can be shorter where the start has an acceleration or the target moves.
/// * A target outside the limits, or one that cannot be entered without leaving them, is an error.
/// * Positions are not limited while planning; [`StateToState::check_within`] says where a motion
///   leaves a range.
///
/// ```
/// use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
/// let limits = AxisLimits::new((-1.0, 2.0), (-8.0, 5.0), (-80.0, 50.0))?;
/// let start = AxisState::new(0.0, 0.3, -1.0);
/// let target = AxisState::new(1.2, 0.5, 0.0);
/// let motion = StateToState::new(&start, &target, &limits)?;
/// let end = motion.at(motion.duration());
/// assert_eq!((end.p, end.v, end.a), (1.2, 0.5, 0.0));
/// assert!(motion.position_range().max <= 1.2);
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct StateToState {
    pub(super) phases: Phases<PHASES>,
    /// Jerk that brings the acceleration of the target to zero after the end.
    pub(super) release_jerk: f64,
}

/// Lowest and highest position of a motion, and when it is there first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionRange {
    /// Lowest position (m).
    pub min: f64,
    /// Time of the lowest position (s).
    pub t_min: f64,
    /// Highest position (m).
    pub max: f64,
    /// Time of the highest position (s).
    pub t_max: f64,
}

impl StateToState {
    /// A standstill at a position, which takes no time.
    pub const fn standing(position: f64) -> Self {
        Self { phases: Phases::at_rest(MotionState { p: position, v: 0.0, a: 0.0, j: 0.0 }), release_jerk: 0.0 }
    }

    /// One motion after another, with a rest of `pause` seconds between them, which begins and ends
    /// at rest if it is not 0; `None` if they are too many phases.
    pub(super) fn joined(first: &Self, pause: f64, second: &Self) -> Option<Self> {
        let mut all = *first;
        let still = Phase { t: 0.0, s: first.phases.end.p, v: 0.0, a: 0.0, j: 0.0 };
        let count = first.phases.len() + usize::from(pause > 0.0) + second.phases.len();
        if count > PHASES {
            return None;
        }
        all.phases.push(still, pause);
        for (phase, dt) in second.phases() {
            all.phases.push(phase, dt);
        }
        all.phases.end = second.phases.end;
        all.release_jerk = second.release_jerk;
        Some(all)
    }

    /// The motion backwards in time, from `start` to `target`, which are its target and its start
    /// then; the jerk limits are those of the way on.
    pub(super) fn backwards(&self, start: &AxisState, target: &AxisState, jerk: (f64, f64)) -> Self {
        let mut motion = Self::default();
        for (phase, dt) in self.phases.iter().rev() {
            let end = phase.after(dt);
            motion.phases.push(Phase { t: 0.0, s: end.p, v: -end.v, a: end.a, j: -phase.j }, dt);
        }
        motion.phases.begin_at([start.p, start.v, start.a]);
        motion.phases.duration = self.phases.duration;
        motion.set_target(target, jerk);
        motion
    }

    /// The same motion, whose duration is this but for round-off.
    pub(super) const fn lasting(mut self, duration: f64) -> Self {
        self.phases.duration = duration;
        self
    }

    /// Out of working units, the target and what follows it excepted.
    pub(super) fn rescale(&mut self, units: Units) {
        self.phases.map(|p, dt| {
            let phase = Phase {
                t: units.time_back(p.t),
                s: units.back(p.s, 0),
                v: units.back(p.v, 1),
                a: units.back(p.a, 2),
                j: units.back(p.j, 3),
            };
            (phase, units.time_back(dt))
        });
        self.phases.duration = units.time_back(self.phases.duration);
    }

    /// Ends in `target`; the jerk limits are those of the way on.
    pub(super) fn set_target(&mut self, t: &AxisState, jerk: (f64, f64)) {
        self.phases.end = MotionState { p: t.p, v: t.v, a: t.a, j: 0.0 };
        self.release_jerk = if t.a > 0.0 { jerk.0 } else { jerk.1 };
    }

    /// The phase after the end, which brings the acceleration of the target to zero, and its
    /// duration.
    fn release(&self) -> (Phase, f64) {
        let MotionState { p, v, a, .. } = self.phases.end;
        let duration = if a == 0.0 || self.release_jerk == 0.0 { 0.0 } else { (-a / self.release_jerk).max(0.0) };
        (Phase { t: self.phases.duration, s: p, v, a, j: self.release_jerk }, duration)
    }

    pub(super) fn check_sound(&self) -> Result<(), FeedError> {
        let error = FeedError::OutOfRange { what: "duration of the motion" };
        if self.phases.is_finite() { Ok(()) } else { Err(error) }
    }

    /// The phases in order, each with its duration (s), which is not zero.
    pub fn phases(&self) -> impl ExactSizeIterator<Item = (Phase, f64)> + '_ {
        self.phases.iter()
    }

    /// As [`MotionLaw::at`], but beyond the end the motion goes on: the acceleration of the target
    /// is brought to zero with the largest jerk, and the velocity stays what it is then.
    /// [`AxisLimits::check_leaving`](crate::AxisLimits::check_leaving) says whether that velocity
    /// is within its limits.
    pub fn at_or_after(&self, t: f64) -> MotionState {
        if t <= self.phases.duration || t.is_nan() {
            return self.at(t);
        }
        // Zero acceleration times an infinite time would be no number.
        let t = t.min(f64::MAX);
        let (phase, dt, _) = self.phase_at(t);
        phase.after((t - phase.t).min(dt))
    }

    /// The phase that acts at time `t` (s), its duration, and the time at which the next one
    /// begins, infinite for the last one: between the phase's start and that time [`Phase::after`]
    /// gives the state of [`StateToState::at_or_after`].
    pub fn phase_at(&self, t: f64) -> (Phase, f64, f64) {
        let (phases, duration) = (&self.phases, self.phases.duration);
        if t >= duration || phases.len() == 0 {
            let (release, dt) = self.release();
            if t <= duration || t.is_nan() {
                return (Phase { j: 0.0, ..release }, 0.0, duration);
            }
            if t - duration < dt {
                return (release, dt, duration + dt);
            }
            let end = release.after(dt);
            let on = Phase { t: duration + dt, s: end.p, v: end.v, a: 0.0, j: 0.0 };
            return (on, f64::INFINITY, f64::INFINITY);
        }
        let i = phases.index_at(t);
        let next = if i + 1 < phases.len() { phases.get(i + 1).0.t } else { duration };
        let (phase, dt) = phases.get(i);
        (phase, dt, next.min(duration))
    }

    /// The same motion of another axis that moves `ratio` times as far, from `start` to `target`,
    /// which must be in that proportion to the states of this one but for round-off.
    pub fn in_proportion(&self, ratio: f64, start: &AxisState, target: &AxisState) -> Self {
        let from = self.phases.iter().next().map_or(self.phases.end.p, |(phase, _)| phase.s);
        let mut other = *self;
        other.phases.map(|p, dt| {
            let s = start.p + ratio * (p.s - from);
            (Phase { t: p.t, s, v: ratio * p.v, a: ratio * p.a, j: ratio * p.j }, dt)
        });
        // A ratio below zero exchanges the jerk limits, and the sign of the acceleration with them.
        other.phases.end = MotionState { p: target.p, v: target.v, a: target.a, j: 0.0 };
        other.release_jerk = ratio * self.release_jerk;
        other
    }

    /// Lowest and highest position on the way, both ends included.
    pub fn position_range(&self) -> PositionRange {
        let (end, duration) = (self.phases.end.p, self.phases.duration);
        let mut range = PositionRange { min: end, t_min: duration, max: end, t_max: duration };
        let mut visit = |t: f64, p: f64| {
            if p < range.min || (p == range.min && t < range.t_min) {
                (range.min, range.t_min) = (p, t);
            }
            if p > range.max || (p == range.max && t < range.t_max) {
                (range.max, range.t_max) = (p, t);
            }
        };
        for (phase, dt) in self.phases() {
            visit(phase.t, phase.s);
            for root in turning_times(&phase) {
                if root > 0.0 && root < dt {
                    visit(phase.t + root, phase.after(root).p);
                }
            }
        }
        range
    }
}

/// The jerk after the end counts only where the target has an acceleration.
impl PartialEq for StateToState {
    fn eq(&self, other: &Self) -> bool {
        self.phases == other.phases && (self.phases.end.a == 0.0 || self.release_jerk == other.release_jerk)
    }
}

impl MotionLaw for StateToState {
    fn duration(&self) -> f64 {
        self.phases.duration
    }

    #[inline]
    fn at(&self, t: f64) -> MotionState {
        self.phases.at(t)
    }
}

/// Times from the start of a phase at which its velocity is zero; NaN where there is none.
fn turning_times(p: &Phase) -> [f64; 2] {
    // v + a t + j/2 t² = 0 without cancellation.
    let root = (p.a * p.a - 2.0 * p.j * p.v).sqrt();
    let w = -(p.a + root.copysign(p.a));
    [w / p.j, 2.0 * p.v / w]
}
