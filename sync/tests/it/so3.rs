//! Rotation vectors against matrices, series against closed forms, derivatives against differences.
use arcfeed_sync::nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use arcfeed_sync::so3;

/// The exponential of a matrix by its series, after halving.
fn matrix_exp(m: Matrix3<f64>) -> Matrix3<f64> {
    let m = m / 64.0;
    let mut term = Matrix3::identity();
    let mut sum = term;
    for n in 1..20 {
        term = term * m / f64::from(n);
        sum += term;
    }
    for _ in 0..6 {
        sum = sum * sum;
    }
    sum
}

fn vectors() -> Vec<Vector3<f64>> {
    let mut all = vec![Vector3::zeros()];
    for size in [1e-300, 1e-160, 1e-20, 1e-9, 1e-8, 1e-4, 0.3, 0.999, 1.0, 1.001, 2.0, 3.0, std::f64::consts::PI - 1e-9]
    {
        for direction in [Vector3::x(), Vector3::new(0.6, -0.48, 0.64), Vector3::new(-0.1, 0.2, -1.0).normalize()] {
            all.push(direction * size);
        }
    }
    all
}

#[test]
fn exponential_and_logarithm() {
    for phi in vectors() {
        let q = so3::exp(&phi);
        assert!((q.norm() - 1.0).abs() < 1e-15);
        let matrix = matrix_exp(phi.cross_matrix());
        // The series squares its round-off up to six times.
        assert!((q.to_rotation_matrix().matrix() - matrix).norm() < 1e-13, "{phi:?}");
        let back = so3::log(&q);
        // Near pi the rotation vector itself is as good as the angle: both ways of rounding are the same rotation.
        assert!((back - phi).norm() <= 4e-16 * phi.norm().max(1e-290), "{phi:?} {back:?}");
        let negative = UnitQuaternion::new_unchecked(-q.into_inner());
        assert!((so3::log(&negative) - phi).norm() <= 1e-15 * phi.norm().max(1e-290), "{phi:?}");
    }
    // A turn beyond pi comes back the shorter way; at pi either sign will do.
    let long = so3::log(&so3::exp(&Vector3::new(4.0, 0.0, 0.0)));
    assert!((long.x - (4.0 - std::f64::consts::TAU)).abs() < 1e-15);
    let half = so3::log(&so3::exp(&Vector3::new(0.0, std::f64::consts::PI, 0.0)));
    assert!((half.norm() - std::f64::consts::PI).abs() < 1e-15);
}

#[test]
fn jacobian_is_the_mean_of_the_rotations_on_the_way() {
    for phi in vectors().into_iter().chain([Vector3::new(3.0, -4.0, 2.0), Vector3::new(6.0, 0.0, 0.5)]) {
        // J = integral of exp(s phi) over s in [0, 1], by Gauss-Legendre on 40 pieces.
        let mut mean = Matrix3::zeros();
        for i in 0..40 {
            for node in [-0.6f64.sqrt(), 0.0, 0.6f64.sqrt()] {
                let weight = if node == 0.0 { 8.0 / 18.0 } else { 5.0 / 18.0 };
                let s = (f64::from(i) + 0.5 + 0.5 * node) / 40.0;
                mean += Rotation3::new(phi * s).matrix() * (weight / 40.0);
            }
        }
        assert!((so3::left_jacobian(&phi) - mean).norm() < 1e-11, "{phi:?}");
    }
}

#[test]
fn rates_are_what_the_rotation_does() {
    let (c, d) = (Vector3::new(0.4, -0.9, 0.2), Vector3::new(-0.5, 0.3, 1.1));
    for a in vectors() {
        let phi = |t: f64| a + c * t + d * (0.5 * t * t);
        let (omega, alpha) = so3::angular_rates(&a, &c, &d);
        let h = 1e-4;
        let turn = |t: f64| so3::log(&(so3::exp(&phi(t + h)) * so3::exp(&phi(t - h)).inverse())) / (2.0 * h);
        assert!((turn(0.0) - omega).norm() < 1e-7, "{a:?}");
        let rate = |t: f64| so3::angular_rates(&phi(t), &(c + d * t), &d).0;
        let change = (rate(h) - rate(-h)) / (2.0 * h);
        assert!((change - alpha).norm() < 1e-6, "{a:?}: {change:?} {alpha:?}");
        assert!((so3::left_jacobian(&a) * c - omega).norm() < 1e-14);
    }
}

#[test]
fn a_step_is_of_fourth_order() {
    // exp(phi(t)) with a known angular velocity.
    let (c, d) = (Vector3::new(0.4, -0.9, 0.2), Vector3::new(-2.5, 1.3, 3.1));
    let phi = |t: f64| c * t + d * (0.5 * t * t);
    let omega = |t: f64| so3::angular_rates(&phi(t), &(c + d * t), &d).0;
    let error = |n: u32| {
        let h = 1.0 / f64::from(n);
        let mut q = UnitQuaternion::identity();
        for i in 0..n {
            let t = h * f64::from(i);
            let offset = 3f64.sqrt() / 6.0;
            q = so3::step(&q, &omega(t + (0.5 - offset) * h), &omega(t + (0.5 + offset) * h), h);
        }
        so3::log(&(q * so3::exp(&phi(1.0)).inverse())).norm()
    };
    let (coarse, fine) = (error(20), error(40));
    assert!(coarse / fine > 14.0 && fine < 1e-6, "{coarse} {fine}");
}
