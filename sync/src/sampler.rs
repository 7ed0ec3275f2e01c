//! Sampling in the order of time.

use arcfeed_feedrate::{MotionState, Phase};

use crate::point_to_point::JointState;
use crate::state_to_state::Trajectory;

/// Samples of a [`Trajectory`]: any order of times is fine, neighbouring ones are fast.
#[derive(Debug, Clone)]
pub struct Sampler<'a, const N: usize> {
    pub(crate) motion: &'a Trajectory<N>,
    pub(crate) window: Window<N>,
}

impl<const N: usize> Sampler<'_, N> {
    /// As [`Trajectory::at`].
    #[inline]
    pub fn at(&mut self, t: f64) -> JointState<N> {
        self.window.sample(self.motion, t)
    }
}

/// A time in which no axis passes on to another phase. Belongs to one motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window<const N: usize> {
    from: f64,
    until: f64,
    phases: [Phase; N],
    lasting: [f64; N],
}

impl<const N: usize> Default for Window<N> {
    fn default() -> Self {
        Self { from: 0.0, until: 0.0, phases: [Phase::default(); N], lasting: [0.0; N] }
    }
}

impl<const N: usize> Window<N> {
    #[inline]
    pub fn sample(&mut self, motion: &Trajectory<N>, t: f64) -> JointState<N> {
        if !(self.from <= t && t < self.until) {
            self.find(motion, t);
            if !(self.from <= t && t < self.until) {
                // The very end of an axis, before the start, or not a number.
                return motion.at(t);
            }
        }
        let mut state = JointState::default();
        for k in 0..N {
            let phase = &self.phases[k];
            let MotionState { p, v, a, j } = phase.after((t - phase.t).min(self.lasting[k]));
            (state.q[k], state.qd[k], state.qdd[k], state.qddd[k]) = (p, v, a, j);
        }
        state
    }

    #[cold]
    fn find(&mut self, motion: &Trajectory<N>, t: f64) {
        (self.from, self.until) = (f64::NEG_INFINITY, f64::INFINITY);
        for (k, axis) in motion.axes().iter().enumerate() {
            let until;
            (self.phases[k], self.lasting[k], until) = axis.phase_at(t);
            self.from = self.from.max(self.phases[k].t);
            self.until = self.until.min(until);
        }
    }
}
