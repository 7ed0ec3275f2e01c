//! All inverse solutions of six-joint arms with a spherical wrist (KUKA, ABB, Fanuc, Staeubli, the Puma and their kin).
//!
//! The geometry: axes 4, 5, 6 meet in a point W; axis 5 perpendicular to 4 and 6; axes 2 and 3 parallel (direction n);
//! axis 1 perpendicular to n. Axis 1 need not meet axis 2, nor W lie in the plane of the arm (the Puma's shoulder
//! offset). Everything is read from the chain at zero joint values: any zero convention, sense of rotation, base and
//! tool will do.
//!
//! In the frame F of the arm's plane (see `planar`),
//!
//! 1. joints 2 and 3 do not move W along n: two values of joint 1.
//! 2. W is the end of a planar two-link arm: two values of joints 2 and 3 each.
//! 3. what is left of the orientation is `Rz(A) Rx(B) Rz(C)` about (axis 4, axis 5, axis 6), ZXZ Euler angles of
//!    A = q4, B = q5 (+ const), C = q6: two solutions each, +-B.
//!
//! C is read from what A leaves over, so that the pose stays exact to rounding however badly A is determined.

use super::arm_plane::{ArmPlane, Seen};
use super::planar::TwoLink;
use super::rules::{Rules, WRIST_SINGULAR, distances};
use super::{ClosedForm, Collect, Collector};
use crate::error::KinematicsError;
use crate::jacobian::Configuration;
use crate::joint::Joints;
use crate::posture::Posture;
use crate::singularity::SingularityDistances;
use crate::trig::{atan2, principal, sin_cos};
use nalgebra::{Isometry3, Matrix3, Vector2};
#[cfg(not(feature = "std"))]
use num_traits::Float;
use std::f64::consts::PI;

/// The numbers of one arm with a spherical wrist.
#[derive(Debug, Clone, Copy)]
pub struct SphericalWrist {
    /// The frame F and the wrist in the tool.
    plane: ArmPlane,
    /// F to the frame of the wrist: z along axis 4, x along axis 5, at zero.
    frame_to_wrist: Matrix3<f64>,
    /// A point of axis 2 in (u, v).
    axis2: Vector2<f64>,
    /// From axis 2 to axis 3 to W.
    links: TwoLink,
    /// The value of joint 5, negated, where axes 4 and 6 line up.
    wrist_zero: f64,
    /// True if axis 3 points along n (+1) or against it (-1).
    sign3: f64,
    exact: bool,
}

impl SphericalWrist {
    /// Step 3: the two values of joints 4 to 6 for orientation `m` (in the frame of the wrist), or the free wrist.
    #[inline]
    fn wrist_branches(&self, m: &Matrix3<f64>, [q1, q2, q3]: [f64; 3], seed: &Joints<6>, found: &mut Collector<'_>) {
        let sine = (m[(0, 2)] * m[(0, 2)] + m[(1, 2)] * m[(1, 2)]).sqrt();
        let singular = sine < WRIST_SINGULAR;
        let (a, sin_a, cos_a, b) = if singular {
            found.solutions().mark_wrist_singular();
            let ([sin], [cos]) = sin_cos(&[seed[3]]);
            (seed[3], sin, cos, if m[(2, 2)] > 0.0 { 0.0 } else { PI })
        } else {
            let (sin, cos) = (m[(0, 2)] / sine, -m[(1, 2)] / sine);
            (atan2(sin, cos), sin, cos, atan2(sine, m[(2, 2)]))
        };
        let c = atan2(-(cos_a * m[(0, 1)] + sin_a * m[(1, 1)]), cos_a * m[(0, 0)] + sin_a * m[(1, 0)]);
        let mut push = |q4: f64, b: f64, q6: f64| {
            found.push(Joints::from([q1, q2, q3, q4, b - self.wrist_zero, q6].map(principal)));
        };
        push(a, b, c);
        if !singular {
            push(a + PI, -b, c + PI);
        }
    }
}

