//! Sampling of a speed law in the order of time.

use super::SpeedLaw;
use crate::state::MotionState;

/// A place in a [`SpeedLaw`] from which sampling goes on; see [`SpeedLaw::cursor`].
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    pub(super) law: &'a SpeedLaw,
    pub(super) i: usize,
}

impl Cursor<'_> {
    /// The state at time `t` (s), the same as [`MotionLaw::at`](crate::MotionLaw::at) of the law. Times may also go back; that costs a
    /// search.
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
