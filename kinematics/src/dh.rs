//! Denavit-Hartenberg parameters, in both conventions, as a way to describe a [`Chain`].

use crate::{
    chain::Chain,
    error::KinematicsError,
    joint::{Joint, JointKind},
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// One row of a Denavit-Hartenberg table (m, rad). Which row `a` and `alpha` belong to is a matter of the convention.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DhRow {
    /// Distance between the joint axes along their common normal, m.
    pub a: f64,
    /// Angle between the joint axes about that normal, rad.
    pub alpha: f64,
    /// Distance along the joint axis, m; a prismatic joint adds its value.
    pub d: f64,
    /// Angle about the joint axis at joint value 0, rad; a revolute joint adds its value.
    pub theta: f64,
    /// Which of the two moves.
    pub kind: JointKind,
}

impl DhRow {
    /// A revolute joint: `a` m, `alpha` rad, `d` m and the angle `theta` (rad) it has at joint value 0.
    pub const fn revolute(a: f64, alpha: f64, d: f64, theta: f64) -> Self {
        Self { a, alpha, d, theta, kind: JointKind::Revolute }
    }

    /// A prismatic joint: `a` m, `alpha` rad, the length `d` (m) it has at joint value 0, and `theta` rad.
    pub const fn prismatic(a: f64, alpha: f64, d: f64, theta: f64) -> Self {
        Self { a, alpha, d, theta, kind: JointKind::Prismatic }
    }

    /// Rz(theta) Tz(d), the part about the joint's own axis. They commute with the joint's motion.
    fn about_axis(&self) -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::new(0.0, 0.0, self.d),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.theta),
        )
    }

    /// Tx(a) Rx(alpha), which commute with each other.
    fn about_normal(&self) -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::new(self.a, 0.0, 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), self.alpha),
        )
    }
}

impl<const N: usize> Chain<N> {
    /// A chain from standard (distal) parameters: `A_i = Rz(theta_i + q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)`.
    ///
    /// The flange is frame N of the table; its last `a` and `alpha` are kept in [`Chain::flange`].
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`].
    pub fn from_dh(rows: &[DhRow; N]) -> Result<Self, KinematicsError> {
        let mut before = Isometry3::identity();
        let joints = try_map(rows, |row| {
            let origin = before * row.about_axis();
            before = row.about_normal();
            Joint::new(origin, Vector3::z(), row.kind)
        })?;
        Self::new(joints)?.with_flange(before)
    }

    /// A chain from modified (proximal, Craig) parameters:
    /// `A_i = Rx(alpha_(i-1)) Tx(a_(i-1)) Rz(theta_i + q_i) Tz(d_i)`; a row holds the `a` and `alpha` before its joint.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`].
    pub fn from_modified_dh(rows: &[DhRow; N]) -> Result<Self, KinematicsError> {
        let joints = try_map(rows, |row| Joint::new(row.about_normal() * row.about_axis(), Vector3::z(), row.kind))?;
        Self::new(joints)
    }
}

/// `map` over an array, stopping at the first error.
fn try_map<const N: usize>(
    rows: &[DhRow; N],
    mut make: impl FnMut(&DhRow) -> Result<Joint, KinematicsError>,
) -> Result<[Joint; N], KinematicsError> {
    let mut joints = [Joint::revolute(Isometry3::identity(), Vector3::z())?; N];
    for (joint, row) in joints.iter_mut().zip(rows) {
        *joint = make(row)?;
    }
    Ok(joints)
}
