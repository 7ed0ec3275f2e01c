//! Change of speed and braking from any state, by the shortest jerk-limited way (Liu et al. 2023,
//! section 3.2).

use super::closed_form::{Change, Jerks};
use super::phase::Phase;
use super::phases::Phases;
use crate::error::{FeedError, finite, not_negative};
use crate::limits::AxisLimits;
use crate::state::{MotionLaw, MotionState};

/// The fastest jerk-limited motion from speed and acceleration `(v, a)` to a speed with zero
/// acceleration.
///
/// Liu et al. 2023, eqs. 14 to 18, first bring the acceleration to zero and then change the speed.
/// That is the shortest way only if the speed then has to be changed in the other direction; when
/// the acceleration already points the right way it throws it away. Here the one extremal of the
/// problem is taken: with `v_free = v + a |a| / (2 j_max)`, the speed left after bringing the
/// acceleration straight to zero, the motion goes to a peak acceleration on the side of
/// `target - v_free`, holds it if it is `a_max`, and returns to zero. (In print eq. 15 adds
/// `J t^2 / 2` for either sign of the acceleration; the jerk acts against it.)
///
/// An acceleration outside its limits is brought back inside with the largest jerk, not cut off. A
/// start above `v_max` brakes. The speed leaves the range between start and target only where no
/// jerk-limited motion can avoid it; see [`SpeedChange::lowest_speed`].
///
/// ```
/// use arcfeed_feedrate::{AxisLimits, MotionLaw, SpeedChange};
/// let limits = AxisLimits::symmetric(0.1, 1.0, 50.0)?;
/// let brake = SpeedChange::brake(0.08, 0.5, &limits)?; // moving and still accelerating
/// let end = brake.at(brake.duration());
/// assert_eq!((end.v, end.a), (0.0, 0.0));
/// assert!(!brake.reverses());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedChange {
    phases: Phases<4>,
    /// Speed and acceleration at the start.
    start: (f64, f64),
    /// Time at which the peak acceleration is reached (s).
    pub(crate) peak_time: f64,
}

impl SpeedChange {
    /// From speed `v` (m/s, any sign) and acceleration `a` (m/s²) to speed `target` (m/s) and
    /// acceleration 0.
    ///
    /// # Errors
    /// [`FeedError::AboveLimit`] if `target` is above `v_max`; [`FeedError::Negative`] if it is
    /// negative; [`FeedError::NotFinite`] for NaN or infinity.
    pub fn new(v: f64, a: f64, target: f64, limits: &AxisLimits) -> Result<Self, FeedError> {
        finite("v", v)?;
        finite("a", a)?;
        not_negative("target", target)?;
        if target > limits.v_max() {
            return Err(FeedError::AboveLimit { what: "target", value: target, limit: limits.v_max() });
        }
        let change = Self::between((v, a), (target, 0.0), limits);
        let sound = change.phases.is_finite();
        if sound { Ok(change) } else { Err(FeedError::OutOfRange { what: "duration of the change of speed" }) }
    }

    /// From speed `v` and acceleration `a` to rest.
    ///
    /// # Errors
    /// As [`SpeedChange::new`].
    pub fn brake(v: f64, a: f64, limits: &AxisLimits) -> Result<Self, FeedError> {
        Self::new(v, a, 0.0, limits)
    }

    /// From one speed and acceleration to another, unchecked.
    pub(crate) fn between(from: (f64, f64), to: (f64, f64), limits: &AxisLimits) -> Self {
        let (v, a) = from;
        let mut phases = Phases::default();
        let bound = a.min(limits.a.1).max(limits.a.0);
        let jerk = if a > bound { limits.j.0 } else { limits.j.1 };
        let t0 = (bound - a) / jerk;
        let lead = Phase { t: 0.0, s: 0.0, v, a, j: jerk };
        phases.push(lead, t0);
        let (s, v1) = if t0 > 0.0 { (lead.advance(t0), v + 0.5 * t0 * (a + bound)) } else { (0.0, v) };

        let j = Jerks::new(limits.j.1, -limits.j.0);
        let change = Change::new((v1, bound), to, (limits.a.1, -limits.a.0), &j);
        let (rise, fall) = (limits.j.1, limits.j.0);
        let (j1, j3) = if change.up { (rise, fall) } else { (fall, rise) };
        let first = Phase { t: 0.0, s, v: v1, a: bound, j: j1 };
        phases.push(first, change.t1);
        // The velocities of the later phases are computed from the end backwards.
        let peak = change.peak;
        let s = s + first.advance(change.t1);
        phases.push(Phase { t: 0.0, s, v: change.v2 - peak.a * peak.hold, a: peak.a, j: 0.0 }, peak.hold);
        let s = s + change.d2;
        phases.push(Phase { t: 0.0, s, v: change.v2, a: peak.a, j: j3 }, change.t3);
        phases.duration = t0 + change.t1 + peak.hold + change.t3;
        phases.end = MotionState { p: s + change.d3, v: to.0, a: to.1, j: 0.0 };
        Self { phases, start: from, peak_time: t0 + change.t1 }
    }

    /// Displacement of the whole change (m).
    pub const fn length(&self) -> f64 {
        self.phases.end.p
    }

    /// The phases in order, each with its duration (s), which is not zero.
    pub fn phases(&self) -> impl ExactSizeIterator<Item = (Phase, f64)> + '_ {
        self.phases.iter()
    }

    /// Lowest speed on the way (m/s). Below 0 only if the start state forces it: the speed is
    /// negative to begin with, or so strong a braking acts that it cannot be taken off in time.
    pub fn lowest_speed(&self) -> f64 {
        self.speeds().fold(self.start.0.min(self.phases.end.v), f64::min)
    }

    /// Highest speed on the way (m/s). Above start and target only if the start acceleration forces
    /// it.
    pub fn highest_speed(&self) -> f64 {
        self.speeds().fold(self.start.0.max(self.phases.end.v), f64::max)
    }

    /// Returns true if the motion must run backwards for a while (by more than round-off).
    pub fn reverses(&self) -> bool {
        self.lowest_speed() < -1e-12 * self.highest_speed().abs().max(self.start.0.abs())
    }

    /// Speeds between the phases' ends at which the acceleration is zero.
    fn speeds(&self) -> impl Iterator<Item = f64> + '_ {
        self.phases.iter().filter_map(|(phase, dt)| phase.turn(dt).map(|t| phase.after(t).v))
    }
}

impl MotionLaw for SpeedChange {
    fn duration(&self) -> f64 {
        self.phases.duration
    }

    fn at(&self, t: f64) -> MotionState {
        let state = self.phases.at(t);
        // Later phases are computed from the end: at the start itself their round-off does not
        // count.
        let (v, a) = self.start;
        if t > 0.0 || self.phases.duration <= 0.0 { state } else { MotionState { p: 0.0, v, a, j: state.j } }
    }
}
