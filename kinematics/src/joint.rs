//! Joints, joint vectors and joint limits.

use crate::error::KinematicsError;
use nalgebra::{Isometry3, SVector, Unit, UnitQuaternion, Vector3};

/// One value per joint: rad for a revolute joint, m for a prismatic one (or their derivatives).
pub type Joints<const N: usize> = SVector<f64, N>;

/// The kind of motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis; its value is an angle, rad.
    Revolute,
    /// Slides along its axis; its value is a length, m.
    Prismatic,
}

/// One joint: where it sits on the link before it, its axis and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    origin: Isometry3<f64>,
    axis: Unit<Vector3<f64>>,
    kind: JointKind,
}

impl Joint {
    /// A joint at `origin` (its frame at value 0, in the frame of the joint before it, m) that moves about or along
    /// `axis` (any length but 0; in the joint's own frame).
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`], [`KinematicsError::NotUnit`] or [`KinematicsError::ZeroAxis`].
    pub fn new(origin: Isometry3<f64>, axis: Vector3<f64>, kind: JointKind) -> Result<Self, KinematicsError> {
        let origin = checked_pose("joint origin", &origin)?;
        let length = axis.norm();
        if !(length.is_finite() && length > f64::MIN_POSITIVE) {
            return Err(KinematicsError::ZeroAxis { length });
        }
        Ok(Self { origin, axis: Unit::new_unchecked(axis / length), kind })
    }

    /// A revolute joint, see [`Joint::new`].
    ///
    /// # Errors
    /// As [`Joint::new`].
    pub fn revolute(origin: Isometry3<f64>, axis: Vector3<f64>) -> Result<Self, KinematicsError> {
        Self::new(origin, axis, JointKind::Revolute)
    }

    /// A prismatic joint, see [`Joint::new`].
    ///
    /// # Errors
    /// As [`Joint::new`].
    pub fn prismatic(origin: Isometry3<f64>, axis: Vector3<f64>) -> Result<Self, KinematicsError> {
        Self::new(origin, axis, JointKind::Prismatic)
    }

    /// The joint's frame at value 0, in the frame of the joint before it (m).
    pub fn origin(&self) -> &Isometry3<f64> {
        &self.origin
    }

    /// The axis, in the joint's own frame.
    pub fn axis(&self) -> &Unit<Vector3<f64>> {
        &self.axis
    }

    /// The motion of the joint at `value` (rad or m): from its frame at value 0 to the one after the motion.
    pub fn motion(&self, value: f64) -> Isometry3<f64> {
        match self.kind {
            JointKind::Revolute => Isometry3::rotation(self.axis.into_inner() * value),
            JointKind::Prismatic => {
                Isometry3::from_parts((self.axis.into_inner() * value).into(), UnitQuaternion::identity())
            }
        }
    }

    /// Revolute or prismatic.
    pub fn kind(&self) -> JointKind {
        self.kind
    }
}

/// `pose` with its quaternion renormalised, or the reason why it is none.
pub(crate) fn checked_pose(what: &'static str, pose: &Isometry3<f64>) -> Result<Isometry3<f64>, KinematicsError> {
    let quaternion = pose.rotation.quaternion();
    let norm = quaternion.norm();
    if !(norm.is_finite() && pose.translation.vector.iter().all(|v| v.is_finite())) {
        return Err(KinematicsError::NotFinite { what });
    }
    if (norm - 1.0).abs() > 1e-6 {
        return Err(KinematicsError::NotUnit { what, norm });
    }
    let rotation = Unit::new_unchecked(quaternion / norm);
    Ok(Isometry3::from_parts(pose.translation, rotation))
}

/// The first of the joint values that is NaN or infinite, as an error.
pub(crate) fn check_finite<const N: usize>(what: &'static str, q: &Joints<N>) -> Result<(), KinematicsError> {
    match (0..N).find(|i| !q[*i].is_finite()) {
        Some(joint) => Err(KinematicsError::JointNotFinite { joint, what, value: q[joint] }),
        None => Ok(()),
    }
}

/// The range in which each joint may stand, rad (m for prismatic joints): finite, lower < upper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRange<const N: usize> {
    lower: Joints<N>,
    upper: Joints<N>,
}

impl<const N: usize> JointRange<N> {
    /// The range from `lower` to `upper`.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidLimit`] names the joint, the value and the rule.
    pub fn new(lower: Joints<N>, upper: Joints<N>) -> Result<Self, KinematicsError> {
        for joint in 0..N {
            for (what, value) in [("lower", lower[joint]), ("upper", upper[joint])] {
                if !value.is_finite() {
                    return Err(KinematicsError::InvalidLimit { joint, what, value, rule: "finite" });
                }
            }
            if lower[joint] >= upper[joint] {
                let rule = "less than the upper limit";
                return Err(KinematicsError::InvalidLimit { joint, what: "lower", value: lower[joint], rule });
            }
        }
        Ok(Self { lower, upper })
    }

    /// The least joint values.
    pub fn lower(&self) -> &Joints<N> {
        &self.lower
    }

    /// The greatest joint values.
    pub fn upper(&self) -> &Joints<N> {
        &self.upper
    }

    /// True if every joint of `q` is inside (ends included; NaN is outside).
    pub fn contains(&self, q: &Joints<N>) -> bool {
        (0..N).all(|i| self.lower[i] <= q[i] && q[i] <= self.upper[i])
    }

    /// This range together with limits of velocity, acceleration and jerk.
    ///
    /// # Errors
    /// As [`JointLimits::new`].
    pub fn with_rates(
        &self,
        velocity: Joints<N>,
        acceleration: Joints<N>,
        jerk: Joints<N>,
    ) -> Result<JointLimits<N>, KinematicsError> {
        JointLimits::new(self.lower, self.upper, velocity, acceleration, jerk)
    }
}

