//! All inverse solutions of six-joint arms with three parallel axes (Universal Robots, Dobot CR and their kin).
//!
//! The geometry: axes 2, 3, 4 parallel (direction n); axis 1 perpendicular to n; axis 5 perpendicular to n and to
//! axis 6; axes 5 and 6 meet in a point W, the wrist. Everything is read from the chain at zero joint values, so any
//! zero convention, base and tool will do.
//!
//! Let F = (u, v, n) with v along axis 1 and u = v x n, its origin on axis 1. Then, in F at zero,
//!
//! 1. joints 2 to 6 do not move W along n, so n(q1) . W = d with d known: `q1 = atan2(x, z) +- atan2(sqrt(r^2-d^2), d)`.
//! 2. what is left of the orientation is `Rz(A) Rx(B) Rz(C)` about (n, axis 5, n), ZXZ Euler angles of
//!    A = q2 + q3 + q4 (+ const), B = q5 (+ const), C = q6 (+ const): two solutions, +-B.
//! 3. W less the turned vector from axis 4 to W is the end of a planar two-link arm: two solutions, +-elbow.
//!
//! Every angle comes from an arc tangent of what the later steps use too, so that a badly determined angle (near a
//! singular pose) is made up for by the others and the pose stays exact to rounding.

use super::arm_plane::ArmPlane;
use super::planar::{FirstJoint, Miss, TwoLink};
use super::rules::{Rules, WRIST_SINGULAR, distances};
use super::{ClosedForm, Collect, Collector};
use crate::error::KinematicsError;
use crate::jacobian::Configuration;
use crate::joint::Joints;
use crate::posture::Posture;
use crate::singularity::SingularityDistances;
use crate::trig::{atan2, principal, sin_cos};
use nalgebra::{Isometry3, Matrix3, Rotation3, Vector2, Vector3};
#[cfg(not(feature = "std"))]
use num_traits::Float;
use std::f64::consts::PI;

/// Sine below which joint 6 is so badly determined by the pose that its error can put the elbow out of reach.
const NEARLY_SINGULAR: f64 = 1e-3;
/// Error of orientation that is taken as rounding, rad.
const ORIENTATION_ROUNDING: f64 = 1e-12;

/// The numbers of one arm with three parallel axes.
#[derive(Debug, Clone, Copy)]
pub struct ParallelAxes {
    /// The frame F and the wrist in the tool.
    plane: ArmPlane,
    /// A point of axis 2 in (u, v).
    axis2: Vector2<f64>,
    /// The links between the parallel axes.
    links: TwoLink,
    /// From axis 4 to W in (u, v) at zero.
    hand: Vector2<f64>,
    /// Direction of axis 5 in (u, v) at zero.
    axis5_angle: f64,
    cos_axis5: f64,
    sin_axis5: f64,
    /// The value of joint 5, negated, where axis 6 is parallel to n.
    wrist_zero: f64,
    /// True if axes 3 and 4 point along n (+1) or against it (-1).
    sign3: f64,
    sign4: f64,
    exact: bool,
}

/// One value of joint 1 and what the target looks like from link 1.
struct Shoulder {
    q1: f64,
    /// See [`FirstJoint::rounding`].
    rounding: f64,
    /// Orientation and wrist point in F, with joint 1 undone.
    orientation: Matrix3<f64>,
    wrist: Vector2<f64>,
}

impl ParallelAxes {
    /// Step 2: the two values of joint 5, or the free wrist.
    fn wrist_branches(&self, shoulder: &Shoulder, seed: &Joints<6>, found: &mut Collector<'_>, miss: &mut Miss) {
        let m = &shoulder.orientation;
        let sine = (m[(2, 0)] * m[(2, 0)] + m[(2, 1)] * m[(2, 1)]).sqrt();
        if sine < WRIST_SINGULAR {
            found.solutions().mark_wrist_singular();
            self.free_wrist(shoulder, seed, found, miss);
            return;
        }
        let (sin_c, cos_c) = (m[(2, 0)] / sine, m[(2, 1)] / sine);
        let b = atan2(sine, m[(2, 2)]);
        let c = atan2(sin_c, cos_c);
        let (sin_a, cos_a) = self.sum_of_parallel(m, sin_c, cos_c);
        let a = atan2(sin_a, cos_a);
        let phi = a - self.axis5_angle;
        let hand = self.turned_hand(sin_a, cos_a);
        let q5 = b - self.wrist_zero;
        let q6 = c + self.axis5_angle;
        let reach = shoulder.wrist - self.axis2;
        for (hand, phi, q5, q6) in [(hand, phi, q5, q6), (-hand, phi + PI, -b - self.wrist_zero, q6 + PI)] {
            if sine < NEARLY_SINGULAR {
                let turn = self.turn_into_reach(&reach, &hand);
                if turn != 0.0 && sine * turn.abs() < ORIENTATION_ROUNDING {
                    let end = reach - turned(&hand, turn);
                    let q6 = q6 - turn * m[(2, 2)].signum();
                    self.elbow_branches(&end, shoulder, [phi + turn, q5, q6], found, miss);
                    continue;
                }
            }
            if found.wants([(4, q5), (5, q6)]) {
                self.elbow_branches(&(reach - hand), shoulder, [phi, q5, q6], found, miss);
            }
        }
    }

