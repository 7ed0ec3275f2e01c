//! Rotation vectors and the rates of orientations that follow from them.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// An orientation with its angular rate and the rate's derivatives, all by arc length and in base axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientationJet {
    /// Rotation from tool axes to base axes.
    pub rotation: UnitQuaternion<f64>,
    /// Rotation vector per unit of arc length (rad/m): times the feed rate, the angular velocity.
    pub rate: Vector3<f64>,
    /// First derivative of the rate by arc length (rad/m^2).
    pub d_rate: Vector3<f64>,
    /// Second derivative of the rate by arc length (rad/m^3).
    pub dd_rate: Vector3<f64>,
}

/// Rotation vector from `a` to `b` in the axes of `a`, at most half a turn long.
pub(crate) fn shorter_way(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = (a.inverse() * b).into_inner();
    let (sin, cos) = (q.imag().norm(), q.w.abs());
    if sin == 0.0 {
        return Vector3::zeros();
    }
    q.imag() * (2.0 * sin.atan2(cos) / if q.w < 0.0 { -sin } else { sin })
}

/// The right Jacobian of the rotation group at the rotation vector `r`, and its inverse: the angular rate in the turned
/// axes is `J(phi) phi'`.
pub(super) fn right_jacobian(r: &Vector3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    let cross = r.cross_matrix();
    let square = cross * cross;
    let angle = r.norm();
    let (a, b, c) = if angle < 1e-2 {
        let x = angle * angle;
        (0.5 - x / 24.0, 1.0 / 6.0 - x / 120.0, 1.0 / 12.0 + x / 720.0)
    } else {
        let (sin, cos) = (0.5 * angle).sin_cos();
        let x = angle * angle;
        (2.0 * sin * sin / x, (angle - angle.sin()) / (x * angle), (1.0 - 0.5 * angle * cos / sin) / x)
    };
    let one = Matrix3::identity();
    (one - cross * a + square * b, one + cross * 0.5 + square * c)
}

/// The angular acceleration at the end of `exp(phi)`, seen in the axes there, given `phi` and three derivatives.
pub(super) fn end_acceleration(phi: &[Vector3<f64>; 4]) -> Vector3<f64> {
    let end = rotate_along(&UnitQuaternion::identity(), phi);
    end.rotation.inverse() * end.d_rate
}

/// Orientation `first * exp(phi)` and its rates, given `phi` and three derivatives.
///
/// With the quaternion `q = exp(phi / 2)` and its derivatives: rate = 2 vec(q' q*), and so on by the product rule.
pub(super) fn rotate_along(first: &UnitQuaternion<f64>, phi: &[Vector3<f64>; 4]) -> OrientationJet {
    // x = |phi|^2 and its derivatives.
    let x = [
        phi[0].dot(&phi[0]),
        2.0 * phi[0].dot(&phi[1]),
        2.0 * (phi[0].dot(&phi[2]) + phi[1].dot(&phi[1])),
        2.0 * (phi[0].dot(&phi[3]) + 3.0 * phi[1].dot(&phi[2])),
    ];
    let f = half_sinc(x[0]);
    // Chain rule for g(x(s)), given g and its derivatives by x.
    let chain = |g: [f64; 4]| {
        [
            g[0],
            g[1] * x[1],
            g[2] * x[1] * x[1] + g[1] * x[2],
            g[3] * x[1] * x[1] * x[1] + 3.0 * g[2] * x[1] * x[2] + g[1] * x[3],
        ]
    };
    let sinc = chain(f);
    // cos(sqrt(x) / 2) has the derivative -half_sinc / 4.
    let cos = chain([(0.5 * x[0].sqrt()).cos(), -0.25 * f[0], -0.25 * f[1], -0.25 * f[2]]);
    let part = |w: f64, v: Vector3<f64>| Quaternion::from_parts(w, v);
    let q0 = part(cos[0], phi[0] * sinc[0]);
    let q1 = part(cos[1], phi[0] * sinc[1] + phi[1] * sinc[0]);
    let q2 = part(cos[2], phi[0] * sinc[2] + phi[1] * (2.0 * sinc[1]) + phi[2] * sinc[0]);
    let q3 = part(cos[3], phi[0] * sinc[3] + phi[1] * (3.0 * sinc[2]) + phi[2] * (3.0 * sinc[1]) + phi[3] * sinc[0]);
    let (c0, c1, c2) = (q0.conjugate(), q1.conjugate(), q2.conjugate());
    let rate = (q1 * c0).imag() * 2.0;
    let d_rate = (q2 * c0 + q1 * c1).imag() * 2.0;
    let dd_rate = (q3 * c0 + q2 * c1 * 2.0 + q1 * c2).imag() * 2.0;
    OrientationJet {
        rotation: first * UnitQuaternion::new_normalize(q0),
        rate: first * rate,
        d_rate: first * d_rate,
        dd_rate: first * dd_rate,
    }
}

/// `sin(sqrt(x) / 2) / sqrt(x)` and its first three derivatives by `x`.
fn half_sinc(x: f64) -> [f64; 4] {
    if x < 1.0 {
        // Series sum (-1)^k x^k / (2^(2k+1) (2k+1)!): the closed forms below cancel here.
        let mut out = [0.0; 4];
        let mut c = 0.5;
        for k in 0..12i32 {
            let kf = k as f64;
            out[0] += c * x.powi(k);
            if k >= 1 {
                out[1] += c * kf * x.powi(k - 1);
            }
            if k >= 2 {
                out[2] += c * kf * (kf - 1.0) * x.powi(k - 2);
            }
            if k >= 3 {
                out[3] += c * kf * (kf - 1.0) * (kf - 2.0) * x.powi(k - 3);
            }
            c *= -1.0 / (4.0 * (2.0 * kf + 2.0) * (2.0 * kf + 3.0));
        }
        return out;
    }
    let root = x.sqrt();
    let (sin, cos) = (0.5 * root).sin_cos();
    let s = sin / root;
    let s1 = (0.5 * cos - s) / (2.0 * x);
    let s2 = (-0.125 * s - 3.0 * s1) / (2.0 * x);
    let s3 = (-0.125 * s1 - 5.0 * s2) / (2.0 * x);
    [s, s1, s2, s3]
}
