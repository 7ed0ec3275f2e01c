//! Bounds on the torque of all motions whose joints keep given rates.
//!
//! By d'Alembert's principle the torque of joint j is `sum m (dp/dq_j) . (p'' - g)` over points p with masses m. A body is a point at its
//! centre of mass, and its second moment about that: unit vectors e fixed in it with weights, which add `(de/dq_j) . e''`.
//!
//! Such a vector is a sum of segments, each of which a product of rotations turns. A derivative by several joint values puts a matrix
//! `[z]x`, whose norm is 1, into the product for each of them, and so never makes a segment longer. Therefore its derivatives by time are
//! at most those of `length exp(Q)` with Q the sum of the joints before the segment, if all rates are replaced by their bounds. A joint that
//! slides makes a segment longer and turns nothing.

use super::Friction;
use super::inertial::Moments;
use crate::joint::{JointKind, Joints};
use crate::normalised::Normalised;
use nalgebra::{Matrix3, SymmetricEigen};

/// Part by which all bounds are raised: it covers the rounding of their sums, all terms of which are positive.
const ROUNDING: f64 = 1e-12;

/// What torques do not exceed in any motion whose joints keep given rates; see
/// [`Dynamics::torque_bounds`](crate::Dynamics::torque_bounds).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueBounds<const N: usize> {
    /// Bounds on the size of the torques, friction included, N m (N).
    pub size: Joints<N>,
    /// Bounds on the second derivative by time of the torques, without the jumps of friction where a joint turns back, N m/s^2 (N/s^2).
    pub second_derivative: Joints<N>,
}

/// A size and bounds on its first four derivatives by time.
type Series = [f64; 5];

/// The derivatives of `exp(Q)` over `exp(Q)` (complete Bell polynomials) for the first four derivatives of Q.
fn exponential([a, b, c, d]: [f64; 4]) -> Series {
    let square = a * a;
    let fourth = d + 4.0 * a * c + 3.0 * b * b + 6.0 * square * b + square * square;
    [1.0, a, b + square, c + 3.0 * a * b + square * a, fourth]
}

/// The derivatives of a product.
fn product(x: &Series, y: &Series) -> Series {
    const CHOOSE: [[f64; 5]; 5] = [
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0, 0.0],
        [1.0, 2.0, 1.0, 0.0, 0.0],
        [1.0, 3.0, 3.0, 1.0, 0.0],
        [1.0, 4.0, 6.0, 4.0, 1.0],
    ];
    std::array::from_fn(|n| (0..=n).map(|k| CHOOSE[n][k] * x[k] * y[n - k]).sum())
}

fn plus(x: &Series, y: &Series) -> Series {
    std::array::from_fn(|n| x[n] + y[n])
}

/// `partial . (p'' - g)` and its second derivative, from the series of `partial` and of p.
fn work(partial: &Series, p: &Series, gravity: f64) -> [f64; 2] {
    let force = p[2] + gravity;
    [partial[0] * force, partial[2] * force + 2.0 * partial[1] * p[3] + partial[0] * p[4]]
}

/// The rigid bodies of an arm as the bounds need them.
pub(super) struct Arm<'a, const N: usize> {
    pub chain: &'a Normalised<N>,
    pub bodies: &'a [Moments; N],
    pub rotor: &'a Joints<N>,
    pub friction: &'a Friction<N>,
    /// Size of gravity, m/s^2.
    pub gravity: f64,
}

impl<const N: usize> Arm<'_, N> {
    /// For joint values and their first four derivatives of at most these sizes.
    pub fn torque_bounds(&self, sizes: &[Joints<N>; 5]) -> TorqueBounds<N> {
        let (turns, segments) = self.series(sizes);
        let mut bounds = [Joints::<N>::zeros(); 2];
        for (b, body) in self.bodies.iter().enumerate() {
            let (centre, spread) = centre_and_spread(body);
            let direction = &turns[b];
            let mut point = direction.map(|d| centre * d);
            // From the tip inwards: what follows a joint is what it turns.
            let mut partials = [[0.0; 5]; N];
            for j in (0..=b).rev() {
                partials[j] = match self.chain.links[j].kind {
                    JointKind::Revolute => point,
                    JointKind::Prismatic => before(&turns, j),
                };
                point = plus(&point, &segments[j]);
            }
            for j in 0..=b {
                let turned = self.chain.links[j].kind == JointKind::Revolute;
                let moved = work(&partials[j], &point, self.gravity);
                let spun = if turned { work(direction, direction, 0.0) } else { [0.0; 2] };
                for (bound, (moved, spun)) in bounds.iter_mut().zip(moved.into_iter().zip(spun)) {
                    bound[j] += body.mass * moved + spread * spun;
                }
            }
        }
        let [_, qd, qdd, jerk, snap] = sizes;
        let viscous = self.friction.viscous();
        let coulomb = self.friction.forward().sup(self.friction.backward());
        let size = bounds[0] + self.rotor.component_mul(qdd) + viscous.component_mul(qd) + coulomb;
        let second = bounds[1] + self.rotor.component_mul(snap) + viscous.component_mul(jerk);
        TorqueBounds { size: size * (1.0 + ROUNDING), second_derivative: second * (1.0 + ROUNDING) }
    }

    /// The series of a unit vector that turns with each link, and of the segment before each joint.
    fn series(&self, sizes: &[Joints<N>; 5]) -> ([Series; N], [Series; N]) {
        let (mut turns, mut segments) = ([[0.0; 5]; N], [[0.0; 5]; N]);
        let mut rates = [0.0; 4];
        for (j, link) in self.chain.links.iter().enumerate() {
            let mut length = [link.translation.norm(), 0.0, 0.0, 0.0, 0.0];
            if link.kind == JointKind::Prismatic {
                length.iter_mut().zip(sizes).for_each(|(length, size)| *length += size[j]);
            }
            segments[j] = product(&length, &exponential(rates));
            if link.kind == JointKind::Revolute {
                rates.iter_mut().zip(&sizes[1..]).for_each(|(rate, size)| *rate += size[j]);
            }
            turns[j] = exponential(rates);
        }
        (turns, segments)
    }
}

