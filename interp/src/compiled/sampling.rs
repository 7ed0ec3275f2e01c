//! Sampling of a joint trajectory in the order of time.

use super::joint_trajectory::{JointSetpoint, JointTrajectory};
use crate::error::{LimitError, positive};
use crate::setpoint::cycles;

impl<const N: usize> JointTrajectory<N> {
    /// A sampler that remembers its place, for times that increase.
    pub fn cursor(&self) -> JointCursor<'_, N> {
        JointCursor::new(self)
    }

    /// Setpoints at the control `period`, s, and one exactly at the end.
    ///
    /// # Errors
    /// [`LimitError::NotPositive`] when the period is not a finite number above 0.
    pub fn setpoints(&self, period: f64) -> Result<JointSetpoints<'_, N>, LimitError> {
        Ok(JointSetpoints::new(self, positive("control period", period)?))
    }
}

/// A place in a [`JointTrajectory`] from which sampling goes on; see [`JointTrajectory::cursor`].
#[derive(Debug, Clone)]
pub struct JointCursor<'a, const N: usize = 6> {
    motion: &'a JointTrajectory<N>,
    piece: usize,
}

impl<'a, const N: usize> JointCursor<'a, N> {
    fn new(motion: &'a JointTrajectory<N>) -> Self {
        Self { motion, piece: 0 }
    }

    /// The motion at time `t`, s: the same as [`JointTrajectory::at`]. Times may also go back. It does not allocate.
    #[inline]
    pub fn at(&mut self, t: f64) -> JointSetpoint<N> {
        self.piece = self.motion.walk(self.piece, t);
        self.motion.in_piece(self.piece, t)
    }

    /// Goes to the time `t`, s, in a search of its own.
    pub fn seek(&mut self, t: f64) {
        self.piece = self.motion.find(t);
    }
}

/// Yields the setpoints of a joint trajectory, one per control period and one exactly at the end.
#[derive(Debug, Clone)]
pub struct JointSetpoints<'a, const N: usize = 6> {
    cursor: JointCursor<'a, N>,
    duration: f64,
    period: f64,
    cycle: usize,
    cycles: usize,
}

impl<'a, const N: usize> JointSetpoints<'a, N> {
    fn new(motion: &'a JointTrajectory<N>, period: f64) -> Self {
        let duration = motion.duration();
        Self { cursor: motion.cursor(), duration, period, cycle: 0, cycles: cycles(duration, period) }
    }

    /// Number of setpoints in all, both ends included.
    pub fn samples(&self) -> usize {
        self.cycles.saturating_add(1)
    }
}

impl<const N: usize> Iterator for JointSetpoints<'_, N> {
    type Item = JointSetpoint<N>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.cycle > self.cycles {
            return None;
        }
        let t = if self.cycle == self.cycles { self.duration } else { self.cycle as f64 * self.period };
        self.cycle += 1;
        Some(self.cursor.at(t))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let rest = self.samples().saturating_sub(self.cycle);
        (rest, Some(rest))
    }
}
