//! The common parts of the closed forms: joint 1, whose axis is perpendicular to those of joints 2 and 3, and the planar two-link
//! arm of joints 2 and 3.
//!
//! Both work in the frame F = (u, v, n): v along axis 1, n along axis 2, u = v x n, origin on axis 1.

use super::Collector;
use crate::{
    error::{KinematicsError, ReachSide},
    jacobian::Configuration,
    trig::{atan2, sin_cos},
};
use nalgebra::{Matrix3, Vector2, Vector3};
#[cfg(not(feature = "std"))]
use num_traits::Float;
use std::f64::consts::PI;

/// Excess of reach, relative to the arm's size, that is taken as rounding and clamped, ...
const REACH_ROUNDING: f64 = 1e-12;
/// ... and the most of it where a point near axis 1 enlarges the rounding, ...
const ENLARGED_ROUNDING: f64 = 1e-10;
/// ... which is this for coordinates of the target.
const ROUNDING: f64 = 1e-15;
/// Distance from a double root, relative to the arm's size, below which the two roots are one: the root itself is
/// then accurate where its square root is noise.
const DOUBLE_ROOT: f64 = 1e-14;

/// The least miss over all branches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Miss {
    distance: f64,
    side: ReachSide,
}

impl Miss {
    fn none() -> Self {
        Self { distance: f64::INFINITY, side: ReachSide::TooFar }
    }

    pub(super) fn note(&mut self, distance: f64, side: ReachSide) {
        if distance < self.distance {
            *self = Self { distance, side };
        }
    }
}

/// The frame F of an arm that looks like `zero` at zero joint values: base to F, transposed.
pub(super) fn plane_of_arm(zero: &Configuration<6>) -> Matrix3<f64> {
    let (v, n) = (&zero.axes[0], &zero.axes[1]);
    let u = v.cross(n).normalize();
    Matrix3::from_columns(&[u, *v, u.cross(v)]).transpose()
}

/// One value of joint 1, its sine and its cosine.
#[derive(Debug, Clone, Copy)]
pub(super) struct FirstJoint {
    pub(super) q: f64,
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// Rounding of the point in the plane of the arm, m: near axis 1 that of the target is enlarged.
    pub(super) rounding: f64,
}

/// The values of joint 1 that put a point at the offset it has from the plane of the arm.
enum FirstJoints {
    /// The point is on the axis and without offset: any value will do.
    Free,
    /// The point is inside the offset, by this much, m.
    TooNear(f64),
    Two([FirstJoint; 2]),
    /// The point is at the offset but for rounding; should that give nothing, the two values that rounding makes of it.
    Double(FirstJoint, Option<[FirstJoint; 2]>),
}

impl FirstJoint {
    /// At `q`, for a point on axis 1.
    fn at(q: f64, size: f64) -> Self {
        let ([sin], [cos]) = sin_cos(&[q]);
        Self { q, sin, cos, rounding: REACH_ROUNDING * size }
    }
}

impl FirstJoints {
    /// For a `point` in F that is to have n-coordinate `offset` once joint 1 is undone, on an arm of size `size` (m).
    #[inline]
    fn new(point: &Vector3<f64>, offset: f64, size: f64) -> Self {
        let d = offset;
        let r = (point.x * point.x + point.z * point.z).sqrt();
        let slack = r - d.abs();
        if r <= REACH_ROUNDING * size && d.abs() <= REACH_ROUNDING * size {
            return Self::Free;
        }
        if slack < -REACH_ROUNDING * size {
            return Self::TooNear(-slack);
        }
        let root = (slack * (r + d.abs())).max(0.0).sqrt();
        let middle = atan2(point.x, point.z);
        let rounding = (ROUNDING * size * size / root).min(ENLARGED_ROUNDING * size).max(REACH_ROUNDING * size);
        let branch = |side: f64, root: f64| {
            let half = atan2(root, d);
            let cos = (point.z * d - side * point.x * root) / (r * r);
            let sin = (point.x * d + side * point.z * root) / (r * r);
            FirstJoint { q: middle + side * half, sin, cos, rounding }
        };
        if slack <= DOUBLE_ROOT * size {
            let split = (root > 0.0).then(|| [branch(1.0, root), branch(-1.0, root)]);
            return Self::Double(branch(1.0, 0.0), split);
        }
        Self::Two([branch(1.0, root), branch(-1.0, root)])
    }
}

