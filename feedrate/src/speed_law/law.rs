//! The law itself: pieces, end and duration.

use super::piece::{Piece, Shape};
use crate::error::{FeedError, positive};
use crate::state::{MotionLaw, MotionState};

/// Positions this close, as a part of the largest one, are the same.
const SAME_PLACE: f64 = 1e-12;
/// Halvings of the time on a piece in which a position is passed.
const MOST_HALVINGS: usize = 80;

/// The motion along a path over time, exact between its knots.
///
/// A piece between two knots has constant jerk (the S-profile scans), or an acceleration that is
/// linear in `s` (the planners on rows: `v^2` is quadratic in `s`; constant acceleration is the
/// special case). Pieces are anchored to positions on the path, so that rounding does not add up;
/// the end is exactly the end of the path.
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
    pub(super) pieces: Vec<Piece>,
    pub(super) end: MotionState,
    pub(super) duration: f64,
}

impl SpeedLaw {
    /// Laws one after the other, as where a path has corners at which the tool stands, the first
    /// from position `start` on. Each is taken to start where the one before ends; without any the
    /// result is the empty motion.
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

    /// The same motion with all speeds multiplied by `factor`: it takes `1 / factor` of the time. Accelerations are multiplied by its
    /// square, jerks by its third power.
    ///
    /// ```
    /// use arcfeed_feedrate::SpeedLaw;
    /// let law = SpeedLaw::from_knots(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0])?.scaled(0.5)?;
    /// assert_eq!((law.duration(), law.end().v), (6.0, 0.5));
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`] for a factor that is not a number above 0.
    pub fn scaled(&self, factor: f64) -> Result<Self, FeedError> {
        let factor = positive("factor of the speed", factor)?;
        let square = factor * factor;
        let shape = |shape: Shape| match shape {
            Shape::Jerk(j) => Shape::Jerk(j * square * factor),
            Shape::Slope(w) => Shape::Slope(w * square),
        };
        let piece =
            |p: &Piece| Piece { t: p.t / factor, s: p.s, v: p.v * factor, a: p.a * square, shape: shape(p.shape) };
        Ok(Self {
            pieces: self.pieces.iter().map(piece).collect(),
            end: MotionState { v: self.end.v * factor, ..self.end },
            duration: self.duration / factor,
        })
    }

    /// The motion up to the knot at position `s` (m).
    pub(crate) fn until(mut self, s: f64) -> Self {
        let i = self.pieces.partition_point(|piece| piece.s < s);
        if let Some(knot) = self.pieces.get(i) {
            (self.end, self.duration) = (knot.after(0.0), knot.t);
            self.pieces.truncate(i);
            self.pieces.shrink_to_fit();
        }
        self
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

    /// The first time (s) at which the motion is at position `s` (m), clamped to the path (NaN counts as its start). Exactly
    /// the time of a knot where that has the position but for rounding.
    ///
    /// ```
    /// use arcfeed_feedrate::SpeedLaw;
    /// let law = SpeedLaw::from_knots(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0])?;
    /// assert_eq!(law.time_at_position(1.0), 2.0);
    /// assert!((law.time_at_position(0.25) - 1.0).abs() < 1e-12);
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    pub fn time_at_position(&self, s: f64) -> f64 {
        let near = SAME_PLACE * self.end.p.abs().max(self.start().abs());
        let after = self.pieces.partition_point(|piece| piece.s < s - near);
        let (mut high, place) = self.pieces.get(after).map_or((self.duration, self.end.p), |knot| (knot.t, knot.s));
        let Some(before) = after.checked_sub(1) else { return high };
        if place <= s + near {
            return high;
        }
        let mut low = self.pieces[before].t;
        for _ in 0..MOST_HALVINGS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.state_in(before, middle).p < s {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// The state a distance `ds` (m) after the start of piece `k`.
    pub(crate) fn within(&self, k: usize, ds: f64) -> MotionState {
        let end = self.pieces.get(k + 1).map_or(self.duration, |next| next.t);
        self.pieces[k].after_distance(ds, end - self.pieces[k].t)
    }

    #[inline]
    pub(super) fn state_in(&self, i: usize, t: f64) -> MotionState {
        let Some(piece) = self.pieces.get(i) else { return self.end };
        let (end_s, end_t, end_v) = match self.pieces.get(i + 1) {
            Some(next) => (next.s, next.t, next.v),
            None => (self.end.p, self.duration, self.end.v),
        };
        let mut state = match piece.reversed([end_s, end_t, end_v], t) {
            Some(reversed) => reversed.after(t - end_t),
            None => piece.after(t - piece.t),
        };
        // Round-off may carry a full stop below 0 or a hair beyond the next knot.
        state.v = state.v.max(0.0);
        state.p = state.p.min(end_s);
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
