//! Denavit-Hartenberg parameters, in both conventions, as a way to describe a [`Chain`].

use crate::{
    chain::Chain,
    error::KinematicsError,
    joint::{Joint, JointKind, Joints},
    traits::ForwardKinematics,
};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
#[cfg(not(feature = "std"))]
use num_traits::Float;

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
    /// [`KinematicsError::NotFinite`], with the number of the joint.
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
    /// [`KinematicsError::NotFinite`], with the number of the joint.
    pub fn from_modified_dh(rows: &[DhRow; N]) -> Result<Self, KinematicsError> {
        let joints = try_map(rows, |row| Joint::new(row.about_normal() * row.about_axis(), Vector3::z(), row.kind))?;
        Self::new(joints)
    }
}

/// A chain in Denavit-Hartenberg form: `base * A_1(q_1) * ... * A_N(q_N) * flange`, with the `A_i` of the convention that
/// was asked for: see [`Chain::to_dh`] and [`Chain::to_modified_dh`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DhTable<const N: usize> {
    /// From the working frame to frame 0 of the table.
    pub base: Isometry3<f64>,
    /// The table.
    pub rows: [DhRow; N],
    /// From frame N of the table to the flange.
    pub flange: Isometry3<f64>,
}

/// Sine of the angle between axes, and their distance in m, below which they count as parallel or meeting.
const DH_ROUNDING: f64 = 1e-9;

impl<const N: usize> Chain<N> {
    /// The chain in modified (Craig) Denavit-Hartenberg form, tool left out: the inverse of [`Chain::from_modified_dh`], with
    /// base and flange as in [`Chain::to_dh`]. The first `a` and `alpha` are 0.
    ///
    /// ```
    /// use arcfeed_kinematics::models;
    /// let table = models::panda().chain().to_modified_dh()?;
    /// assert!((table.rows[3].a - 0.0825).abs() < 1e-15 && (table.rows[6].d - 0.107).abs() < 1e-15);
    /// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Chain::to_dh`].
    pub fn to_modified_dh(&self) -> Result<DhTable<N>, KinematicsError> {
        // The same product with other brackets: `Tx(a) Rx(alpha)` goes from the end of a joint to the start of the next.
        let DhTable { base, mut rows, mut flange } = self.to_dh()?;
        let (mut a, mut alpha) = (0.0, 0.0);
        for row in &mut rows {
            (row.a, a) = (a, row.a);
            (row.alpha, alpha) = (alpha, row.alpha);
        }
        flange = DhRow::revolute(a, alpha, 0.0, 0.0).about_normal() * flange;
        Ok(DhTable { base, rows, flange })
    }

