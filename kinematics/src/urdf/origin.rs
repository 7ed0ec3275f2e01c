//! `<origin>`: a frame in that of its parent, by a rule that depends on the version of the file.

use super::markup::{Attributes, numbers, unreadable, usable};
use crate::{error::KinematicsError, joint::checked_pose};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion};

/// The `version` of a robot: later ones know more attributes.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Version(pub(super) u32, pub(super) u32);

impl Version {
    /// A missing or malformed one counts as 1.0.
    pub(super) fn of(text: Option<&str>) -> Self {
        let read = |text: &str| {
            let (major, minor) = text.trim().split_once('.')?;
            Some(Self(major.parse().ok()?, minor.parse().ok()?))
        };
        text.and_then(read).unwrap_or(Self(1, 0))
    }
}

/// A frame in that of its parent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Origin {
    xyz: [f64; 3],
    turn: UnitQuaternion<f64>,
}

impl Default for Origin {
    fn default() -> Self {
        Self { xyz: [0.0; 3], turn: UnitQuaternion::identity() }
    }
}

impl Origin {
    /// `<origin>` of a joint or of an inertial.
    pub(super) fn of(element: &Attributes<'_>, version: Version) -> Result<Self, String> {
        Self::read(version, |name| element.vector(name), |name| element.vector(name))
    }

    /// Fixed-axis angles or, since version 1.1, a quaternion; `three` and `four` give the numbers of an attribute.
    fn read(
        version: Version,
        three: impl Fn(&str) -> Result<Option<[f64; 3]>, String>,
        four: impl Fn(&str) -> Result<Option<[f64; 4]>, String>,
    ) -> Result<Self, String> {
        let xyz = three("xyz")?.unwrap_or_default();
        let angles = three("rpy")?;
        let quaternion = if version >= Version(1, 1) { four("quat_xyzw")? } else { None };
        let turn = match (angles, quaternion) {
            (Some(_), Some(_)) => return Err("its <origin> has both rpy and quat_xyzw: leave one".to_owned()),
            (angles, None) => {
                let [roll, pitch, yaw] = angles.unwrap_or_default();
                UnitQuaternion::from_euler_angles(roll, pitch, yaw)
            }
            (None, Some([x, y, z, w])) => {
                let quaternion = Quaternion::new(w, x, y, z);
                let short = || format!("its quat_xyzw has length {}: it must not be 0", quaternion.norm());
                UnitQuaternion::try_new(quaternion, 0.0).ok_or_else(short)?
            }
        };
        Ok(Self { xyz, turn })
    }

    /// The pose; none is that of the parent.
    pub(super) fn pose(origin: Option<Self>) -> Result<Isometry3<f64>, KinematicsError> {
        let Self { xyz, turn } = origin.unwrap_or_default();
        checked_pose("the origin", &Isometry3::from_parts(xyz.into(), turn))
    }
}

/// The pose of a URDF's `<origin>` in the frame of its parent, m: as [`ArmDescription::from_urdf`](crate::ArmDescription::from_urdf) reads
/// it, for elements that it skips, such as `<visual>`. `version` is the attribute of `<robot>`, and `attribute` gives the text of one of the
/// `<origin>`: `xyz`, `rpy` (fixed-axis angles, rad) or, since version 1.1, `quat_xyzw` in the place of `rpy`. What is absent is 0.
///
/// # Errors
/// [`KinematicsError::Unreadable`] for an attribute that does not hold its numbers, for `rpy` beside `quat_xyzw` and for a quaternion of
/// length 0; [`KinematicsError::NotFinite`].
pub fn urdf_origin<'t>(
    version: Option<&str>,
    attribute: impl Fn(&str) -> Option<&'t str>,
) -> Result<Isometry3<f64>, KinematicsError> {
    let text = |name: &str| attribute(name).map(|text| usable(name, text)).transpose();
    let origin = Origin::read(
        Version::of(version),
        |name| text(name)?.map(|text| numbers(name, text)).transpose(),
        |name| text(name)?.map(|text| numbers(name, text)).transpose(),
    );
    Origin::pose(Some(origin.map_err(|reason| unreadable(format!("<origin>: {reason}")))?))
}
