//! Closed-form inverse kinematics.

mod arm_plane;
mod collector;
mod parallel_axis;
mod planar;
mod rules;
mod solutions;
mod spherical_wrist;

pub(crate) use collector::{Collect, Collector};
pub use parallel_axis::ParallelAxes;
pub use solutions::Solutions;
pub use spherical_wrist::SphericalWrist;

use crate::{
    error::KinematicsError, jacobian::Configuration, joint::Joints, posture::Posture, singularity::SingularityDistances,
};
use nalgebra::Isometry3;

/// A family of six-joint arms whose inverse is known in closed form, with the numbers of one of them. The families are those of this
/// crate.
pub trait ClosedForm: Collect + Copy + Send + Sync + 'static {
    /// The joint that keeps its value from the seed where the wrist is singular.
    const FREE_JOINT: usize;

    /// The solver for an arm that looks like `zero` at zero joint values.
    ///
    /// # Errors
    /// The first rule of the family's geometry that the arm breaks.
    fn recognise(zero: &Configuration<6>) -> Result<Self, KinematicsError>;

    /// True if the geometry is ideal to rounding, so that solutions need no polish.
    fn is_exact(&self) -> bool;

    /// All solutions for `target`. Where a singular pose leaves a joint free it takes its value from `seed` (which must be finite).
    ///
    /// # Errors
    /// [`KinematicsError::Unreachable`], or what is wrong with the target.
    fn solve(&self, target: &Isometry3<f64>, seed: &Joints<6>) -> Result<Solutions<6>, KinematicsError> {
        let mut all = Collector::all();
        self.collect(target, seed, &mut all)?;
        Ok(all.into_solutions())
    }

    /// Distances of an arm that looks like `at` from the singular poses of its kinds.
    fn singularity_distances(&self, at: &Configuration<6>) -> SingularityDistances;

    /// Which of the solutions an arm that looks like `at` stands in.
    fn posture(&self, at: &Configuration<6>) -> Posture;
}