    /// The chain in standard Denavit-Hartenberg form, tool left out: same zero, same senses of rotation.
    ///
    /// Frame 0 is the base itself if axis 1 is its z, and frame N the flange itself if its z is along axis N; otherwise
    /// the table's base and flange hold the difference.
    ///
    /// # Errors
    /// [`KinematicsError::NoDhForm`] if two axes are so nearly parallel that the form would not give the arm back to
    /// 1e-9.
    pub fn to_dh(&self) -> Result<DhTable<N>, KinematicsError> {
        let bare = self.with_tool(Isometry3::identity())?;
        let zero = bare.configuration(&Joints::zeros());
        let (z, o) = (zero.axes(), zero.points());
        let flange = bare.forward(&Joints::zeros());
        if N == 0 {
            return Ok(DhTable {
                base: *self.base(),
                rows: [DhRow::revolute(0.0, 0.0, 0.0, 0.0); N],
                flange: *self.flange(),
            });
        }
        let mut rows = [DhRow::revolute(0.0, 0.0, 0.0, 0.0); N];
        // Frame 0: the base, moved onto axis 1 if that is elsewhere.
        let base_z = self.base().rotation * Vector3::z();
        let from_axis = o[0] - self.base().translation.vector;
        let on_axis = base_z.cross(&z[0]).norm() < DH_ROUNDING
            && base_z.dot(&z[0]) > 0.0
            && z[0].cross(&from_axis).norm() < DH_ROUNDING;
        let start = if on_axis { *self.base() } else { frame_on(&o[0], &z[0], &(self.base().rotation * Vector3::x())) };
        let mut before = start;
        for i in 0..N {
            let here = before.translation.vector;
            let x = before.rotation * Vector3::x();
            let next = if i + 1 < N {
                let across = z[i].cross(&z[i + 1]);
                if across.norm() < DH_ROUNDING {
                    // Parallel: of the common normals the one through the origin before.
                    let foot = o[i + 1] + z[i + 1] * z[i + 1].dot(&(here - o[i + 1]));
                    let normal = foot - here - z[i] * z[i].dot(&(foot - here));
                    let direction = if normal.norm() < DH_ROUNDING { x } else { normal };
                    frame_on(&foot, &z[i + 1], &direction)
                } else {
                    // The foot of the common normal on axis i + 1.
                    let along = (o[i] - o[i + 1]).cross(&z[i]).dot(&across) / across.norm_squared();
                    let foot = o[i + 1] - z[i + 1] * along;
                    let normal = foot - o[i];
                    let side =
                        if normal.dot(&across).abs() < DH_ROUNDING { across.dot(&x) } else { normal.dot(&across) };
                    frame_on(&foot, &z[i + 1], &(if side < 0.0 { -across } else { across }))
                }
            } else {
                // Frame N: on axis N, at the flange if that is there.
                let (p, turn) = (flange.translation.vector, flange.rotation);
                let foot = o[i] + z[i] * z[i].dot(&(p - o[i]));
                if (turn * Vector3::z() - z[i]).norm() < DH_ROUNDING && (p - foot).norm() < DH_ROUNDING {
                    flange
                } else {
                    frame_on(&foot, &z[i], &(turn * Vector3::x()))
                }
            };
            let step = before.inv_mul(&next);
            let (r, p) = (step.rotation.to_rotation_matrix().into_inner(), step.translation.vector);
            let theta = r[(1, 0)].atan2(r[(0, 0)]);
            let a = p.x * theta.cos() + p.y * theta.sin();
            rows[i] = DhRow { a, alpha: r[(2, 1)].atan2(r[(2, 2)]), d: p.z, theta, kind: self.joints()[i].kind() };
            before = next;
        }
        let table = DhTable { base: start, rows, flange: before.inv_mul(&flange) };
        let again = Self::from_dh(&rows)?.with_base(table.base)?;
        let again = again.with_flange(again.flange() * table.flange)?;
        let mut off = 0.0_f64;
        for k in 0..4 {
            let q = Joints::from_fn(|i, _| f64::from(k) * (0.3 + 0.2 * i as f64));
            let (a, b) = (bare.configuration(&q), again.configuration(&q));
            off = off.max((a.position() - b.position()).amax()).max((a.rotation() - b.rotation()).amax());
        }
        if off < DH_ROUNDING { Ok(table) } else { Err(KinematicsError::NoDhForm { deviation: off }) }
    }
}

/// A frame at `origin` with z along `z` and x as near to `x` as that allows.
fn frame_on(origin: &Vector3<f64>, z: &Vector3<f64>, x: &Vector3<f64>) -> Isometry3<f64> {
    let flat = x - z * z.dot(x);
    // Should x be along z, any direction across will do.
    let flat = if flat.norm() < DH_ROUNDING { Vector3::new(z.y, z.z, -z.x).cross(z) } else { flat };
    let x = flat.normalize();
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), *z]));
    Isometry3::from_parts((*origin).into(), UnitQuaternion::from_rotation_matrix(&turn))
}

/// `map` over an array, stopping at the first error, which gets the number of its row.
fn try_map<const N: usize>(
    rows: &[DhRow; N],
    mut make: impl FnMut(&DhRow) -> Result<Joint, KinematicsError>,
) -> Result<[Joint; N], KinematicsError> {
    let mut joints = [Joint::revolute(Isometry3::identity(), Vector3::z())?; N];
    for (i, (joint, row)) in joints.iter_mut().zip(rows).enumerate() {
        *joint = make(row).map_err(|error| in_row(error, i))?;
    }
    Ok(joints)
}

/// An error of the row `i`, from 0. Without the standard library it has no room for the number.
fn in_row(error: KinematicsError, i: usize) -> KinematicsError {
    #[cfg(feature = "std")]
    return error.in_part(crate::error::Part::Joint, &(i + 1).to_string());
    #[cfg(not(feature = "std"))]
    {
        let _ = i;
        error
    }
}
