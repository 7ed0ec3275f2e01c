//! The abilities of an arm, as traits: planners ask for these and not for a particular arm.

use crate::{
    analytic::Solutions,
    error::KinematicsError,
    jacobian::{Configuration, Jacobian, Twist},
    joint::Joints,
    posture::Posture,
    singularity_kind::SingularityKind,
};
use nalgebra::Isometry3;

/// From joint values to the tool: pose, Jacobian and its derivatives.
///
/// Poses are tool in base. Jacobian rows are linear x y z, then angular x y z, along the axes of the base, at the tool
/// point. Joint values that are not finite give results that are not finite; nothing panics.
pub trait ForwardKinematics<const N: usize> {
    /// The arm at `q`: the tool pose and every joint axis. All the other methods follow from it; take it once when
    /// several are needed at the same `q`.
    fn configuration(&self, q: &Joints<N>) -> Configuration<N>;

    /// Pose of the tool in the base.
    fn forward(&self, q: &Joints<N>) -> Isometry3<f64> {
        self.configuration(q).pose()
    }

    /// Geometric Jacobian J of the tool point: twist = J qd.
    fn jacobian(&self, q: &Joints<N>) -> Jacobian<N> {
        self.configuration(q).jacobian()
    }

    /// Pose and Jacobian for little more than the price of the pose.
    fn forward_jacobian(&self, q: &Joints<N>) -> (Isometry3<f64>, Jacobian<N>) {
        let configuration = self.configuration(q);
        (configuration.pose(), configuration.jacobian())
    }

    /// J' qd: the tool's acceleration (linear, angular) when the joint accelerations are 0.
    fn jacobian_dot_qd(&self, q: &Joints<N>, qd: &Joints<N>) -> Twist {
        self.configuration(q).acceleration_bias(qd)
    }

    /// 2 J' qdd + J'' qd: the tool's jerk (linear, angular) when the joint jerks are 0.
    fn jerk_bias(&self, q: &Joints<N>, qd: &Joints<N>, qdd: &Joints<N>) -> Twist {
        self.configuration(q).jerk_bias(qd, qdd)
    }

    /// The kind of singular pose nearest to `q`, if the arm knows its own kinds. It names an error, it decides nothing.
    fn nearest_singularity(&self, _q: &Joints<N>) -> Option<SingularityKind> {
        None
    }
}

/// From a tool pose to joint values, near given ones. Usable as `dyn InverseKinematics<N>`.
pub trait InverseKinematics<const N: usize> {
    /// Joint values inside the joint limits that put the tool at `target`, as near to `seed` as can be (least largest
    /// joint step, over all turns of 2 pi). Where a singular pose leaves a joint free it keeps its value from `seed`.
    ///
    /// # Errors
    /// [`KinematicsError::Unreachable`], [`KinematicsError::OutsideLimits`]; [`KinematicsError::NotFinite`] and
    /// [`KinematicsError::NotUnit`] for a target that is none, [`KinematicsError::JointNotFinite`] for such a seed.
    fn inverse(&self, target: &Isometry3<f64>, seed: &Joints<N>) -> Result<Joints<N>, KinematicsError>;

    /// The distance from its target at which a solution `q` may leave the tool, by rounding alone.
    /// Solutions along a smooth path are smooth up to this much, carried to the joints by the
    /// inverse of the Jacobian.
    ///
    /// Unless an arm says otherwise, that of six joints within a metre.
    fn residual(&self, q: &Joints<N>) -> PoseResidual {
        PoseResidual::of_rounding(1.0, q.iter().map(|value| value.abs()).sum())
    }
}

/// The distance from its target at which an inverse leaves the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseResidual {
    /// Distance of the tool point from the target, m.
    pub position: f64,
    /// Angle between the tool and the target, rad.
    pub orientation: f64,
}

impl PoseResidual {
    /// The residual that rounding leaves at an arm whose coordinates are at most `extent` (m) and whose turning
    /// joints stand at angles with absolute values of the sum `angles` (rad): each step along the
    /// arm rounds once, each angle by its own size.
    pub(crate) fn of_rounding(extent: f64, angles: f64) -> Self {
        const STEPS: f64 = 32.0;
        let orientation = f64::EPSILON * (STEPS + angles);
        Self { position: orientation * extent, orientation }
    }

    /// True if a miss of `position` (m) and `orientation` (rad) is no more than this.
    pub(crate) fn covers(&self, position: f64, orientation: f64) -> bool {
        position <= self.position && orientation <= self.orientation
    }
}

/// From a tool pose to all joint values that reach it.
pub trait AnalyticInverse<const N: usize> {
    /// Every solution modulo 2 pi, each angle in (-pi, pi], joint limits ignored. Never empty.
    ///
    /// # Errors
    /// [`KinematicsError::Unreachable`] when there is none; [`KinematicsError::NotFinite`] and
    /// [`KinematicsError::NotUnit`] for a target that is none.
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Solutions<N>, KinematicsError>;

    /// Which of the solutions of its pose `q` is, by name; `None` for an arm whose solutions have no names.
    fn posture(&self, _q: &Joints<N>) -> Option<Posture> {
        None
    }
}
