//! Laws from knots and from phases.

use super::builder::Builder;
use super::law::SpeedLaw;
use crate::error::FeedError;
use crate::scurve::phase::Phase;
use crate::state::MotionState;

impl SpeedLaw {
    /// A law by speeds `v` (m/s, not negative) at positions `s` (m, increasing), with constant
    /// acceleration between.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`], [`FeedError::Empty`] for fewer than two knots,
    /// [`FeedError::NotFinite`], [`FeedError::Negative`], [`FeedError::BadGrid`] for positions that
    /// do not increase, [`FeedError::StandsStill`] for two knots in a row at rest.
    pub fn from_knots(s: &[f64], v: &[f64]) -> Result<Self, FeedError> {
        if s.len() != v.len() {
            return Err(FeedError::LengthMismatch { what: "speeds at the knots", got: v.len(), expected: s.len() });
        }
        if s.len() < 2 {
            return Err(FeedError::Empty { what: "knots of a speed law, at least two" });
        }
        for (what, values) in [("position of a knot", s), ("speed at a knot", v)] {
            if let Some(&value) = values.iter().find(|x| !x.is_finite()) {
                return Err(FeedError::NotFinite { what, value });
            }
        }
        if let Some(&value) = v.iter().find(|v| **v < 0.0) {
            return Err(FeedError::Negative { what: "speed at a knot", value });
        }
        for k in 1..s.len() {
            if s[k] <= s[k - 1] {
                return Err(FeedError::BadGrid { index: k, s: s[k], previous: s[k - 1] });
            }
            if v[k] == 0.0 && v[k - 1] == 0.0 {
                return Err(FeedError::StandsStill { index: k - 1, s: s[k - 1], next: s[k] });
            }
        }
        Self::between(s, v.iter().map(|v| v * v))
    }

    /// A law of constant-jerk phases `(jerk in m/s³, duration in s)` from the state `start` on.
    ///
    /// ```
    /// use arcfeed_feedrate::{MotionLaw, MotionState, SpeedLaw};
    /// // From rest to 1 m/s within 2 s.
    /// let law = SpeedLaw::from_phases(MotionState::default(), &[(1.0, 1.0), (-1.0, 1.0)])?;
    /// assert_eq!((law.end().v, law.end().p), (1.0, 1.0));
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    ///
    /// # Errors
    /// [`FeedError::Empty`], [`FeedError::NotFinite`], [`FeedError::Negative`] for a duration below
    /// 0 or a phase in which the speed falls below 0.
    pub fn from_phases(start: MotionState, phases: &[(f64, f64)]) -> Result<Self, FeedError> {
        if phases.is_empty() {
            return Err(FeedError::Empty { what: "phases of a speed law" });
        }
        let mut builder = Builder::with_capacity(phases.len());
        let mut state = start;
        for &(j, dt) in phases {
            if !(j + dt + state.p + state.v + state.a).is_finite() {
                return Err(FeedError::NotFinite { what: "phase of a speed law", value: j + dt });
            }
            if dt < 0.0 {
                return Err(FeedError::Negative { what: "duration of a phase", value: dt });
            }
            builder.push_phase(state.p, state.v, state.a, j, dt);
            let phase = Phase { t: 0.0, s: state.p, v: state.v, a: state.a, j };
            // The speed is least at an end of the phase or where its acceleration is zero.
            let turn = -state.a / j;
            for at in [dt, if turn > 0.0 && turn < dt { turn } else { 0.0 }] {
                let v = phase.after(at).v;
                if v < -1e-12 * (state.v.abs() + state.a.abs() * dt + j.abs() * dt * dt) {
                    return Err(FeedError::Negative { what: "speed in a phase", value: v });
                }
            }
            state = phase.after(dt);
        }
        builder.finish(state.p, state.v.max(0.0))
    }

    /// Constant acceleration between grid points, from the squared speeds at them.
    pub(crate) fn from_squared_speeds(s: &[f64], x: &[f64]) -> Result<Self, FeedError> {
        Self::between(s, x.iter().copied())
    }

    fn between(s: &[f64], x: impl Iterator<Item = f64>) -> Result<Self, FeedError> {
        let mut builder = Builder::with_capacity(s.len());
        let mut last: Option<(f64, f64)> = None;
        let mut v_end = 0.0;
        for (&s, x) in s.iter().zip(x) {
            v_end = x.sqrt();
            if let Some((s0, x0)) = last {
                let h = s - s0;
                builder.push_constant(s0, h, [x0.sqrt(), v_end], 0.5 * (x - x0) / h);
            }
            last = Some((s, x));
        }
        builder.finish(s[s.len() - 1], v_end)
    }
}
