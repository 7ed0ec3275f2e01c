//! The stand-in for the arm of Huang et al. 2025, and the motions of its Tables 2 and 3.

use arcfeed_geometry::{GeometryError, PoseMotion};
use arcfeed_interp::{LimitError, PathError, PlanError, SpeedError};
use arcfeed_kinematics::{Arm, JointLimits, Joints, KinematicsError};
use nalgebra::{Isometry3, Translation3};
use serde::Deserialize;
use thiserror::Error;

use crate::input::toml_check::rotation;
use crate::run::stand_in;

/// The motions of the paper.
#[derive(Debug, Deserialize)]
pub(super) struct Data {
    pub(super) po: Way,
    pub(super) to: Way,
}

#[derive(Debug, Deserialize)]
pub(super) struct Way {
    pub(super) start: [f64; 6],
    pub(super) goal: [f64; 6],
    pub(super) near_rad: [f64; 6],
}

impl Way {
    pub(super) fn motion(&self) -> Result<PoseMotion, GeometryError> {
        let pose =
            |p: &[f64; 6]| Isometry3::from_parts(Translation3::new(p[0], p[1], p[2]), rotation([p[3], p[4], p[5]]));
        PoseMotion::new(&pose(&self.start), &pose(&self.goal))
    }
}

/// Why a motion of the paper could not be computed.
#[derive(Debug, Error)]
pub enum QbError {
    /// The embedded data.
    #[error("{0}")]
    Data(#[from] serde_json::Error),
    /// The arm.
    #[error("{0}")]
    Arm(#[from] KinematicsError),
    /// A pose.
    #[error("{0}")]
    Geometry(#[from] GeometryError),
    /// A plan.
    #[error("{0}")]
    Plan(#[from] PlanError),
    /// A path.
    #[error("{0}")]
    Path(#[from] PathError),
    /// A limit.
    #[error("{0}")]
    Limit(#[from] LimitError),
    /// A speed.
    #[error("{0}")]
    Speed(#[from] SpeedError),
    /// Limits or links of the stand-in.
    #[error("limits or links of the stand-in are missing")]
    StandIn,
    /// Limits along the path.
    #[error("{0}")]
    Feed(#[from] arcfeed_feedrate::FeedError),
}

impl Data {
    pub(super) fn load() -> Result<Self, QbError> {
        Ok(serde_json::from_str(stand_in::DATA)?)
    }
}

/// The stand-in for the arm of the paper, with its limits on rates and on torque.
pub(super) fn arm() -> Result<(Arm<6>, JointLimits<6>, Joints<6>), QbError> {
    let arm = stand_in::description()?.build::<6>()?;
    let joints = arm.limits().ok_or(QbError::StandIn)?;
    let torque = arm.drive_limits().torque.ok_or(QbError::StandIn)?;
    Ok((arm, joints, torque))
}
