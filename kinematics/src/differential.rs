//! Joint derivatives along a tool path, to third order.
//!
//! A tool path by any one parameter s (time, arc length, ...) has derivatives x', x'', x''' (linear and angular
//! velocity, and their plain derivatives). With q(s) the joints that follow it, differentiating x' = J q' gives
//!
//! ```text
//! J q'   = x'
//! J q''  = x''  - J' q'
//! J q''' = x''' - (2 J' q'' + J'' q')
//! ```
//!
//! J is factored once; the terms on the right come from [`Configuration`](crate::Configuration)'s forward recursion, so
//! no difference quotient is taken anywhere.

use crate::{
    error::KinematicsError,
    jacobian::Twist,
    joint::{Joints, check_finite},
    lu::Lu6,
    singularity::{condition_number, smallest_singular_value},
    traits::ForwardKinematics,
};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Derivatives of a tool path by one parameter s: linear x y z, then angular x y z, base-aligned, at the tool point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolDerivatives {
    /// Velocity of the tool point and angular velocity: m and rad per unit of s.
    pub first: Twist,
    /// Derivative of `first` by s.
    pub second: Twist,
    /// Derivative of `second` by s.
    pub third: Twist,
}

/// Derivatives of the joints by the parameter of the tool path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDerivatives<const N: usize> {
    /// q', rad (m) per unit of s.
    pub first: Joints<N>,
    /// q''.
    pub second: Joints<N>,
    /// q'''.
    pub third: Joints<N>,
}

/// A usual choice for the least singular value in [`joint_derivatives`]: there a tool speed of 1 m/s would ask for
/// some 1e6 rad/s.
pub const MIN_SINGULAR_VALUE: f64 = 1e-6;

/// The joint derivatives q', q'', q''' of an arm at `q` that follow a tool path with derivatives `tool`.
///
/// `min_singular_value` (rows of J in m and rad, unscaled) is how near to a singular pose is refused, see
/// [`MIN_SINGULAR_VALUE`].
///
/// ```
/// use arcfeed_kinematics::{Joints, MIN_SINGULAR_VALUE, ToolDerivatives, Twist, joint_derivatives, models};
/// let q = Joints::<6>::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.0]);
/// // A straight line along x at constant speed: only the first derivative is not 0.
/// let line = ToolDerivatives { first: Twist::x(), second: Twist::zeros(), third: Twist::zeros() };
/// let by_s = joint_derivatives(&models::cr7(), &q, &line, MIN_SINGULAR_VALUE)?;
/// assert!(by_s.third.norm() > 0.0);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
///
/// # Errors
/// [`KinematicsError::Singular`] with the smallest singular value, the condition and, if the arm knows, the kind of
/// singular pose; [`KinematicsError::JointNotFinite`] for `q`; [`KinematicsError::NotFinite`] if `tool` is not finite.
pub fn joint_derivatives<A: ForwardKinematics<6> + ?Sized>(
    arm: &A,
    q: &Joints<6>,
    tool: &ToolDerivatives,
    min_singular_value: f64,
) -> Result<JointDerivatives<6>, KinematicsError> {
    let at = arm.configuration(q);
    let jacobian = at.jacobian();
    // Checks of the input wait until something has gone wrong: NaN runs through to the end.
    let refused = || {
        if let Err(error) = check_finite("its value", q) {
            return error;
        }
        KinematicsError::Singular {
            kind: arm.nearest_singularity(q),
            sigma_min: smallest_singular_value(&jacobian),
            required: min_singular_value,
            condition: condition_number(&jacobian),
        }
    };
    let lu = Lu6::new(&jacobian).ok_or_else(refused)?;
    // The product of the other five singular values is at most (|J|_F^2 / 5)^(5/2), mean against geometric mean; so
    // |det J| bounds the smallest from below. The exact value only where that does not settle it.
    let mean = jacobian.norm_squared() / 5.0;
    let at_least = lu.determinant() / (mean * mean * mean.sqrt());
    if !(at_least >= min_singular_value || smallest_singular_value(&jacobian) >= min_singular_value) {
        return Err(refused());
    }
    let first = lu.solve(&tool.first);
    let second = lu.solve(&(tool.second - at.acceleration_bias(&first)));
    let third = lu.solve(&(tool.third - at.jerk_bias(&first, &second)));
    if !third.sum().is_finite() {
        return Err(KinematicsError::NotFinite {
            what: "a derivative of the tool path (or of a joint that follows it)",
        });
    }
    Ok(JointDerivatives { first, second, third })
}

/// The joint derivatives of least norm, order by order, that follow a tool path with an arm of more than six joints.
///
/// At each order the tool's derivative is met exactly and the norm of the joints' derivative is least. Along a path these
/// are not derivatives of one another, as the least second derivative is not that of the least first one: they serve
/// control at one instant. To plan along a path, hold a joint ([`Arm::locked`](crate::Arm::locked)) and take
/// [`joint_derivatives`].
///
/// # Errors
/// As [`joint_derivatives`]; an arm of fewer than six joints is always [`KinematicsError::Singular`].
pub fn least_norm_derivatives<const N: usize, A: ForwardKinematics<N> + ?Sized>(
    arm: &A,
    q: &Joints<N>,
    tool: &ToolDerivatives,
    min_singular_value: f64,
) -> Result<JointDerivatives<N>, KinematicsError> {
    let at = arm.configuration(q);
    let jacobian = at.jacobian();
    check_finite("its value", q)?;
    let sigma_min = if N < 6 { 0.0 } else { smallest_singular_value(&jacobian) };
    let singular = || KinematicsError::Singular {
        kind: arm.nearest_singularity(q),
        sigma_min,
        required: min_singular_value,
        condition: condition_number(&jacobian),
    };
    if sigma_min < min_singular_value || sigma_min == 0.0 {
        return Err(singular());
    }
    let lu = Lu6::new(&(jacobian * jacobian.transpose())).ok_or_else(singular)?;
    let solve = |twist: &Twist| {
        let once = jacobian.transpose() * lu.solve(twist);
        // J J^T has the square of J's condition: one correction gives the digits back.
        once + jacobian.transpose() * lu.solve(&(twist - jacobian * once))
    };
    let first = solve(&tool.first);
    let second = solve(&(tool.second - at.acceleration_bias(&first)));
    let third = solve(&(tool.third - at.jerk_bias(&first, &second)));
    if !third.sum().is_finite() {
        return Err(KinematicsError::NotFinite {
            what: "a derivative of the tool path (or of a joint that follows it)",
        });
    }
    Ok(JointDerivatives { first, second, third })
}