/// The solutions that `each` finds for every wanted value of joint 1, see [`FirstJoints::new`]. Where joint 1 is free it stands at
/// `free`.
///
/// # Errors
/// [`KinematicsError::Unreachable`] by the least miss that was noted, if there are none.
#[inline(always)]
pub(super) fn for_first_joints(
    point: &Vector3<f64>,
    offset: f64,
    size: f64,
    free: f64,
    found: &mut Collector<'_>,
    mut each: impl FnMut(&FirstJoint, &mut Collector<'_>, &mut Miss),
) -> Result<(), KinematicsError> {
    let mut miss = Miss::none();
    let mut all = |two: &[FirstJoint], found: &mut Collector<'_>| {
        for first in two {
            if found.wants([(0, first.q)]) {
                each(first, found, &mut miss);
            }
        }
    };
    match FirstJoints::new(point, offset, size) {
        FirstJoints::Free => {
            found.solutions().mark_shoulder_singular();
            all(&[FirstJoint::at(free, size)], found);
        }
        FirstJoints::TooNear(distance) => miss.note(distance, ReachSide::TooNear),
        // The nearer one first, so that the other one may not be wanted.
        FirstJoints::Two([first, second]) if found.is_second_nearer(0, [first.q, second.q]) => {
            all(&[second], found);
            let nearer = found.solutions().len();
            all(&[first], found);
            // In the same order as all of them.
            found.solutions().rotate_left(nearer);
        }
        FirstJoints::Two(two) => all(&two, found),
        FirstJoints::Double(one, split) => {
            all(&[one], found);
            if let (true, Some(two)) = (found.solutions().is_empty(), split) {
                all(&two, found);
            }
        }
    }
    if !found.solutions().is_empty() {
        return Ok(());
    }
    if !miss.distance.is_finite() {
        return Err(KinematicsError::NotFinite { what: "the target's distance" });
    }
    Err(KinematicsError::Unreachable { distance: miss.distance, side: miss.side })
}

/// The planar arm of joints 2 and 3, in the (u, v) of F.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoLink {
    pub(super) upper_arm: f64,
    pub(super) forearm: f64,
    /// Direction of the upper arm, and of the forearm against it, at zero joint values.
    upper_arm_angle: f64,
    elbow_angle: f64,
    /// Distance from a double root, m, that is none.
    double: f64,
}

impl TwoLink {
    /// From the two links at zero joint values, on an arm of size `size` (m).
    pub(super) fn new(upper_arm: &Vector2<f64>, forearm: &Vector2<f64>, size: f64) -> Self {
        let angle = |vector: &Vector2<f64>| vector.y.atan2(vector.x);
        Self {
            upper_arm: upper_arm.norm(),
            forearm: forearm.norm(),
            upper_arm_angle: angle(upper_arm),
            elbow_angle: angle(forearm) - angle(upper_arm),
            double: DOUBLE_ROOT * size,
        }
    }

    /// Calls `found` with the turns about n of joint 2 and of joint 3 for each way to put the arm's end at `end` (m from
    /// axis 2). A miss by `rounding` (m) is none.
    #[inline]
    pub(super) fn solve(&self, end: &Vector2<f64>, rounding: f64, miss: &mut Miss, mut found: impl FnMut(f64, f64)) {
        let (l2, l3) = (self.upper_arm, self.forearm);
        let length = end.norm();
        let (far, near) = (l2 + l3 - length, length - (l2 - l3).abs());
        // A target so far away that squares overflow gives NaN, which counts as a miss.
        if far < -rounding || far.is_nan() {
            return miss.note(-far, ReachSide::TooFar);
        }
        if near < -rounding {
            return miss.note(-near, ReachSide::TooNear);
        }
        let direction = atan2(end.y, end.x) - self.upper_arm_angle;
        if far <= self.double {
            found(direction, -self.elbow_angle);
        } else if near <= self.double {
            found(if l2 >= l3 { direction } else { direction - PI }, PI - self.elbow_angle);
        } else {
            // 1 - cos and 1 + cos of the elbow angle, each without cancellation.
            let scale = 1.0 / (2.0 * l2 * l3);
            let less = far * (l2 + l3 + length) * scale;
            let more = near * (length + (l2 - l3).abs()) * scale;
            let sin = (less * more).max(0.0).sqrt();
            let cos = if less < 1.0 { 1.0 - less } else { more - 1.0 };
            let elbow = atan2(sin, cos);
            let offset = atan2(l3 * sin, l2 + l3 * cos);
            found(direction - offset, elbow - self.elbow_angle);
            found(direction + offset, -elbow - self.elbow_angle);
        }
    }
}
