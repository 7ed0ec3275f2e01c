//! The stand-in for the Delta DRV70L, the arm of Electronics 2025, 14, 3869, whose parameters are
//! not published: the geometry and the links of another arm, with fitted friction and rotors.

use arcfeed_kinematics::{ArmDescription, Inertial, KinematicsError, models};
use serde::Deserialize;

/// Its name among the built-in robots.
pub(crate) const NAME: &str = "drv70l_stand_in";

/// The file of the stand-in; poses in it are those of the paper.
pub(crate) const DATA: &str = include_str!("../../data/qb_arm.json");

/// Jerk limit of the stand-in, rad/s^3; the paper has none.
pub(crate) const JERK: f64 = 40.0;

#[derive(Debug, Deserialize)]
struct StandIn {
    source: String,
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
}

/// The description of the stand-in.
///
/// # Errors
/// [`KinematicsError`] for embedded data that is no arm, which would be a bug.
pub(crate) fn description() -> Result<ArmDescription, KinematicsError> {
    let bad = |reason: String| KinematicsError::Unreadable { format: "JSON", reason };
    let data: StandIn = serde_json::from_str(DATA).map_err(|e| bad(e.to_string()))?;
    let mut description =
        models::description(&data.arm).ok_or_else(|| bad(format!("the arm {} is not built in", data.arm)))?;
    for (i, joint) in description.joints.iter_mut().enumerate() {
        let link = joint.inertial.ok_or_else(|| bad(format!("the links of {} are unknown", data.arm)))?;
        let scale = data.inertial_scale;
        joint.inertial = Some(Inertial::new(link.mass() * scale, *link.centre(), *link.tensor() * scale)?);
        joint.rotor_inertia = Some(data.rotor[i]);
        joint.friction = Some([data.viscous[i], data.coulomb[i], data.coulomb[i]]);
        joint.velocity = Some(data.velocity[i]);
        joint.acceleration = Some(data.acceleration[i]);
        joint.jerk = Some(JERK);
        joint.torque = Some(data.torque[i]);
    }
    description.name = NAME.to_owned();
    description.source = data.source;
    description.notes = vec![
        "synthetic, not measured: geometry and links of the KUKA KR 6 R700, masses scaled, friction and rotors fitted \
         so that the clamps printed for two motions come out approximately; the fit is not unique"
            .to_owned(),
        format!("the jerk limit of {JERK} rad/s^3 is assumed"),
    ];
    Ok(description)
}
