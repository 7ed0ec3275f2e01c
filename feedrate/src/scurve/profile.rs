//! The seven-phase S-profile over a given displacement (Liu et al. 2023, section 3.1).

use super::phase::Phase;
use super::phases::Phases;
use super::solve::{Leg, distance, fits, lower, peak, raise};
use crate::error::{FeedError, not_negative, positive};
use crate::limits::AxisLimits;
use crate::state::{MotionLaw, MotionState};

/// The speed that may be moved when the displacement is too short to get from one to the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adjust {
    /// Keep the start speed, move the end speed towards it.
    End,
    /// Keep the end speed, move the start speed towards it.
    Start,
}

/// The change that an adaptive profile had to make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Adjusted {
    /// Both speeds are the ones asked for.
    No,
    /// The end speed is `reached` instead of `asked` (lower if the motion accelerates, higher if it
    /// brakes).
    End {
        /// End speed asked for (m/s).
        asked: f64,
        /// End speed of the profile (m/s).
        reached: f64,
    },
    /// The start speed is `needed` instead of `asked`.
    Start {
        /// Start speed asked for (m/s).
        asked: f64,
        /// Start speed of the profile (m/s).
        needed: f64,
    },
}

/// A time-optimal motion over a displacement, from speed to speed, with zero acceleration at both
/// ends.
///
/// Seven phases (Liu et al. 2023, eqs. 11 to 13): jerk up, constant acceleration, jerk down,
/// cruise, jerk down, constant braking, jerk up; any of them may have zero duration. The printed
/// equations measure the last phases from a start that accumulates; here the braking leg is built
/// from the end state backwards and the cruise takes what displacement is left, so the end is
/// exact. Where print looks for the cruise speed when `v_max` is not reached, the displacement
/// equation is solved directly (closed form when both legs reach `a_max`).
///
/// ```
/// use arcfeed_feedrate::{MotionLaw, AxisLimits, SProfile};
/// let limits = AxisLimits::symmetric(0.1, 1.0, 50.0)?;
/// let move_ = SProfile::new(0.02, 0.0, 0.0, &limits)?;
/// let end = move_.at(move_.duration());
/// assert_eq!((end.p, end.v, end.a), (0.02, 0.0, 0.0));
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SProfile {
    phases: Phases<7>,
    v_start: f64,
    v_peak: f64,
    adjusted: Adjusted,
}

impl SProfile {
    /// The fastest motion over `length` (m) from speed `v_start` to `v_end` (m/s).
    ///
    /// # Errors
    /// [`FeedError::TooShort`] if `length` does not suffice to get from one speed to the other;
    /// [`FeedError::AboveLimit`] if a speed is above `v_max`; [`FeedError::Negative`] or
    /// [`FeedError::NotFinite`] for invalid numbers.
    pub fn new(length: f64, v_start: f64, v_end: f64, limits: &AxisLimits) -> Result<Self, FeedError> {
        check(length, v_start, v_end, limits)?;
        let required = distance(v_start, v_end, limits.a_max(), limits.j_max());
        if !fits(v_start, v_end, length, limits.a_max(), limits.j_max()) {
            return Err(FeedError::TooShort { length, required, v_start, v_end });
        }
        finish(Self::build(length, v_start, v_end, limits, Adjusted::No))
    }

    /// Like [`SProfile::new`], but when `length` is too short one speed is moved towards the other,
    /// as little as possible, and [`SProfile::adjusted`] says so.
    ///
    /// A length of 0 moves the adjustable speed all the way onto the other one.
    ///
    /// # Errors
    /// As [`SProfile::new`], without `TooShort`.
    pub fn adaptive(
        length: f64,
        v_start: f64,
        v_end: f64,
        limits: &AxisLimits,
        adjust: Adjust,
    ) -> Result<Self, FeedError> {
        check(length, v_start, v_end, limits)?;
        let (a_max, j_max) = (limits.a_max(), limits.j_max());
        if fits(v_start, v_end, length, a_max, j_max) {
            return finish(Self::build(length, v_start, v_end, limits, Adjusted::No));
        }
        let (kept, moved) = match adjust {
            Adjust::End => (v_start, v_end),
            Adjust::Start => (v_end, v_start),
        };
        // The clamps only take off rounding.
        let reached = if moved > kept {
            raise(kept, length, a_max, j_max).clamp(kept, moved)
        } else {
            lower(kept, length, a_max, j_max).clamp(moved, kept)
        };
        finish(match adjust {
            Adjust::End => Self::build(length, v_start, reached, limits, Adjusted::End { asked: v_end, reached }),
            Adjust::Start => {
                Self::build(length, reached, v_end, limits, Adjusted::Start { asked: v_start, needed: reached })
            }
        })
    }

