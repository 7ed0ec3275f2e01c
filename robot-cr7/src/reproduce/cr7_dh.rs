//! Forward kinematics of the CR7 from its Denavit-Hartenberg table: a second path beside the
//! library's chain.

use nalgebra::{Matrix4, Vector3};

/// a (m), alpha (rad), d (m), offset of the angle (rad): the standard table of the maker's
/// description.
const TABLE: [[f64; 4]; 6] = {
    use std::f64::consts::FRAC_PI_2 as Q;
    [
        [0.0, Q, 0.147, 0.0],
        [-0.377, 0.0, 0.0, -Q],
        [-0.307, 0.0, 0.0, 0.0],
        [0.0, Q, 0.141, -Q],
        [0.0, -Q, 0.116, 0.0],
        [0.0, 0.0, 0.105, 0.0],
    ]
};

/// The flange in the base, at joint values in the maker's zero.
pub fn flange(q: &[f64; 6]) -> Matrix4<f64> {
    TABLE.iter().zip(q).fold(Matrix4::identity(), |pose, (&[a, alpha, d, offset], q)| {
        let (s, c) = (q + offset).sin_cos();
        let (sa, ca) = alpha.sin_cos();
        #[rustfmt::skip]
        let step = Matrix4::new(
            c, -s * ca, s * sa, a * c,
            s, c * ca, -c * sa, a * s,
            0.0, sa, ca, d,
            0.0, 0.0, 0.0, 1.0,
        );
        pose * step
    })
}

/// The origin of the flange, m.
pub fn position(q: &[f64; 6]) -> Vector3<f64> {
    flange(q).fixed_view::<3, 1>(0, 3).into_owned()
}
