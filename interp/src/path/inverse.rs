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

/// Units in the last place of a parameter and of a coordinate that a path may be off by.
const PATH: f64 = 16.0 * f64::EPSILON;

/// By how much rounding of the parameter of a path of `length` may have moved each joint where its derivative is `slope`. At a narrow
/// bend of a tool that follows its direction a joint turns by some 1e4 rad/m.
pub(crate) fn rounding_of_parameter<const N: usize>(slope: &Joints<N>, length: f64) -> Joints<N> {
    slope.abs() * (PATH * length)
}

/// By how much rounding may have moved each joint at `q`: the residual of the inverse and the rounding of the pose, carried to the
/// joints, and the rounding of the joint values.
pub(crate) fn rounding<const N: usize>(arm: &dyn PathArm<N>, q: &Joints<N>) -> Joints<N> {
    let PoseResidual { position, orientation } = arm.residual(q);
    let reach = arm.configuration(q).position().norm();
    let position = position + PATH * reach;
    let orientation = orientation + PATH;
    let mut moved = q.map(|value| PATH * value.abs());
    for row in 0..6 {
        let mut first = Twist::zeros();
        first[row] = if row < 3 { position } else { orientation };
        let tool = ToolDerivatives { first, second: Twist::zeros(), third: Twist::zeros() };
        // Through a singular pose the joints are a polynomial, which has no such rounding.
        let Ok(step) = arm.derivatives(q, &tool) else { return moved };
        moved += step.first.abs();
    }
    moved
}