    /// The profile for speeds between which `length` is known to suffice.
    pub(crate) fn build(length: f64, v0: f64, v1: f64, limits: &AxisLimits, adjusted: Adjusted) -> Self {
        let (a_max, j_max) = (limits.a_max(), limits.j_max());
        let v = peak(v0, v1, length, limits);
        let mut up = Leg::new(v - v0, a_max, j_max);
        let mut down = Leg::new(v - v1, a_max, j_max);
        let legs = (0.5 * v0 + 0.5 * v) * up.duration() + (0.5 * v + 0.5 * v1) * down.duration();
        if legs > length {
            // Round-off in the speeds; where they differ by a few units in the last place it
            // matters for the times.
            let k = length / legs;
            up = Leg { ramp: up.ramp * k, hold: up.hold * k };
            down = Leg { ramp: down.ramp * k, hold: down.hold * k };
        }
        let (t_up, t_down) = (up.duration(), down.duration());
        let d_up = (0.5 * v0 + 0.5 * v) * t_up;
        let left = (length - d_up - (0.5 * v + 0.5 * v1) * t_down).max(0.0);
        let t_cruise = if left > 0.0 { left / v } else { 0.0 };

        let mut phases = Phases::at_rest(MotionState { p: length, v: v1, a: 0.0, j: 0.0 });
        let mut push = |s, v, a, j, dt| phases.push(Phase { t: 0.0, s, v, a, j }, dt);
        let j = j_max;
        let a_up = j * up.ramp;
        let (v_a, v_b) = (v0 + 0.5 * a_up * up.ramp, v - 0.5 * a_up * up.ramp);
        let s_a = up.ramp * (v0 + a_up * up.ramp / 6.0);
        let s_b = s_a + 0.5 * (v_a + v_b) * up.hold;
        push(0.0, v0, 0.0, j, up.ramp);
        push(s_a, v_a, a_up, 0.0, up.hold);
        push(s_b, v_b, a_up, -j, up.ramp);
        push(d_up, v, 0.0, 0.0, t_cruise);
        // The braking leg from its end backwards.
        let a_down = j * down.ramp;
        let (v_d, v_c) = (v1 + 0.5 * a_down * down.ramp, v - 0.5 * a_down * down.ramp);
        let s_d = length - down.ramp * (v1 + a_down * down.ramp / 6.0);
        let s_c = s_d - 0.5 * (v_c + v_d) * down.hold;
        push(d_up + left, v, 0.0, -j, down.ramp);
        push(s_c, v_c, -a_down, 0.0, down.hold);
        push(s_d, v_d, -a_down, j, down.ramp);
        phases.duration = t_up + t_cruise + t_down;
        Self { phases, v_start: v0, v_peak: v, adjusted }
    }

    /// The change that made the displacement suffice.
    pub const fn adjusted(&self) -> Adjusted {
        self.adjusted
    }

    /// Displacement (m).
    pub const fn length(&self) -> f64 {
        self.phases.end.p
    }

    /// Speed at the start (m/s).
    pub const fn v_start(&self) -> f64 {
        self.v_start
    }

    /// Speed at the end (m/s).
    pub const fn v_end(&self) -> f64 {
        self.phases.end.v
    }

    /// Highest speed of the profile (m/s).
    pub const fn v_peak(&self) -> f64 {
        self.v_peak
    }

    /// The phases in order, at most seven, each with its duration (s), which is not zero.
    pub fn phases(&self) -> impl ExactSizeIterator<Item = (Phase, f64)> + '_ {
        self.phases.iter()
    }

    /// The state at position `s` (m), clamped to `[0, length]` (NaN counts as 0).
    pub fn at_position(&self, s: f64) -> MotionState {
        if s >= self.phases.end.p {
            return self.phases.end;
        }
        if s.is_nan() || s <= 0.0 {
            return self.at(0.0);
        }
        let last = self.phases.iter().take_while(|(phase, _)| phase.s <= s).last();
        let Some((phase, duration)) = last else { return self.at(0.0) };
        MotionState { p: s, ..phase.after(phase.time_to_cover(s - phase.s, duration)) }
    }
}

fn check(length: f64, v_start: f64, v_end: f64, limits: &AxisLimits) -> Result<(), FeedError> {
    not_negative("length", length)?;
    positive("v_max", limits.v_max())?;
    limits.check_symmetric_acceleration()?;
    for (what, value) in [("v_start", v_start), ("v_end", v_end)] {
        not_negative(what, value)?;
        if value > limits.v_max() {
            return Err(FeedError::AboveLimit { what, value, limit: limits.v_max() });
        }
    }
    Ok(())
}

fn finish(profile: SProfile) -> Result<SProfile, FeedError> {
    if profile.phases.is_finite() {
        Ok(profile)
    } else {
        Err(FeedError::OutOfRange { what: "duration of the S-profile" })
    }
}

impl MotionLaw for SProfile {
    fn duration(&self) -> f64 {
        self.phases.duration
    }

    fn at(&self, t: f64) -> MotionState {
        let state = self.phases.at(t);
        if t >= self.phases.duration {
            return state;
        }
        if t > 0.0 {
            // Round-off may carry the last speeds of a full stop below 0.
            return MotionState { v: state.v.max(0.0), ..state };
        }
        MotionState { p: 0.0, v: self.v_start, a: 0.0, j: state.j }
    }
}
