//! A serial chain of joints and its fast forward kinematics.

use crate::{
    error::KinematicsError,
    jacobian::{Configuration, quaternion},
    joint::{Joint, JointKind, Joints, checked_pose},
    normalised::Normalised,
    traits::{ForwardKinematics, PoseResidual},
};
use nalgebra::{Isometry3, Matrix3};

/// A serial arm of `N` joints with arbitrary origins and axes:
/// `base * origin_1 * motion_1(q_1) * ... * origin_N * motion_N(q_N) * flange * tool`.
///
/// `base` is where the arm stands in the frame you work in, `flange` leads from the last joint's frame to the mounting
/// face (z out of it), `tool` from there to the tool point; all three are the identity unless set.
///
/// ```
/// use arcfeed_kinematics::{Chain, ForwardKinematics, Joint, Joints, nalgebra::{Isometry3, Vector3}};
/// let elbow = Isometry3::translation(0.4, 0.0, 0.0);
/// let arm = Chain::new([
///     Joint::revolute(Isometry3::identity(), Vector3::z())?,
///     Joint::revolute(elbow, Vector3::z())?,
/// ])?
/// .with_tool(Isometry3::translation(0.3, 0.0, 0.0))?;
/// let pose = arm.forward(&Joints::<2>::new(0.0, std::f64::consts::FRAC_PI_2));
/// assert!((pose.translation.vector - Vector3::new(0.4, 0.3, 0.0)).norm() < 1e-15);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Chain<const N: usize> {
    base: Isometry3<f64>,
    joints: [Joint; N],
    flange: Isometry3<f64>,
    tool: Isometry3<f64>,
    /// Sum of all lengths from the origin of the working frame to the tool, m.
    lengths: f64,
    fast: Normalised<N>,
}

impl<const N: usize> Chain<N> {
    /// A chain of joints from the base outwards, with base, flange and tool the identity.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] if the lengths are so large that their sum overflows.
    pub fn new(joints: [Joint; N]) -> Result<Self, KinematicsError> {
        let identity = Isometry3::identity();
        Self::assemble(identity, joints, identity, identity)
    }

    /// The same arm standing at `base` in the working frame.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_base(&self, base: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Self::assemble(checked_pose("base", &base)?, self.joints, self.flange, self.tool)
    }

    /// The same arm with its mounting face at `flange` in the frame of the last joint.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_flange(&self, flange: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Self::assemble(self.base, self.joints, checked_pose("flange", &flange)?, self.tool)
    }

    /// The same arm with its tool point at `tool` in the frame of the flange.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_tool(&self, tool: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Self::assemble(self.base, self.joints, self.flange, checked_pose("tool", &tool)?)
    }

    fn assemble(
        base: Isometry3<f64>,
        joints: [Joint; N],
        flange: Isometry3<f64>,
        tool: Isometry3<f64>,
    ) -> Result<Self, KinematicsError> {
        let (fast, _) = Normalised::new(&base, &joints, &(flange * tool));
        let parts = joints.iter().map(Joint::origin).chain([&base, &flange, &tool]);
        let lengths = parts.map(|part| part.translation.vector.norm()).sum();
        let chain = Self { base, joints, flange, tool, lengths, fast };
        let zero = chain.configuration(&Joints::zeros());
        if !zero.tool.iter().chain(zero.points.iter().flatten()).all(|v| v.is_finite()) {
            return Err(KinematicsError::NotFinite { what: "the sum of the chain's lengths" });
        }
        Ok(chain)
    }

    /// The chain of the `M` = N - 1 other joints with `joint` held at `value`.
    pub(crate) fn locked<const M: usize>(&self, joint: usize, value: f64) -> Result<Chain<M>, KinematicsError> {
        let mut carried = Isometry3::identity();
        let mut joints = [self.joints[0]; M];
        let mut place = joints.iter_mut();
        for (i, one) in self.joints.iter().enumerate() {
            let origin = carried * one.origin();
            if i == joint {
                carried = origin * one.motion(value);
            } else if let Some(place) = place.next() {
                *place = Joint::new(origin, one.axis().into_inner(), one.kind())?;
                carried = Isometry3::identity();
            }
        }
        Chain::new(joints)?.with_base(self.base)?.with_flange(carried * self.flange)?.with_tool(self.tool)
    }

    /// The form the arithmetic runs in, and the orientation of its link frames in those of the joints.
    pub(crate) fn normalised(&self) -> (Normalised<N>, [Matrix3<f64>; N]) {
        Normalised::new(&self.base, &self.joints, &(self.flange * self.tool))
    }

    /// The distance from an inverse's target that rounding alone leaves at `q`.
    pub(crate) fn residual(&self, q: &Joints<N>) -> PoseResidual {
        let (mut extent, mut angles) = (self.lengths, 0.0);
        for (joint, value) in self.joints.iter().zip(q.iter()) {
            match joint.kind() {
                JointKind::Revolute => angles += value.abs(),
                JointKind::Prismatic => extent += value.abs(),
            }
        }
        PoseResidual::of_rounding(extent, angles)
    }

    /// The place of the arm in the working frame.
    pub fn base(&self) -> &Isometry3<f64> {
        &self.base
    }

    /// The joints, from the base outwards.
    pub fn joints(&self) -> &[Joint; N] {
        &self.joints
    }

    /// The mounting face in the frame of the last joint.
    pub fn flange(&self) -> &Isometry3<f64> {
        &self.flange
    }

    /// The tool point in the frame of the flange.
    pub fn tool(&self) -> &Isometry3<f64> {
        &self.tool
    }
}

impl<const N: usize> ForwardKinematics<N> for Chain<N> {
    #[inline]
    fn configuration(&self, q: &Joints<N>) -> Configuration<N> {
        self.fast.configuration(q)
    }

    #[inline]
    fn forward(&self, q: &Joints<N>) -> Isometry3<f64> {
        let (rotation, position) = self.fast.tool(q);
        Isometry3::from_parts(position.into(), quaternion(&rotation))
    }
}