impl Collect for SphericalWrist {
    fn collect(
        &self,
        target: &Isometry3<f64>,
        seed: &Joints<6>,
        found: &mut Collector<'_>,
    ) -> Result<(), KinematicsError> {
        self.plane.solve(target, seed, found, |first, Seen { orientation, wrist }, found, miss| {
            let upright = orientation_undone::<0, 2>(orientation, -first.sin, first.cos);
            let end = Vector2::new(first.cos * wrist.x - first.sin * wrist.z, wrist.y) - self.axis2;
            self.links.solve(&end, first.rounding, miss, |q2, q3| {
                if !found.wants([(1, q2), (2, q3 * self.sign3)]) {
                    return;
                }
                let ([sin], [cos]) = sin_cos(&[q2 + q3]);
                let level = orientation_undone::<0, 1>(&upright, sin, cos);
                self.wrist_branches(&(self.frame_to_wrist * level), [first.q, q2, q3 * self.sign3], seed, found);
            });
        })
    }
}

impl ClosedForm for SphericalWrist {
    const FREE_JOINT: usize = 3;

    fn recognise(zero: &Configuration<6>) -> Result<Self, KinematicsError> {
        let (z, o) = (&zero.axes, &zero.points);
        let mut rules = Rules::new(zero)?;
        let mut rule = |rule: &'static str, deviation: f64| rules.hold(rule, deviation);
        rule("axes 4 and 5 must be perpendicular", z[3].dot(&z[4]).abs())?;
        rule("axes 5 and 6 must be perpendicular", z[4].dot(&z[5]).abs())?;
        // W: where axis 5 comes nearest to axis 4; the three distances of the axes from it must vanish.
        let wrist = o[3] + z[3] * z[3].dot(&(o[4] - o[3]));
        let distance = |i: usize| (wrist - o[i]).cross(&z[i]).norm();
        rule("axes 4 and 5 must meet", distance(4))?;
        rule("axis 6 must pass through the point where axes 4 and 5 meet", distance(5))?;
        let n = z[1];
        rule("axes 2 and 3 must be parallel", n.cross(&z[2]).norm())?;
        rule("axes 1 and 2 must be perpendicular", z[0].dot(&n).abs())?;

        let plane = ArmPlane::new(zero, &wrist);
        let [axis2, axis3] = [o[1], o[2]].map(|point| plane.in_frame(&point).xy());
        let centre = plane.in_frame(&wrist);
        let (upper_arm, forearm) = (axis3 - axis2, centre.xy() - axis3);
        rules.has_length("axes 2 and 3 must not coincide", upper_arm.norm())?;
        rules.has_length("the wrist must not lie on axis 3", forearm.norm())?;

        let x = (z[4] - z[3] * z[3].dot(&z[4])).normalize();
        let wrist_frame = Matrix3::from_columns(&[x, z[3].cross(&x), z[3]]);
        let last = wrist_frame.transpose() * z[5];
        let wrist_zero = (-last.y).atan2(last.z);
        let (sin, cos) = wrist_zero.sin_cos();
        let to_singular = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
        let tool_to_wrist = zero.rotation.transpose() * wrist_frame * to_singular;
        let size = upper_arm.norm() + forearm.norm() + centre.z.abs() + axis2.norm();
        Ok(Self {
            plane: plane.with_wrist(tool_to_wrist, size),
            frame_to_wrist: wrist_frame.transpose() * plane.to_frame.transpose(),
            axis2,
            links: TwoLink::new(&upper_arm, &forearm, size),
            wrist_zero,
            sign3: z[2].dot(&n).signum(),
            exact: rules.exact(size),
        })
    }

    fn is_exact(&self) -> bool {
        self.exact
    }

    fn singularity_distances(&self, at: &Configuration<6>) -> SingularityDistances {
        let (z, o) = (&at.axes, &at.points);
        let wrist = o[3] + z[3] * z[3].dot(&(o[4] - o[3]));
        distances(at, &wrist, [&z[3], &z[5]], &wrist, self.plane.size)
    }

    fn posture(&self, at: &Configuration<6>) -> Posture {
        let (z, o) = (&at.axes, &at.points);
        let wrist = o[3] + z[3] * z[3].dot(&(o[4] - o[3]));
        Posture::of(at, &wrist, [&z[3], &z[5]], &wrist)
    }
}

/// `m` with the turn of rows `I` and `J` by (`sin`, `cos`) undone.
#[inline]
fn orientation_undone<const I: usize, const J: usize>(m: &Matrix3<f64>, sin: f64, cos: f64) -> Matrix3<f64> {
    let mut undone = *m;
    for column in 0..3 {
        let (x, y) = (m[(I, column)], m[(J, column)]);
        undone[(I, column)] = cos * x + sin * y;
        undone[(J, column)] = cos * y - sin * x;
    }
    undone
}
