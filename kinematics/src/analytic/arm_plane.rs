//! A target as seen from the plane of the arm.

use super::{
    Collector,
    planar::{FirstJoint, Miss, for_first_joints, plane_of_arm},
};
use crate::{
    error::KinematicsError,
    jacobian::Configuration,
    joint::{Joints, checked_pose},
};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// The frame F of an arm, and the wrist point of its tool.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArmPlane {
    /// Base to F, transposed rotation and origin.
    pub(super) to_frame: Matrix3<f64>,
    origin: Vector3<f64>,
    /// The wrist point in the tool frame.
    wrist_in_tool: Vector3<f64>,
    /// Tool to the frame whose orientation in that of the wrist is Rz(A) Rx(B) Rz(C).
    tool_to_wrist: Matrix3<f64>,
    /// n . W, the offset of the wrist from the plane through axis 1.
    shoulder_offset: f64,
    /// The scale of the roundings.
    pub(super) size: f64,
}

/// Orientation and wrist point of a target in F.
pub(super) struct Seen {
    pub(super) orientation: Matrix3<f64>,
    pub(super) wrist: Vector3<f64>,
}

impl ArmPlane {
    /// The plane of an arm that looks like `zero` at zero joint values, with this wrist point in the base frame. Size and
    /// frame of the wrist follow by [`ArmPlane::with_wrist`].
    pub(super) fn new(zero: &Configuration<6>, wrist: &Vector3<f64>) -> Self {
        let to_frame = plane_of_arm(zero);
        let origin = zero.points[0];
        Self {
            to_frame,
            origin,
            wrist_in_tool: zero.rotation.transpose() * (wrist - zero.tool),
            tool_to_wrist: Matrix3::identity(),
            shoulder_offset: (to_frame * (wrist - origin)).z,
            size: 0.0,
        }
    }

    /// With the frame of the wrist and the size of the arm.
    pub(super) fn with_wrist(self, tool_to_wrist: Matrix3<f64>, size: f64) -> Self {
        Self { tool_to_wrist, size, ..self }
    }

    /// A point of the base frame in F.
    pub(super) fn in_frame(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.to_frame * (point - self.origin)
    }

    /// The wanted solutions for `target` that `each` finds for the values of joint 1. A free joint 1 takes its value from `seed`.
    ///
    /// # Errors
    /// [`KinematicsError::Unreachable`], or what is wrong with the target.
    #[inline]
    pub(super) fn solve(
        &self,
        target: &Isometry3<f64>,
        seed: &Joints<6>,
        found: &mut Collector<'_>,
        mut each: impl FnMut(&FirstJoint, &Seen, &mut Collector<'_>, &mut Miss),
    ) -> Result<(), KinematicsError> {
        let target = checked_pose("target", target)?;
        let turned = self.to_frame * target.rotation.to_rotation_matrix().into_inner();
        let wrist = self.to_frame * (target.translation.vector - self.origin) + turned * self.wrist_in_tool;
        let seen = Seen { orientation: turned * self.tool_to_wrist, wrist };
        for_first_joints(&seen.wrist, self.shoulder_offset, self.size, seed[0], found, |first, found, miss| {
            each(first, &seen, found, miss);
        })
    }
}
