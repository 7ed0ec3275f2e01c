//! Limits on the torque of the drives.

use std::fmt;

use arcfeed_kinematics::{Dynamics, Joints, KinematicsError};

use crate::error::LimitError;

/// The load of the drives and their limits: dynamics of the arm with its payload, and greatest torques.
#[derive(Clone, Copy)]
pub struct TorqueLimits<'a, const N: usize = 6> {
    dynamics: &'a (dyn Dynamics<N> + Sync),
    limits: Joints<N>,
}

impl<const N: usize> fmt::Debug for TorqueLimits<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TorqueLimits").field("limits", &self.limits).finish_non_exhaustive()
    }
}

impl<'a, const N: usize> TorqueLimits<'a, N> {
    /// The greatest torques `limits` (N m, either sign; infinite means none) of an arm with `dynamics`.
    ///
    /// # Errors
    /// [`LimitError::Joint`] for a torque that is not above 0.
    pub fn new(dynamics: &'a (dyn Dynamics<N> + Sync), limits: Joints<N>) -> Result<Self, LimitError> {
        match (0..N).find(|&j| limits[j].is_nan() || limits[j] <= 0.0) {
            Some(joint) => {
                let (value, rule) = (limits[joint], "greater than 0 (infinite for none)");
                Err(KinematicsError::InvalidLimit { joint, what: "torque", value, rule }.into())
            }
            None => Ok(Self { dynamics, limits }),
        }
    }

    /// Greatest torques, N m.
    pub fn limits(&self) -> &Joints<N> {
        &self.limits
    }

    /// The dynamics of the arm, payload and friction included.
    pub fn dynamics(&self) -> &'a (dyn Dynamics<N> + Sync) {
        self.dynamics
    }

    /// The torque of a motion, N m.
    pub fn torque(&self, q: &Joints<N>, qd: &Joints<N>, qdd: &Joints<N>) -> Joints<N> {
        self.dynamics.torque(q, qd, qdd)
    }
}
