//! Rotations as vectors: exponential, logarithm, and what the derivatives of a rotation vector mean
//! as angular rates.
//!
//! A rotation vector `phi` turns by `|phi|` about its own direction. All formulas are in base axes:
//! with `R = exp(phi(t)) R0` the angular velocity is `omega = J(phi) phi'`, `J` the left Jacobian.
//! Nothing is singular at zero.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// The rotation by `|phi|` (rad) about `phi`.
///
/// ```
/// use arcfeed_sync::{nalgebra::Vector3, so3};
/// let phi = Vector3::new(0.1, -2.0, 0.3);
/// assert!((so3::log(&so3::exp(&phi)) - phi).norm() < 1e-15);
/// ```
pub fn exp(phi: &Vector3<f64>) -> UnitQuaternion<f64> {
    let half = 0.5 * phi.norm();
    // sin(x)/x is 1 to machine precision below 1e-8.
    let sinc = if half > 1e-8 { half.sin() / half } else { 1.0 };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(half.cos(), phi * (0.5 * sinc)))
}

/// The rotation vector of `q`, on the shorter arc: at most pi long. (Liu et al. 2024, eq. 19:
/// `2 Im log q`; `q` and `-q` are the same rotation, and the one with a non-negative real part is
/// the shorter way.)
pub fn log(q: &UnitQuaternion<f64>) -> Vector3<f64> {
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let (v, w) = (q.imag() * sign, q.w * sign);
    let n = v.norm();
    // atan2(n, w)/n tends to 1/w = 1.
    if n > 1e-150 { v * (2.0 * n.atan2(w) / n) } else { v * 2.0 }
}

/// `(1 - cos x)/x²`, `(x - sin x)/x³` and their derivatives by `x` over `x`, as functions of `x²`.
fn coefficients(square: f64) -> [f64; 4] {
    if square > 1.0 {
        let x = square.sqrt();
        let (sin, cos) = x.sin_cos();
        let quartic = square * square;
        return [
            (1.0 - cos) / square,
            (x - sin) / (square * x),
            (x * sin - 2.0 * (1.0 - cos)) / quartic,
            (3.0 * sin - 2.0 * x - x * cos) / (quartic * x),
        ];
    }
    // Power series: terms (-x²)^n / (2n+2)! and (-x²)^n / (2n+3)!, and 2n/x² times these.
    let mut sums = [0.0; 4];
    let (mut power, mut factorial) = (1.0, 2.0);
    for n in 0..10 {
        let n = f64::from(n);
        let (even, odd) = (power / factorial, power / (factorial * (2.0 * n + 3.0)));
        sums[0] += even;
        sums[1] += odd;
        // The next terms, divided by x².
        let next = -power * (2.0 * n + 2.0) / (factorial * (2.0 * n + 3.0) * (2.0 * n + 4.0));
        sums[2] += next;
        sums[3] += next / (2.0 * n + 5.0);
        power *= -square;
        factorial *= (2.0 * n + 3.0) * (2.0 * n + 4.0);
    }
    sums
}

/// The left Jacobian `J(phi) = I + (1 - cos x)/x² [phi] + (x - sin x)/x³ [phi]²`, `x = |phi|`.
pub fn left_jacobian(phi: &Vector3<f64>) -> Matrix3<f64> {
    let [c1, c2, ..] = coefficients(phi.norm_squared());
    let cross = phi.cross_matrix();
    Matrix3::identity() + cross * c1 + cross * cross * c2
}

/// Angular velocity and acceleration of `exp(phi(t)) R0` from the first two derivatives of `phi`,
/// in base axes.
pub fn angular_rates(phi: &Vector3<f64>, rate: &Vector3<f64>, second: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let [c1, c2, d1, d2] = coefficients(phi.norm_squared());
    let jacobian = |y: &Vector3<f64>| {
        let once = phi.cross(y);
        y + once * c1 + phi.cross(&once) * c2
    };
    let (turn, grow) = (phi.cross(rate), phi.dot(rate));
    // The derivative of J, applied to the rate: of its three cross products only those with phi x
    // rate are not zero.
    let change = turn * (d1 * grow) + phi.cross(&turn) * (d2 * grow) + rate.cross(&turn) * c2;
    (jacobian(rate), jacobian(second) + change)
}

/// The rotation after `h` seconds with the angular velocities `early` and `late` at the Gauss
/// points `(1/2 -+ sqrt(3)/6) h`, exponentially and to fourth order (Liu et al. 2024, eq. 20,
/// corrected: there a sum of quaternions).
pub fn step(from: &UnitQuaternion<f64>, early: &Vector3<f64>, late: &Vector3<f64>, h: f64) -> UnitQuaternion<f64> {
    let mean = (early + late) * (0.5 * h);
    let commutator = early.cross(late) * (h * h * 3f64.sqrt() / 12.0);
    UnitQuaternion::new_normalize((exp(&(mean - commutator)) * from).into_inner())
}
