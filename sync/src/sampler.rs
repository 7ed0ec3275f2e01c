//! Sampling in the order of time.

use arcfeed_feedrate::{MotionState, Phase, StateToState};

use crate::joint_state::JointState;
use crate::state_to_state::Trajectory;

/// Samples of a [`Trajectory`]: any order of times is fine, neighbouring ones are fast.
#[derive(Debug, Clone)]
pub struct Sampler<'a, const N: usize> {
    motion: &'a Trajectory<N>,
    windows: [Window; N],
}

impl<const N: usize> Sampler<'_, N> {
    /// As [`Trajectory::at`].
    #[inline]
    pub fn at(&mut self, t: f64) -> JointState<N> {
        let mut state = JointState::default();
        for (k, (window, axis)) in self.windows.iter_mut().zip(self.motion.axes()).enumerate() {
            let MotionState { p, v, a, j } = window.sample(axis, t);
            (state.q[k], state.qd[k], state.qdd[k], state.qddd[k]) = (p, v, a, j);
        }
        state
    }
}

impl<const N: usize> Trajectory<N> {
    /// Samples in a few ns as long as no axis passes on to its next phase.
    pub fn sampler(&self) -> Sampler<'_, N> {
        Sampler { motion: self, windows: [Window::default(); N] }
    }
}

/// The phase in which an axis was sampled last. Belongs to one motion.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Window {
    phase: Phase,
    duration: f64,
    until: f64,
}

impl Window {
    /// As [`StateToState::at_or_after`].
    #[inline]
    pub fn sample(&mut self, motion: &StateToState, t: f64) -> MotionState {
        if !(self.phase.t <= t && t < self.until) {
            (self.phase, self.duration, self.until) = motion.phase_at(t);
            if !(self.phase.t <= t && t < self.until) {
                // The very end, before the start, or not a number.
                return motion.at_or_after(t);
            }
        }
        self.phase.after((t - self.phase.t).min(self.duration))
    }
}
