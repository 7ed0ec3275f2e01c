//! The form of a chain in which its arithmetic is cheapest.

use crate::{
    jacobian::Configuration,
    joint::{Joint, JointKind, Joints},
    trig::sin_cos,
};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// The chain rewritten so that every joint moves about or along +z and successive axes differ by a turn about x only:
/// `start * Rz(q_1 + offset_1) * [t_2, Rx(alpha_2)] * Rz(q_2 + offset_2) * ... * end`.
///
/// Any rotation is Rz Rx Rz, and the two Rz merge into the joints beside it; the offsets t stay full vectors, so unlike
/// Denavit-Hartenberg parameters this is well conditioned for nearly parallel axes too. It replaces the 27
/// multiplications of a matrix product by 8 per joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normalised<const N: usize> {
    pub(crate) start: Frame,
    pub(crate) links: [Link; N],
    pub(crate) end: Frame,
    kinds: [JointKind; N],
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) translation: Vector3<f64>,
}

/// From the frame of the joint before to this joint (the first one's is in `start`).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Link {
    pub(crate) translation: Vector3<f64>,
    pub(crate) cos_alpha: f64,
    pub(crate) sin_alpha: f64,
    /// alpha = 0, as between the parallel axes of many arms: nothing to turn.
    parallel: bool,
    /// Added to a revolute joint's value, the constant angle of a prismatic one.
    pub(crate) offset: f64,
    pub(crate) kind: JointKind,
}

impl Frame {
    fn new(pose: &Isometry3<f64>) -> Self {
        Self { rotation: pose.rotation.to_rotation_matrix().into_inner(), translation: pose.translation.vector }
    }

    fn then(&self, next: &Self) -> Self {
        Self {
            rotation: self.rotation * next.rotation,
            translation: self.translation + self.rotation * next.translation,
        }
    }
}

/// Sine of the angle between two axes below which they count as parallel: a little above the rounding of a product of
/// rotations.
const PARALLEL: f64 = 1e-14;

impl<const N: usize> Normalised<N> {
    /// The chain in this form, and the orientation of each of its link frames in the frame of that link's joint.
    pub(crate) fn new(base: &Isometry3<f64>, joints: &[Joint; N], end: &Isometry3<f64>) -> (Self, [Matrix3<f64>; N]) {
        let mut start = Frame::new(&Isometry3::identity());
        let mut links = joints.map(|joint| Link {
            translation: Vector3::zeros(),
            cos_alpha: 1.0,
            sin_alpha: 0.0,
            parallel: true,
            offset: 0.0,
            kind: joint.kind(),
        });
        let mut carried = Frame::new(base);
        let mut frames = [Matrix3::identity(); N];
        for i in 0..N {
            let to_z = rotation_from_z_to(joints[i].axis());
            let mut step = carried.then(&Frame::new(joints[i].origin()));
            step.rotation *= to_z;
            let (first, alpha, second) = zxz(&step.rotation);
            links[i].offset = second.angle();
            if i == 0 {
                start.rotation = first.about_z() * alpha.about_x();
                start.translation = step.translation;
            } else {
                links[i - 1].offset += first.angle();
                frames[i - 1] *= first.about_z();
                links[i].translation = first.about_z().transpose() * step.translation;
                links[i].cos_alpha = alpha.cos;
                links[i].sin_alpha = alpha.sin;
                links[i].parallel = alpha.sin == 0.0 && alpha.cos > 0.0;
            }
            frames[i] = to_z;
            carried = Frame { rotation: to_z.transpose(), translation: Vector3::zeros() };
        }
        let end = carried.then(&Frame::new(end));
        (Self { start, links, end, kinds: joints.map(|joint| joint.kind()) }, frames)
    }

    /// Sines and cosines of the turns about z.
    #[inline]
    pub(crate) fn turns(&self, q: &Joints<N>) -> ([f64; N], [f64; N]) {
        sin_cos(&std::array::from_fn::<f64, N, _>(|i| {
            let link = &self.links[i];
            link.offset + if link.kind == JointKind::Revolute { q[i] } else { 0.0 }
        }))
    }