/// The limits of each joint: its range, and its rates, symmetric about 0.
///
/// Units: rad, rad/s, rad/s^2, rad/s^3 (m for prismatic joints). A value that exists is valid: all finite,
/// lower < upper, rates > 0.
///
/// ```
/// use arcfeed_kinematics::{JointLimits, Joints};
/// let limits = JointLimits::<6>::new(
///     Joints::repeat(-6.27), Joints::repeat(6.27), Joints::repeat(3.14), Joints::repeat(10.0), Joints::repeat(100.0),
/// )?;
/// assert_eq!(limits.velocity()[2], 3.14);
/// let error = limits.range().with_rates(Joints::repeat(1.0), Joints::repeat(0.0), Joints::repeat(1.0)).unwrap_err();
/// assert_eq!(error.to_string(), "joint 1: acceleration limit 0 must be finite and greater than 0");
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits<const N: usize> {
    range: JointRange<N>,
    velocity: Joints<N>,
    acceleration: Joints<N>,
    jerk: Joints<N>,
}

impl<const N: usize> JointLimits<N> {
    /// Limits of position, velocity, acceleration and jerk.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidLimit`] names the joint, the value and the rule.
    pub fn new(
        lower: Joints<N>,
        upper: Joints<N>,
        velocity: Joints<N>,
        acceleration: Joints<N>,
        jerk: Joints<N>,
    ) -> Result<Self, KinematicsError> {
        let range = JointRange::new(lower, upper)?;
        for joint in 0..N {
            for (what, value) in
                [("velocity", velocity[joint]), ("acceleration", acceleration[joint]), ("jerk", jerk[joint])]
            {
                if !(value.is_finite() && value > 0.0) {
                    let rule = "finite and greater than 0";
                    return Err(KinematicsError::InvalidLimit { joint, what, value, rule });
                }
            }
        }
        Ok(Self { range, velocity, acceleration, jerk })
    }

    /// The range in which the joints may stand.
    pub fn range(&self) -> &JointRange<N> {
        &self.range
    }

    /// The least joint values, rad (m).
    pub fn lower(&self) -> &Joints<N> {
        self.range.lower()
    }

    /// The greatest joint values, rad (m).
    pub fn upper(&self) -> &Joints<N> {
        self.range.upper()
    }

    /// The greatest speeds, rad/s (m/s).
    pub fn velocity(&self) -> &Joints<N> {
        &self.velocity
    }

    /// The greatest accelerations, rad/s^2 (m/s^2).
    pub fn acceleration(&self) -> &Joints<N> {
        &self.acceleration
    }

    /// The greatest jerks, rad/s^3 (m/s^3).
    pub fn jerk(&self) -> &Joints<N> {
        &self.jerk
    }
}
