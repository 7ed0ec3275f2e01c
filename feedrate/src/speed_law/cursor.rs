//! Sampling of a speed law in the order of time.

use super::law::SpeedLaw;
use crate::state::MotionState;

/// A place in a [`SpeedLaw`] from which sampling goes on; see [`SpeedLaw::cursor`].
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    pub(super) law: &'a SpeedLaw,
    pub(super) i: usize,
}

impl Cursor<'_> {
    /// The state at time `t` (s), the same as [`MotionLaw::at`](crate::MotionLaw::at) of the law.
    /// Times may also go back; that costs a search.
    #[inline]
    pub fn at(&mut self, t: f64) -> MotionState {
        let law = self.law;
        if t >= law.duration {
            return law.end;
        }
        let t = if t.is_nan() { 0.0 } else { t.max(0.0) };
        if law.pieces.get(self.i).is_some_and(|piece| piece.t > t) {
            self.i = law.pieces.partition_point(|piece| piece.t <= t).saturating_sub(1);
        }
        while law.pieces.get(self.i + 1).is_some_and(|next| next.t <= t) {
            self.i += 1;
        }
        law.state_in(self.i, t)
    }
}

impl SpeedLaw {
    /// A sampler that remembers its place: amortised constant time for increasing `t`, no
    /// allocation.
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
}
