//! The motion law of a path, `s(t)`: what every planner returns.

mod builder;
mod cursor;
mod piece;

pub(crate) use builder::Builder;
pub use cursor::Cursor;

use crate::error::FeedError;
use crate::state::{MotionLaw, MotionState};
use piece::Piece;

/// The motion along a path over time, exact between its knots.
///
/// A piece between two knots has constant jerk (the S-profile scans), or an acceleration that is linear in `s` (the planners on rows:
/// `v^2` is quadratic in `s`; constant acceleration is the special case). Pieces are anchored to positions on the path, so that
/// rounding does not add up; the end is exactly the end of the path.
///
/// ```
/// use arcfeed_feedrate::{MotionLaw, SpeedLaw};
/// // 2 m: the first at constant acceleration from rest to 1 m/s, the second at 1 m/s.
/// let law = SpeedLaw::from_knots(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0])?;
/// assert_eq!(law.duration(), 3.0);
/// assert_eq!(law.at(1.0).v, 0.5);
/// assert_eq!(law.at_position(0.25).v, 0.5);
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedLaw {
    pieces: Vec<Piece>,
    end: MotionState,
    duration: f64,
}

impl SpeedLaw {
    /// A law by speeds `v` (m/s, not negative) at positions `s` (m, increasing), with constant acceleration between.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`], [`FeedError::Empty`] for fewer than two knots, [`FeedError::NotFinite`], [`FeedError::Negative`],
    /// [`FeedError::BadGrid`] for positions that do not increase, [`FeedError::StandsStill`] for two knots in a row at rest.
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
    /// [`FeedError::Empty`], [`FeedError::NotFinite`], [`FeedError::Negative`] for a duration below 0 or a phase in which the speed
    /// falls below 0.
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
            let phase = crate::scurve::phase::Phase { t: 0.0, s: state.p, v: state.v, a: state.a, j };
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

    /// Laws one after the other, as where a path has corners at which the tool stands, the first from position `start` on. Each is
    /// taken to start where the one before ends; without any the result is the empty motion.
    pub fn chain(start: f64, parts: impl IntoIterator<Item = Self>) -> Self {
        let end = MotionState { p: start, ..MotionState::default() };
        let mut chained = Self { pieces: Vec::new(), end, duration: 0.0 };
        for part in parts {
            let (t0, s0) = (chained.duration, chained.end.p - part.start());
            chained.pieces.extend(part.pieces.iter().map(|p| Piece { t: t0 + p.t, s: s0 + p.s, ..*p }));
            chained.end = MotionState { p: s0 + part.end.p, ..part.end };
            chained.duration = t0 + part.duration;
        }
        chained
    }

    /// Duration of the motion (s).
    pub const fn duration(&self) -> f64 {
        self.duration
    }

    /// Position at the start (m).
    pub fn start(&self) -> f64 {
        self.pieces.first().map_or(self.end.p, |piece| piece.s)
    }

    /// The state at the end of the path; acceleration and jerk are 0 there, the motion being over.
    pub const fn end(&self) -> MotionState {
        self.end
    }

    /// Time (s) and state at the start of every piece; the last piece ends in [`SpeedLaw::end`].
    pub fn knots(&self) -> impl ExactSizeIterator<Item = (f64, MotionState)> + '_ {
        self.pieces.iter().map(|piece| (piece.t, piece.after(0.0)))
    }

    /// Speed (m/s) at position `s` (m), clamped to the path (NaN counts as its start).
    pub fn v_at_s(&self, s: f64) -> f64 {
        self.at_position(s).v
    }

    /// The state at position `s` (m), clamped to the path (NaN counts as its start).
    pub fn at_position(&self, s: f64) -> MotionState {
        if s >= self.end.p || self.pieces.is_empty() {
            return self.end;
        }
        let s = if s >= self.start() { s } else { self.start() };
        let i = self.pieces.partition_point(|piece| piece.s <= s).saturating_sub(1);
        self.within(i, s - self.pieces[i].s)
    }

    /// A sampler that remembers its place: amortised constant time for increasing `t`, no allocation.
    ///
    /// ```
    /// use arcfeed_feedrate::{MotionLaw, Segment, plan_per_segment};
    /// let segments = [Segment::new(0.01, 0.1, 1.0, 50.0)?; 4];
    /// let law = plan_per_segment(&segments, 0.0, 0.0)?;
    /// let mut cursor = law.cursor();
    /// let mut t = 0.0;
    /// while t < law.duration() {
    ///     assert_eq!(cursor.at(t), law.at(t));
    ///     t += 1e-3;
    /// }
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    pub fn cursor(&self) -> Cursor<'_> {
        Cursor { law: self, i: 0 }
    }

    /// The state a distance `ds` (m) after the start of piece `k`.
    pub(crate) fn within(&self, k: usize, ds: f64) -> MotionState {
        let end = self.pieces.get(k + 1).map_or(self.duration, |next| next.t);
        self.pieces[k].after_distance(ds, end - self.pieces[k].t)
    }

    #[inline]
    fn state_in(&self, i: usize, t: f64) -> MotionState {
        let Some(piece) = self.pieces.get(i) else { return self.end };
        let mut state = piece.after(t - piece.t);
        // Round-off may carry a full stop below 0 or a hair beyond the next knot.
        state.v = state.v.max(0.0);
        state.p = state.p.min(self.pieces.get(i + 1).map_or(self.end.p, |next| next.s));
        state
    }
}

impl MotionLaw for SpeedLaw {
    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> MotionState {
        if t >= self.duration {
            return self.end;
        }
        let t = if t.is_nan() { 0.0 } else { t.max(0.0) };
        self.state_in(self.pieces.partition_point(|piece| piece.t <= t).saturating_sub(1), t)
    }
}
