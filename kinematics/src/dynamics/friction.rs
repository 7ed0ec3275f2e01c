//! Friction in the joints.

use crate::{error::KinematicsError, joint::Joints};

/// Viscous and Coulomb friction of every joint, as torques (N m; N for prismatic joints) that the drive must add:
/// `viscous * qd + (coulomb_forward if qd > 0, -coulomb_backward if qd < 0)`.
///
/// At rest the Coulomb part is taken as 0; in truth it may have any value between the two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction<const N: usize> {
    viscous: Joints<N>,
    forward: Joints<N>,
    backward: Joints<N>,
}

impl<const N: usize> Friction<N> {
    /// Friction from viscous coefficients (N m s/rad) and the Coulomb torques in forward and backward motion (N m, both
    /// given as magnitudes).
    ///
    /// # Errors
    /// [`KinematicsError::InvalidLimit`] names the joint: all values must be finite and not negative.
    pub fn new(viscous: Joints<N>, forward: Joints<N>, backward: Joints<N>) -> Result<Self, KinematicsError> {
        for joint in 0..N {
            for (what, value) in [
                ("viscous friction", viscous[joint]),
                ("forward Coulomb friction", forward[joint]),
                ("backward Coulomb friction", backward[joint]),
            ] {
                if !(value.is_finite() && value >= 0.0) {
                    return Err(KinematicsError::InvalidLimit { joint, what, value, rule: "finite and not negative" });
                }
            }
        }
        Ok(Self { viscous, forward, backward })
    }

    /// No friction.
    pub fn none() -> Self {
        Self { viscous: Joints::zeros(), forward: Joints::zeros(), backward: Joints::zeros() }
    }

    /// Viscous coefficients, N m s/rad (N s/m).
    pub fn viscous(&self) -> &Joints<N> {
        &self.viscous
    }

    /// Coulomb torque in forward motion, N m (N).
    pub fn forward(&self) -> &Joints<N> {
        &self.forward
    }

    /// Coulomb torque in backward motion, a magnitude, N m (N).
    pub fn backward(&self) -> &Joints<N> {
        &self.backward
    }

    /// The part that is proportional to speed.
    pub fn viscous_torque(&self, qd: &Joints<N>) -> Joints<N> {
        self.viscous.component_mul(qd)
    }

    /// The part that depends on the direction of motion only.
    pub fn coulomb_torque(&self, qd: &Joints<N>) -> Joints<N> {
        Joints::from_fn(|i, _| match qd[i] {
            speed if speed > 0.0 => self.forward[i],
            speed if speed < 0.0 => -self.backward[i],
            // NaN stays NaN.
            speed => speed * 0.0,
        })
    }

    /// The torque that the drive must add at joint speeds `qd`.
    pub fn torque(&self, qd: &Joints<N>) -> Joints<N> {
        self.viscous_torque(qd) + self.coulomb_torque(qd)
    }
}
