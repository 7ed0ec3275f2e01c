//! Change of speed and braking from any state, by the shortest jerk-limited way (Liu et al. 2023, section 3.2).

use super::phases::Phase;
use crate::error::{FeedError, finite, not_negative};
use crate::limits::AxisLimits;
use crate::state::{MotionLaw, MotionState};

/// The fastest jerk-limited motion from speed and acceleration `(v, a)` to a speed with zero acceleration.
///
/// Liu et al. 2023, eqs. 14 to 18, first bring the acceleration to zero and then change the speed. That is the
/// shortest way only if the speed then has to be changed in the other direction; when the acceleration already points
/// the right way it throws it away. Here the one extremal of the problem is taken: with
/// `v_free = v + a |a| / (2 j_max)`, the speed left after bringing the acceleration straight to zero, the motion
/// goes to a peak acceleration on the side of `target - v_free`, holds it if it is `a_max`, and returns to zero. (In
/// print eq. 15 adds `J t^2 / 2` for either sign of the acceleration; the jerk acts against it.)
///
/// An acceleration outside `[-a_max, a_max]` is brought back inside with `j_max`, not cut off. A start above `v_max` simply brakes.
/// The speed leaves the range between start and target only where no jerk-limited motion can avoid it; see
/// [`SpeedChange::lowest_speed`].
///
/// ```
/// use arcfeed_feedrate::{MotionLaw, AxisLimits, SpeedChange};
/// let limits = AxisLimits::symmetric(0.1, 1.0, 50.0)?;
/// let brake = SpeedChange::brake(0.08, 0.5, &limits)?; // moving and still accelerating
/// let end = brake.at(brake.duration());
/// assert_eq!((end.v, end.a), (0.0, 0.0));
/// assert!(!brake.reverses());
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedChange {
    phases: [Phase; 3],
    duration: f64,
    end: MotionState,
}

impl SpeedChange {
    /// From speed `v` (m/s, any sign) and acceleration `a` (m/s²) to speed `target` (m/s) and acceleration 0.
    ///
    /// # Errors
    /// [`FeedError::AboveLimit`] if `target` is above `v_max`; [`FeedError::Negative`] if it is negative;
    /// [`FeedError::NotFinite`] for NaN or infinity.
    pub fn new(v: f64, a: f64, target: f64, limits: &AxisLimits) -> Result<Self, FeedError> {
        finite("v", v)?;
        finite("a", a)?;
        not_negative("target", target)?;
        limits.check_symmetric_acceleration()?;
        if target > limits.v_max() {
            return Err(FeedError::AboveLimit { what: "target", value: target, limit: limits.v_max() });
        }
        let change = Self::build(v, a, target, limits.a_max(), limits.j_max());
        let sound = change.duration.is_finite() && change.end.p.is_finite();
        if sound { Ok(change) } else { Err(FeedError::OutOfRange { what: "duration of the change of speed" }) }
    }

    /// From speed `v` and acceleration `a` to rest.
    ///
    /// # Errors
    /// As [`SpeedChange::new`].
    pub fn brake(v: f64, a: f64, limits: &AxisLimits) -> Result<Self, FeedError> {
        Self::new(v, a, 0.0, limits)
    }

    pub(crate) fn build(v0: f64, a0: f64, target: f64, a_max: f64, j: f64) -> Self {
        let free = v0 + 0.5 * a0 * (a0.abs() / j);
        // Mirror so that the acceleration has to go up.
        let sign = if target >= free { 1.0 } else { -1.0 };
        let (v, a, end) = (sign * v0, sign * a0, sign * target);
        // Without a bound on acceleration: peak^2 / j = (end - v) + a^2 / (2 j).
        let peak = (j * (end - v) + 0.5 * a * a).max(0.0).sqrt().max(a.min(a_max));
        let (t1, j1, peak, hold) = if peak <= a_max {
            let peak = peak.max(a);
            ((peak - a) / j, j, peak, 0.0)
        } else {
            let t1 = (a_max - a).abs() / j;
            let t3 = a_max / j;
            let gained = 0.5 * (a + a_max) * t1 + 0.5 * a_max * t3;
            (t1, if a > a_max { -j } else { j }, a_max, ((end - v - gained) / a_max).max(0.0))
        };
        let t3 = peak / j;
        let mut phases = [Phase::default(); 3];
        phases[0] = Phase { t: 0.0, s: 0.0, v: v0, a: a0, j: sign * j1 };
        let s1 = phases[0].advance(t1);
        // Speeds of the later phases from the end backwards.
        let v2 = target - sign * 0.5 * peak * t3;
        let v1 = v2 - sign * peak * hold;
        phases[1] = Phase { t: t1, s: s1, v: v1, a: sign * peak, j: 0.0 };
        let s2 = s1 + 0.5 * (v1 + v2) * hold;
        phases[2] = Phase { t: t1 + hold, s: s2, v: v2, a: sign * peak, j: -sign * j };
        let length = s2 + t3 * (target - sign * peak * t3 / 6.0);
        Self { phases, duration: t1 + hold + t3, end: MotionState { p: length, v: target, a: 0.0, j: 0.0 } }
    }

    /// Displacement of the whole change (m).
    pub const fn length(&self) -> f64 {
        self.end.p
    }

    /// The three phases, in order; a phase may have zero duration.
    pub const fn phases(&self) -> &[Phase; 3] {
        &self.phases
    }

    /// Lowest speed on the way (m/s). Below 0 only if the start state forces it: the speed is negative to begin with, or so
    /// strong a braking acts that it cannot be taken off in time.
    pub fn lowest_speed(&self) -> f64 {
        self.extreme_speed(-1.0)
    }

    /// Highest speed on the way (m/s). Above start and target only if the start acceleration forces it.
    pub fn highest_speed(&self) -> f64 {
        self.extreme_speed(1.0)
    }

    /// Whether the motion must run backwards for a while (by more than round-off).
    pub fn reverses(&self) -> bool {
        self.lowest_speed() < -1e-12 * self.highest_speed().abs().max(self.phases[0].v.abs())
    }

    fn extreme_speed(&self, side: f64) -> f64 {
        let start = self.phases[0];
        let mut worst = side * start.v;
        worst = worst.max(side * self.end.v);
        // The acceleration changes sign at most once, in the first phase.
        if start.a * start.j < 0.0 {
            let dt = (-start.a / start.j).min(self.phases[1].t);
            worst = worst.max(side * start.after(dt).v);
        }
        side * worst
    }
}

impl MotionLaw for SpeedChange {
    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> MotionState {
        if t >= self.duration {
            return self.end;
        }
        let t = if t.is_nan() { 0.0 } else { t.max(0.0) };
        let i = (1..3).rev().find(|&i| self.phases[i].t <= t).unwrap_or(0);
        let state = self.phases[i].after(t - self.phases[i].t);
        let start = &self.phases[0];
        // Later phases are computed from the end: at the start itself their round-off does not count.
        if t > 0.0 { state } else { MotionState { p: start.s, v: start.v, a: start.a, j: state.j } }
    }
}
