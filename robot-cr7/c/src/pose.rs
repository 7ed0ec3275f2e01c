//! Plain values of tools.

use arcfeed_sync::nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::input::finite;
use crate::status::ArcfeedStatus::ArcfeedInvalid;
use crate::status::{Outcome, refuse};

/// A pose of a tool in the base: position (m) and unit quaternion.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedPose {
    /// Position along x (m).
    pub x: f64,
    /// Position along y (m).
    pub y: f64,
    /// Position along z (m).
    pub z: f64,
    /// Scalar part of the quaternion.
    pub qw: f64,
    /// First vector part of the quaternion.
    pub qx: f64,
    /// Second vector part of the quaternion.
    pub qy: f64,
    /// Third vector part of the quaternion.
    pub qz: f64,
}

impl From<&Isometry3<f64>> for ArcfeedPose {
    fn from(pose: &Isometry3<f64>) -> Self {
        let (at, turn) = (&pose.translation.vector, pose.rotation.quaternion());
        Self { x: at.x, y: at.y, z: at.z, qw: turn.w, qx: turn.i, qy: turn.j, qz: turn.k }
    }
}

/// The pose of an argument.
pub fn pose(what: &str, c: &ArcfeedPose) -> Outcome<Isometry3<f64>> {
    let fields = [(".x", c.x), (".y", c.y), (".z", c.z), (".qw", c.qw), (".qx", c.qx), (".qy", c.qy), (".qz", c.qz)];
    for (field, value) in fields {
        finite(&what, field, value)?;
    }
    let turn = Quaternion::new(c.qw, c.qx, c.qy, c.qz);
    let norm = turn.norm();
    if !((norm - 1.0).abs() <= LARGEST_DEFECT) {
        let why =
            format_args!("{what}: the norm of its quaternion qw, qx, qy, qz is {norm}; it must be 1: normalise it");
        return Err(refuse(ArcfeedInvalid, why));
    }
    Ok(Isometry3::from_parts(Translation3::new(c.x, c.y, c.z), UnitQuaternion::new_normalize(turn)))
}

/// A quaternion may differ from norm 1 by this, so that numbers of single precision are taken.
const LARGEST_DEFECT: f64 = 1e-6;
