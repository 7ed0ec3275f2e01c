//! The abilities of an arm that a planner needs.

use arcfeed_kinematics::{
    ForwardKinematics, InverseKinematics, JointDerivatives, Joints, KinematicsError, ToolDerivatives, joint_derivatives,
};

/// Below this smallest singular value of the Jacobian (rows in m and rad) a pose counts as singular: a tool speed of
/// 1 m/s would ask some joint for 1000 rad/s.
pub const MIN_SINGULAR_VALUE: f64 = 1e-3;

/// An arm that can follow a tool path: its joint values are a smooth function of the pose near a seed, and their
/// derivatives along the path are known.
///
/// Every arm of six joints with [`ForwardKinematics`] and [`InverseKinematics`] is one. An arm with more joints than the
/// tool has freedoms has to say by a rule of its own which of its many configurations belongs to a pose, and
/// `derivatives` has to follow the same rule.
pub trait PathArm<const N: usize>: ForwardKinematics<N> + InverseKinematics<N> + Send + Sync {
    /// The joint derivatives at `q` along a tool path with derivatives `tool`.
    ///
    /// # Errors
    /// [`KinematicsError::Singular`] closer to a singular pose than [`MIN_SINGULAR_VALUE`];
    /// [`KinematicsError::NotFinite`] for numbers that are not.
    fn derivatives(&self, q: &Joints<N>, tool: &ToolDerivatives) -> Result<JointDerivatives<N>, KinematicsError>;
}

impl<A: ForwardKinematics<6> + InverseKinematics<6> + Send + Sync> PathArm<6> for A {
    #[inline]
    fn derivatives(&self, q: &Joints<6>, tool: &ToolDerivatives) -> Result<JointDerivatives<6>, KinematicsError> {
        joint_derivatives(self, q, tool, MIN_SINGULAR_VALUE)
    }
}