    /// Orientation and position of the tool; `joint` is told the index, axis and a point of every joint on the way.
    #[inline(always)]
    fn walk(
        &self,
        q: &Joints<N>,
        mut joint: impl FnMut(usize, Vector3<f64>, Vector3<f64>),
    ) -> (Matrix3<f64>, Vector3<f64>) {
        let (sines, cosines) = self.turns(q);
        let mut x: Vector3<f64> = self.start.rotation.column(0).into();
        let mut y: Vector3<f64> = self.start.rotation.column(1).into();
        let mut z: Vector3<f64> = self.start.rotation.column(2).into();
        let mut p = self.start.translation;
        for i in 0..N {
            let link = &self.links[i];
            if i > 0 {
                let t = &link.translation;
                p += x * t.x + y * t.y + z * t.z;
                if !link.parallel {
                    (y, z) = (y * link.cos_alpha + z * link.sin_alpha, z * link.cos_alpha - y * link.sin_alpha);
                }
            }
            joint(i, z, p);
            if link.kind == JointKind::Prismatic {
                p += z * q[i];
            }
            (x, y) = (x * cosines[i] + y * sines[i], y * cosines[i] - x * sines[i]);
        }
        let rotation = Matrix3::from_columns(&[x, y, z]);
        (rotation * self.end.rotation, p + rotation * self.end.translation)
    }

    /// The tool alone, nothing of the joints kept.
    #[inline]
    pub(crate) fn tool(&self, q: &Joints<N>) -> (Matrix3<f64>, Vector3<f64>) {
        self.walk(q, |_, _, _| {})
    }

    #[inline]
    pub(crate) fn configuration(&self, q: &Joints<N>) -> Configuration<N> {
        let (mut axes, mut points) = ([Vector3::zeros(); N], [Vector3::zeros(); N]);
        let (rotation, tool) = self.walk(q, |i, axis, point| {
            axes[i] = axis;
            points[i] = point;
        });
        Configuration { rotation, tool, axes, points, kinds: self.kinds }
    }
}

/// Cosine and sine of an angle, kept as such because they are exact where the angle is not (pi/2).
#[derive(Debug, Clone, Copy)]
struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    fn angle(self) -> f64 {
        self.sin.atan2(self.cos)
    }

    fn about_x(self) -> Matrix3<f64> {
        Matrix3::new(1.0, 0.0, 0.0, 0.0, self.cos, -self.sin, 0.0, self.sin, self.cos)
    }

    fn about_z(self) -> Matrix3<f64> {
        Matrix3::new(self.cos, -self.sin, 0.0, self.sin, self.cos, 0.0, 0.0, 0.0, 1.0)
    }
}

/// The turns of `r = Rz(first) Rx(alpha) Rz(second)`, with cos(first) >= 0.
fn zxz(r: &Matrix3<f64>) -> (Turn, Turn, Turn) {
    let sine = r[(0, 2)].hypot(r[(1, 2)]);
    let (first, alpha) = if sine < PARALLEL {
        (Turn { cos: 1.0, sin: 0.0 }, Turn { cos: r[(2, 2)].signum(), sin: 0.0 })
    } else {
        // Of the two ways to write it, the one that adds no half turn to the joint before.
        let sine = if r[(1, 2)] > 0.0 { -sine } else { sine };
        (Turn { cos: -r[(1, 2)] / sine, sin: r[(0, 2)] / sine }, Turn { cos: r[(2, 2)], sin: sine })
    };
    // The second turn is what the first two leave over, not read from the last row: for nearly parallel axes the two
    // would each be undetermined and only their sum is not.
    let rest = (first.about_z() * alpha.about_x()).transpose() * r;
    (first, alpha, Turn { cos: rest[(0, 0)], sin: rest[(1, 0)] })
}

/// A rotation that takes z to `axis`; exact for the six coordinate directions.
fn rotation_from_z_to(axis: &Vector3<f64>) -> Matrix3<f64> {
    let sine = axis.x.hypot(axis.y);
    if sine == 0.0 {
        let z = axis.z.signum();
        return Matrix3::new(1.0, 0.0, 0.0, 0.0, z, 0.0, 0.0, 0.0, z);
    }
    let azimuth = Turn { cos: axis.x / sine, sin: axis.y / sine };
    let (c, s) = (axis.z, sine);
    let tilt = Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
    azimuth.about_z() * tilt
}
