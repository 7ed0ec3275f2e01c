//! Sampling of a joint trajectory in the order of time.

use super::joint_trajectory::{JointSetpoint, JointTrajectory};
use crate::error::{LimitError, positive};
use crate::setpoint::SetpointTimes;

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
    times: SetpointTimes,
}

impl<'a, const N: usize> JointSetpoints<'a, N> {
    fn new(motion: &'a JointTrajectory<N>, period: f64) -> Self {
        Self { cursor: motion.cursor(), times: SetpointTimes::new(motion.duration(), period) }
    }

    /// Number of setpoints in all, both ends included.
    pub fn samples(&self) -> usize {
        self.times.samples()
    }
}

impl<const N: usize> Iterator for JointSetpoints<'_, N> {
    type Item = JointSetpoint<N>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let t = self.times.next()?;
        Some(self.cursor.at(t))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.times.size_hint()
    }
}