    /// Sine and cosine of A once C is known: the first column of (Rz(A) Rx(B)), which does not depend on B.
    fn sum_of_parallel(&self, m: &Matrix3<f64>, sin_c: f64, cos_c: f64) -> (f64, f64) {
        (m[(1, 0)] * cos_c - m[(1, 1)] * sin_c, m[(0, 0)] * cos_c - m[(0, 1)] * sin_c)
    }

    /// The vector from axis 4 to the wrist, turned by A less the direction of axis 5.
    fn turned_hand(&self, sin_a: f64, cos_a: f64) -> Vector2<f64> {
        let sin = sin_a * self.cos_axis5 - cos_a * self.sin_axis5;
        let cos = cos_a * self.cos_axis5 + sin_a * self.sin_axis5;
        Vector2::new(cos * self.hand.x - sin * self.hand.y, sin * self.hand.x + cos * self.hand.y)
    }

    /// Axis 6 is parallel to n: joint 6 keeps its value from the seed, or the nearest one at which joints 2 to 4 reach.
    fn free_wrist(&self, shoulder: &Shoulder, seed: &Joints<6>, found: &mut Collector<'_>, miss: &mut Miss) {
        let m = &shoulder.orientation;
        let parallel = m[(2, 2)] > 0.0;
        let b = if parallel { 0.0 } else { PI };
        let ([sin_c], [cos_c]) = sin_cos(&[seed[5] - self.axis5_angle]);
        let (sin_a, cos_a) = self.sum_of_parallel(m, sin_c, cos_c);
        let phi = atan2(sin_a, cos_a) - self.axis5_angle;
        let hand = self.turned_hand(sin_a, cos_a);
        let reach = shoulder.wrist - self.axis2;
        let turn = self.turn_into_reach(&reach, &hand);
        let q6 = seed[5] - if parallel { turn } else { -turn };
        let end = reach - if turn == 0.0 { hand } else { turned(&hand, turn) };
        self.elbow_branches(&end, shoulder, [phi + turn, b - self.wrist_zero, q6], found, miss);
    }

    /// The least turn of `hand`, rad, after which joints 2 and 3 reach the point `reach - hand`; 0 if they do already.
    /// If no turn helps, the one that comes nearest.
    fn turn_into_reach(&self, reach: &Vector2<f64>, hand: &Vector2<f64>) -> f64 {
        // |reach - hand| depends on the angle between the two, and what joints 2 and 3 allow is symmetric about 0.
        let (upper_arm, forearm) = (self.links.upper_arm, self.links.forearm);
        let (max, min) = (upper_arm + forearm, (upper_arm - forearm).abs());
        let (length, product) = ((reach - hand).norm(), reach.norm() * hand.norm());
        if (min <= length && length <= max) || product == 0.0 {
            return 0.0;
        }
        let squares = reach.norm_squared() + hand.norm_squared();
        let angle_at = |length: f64| ((squares - length * length) / (2.0 * product)).clamp(-1.0, 1.0).acos();
        let angle = reach.perp(hand).atan2(reach.dot(hand));
        let allowed = if length < min { angle_at(min) } else { angle_at(max) };
        allowed.copysign(angle) - angle
    }

    /// Step 3: the planar two-link arm from axis 2 to axis 4, which is at `end` from axis 2.
    fn elbow_branches(
        &self,
        end: &Vector2<f64>,
        shoulder: &Shoulder,
        [phi, q5, q6]: [f64; 3],
        found: &mut Collector<'_>,
        miss: &mut Miss,
    ) {
        let q1 = shoulder.q1;
        self.links.solve(end, shoulder.rounding, miss, |q2, q3| {
            let q4 = phi - q2 - q3;
            let q = [q1, q2, q3 * self.sign3, q4 * self.sign4, q5, q6];
            found.push(Joints::from(q.map(principal)));
        });
    }
}

