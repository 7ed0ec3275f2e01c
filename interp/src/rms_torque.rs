//! The thermal load of the drives.

use arcfeed_kinematics::Joints;

use crate::error::PlanError;
use crate::time_pieces::time_pieces;
use crate::trajectory::Trajectory;

/// Places and weights of Gauss's rule with three of them on [0, 1]: exact for polynomials of degree 5, and never at an end.
const GAUSS: [[f64; 2]; 3] =
    [[0.112_701_665_379_258_3, 5.0 / 18.0], [0.5, 8.0 / 18.0], [0.887_298_334_620_741_7, 5.0 / 18.0]];

impl<const N: usize> Trajectory<'_, N> {
    /// Root mean square of the torque of every drive over the motion, N m: what heats its winding, to be held against the torque that a
    /// drive gives for ever. `None` where the dynamics of the arm are not known, that is where no torque is limited.
    ///
    /// A motion that is repeated with pauses heats less, and one that holds the arm against gravity between heats more.
    ///
    /// # Errors
    /// [`PlanError::Path`] as for setpoints.
    pub fn rms_torque(&self) -> Result<Option<Joints<N>>, PlanError> {
        if self.limits().torque().is_none() {
            return Ok(None);
        }
        let mut setpoints = self.setpoints(self.period())?;
        let mut heat = Joints::<N>::zeros();
        for [from, duration] in time_pieces(self.law()) {
            for [place, weight] in GAUSS {
                let at = setpoints.at(from + place * duration)?;
                if let Some(torque) = self.torque(&at) {
                    heat += torque.component_mul(&torque) * (weight * duration);
                }
            }
        }
        Ok(Some((heat / self.duration()).map(f64::sqrt)))
    }
}
