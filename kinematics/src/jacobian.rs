//! The arm at one set of joint values, and what follows from it: Jacobian, acceleration and jerk.
//!
//! The derivatives come from one forward recursion over the joints (the outward half of Newton-Euler, one order
//! further): with w, a, g the angular velocity, acceleration and jerk of the link before a joint of axis z,
//!
//! ```text
//! z'  = w x z          z'' = a x z + w x z'
//! w+  = w + z qd       a+  = a + z' qd + z qdd       g+ = g + z'' qd + 2 z' qdd + z qddd
//! ```
//!
//! and for the vector r from this joint to the next, which turns with the link,
//! `r' = w+ x r`, `r'' = a+ x r + w+ x r'`, `r''' = g+ x r + 2 a+ x r' + w+ x r''`.

use crate::joint::{JointKind, Joints};
use nalgebra::{Isometry3, Matrix3, Quaternion, SMatrix, Translation3, UnitQuaternion, Vector3, Vector6};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Geometric Jacobian: rows linear x y z (m/s per joint unit/s), then angular x y z; base-aligned, at the tool point.
pub type Jacobian<const N: usize> = SMatrix<f64, 6, N>;

/// Linear x y z, then angular x y z; base-aligned, at the tool point. Also used for its derivatives.
pub type Twist = Vector6<f64>;

/// An arm at one set of joint values: the tool frame and every joint's axis, all in the base frame (m).
#[derive(Debug, Clone, Copy)]
pub struct Configuration<const N: usize> {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) tool: Vector3<f64>,
    pub(crate) axes: [Vector3<f64>; N],
    pub(crate) points: [Vector3<f64>; N],
    pub(crate) kinds: [JointKind; N],
}

impl<const N: usize> Configuration<N> {
    /// Pose of the tool in the base.
    pub fn pose(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.tool), quaternion(&self.rotation))
    }

    /// The tool's orientation as a matrix; its columns are the tool's axes in the base.
    pub fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// The tool point in the base, m.
    pub fn position(&self) -> &Vector3<f64> {
        &self.tool
    }

    /// Direction of each joint's axis in the base, unit length.
    pub fn axes(&self) -> &[Vector3<f64>; N] {
        &self.axes
    }

    /// A point on each joint's axis in the base, m.
    pub fn points(&self) -> &[Vector3<f64>; N] {
        &self.points
    }

    /// Geometric Jacobian of the tool point.
    pub fn jacobian(&self) -> Jacobian<N> {
        let mut jacobian = Jacobian::<N>::zeros();
        for i in 0..N {
            let z = &self.axes[i];
            let (linear, angular) = match self.kinds[i] {
                JointKind::Revolute => (z.cross(&(self.tool - self.points[i])), *z),
                JointKind::Prismatic => (*z, Vector3::zeros()),
            };
            jacobian.fixed_view_mut::<3, 1>(0, i).copy_from(&linear);
            jacobian.fixed_view_mut::<3, 1>(3, i).copy_from(&angular);
        }
        jacobian
    }

    /// From joint `i` to the next one, or from the last one to the tool.
    fn link(&self, i: usize) -> Vector3<f64> {
        self.points.get(i + 1).unwrap_or(&self.tool) - self.points[i]
    }

    /// J' qd: the tool's acceleration when the joint accelerations are 0.
    pub fn acceleration_bias(&self, qd: &Joints<N>) -> Twist {
        let mut linear = Vector3::zeros();
        let (mut w, mut a) = (Vector3::zeros(), Vector3::zeros());
        for i in 0..N {
            let z = &self.axes[i];
            let z1 = w.cross(z);
            match self.kinds[i] {
                JointKind::Revolute => {
                    a += z1 * qd[i];
                    w += z * qd[i];
                }
                JointKind::Prismatic => linear += z1 * (2.0 * qd[i]),
            }
            let r = self.link(i);
            linear += a.cross(&r) + w.cross(&w.cross(&r));
        }
        stack(&linear, &a)
    }

    /// 2 J' qdd + J'' qd: the tool's jerk when the joint jerks are 0.
    pub fn jerk_bias(&self, qd: &Joints<N>, qdd: &Joints<N>) -> Twist {
        let mut linear = Vector3::zeros();
        let (mut w, mut a, mut g) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        for i in 0..N {
            let z = &self.axes[i];
            let z1 = w.cross(z);
            let z2 = a.cross(z) + w.cross(&z1);
            match self.kinds[i] {
                JointKind::Revolute => {
                    g += z2 * qd[i] + z1 * (2.0 * qdd[i]);
                    a += z1 * qd[i] + z * qdd[i];
                    w += z * qd[i];
                }
                JointKind::Prismatic => linear += (z2 * qd[i] + z1 * qdd[i]) * 3.0,
            }
            let r = self.link(i);
            let r1 = w.cross(&r);
            let r2 = a.cross(&r) + w.cross(&r1);
            linear += g.cross(&r) + a.cross(&r1) * 2.0 + w.cross(&r2);
        }
        stack(&linear, &g)
    }
}

