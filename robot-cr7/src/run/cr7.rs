//! The Dobot CR7: geometry, joint ranges, and the motion limits that are assumed for it.

use arcfeed_kinematics::{JointLimits, Joints, KinematicsError, ParallelAxisArm, models};
use nalgebra::Isometry3;

use super::error::Cr7Error;
use crate::input::job::Job;
use crate::input::joint_values::JointValues;

/// Highest joint velocity, rad/s (180 deg/s). **Assumed**, the class of the catalogue: the maker's model states 0.
pub const VELOCITY: f64 = std::f64::consts::PI;
/// Highest joint acceleration, rad/s^2. **Assumed**: the maker publishes none.
pub const ACCELERATION: f64 = 10.0;
/// Highest joint jerk, rad/s^3. **Assumed**: the maker publishes none.
pub const JERK: f64 = 100.0;

/// The arm with its motion limits.
///
/// Geometry and joint ranges come from the maker's description (see [`models::cr7`] for source and licence); its zero is
/// the arm upright. Velocity, acceleration and jerk limits are assumptions ([`VELOCITY`], [`ACCELERATION`], [`JERK`]) that
/// a job can replace.
#[derive(Debug, Clone)]
pub struct Cr7 {
    arm: ParallelAxisArm,
    limits: JointLimits<6>,
}

impl Cr7 {
    /// The arm with the tool frame `tool` (tip in the flange frame, m), under the assumed limits.
    ///
    /// # Errors
    /// Fails when the tool frame is not finite.
    pub fn new(tool: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Self::with_limits(tool, Joints::repeat(VELOCITY), Joints::repeat(ACCELERATION), Joints::repeat(JERK))
    }

    /// The arm with a tool frame and limits of joint velocity (rad/s), acceleration (rad/s^2) and jerk (rad/s^3).
    ///
    /// # Errors
    /// Fails when the tool frame is not finite, or a limit is not a finite number above 0.
    pub fn with_limits(
        tool: Isometry3<f64>,
        velocity: Joints<6>,
        acceleration: Joints<6>,
        jerk: Joints<6>,
    ) -> Result<Self, KinematicsError> {
        let arm = models::cr7().with_tool(tool)?;
        let limits = arm.range().with_rates(velocity, acceleration, jerk)?;
        Ok(Self { arm, limits })
    }

    /// The arm with the tool and the joint limits of `job`.
    ///
    /// # Errors
    /// [`Cr7Error::JointCount`], or what [`Cr7::with_limits`] says.
    pub fn of(job: &Job) -> Result<Self, Cr7Error> {
        let or = |key, given: &Option<JointValues>, assumed| match given {
            None => Ok(Joints::repeat(assumed)),
            Some(values) => {
                values.of::<6>().map(Joints::from).map_err(|given| Cr7Error::JointCount { key, given, joints: 6 })
            }
        };
        Ok(Self::with_limits(
            job.tool,
            or("joints.velocity_deg_s", &job.joints.velocity, VELOCITY)?,
            or("joints.acceleration_deg_s2", &job.joints.acceleration, ACCELERATION)?,
            or("joints.jerk_deg_s3", &job.joints.jerk, JERK)?,
        )?)
    }

    /// Forward and inverse kinematics.
    pub fn arm(&self) -> &ParallelAxisArm {
        &self.arm
    }

    /// Position, velocity, acceleration and jerk limits of the joints.
    pub fn limits(&self) -> &JointLimits<6> {
        &self.limits
    }
}
