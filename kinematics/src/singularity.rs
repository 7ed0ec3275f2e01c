//! Distances of an arm from a singular pose.
//!
//! The rows of the Jacobian are in metres and radians and are not scaled against each other, so singular values mix the
//! two: compare them between poses of one arm, not between arms of different size.

use crate::jacobian::Jacobian;
use crate::singularity_kind::SingularityKind;
use nalgebra::Vector3;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Distances of a six-joint arm from its singular poses, kind by kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularityDistances {
    /// Angle between the wrist's first and last axis, or its complement to a half turn: 0 where they line up, rad.
    pub wrist: f64,
    /// Angle between upper arm and forearm, likewise: 0 where the arm is stretched or folded, rad.
    pub elbow: f64,
    /// Distance of the wrist from the plane through axis 1 that is parallel to axis 2, m.
    pub shoulder: f64,
    /// The nearest of the three, with the shoulder's distance taken relative to the size of the arm.
    pub nearest: SingularityKind,
}

impl SingularityDistances {
    pub(crate) fn new(wrist: f64, elbow: f64, shoulder: f64, size: f64) -> Self {
        let nearest = if wrist <= elbow && wrist <= shoulder / size {
            SingularityKind::Wrist
        } else if elbow <= shoulder / size {
            SingularityKind::Elbow
        } else {
            SingularityKind::Shoulder
        };
        Self { wrist, elbow, shoulder, nearest }
    }

    /// Angle between two lines, rad in [0, pi/2].
    pub(crate) fn between_lines(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
        a.cross(b).norm().atan2(a.dot(b).abs())
    }
}

/// The min(6, N) singular values of a Jacobian, largest first; the rest of the array is 0.
///
/// One-sided Jacobi rotations: small singular values come out to full relative accuracy, where eigenvalues of J J^T
/// would lose half the digits. Values that are not finite give values that are not finite.
pub fn singular_values<const N: usize>(jacobian: &Jacobian<N>) -> [f64; 6] {
    let mut values = [0.0; 6];
    let lengths: &mut [f64] = &mut values;
    if N <= 6 {
        let mut columns: [[f64; 6]; N] = std::array::from_fn(|c| std::array::from_fn(|r| jacobian[(r, c)]));
        orthogonalise(&mut columns, &mut [[]; N]);
        columns.iter().zip(lengths).for_each(|(column, value)| *value = dot(column, column).sqrt());
    } else {
        let mut rows: [[f64; N]; 6] = std::array::from_fn(|r| std::array::from_fn(|c| jacobian[(r, c)]));
        orthogonalise(&mut rows, &mut [[]; 6]);
        rows.iter().zip(lengths).for_each(|(row, value)| *value = dot(row, row).sqrt());
    }
    values.sort_unstable_by(|a, b| b.total_cmp(a));
    values
}

/// Smallest singular value: the slowest the tool moves (in the worst direction) at unit joint speed. 0 at a singular pose.
pub fn smallest_singular_value<const N: usize>(jacobian: &Jacobian<N>) -> f64 {
    last_of(&singular_values(jacobian), N)
}

/// Largest over smallest singular value; infinite at a singular pose.
pub fn condition_number<const N: usize>(jacobian: &Jacobian<N>) -> f64 {
    let values = singular_values(jacobian);
    values[0] / last_of(&values, N)
}

/// Yoshikawa's manipulability: the product of the singular values, |det J| for six joints. 0 at a singular pose.
pub fn manipulability<const N: usize>(jacobian: &Jacobian<N>) -> f64 {
    singular_values(jacobian)[..N.min(6)].iter().product()
}

fn last_of(values: &[f64; 6], joints: usize) -> f64 {
    values[joints.clamp(1, 6) - 1]
}

pub(crate) fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Rotates pairs of vectors until all are orthogonal (Hestenes), and `with` along. Quadratic convergence: a handful of
/// sweeps.
pub(crate) fn orthogonalise<const D: usize, const K: usize, const W: usize>(
    vectors: &mut [[f64; D]; K],
    with: &mut [[f64; W]; K],
) {
    const SWEEPS: usize = 30;
    for _ in 0..SWEEPS {
        let mut turned = false;
        for i in 0..K {
            for j in i + 1..K {
                let (aa, bb, ab) =
                    (dot(&vectors[i], &vectors[i]), dot(&vectors[j], &vectors[j]), dot(&vectors[i], &vectors[j]));
                if ab.abs() <= f64::EPSILON * (aa * bb).sqrt() || ab == 0.0 {
                    continue;
                }
                turned = true;
                let zeta = (bb - aa) / (2.0 * ab);
                let tan = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                let sin = cos * tan;
                rotate(vectors, i, j, sin, cos);
                rotate(with, i, j, sin, cos);
            }
        }
        if !turned {
            return;
        }
    }
}

#[inline]
fn rotate<const D: usize>(vectors: &mut [[f64; D]], i: usize, j: usize, sin: f64, cos: f64) {
    let (head, tail) = vectors.split_at_mut(j);
    for (a, b) in head[i].iter_mut().zip(&mut tail[0]) {
        (*a, *b) = (cos * *a - sin * *b, sin * *a + cos * *b);
    }
}