impl Collect for ParallelAxes {
    fn collect(
        &self,
        target: &Isometry3<f64>,
        seed: &Joints<6>,
        found: &mut Collector<'_>,
    ) -> Result<(), KinematicsError> {
        self.plane.solve(target, seed, found, |first, seen, found, miss| {
            self.wrist_branches(&undo_first(first, &seen.orientation, &seen.wrist), seed, found, miss);
        })
    }
}

impl ClosedForm for ParallelAxes {
    const FREE_JOINT: usize = 5;

    fn recognise(zero: &Configuration<6>) -> Result<Self, KinematicsError> {
        let (z, o) = (&zero.axes, &zero.points);
        let mut rules = Rules::new(zero)?;
        let mut rule = |rule: &'static str, deviation: f64| rules.hold(rule, deviation);
        let n = z[1];
        rule("axes 2 and 3 must be parallel", n.cross(&z[2]).norm())?;
        rule("axes 2 and 4 must be parallel", n.cross(&z[3]).norm())?;
        rule("axes 1 and 2 must be perpendicular", z[0].dot(&n).abs())?;
        rule("axes 4 and 5 must be perpendicular", z[4].dot(&n).abs())?;
        rule("axes 5 and 6 must be perpendicular", z[4].dot(&z[5]).abs())?;
        let between = o[5] - o[4];
        rule("axes 5 and 6 must meet", between.dot(&z[4].cross(&z[5])).abs())?;

        let wrist = o[4] + z[4] * z[4].dot(&between);
        let plane = ArmPlane::new(zero, &wrist);
        let axes: [Vector2<f64>; 3] = [o[1], o[2], o[3]].map(|point| plane.in_frame(&point).xy());
        let wrist_in_frame = plane.in_frame(&wrist);
        let (upper_arm, forearm) = (axes[1] - axes[0], axes[2] - axes[1]);
        rules.has_length("axes 2 and 3 must not coincide", upper_arm.norm())?;
        rules.has_length("axes 3 and 4 must not coincide", forearm.norm())?;

        let axis5 = plane.to_frame * z[4];
        let axis5_angle = axis5.y.atan2(axis5.x);
        let wrist_zero = z[5].dot(&z[4].cross(&n)).atan2(z[5].dot(&n));
        let axis5_in_frame = nalgebra::Unit::new_normalize(Vector3::new(axis5.x, axis5.y, 0.0));
        let to_singular = Rotation3::from_axis_angle(&axis5_in_frame, wrist_zero).into_inner();
        let tool_to_wrist = zero.rotation.transpose() * plane.to_frame.transpose() * to_singular;
        let hand = wrist_in_frame.xy() - axes[2];
        let size = upper_arm.norm() + forearm.norm() + hand.norm() + wrist_in_frame.z.abs() + axes[0].norm();
        Ok(Self {
            plane: plane.with_wrist(tool_to_wrist, size),
            axis2: axes[0],
            links: TwoLink::new(&upper_arm, &forearm, size),
            hand,
            axis5_angle,
            cos_axis5: axis5_angle.cos(),
            sin_axis5: axis5_angle.sin(),
            wrist_zero,
            sign3: z[2].dot(&n).signum(),
            sign4: z[3].dot(&n).signum(),
            exact: rules.exact(size),
        })
    }

    fn is_exact(&self) -> bool {
        self.exact
    }

    fn singularity_distances(&self, at: &Configuration<6>) -> SingularityDistances {
        let (z, o) = (&at.axes, &at.points);
        let wrist = o[4] + z[4] * z[4].dot(&(o[5] - o[4]));
        distances(at, &wrist, [&z[1], &z[5]], &o[3], self.plane.size)
    }

    fn posture(&self, at: &Configuration<6>) -> Posture {
        let (z, o) = (&at.axes, &at.points);
        let wrist = o[4] + z[4] * z[4].dot(&(o[5] - o[4]));
        Posture::of(at, &wrist, [&z[1], &z[5]], &o[3])
    }
}

fn turned(vector: &Vector2<f64>, by: f64) -> Vector2<f64> {
    let ([sin], [cos]) = sin_cos(&[by]);
    Vector2::new(cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y)
}

/// The target as seen from link 1.
fn undo_first(first: &FirstJoint, orientation: &Matrix3<f64>, wrist: &Vector3<f64>) -> Shoulder {
    let &FirstJoint { q, sin, cos, rounding } = first;
    let mut turned = *orientation;
    for column in 0..3 {
        let (x, z) = (orientation[(0, column)], orientation[(2, column)]);
        turned[(0, column)] = cos * x - sin * z;
        turned[(2, column)] = sin * x + cos * z;
    }
    Shoulder { q1: q, rounding, orientation: turned, wrist: Vector2::new(cos * wrist.x - sin * wrist.z, wrist.y) }
}