/// The quaternion of a rotation matrix: a row of 4 q q^T, divided by the root of its diagonal entry, which is at least 1
/// (Day, "Converting a Rotation Matrix to a Quaternion"). All four rows are there and one is picked bit by bit, as a
/// branch on a random orientation is mispredicted at more than the price of the rest.
#[inline]
pub(crate) fn quaternion(r: &Matrix3<f64>) -> UnitQuaternion<f64> {
    let (xx, yy, zz) = (r[(0, 0)], r[(1, 1)], r[(2, 2)]);
    let (wx, wy, wz) = (r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let (xy, xz, yz) = (r[(1, 0)] + r[(0, 1)], r[(0, 2)] + r[(2, 0)], r[(2, 1)] + r[(1, 2)]);
    let of_w = [1.0 + xx + yy + zz, wx, wy, wz];
    let of_x = [wx, 1.0 + xx - yy - zz, xy, xz];
    let of_y = [wy, xy, 1.0 - xx + yy - zz, yz];
    let of_z = [wz, xz, yz, 1.0 - xx - yy + zz];
    let mask = |yes: bool| u64::from(yes).wrapping_neg();
    let (down, x_or_y, z_or_w) = (mask(zz < 0.0), mask(xx > yy), mask(xx < -yy));
    let pick = |mask: u64, a: f64, b: f64| f64::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask));
    let picked = |x: f64, y: f64, z: f64, w: f64| pick(down, pick(x_or_y, x, y), pick(z_or_w, z, w));
    let row: [f64; 4] = std::array::from_fn(|i| picked(of_x[i], of_y[i], of_z[i], of_w[i]));
    let scale = 0.5 / picked(of_x[1], of_y[2], of_z[3], of_w[0]).sqrt();
    let [w, x, y, z] = row.map(|v| v * scale);
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}

fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Twist {
    Twist::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// A target pose in the form errors are measured in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target {
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
}

impl Target {
    pub(crate) fn new(pose: &Isometry3<f64>) -> Self {
        Self { rotation: pose.rotation.to_rotation_matrix().into_inner(), position: pose.translation.vector }
    }

    /// The twist that leads from `at` to here, to first order: its angular part is as long as the
    /// sine of the angle.
    pub(crate) fn error<const N: usize>(&self, at: &Configuration<N>) -> Twist {
        let linear = self.position - at.position();
        let angular: Vector3<f64> = (0..3)
            .map(|i| {
                let is: Vector3<f64> = at.rotation().column(i).into();
                let should: Vector3<f64> = self.rotation.column(i).into();
                is.cross(&should) * 0.5
            })
            .sum();
        stack(&linear, &angular)
    }

    /// Cosine of the angle between `at` and here.
    pub(crate) fn cosine<const N: usize>(&self, at: &Configuration<N>) -> f64 {
        0.5 * (at.rotation().component_mul(&self.rotation).sum() - 1.0)
    }
}
