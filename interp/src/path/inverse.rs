//! Joints along a pose of the tool that moves, through the inverse kinematics.

use arcfeed_geometry::PoseJet;
use arcfeed_kinematics::{Joints, KinematicsError, PoseResidual, ToolDerivatives, Twist};

use super::jet::JointJet;
use crate::arm::PathArm;

/// Joint values and derivatives at `s`, by the solution of the inverse nearest to `near` and the Jacobian.
#[inline]
pub(crate) fn jet_near<const N: usize>(
    arm: &dyn PathArm<N>,
    s: f64,
    tool: &PoseJet,
    near: &Joints<N>,
) -> Result<JointJet<N>, KinematicsError> {
    jet_at(arm, s, tool, arm.inverse(&tool.pose, near)?)
}

/// Derivatives at `s`, where the joints are known to be `q`.
pub(crate) fn jet_at<const N: usize>(
    arm: &dyn PathArm<N>,
    s: f64,
    tool: &PoseJet,
    q: Joints<N>,
) -> Result<JointJet<N>, KinematicsError> {
    let d = arm.derivatives(&q, &ToolDerivatives { first: tool.d1, second: tool.d2, third: tool.d3 })?;
    Ok(JointJet { s, q, d1: d.first, d2: d.second, d3: d.third })
}

/// By how much rounding may have moved each joint at `q` on a path of `length` (m): the residual of the inverse and the
/// rounding of the path itself, carried to the joints, and the rounding of the joint values.
pub(crate) fn rounding<const N: usize>(arm: &dyn PathArm<N>, length: f64, q: &Joints<N>) -> Joints<N> {
    /// Units in the last place of an arc length and of a coordinate that a path may be off by.
    const PATH: f64 = 16.0 * f64::EPSILON;
    let PoseResidual { position, orientation } = arm.residual(q);
    let reach = arm.configuration(q).position().norm();
    let position = position + PATH * (length + reach);
    let orientation = orientation + PATH;
    let mut moved = q.map(|value| PATH * value.abs());
    for row in 0..6 {
        let mut first = Twist::zeros();
        first[row] = if row < 3 { position } else { orientation };
        let tool = ToolDerivatives { first, second: Twist::zeros(), third: Twist::zeros() };
        // At a singular pose nothing is allowed: no plan leads there.
        let Ok(step) = arm.derivatives(q, &tool) else { return moved };
        moved += step.first.abs();
    }
    moved
}
