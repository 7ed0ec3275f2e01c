//! The stand-in for the arm of Huang et al. 2025, and the motions of its Tables 2 and 3.

use arcfeed_geometry::{GeometryError, PoseMotion};
use arcfeed_interp::{LimitError, PathError, PlanError, SpeedError};
use arcfeed_kinematics::{Arm, Inertial, JointLimits, Joints, KinematicsError, models};
use nalgebra::{Isometry3, Translation3};
use serde::Deserialize;
use thiserror::Error;

use crate::input::toml_check::rotation;

/// Jerk limit of the motion that the paper does not have, rad/s^3.
pub(super) const JERK: f64 = 40.0;

#[derive(Debug, Deserialize)]
pub(super) struct Data {
    arm: String,
    inertial_scale: f64,
    #[serde(rename = "coulomb_Nm")]
    coulomb: [f64; 6],
    #[serde(rename = "viscous_Nms_per_rad")]
    viscous: [f64; 6],
    #[serde(rename = "rotor_inertia_kgm2")]
    rotor: [f64; 6],
    #[serde(rename = "velocity_rad_s")]
    velocity: [f64; 6],
    #[serde(rename = "acceleration_rad_s2")]
    acceleration: [f64; 6],
    #[serde(rename = "torque_Nm")]
    torque: [f64; 6],
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
    /// Limits along the path.
    #[error("{0}")]
    Feed(#[from] arcfeed_feedrate::FeedError),
    /// The arm of the data.
    #[error("the arm {0} is not built in, or its links are unknown")]
    Model(String),
}

impl Data {
    pub(super) fn load() -> Result<Self, QbError> {
        Ok(serde_json::from_str(include_str!("../../../data/qb_arm.json"))?)
    }

    pub(super) fn arm(&self) -> Result<Arm<6>, QbError> {
        let model = || QbError::Model(self.arm.clone());
        let mut description = models::description(&self.arm).ok_or_else(model)?;
        for (i, joint) in description.joints.iter_mut().enumerate() {
            let link = joint.inertial.ok_or_else(model)?;
            let scale = self.inertial_scale;
            joint.inertial = Some(Inertial::new(link.mass() * scale, *link.centre(), *link.tensor() * scale)?);
            joint.rotor_inertia = Some(self.rotor[i]);
            joint.friction = Some([self.viscous[i], self.coulomb[i], self.coulomb[i]]);
        }
        Ok(description.build::<6>()?)
    }

    pub(super) fn limits(&self, arm: &Arm<6>) -> Result<(JointLimits<6>, Joints<6>), QbError> {
        let (v, a) = (Joints::from(self.velocity), Joints::from(self.acceleration));
        Ok((arm.range().with_rates(v, a, Joints::repeat(JERK))?, Joints::from(self.torque)))
    }
}