/// The series of a unit vector that turns with the link before joint `j`.
fn before(turns: &[Series], j: usize) -> Series {
    if j == 0 { exponential([0.0; 4]) } else { turns[j - 1] }
}

/// The distance of the centre of mass from the origin of the link's frame, and the sum of the sizes of the principal second moments
/// about it.
fn centre_and_spread(body: &Moments) -> (f64, f64) {
    let s = &body.second;
    let about_origin = Matrix3::new(s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz);
    let centre = if body.mass > 0.0 { body.first / body.mass } else { body.first * 0.0 };
    let about_centre = about_origin - body.first * centre.transpose();
    let spread: f64 = SymmetricEigen::new(about_centre).eigenvalues.iter().map(|moment| moment.abs()).sum();
    // The difference of both moments loses digits of the larger one.
    (centre.norm(), spread + ROUNDING * about_origin.iter().map(|entry| entry.abs()).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ArmDynamics, Chain, Dynamics, Inertial, Joint};
    use nalgebra::{Isometry3, Vector3};

    /// A straight arm in a plane with a point mass at the end of each link.
    fn planar(lengths: [f64; 3], masses: [f64; 3]) -> ArmDynamics<3> {
        let joint = |x: f64| Joint::revolute(Isometry3::translation(x, 0.0, 0.0), Vector3::z()).expect("a joint");
        let chain = Chain::new([joint(0.0), joint(lengths[0]), joint(lengths[1])]).expect("an arm");
        let body = |k: usize| Inertial::new(masses[k], Vector3::x() * lengths[k], Matrix3::zeros()).expect("a point");
        ArmDynamics::new(&chain, [0, 1, 2].map(body)).expect("an arm")
    }

    /// On a planar arm of points the bound is the sum of the sizes of all terms of the torque, taken here from power series of the time:
    /// `y' = Q' y` gives those of `y = exp(Q)`, and no formula for its derivatives is used.
    #[test]
    fn the_bound_is_the_sum_of_the_sizes_of_all_terms() {
        let (lengths, masses) = ([0.5, 0.4, 0.3], [2.0, 1.5, 0.7]);
        let arm = planar(lengths, masses);
        let sizes = [[0.0; 3], [1.0, 0.7, 1.3], [0.4, 2.0, 0.9], [3.0, 0.2, 1.7], [0.6, 5.0, 2.2]].map(Joints::from);
        let bounds = arm.torque_bounds(&sizes).expect("known");
        let factorial = [1.0, 1.0, 2.0, 6.0, 24.0];
        // Coefficients by powers of the time.
        let exp = |link: usize| {
            let q: Vec<f64> = (0..5)
                .map(|k| if k == 0 { 0.0 } else { (0..=link).map(|j| sizes[k][j]).sum::<f64>() / factorial[k] })
                .collect();
            let mut y = [1.0, 0.0, 0.0, 0.0, 0.0];
            for n in 1..5 {
                y[n] = (1..=n).map(|k| k as f64 * q[k] * y[n - k]).sum::<f64>() / n as f64;
            }
            y
        };
        let sum = |from: usize, to: usize| -> [f64; 5] {
            std::array::from_fn(|n| (from..=to).map(|link| lengths[link] * exp(link)[n]).sum())
        };
        for j in 0..3 {
            let (mut size, mut second) = (0.0, 0.0);
            for (b, mass) in masses.iter().enumerate().skip(j) {
                let (partial, p) = (sum(j, b), sum(0, b));
                let pull = [2.0 * p[2] + 9.81, 6.0 * p[3], 12.0 * p[4]];
                size += mass * partial[0] * pull[0];
                second += 2.0 * mass * (0..3).map(|k| partial[k] * pull[2 - k]).sum::<f64>();
            }
            assert!((bounds.size[j] - size).abs() < 1e-10 * size, "{} is not {size}", bounds.size[j]);
            let bound = bounds.second_derivative[j];
            assert!((bound - second).abs() < 1e-10 * second, "{bound} is not {second}");
        }
    }

    /// A weightless arm in a straight line whose joints change their jerk, and nothing else, attains the bound.
    #[test]
    fn a_straight_arm_attains_the_bound() {
        let arm = planar([0.5, 0.4, 0.3], [2.0, 1.5, 0.7]).with_gravity(Vector3::zeros()).expect("no gravity");
        let snap = Joints::from([1.0, 0.5, 2.0]);
        let zero = Joints::zeros();
        let bounds = arm.torque_bounds(&[zero, zero, zero, zero, snap]).expect("known");
        let attained = arm.mass_matrix(&zero) * snap;
        assert!((bounds.second_derivative - attained).amax() < 1e-10 * attained.amax(), "{bounds:?} {attained}");
    }
}
