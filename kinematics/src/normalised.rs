//! The form of a chain in which its arithmetic is cheapest.

use crate::{
    jacobian::Configuration,
    joint::{Joint, JointKind, Joints},
    trig::sin_cos,
};
use nalgebra::{Isometry3, Matrix3, Vector3};
#[cfg(not(feature = "std"))]
use num_traits::Float;

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
    /// `end` and the two turns of `start.rotation`, as [`Normalised::tool`] takes them.
    end_rows: Rows,
    first: Option<Turn>,
    second: AboutX,
}

/// A turn about x by a constant angle. Most arms have none but quarter turns, which need no arithmetic.
#[derive(Debug, Clone, Copy)]
enum AboutX {
    None,
    Quarter,
    Half,
    QuarterBack,
    Any(Turn),
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
    turn: AboutX,
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
            turn: AboutX::None,
            offset: 0.0,
            kind: joint.kind(),
        });
        let mut carried = Frame::new(base);
        let mut frames = [Matrix3::identity(); N];
        let (mut start_first, mut start_second) = (None, AboutX::None);
        for i in 0..N {
            let to_z = rotation_from_z_to(joints[i].axis());
            let mut step = carried.then(&Frame::new(joints[i].origin()));
            step.rotation *= to_z;
            let (first, alpha, second) = zxz(&step.rotation);
            links[i].offset = second.angle();
            if i == 0 {
                start.rotation = first.about_z() * alpha.about_x();
                start.translation = step.translation;
                start_first = (first.sin != 0.0 || first.cos < 0.0).then_some(first);
                start_second = AboutX::new(alpha);
            } else {
                links[i - 1].offset += first.angle();
                frames[i - 1] *= first.about_z();
                links[i].translation = first.about_z().transpose() * step.translation;
                links[i].cos_alpha = alpha.cos;
                links[i].sin_alpha = alpha.sin;
                links[i].turn = AboutX::new(alpha);
            }
            frames[i] = to_z;
            carried = Frame { rotation: to_z.transpose(), translation: Vector3::zeros() };
        }
        let end = carried.then(&Frame::new(end));
        let row = |r: usize| Row { x_y: [end.rotation[(r, 0)], end.rotation[(r, 1)]], position: end.translation[r] };
        let form = Self {
            start,
            links,
            end,
            kinds: joints.map(|joint| joint.kind()),
            end_rows: [row(0), row(1), row(2)],
            first: start_first,
            second: start_second,
        };
        (form, frames)
    }

    /// Sines and cosines of the turns about z.
    #[inline]
    pub(crate) fn turns(&self, q: &Joints<N>) -> ([f64; N], [f64; N]) {
        sin_cos(&std::array::from_fn::<f64, N, _>(|i| {
            let link = &self.links[i];
            link.offset + if link.kind == JointKind::Revolute { q[i] } else { 0.0 }
        }))
    }

    /// The tool alone: a walk from the tool to the base. A turn about z is then the same sum of two rows for orientation
    /// and position, and the place of the tool in its last frame costs nothing.
    #[inline]
    pub(crate) fn tool(&self, q: &Joints<N>) -> (Matrix3<f64>, Vector3<f64>) {
        let (sines, cosines) = self.turns(q);
        let mut rows = self.end_rows;
        for i in (0..N).rev() {
            let link = &self.links[i];
            turn_rows(&mut rows, sines[i], cosines[i]);
            if link.kind == JointKind::Prismatic {
                rows[2].position += q[i];
            }
            if i > 0 {
                link.turn.rows(&mut rows);
                rows[0].position += link.translation.x;
                rows[1].position += link.translation.y;
                rows[2].position += link.translation.z;
            }
        }
        self.second.rows(&mut rows);
        if let Some(first) = self.first {
            turn_rows(&mut rows, first.sin, first.cos);
        }
        let [a, b, c] = &rows;
        let x = Vector3::new(a.x_y[0], b.x_y[0], c.x_y[0]);
        let y = Vector3::new(a.x_y[1], b.x_y[1], c.x_y[1]);
        let position = Vector3::new(a.position, b.position, c.position) + self.start.translation;
        (Matrix3::from_columns(&[x, y, x.cross(&y)]), position)
    }

    /// The tool, and the axis and a point of every joint: a walk from the base to the tool.
    #[inline]
    pub(crate) fn configuration(&self, q: &Joints<N>) -> Configuration<N> {
        let (sines, cosines) = self.turns(q);
        let mut x: Vector3<f64> = self.start.rotation.column(0).into();
        let mut y: Vector3<f64> = self.start.rotation.column(1).into();
        let mut z: Vector3<f64> = self.start.rotation.column(2).into();
        let mut p = self.start.translation;
        let (mut axes, mut points) = ([Vector3::zeros(); N], [Vector3::zeros(); N]);
        for i in 0..N {
            let link = &self.links[i];
            if i > 0 {
                let t = &link.translation;
                p += x * t.x + y * t.y + z * t.z;
                match link.turn {
                    AboutX::None => {}
                    AboutX::Quarter => (y, z) = (z, -y),
                    AboutX::Half => (y, z) = (-y, -z),
                    AboutX::QuarterBack => (y, z) = (-z, y),
                    AboutX::Any(Turn { cos, sin }) => (y, z) = (y * cos + z * sin, z * cos - y * sin),
                }
            }
            (axes[i], points[i]) = (z, p);
            if link.kind == JointKind::Prismatic {
                p += z * q[i];
            }
            (x, y) = (x * cosines[i] + y * sines[i], y * cosines[i] - x * sines[i]);
        }
        let turned = Matrix3::from_columns(&[x, y, z]);
        let (rotation, tool) = (turned * self.end.rotation, p + turned * self.end.translation);
        Configuration { rotation, tool, axes, points, kinds: self.kinds }
    }
}

/// A place by rows, its z left out.
type Rows = [Row; 3];

/// One coordinate of the x axis, of the y axis and of the position.
#[derive(Debug, Clone, Copy)]
struct Row {
    x_y: [f64; 2],
    position: f64,
}

impl Row {
    /// `a * u + b * v`.
    #[inline(always)]
    fn blend(a: f64, u: &Self, b: f64, v: &Self) -> Self {
        Self {
            x_y: [a * u.x_y[0] + b * v.x_y[0], a * u.x_y[1] + b * v.x_y[1]],
            position: a * u.position + b * v.position,
        }
    }

    #[inline(always)]
    fn opposite(&self) -> Self {
        Self { x_y: [-self.x_y[0], -self.x_y[1]], position: -self.position }
    }
}

/// `rows` turned about z.
#[inline(always)]
fn turn_rows(rows: &mut Rows, sin: f64, cos: f64) {
    let [a, b, _] = *rows;
    (rows[0], rows[1]) = (Row::blend(cos, &a, -sin, &b), Row::blend(sin, &a, cos, &b));
}

impl AboutX {
    /// Angles that differ from a quarter turn by rounding are taken as one.
    fn new(turn: Turn) -> Self {
        const ROUNDING: f64 = 4.0 * f64::EPSILON;
        match turn {
            Turn { cos, sin: 0.0 } => {
                if cos > 0.0 {
                    Self::None
                } else {
                    Self::Half
                }
            }
            Turn { cos, sin } if cos.abs() <= ROUNDING => {
                if sin > 0.0 {
                    Self::Quarter
                } else {
                    Self::QuarterBack
                }
            }
            any => Self::Any(any),
        }
    }

    /// `rows` turned about x.
    #[inline(always)]
    fn rows(self, rows: &mut Rows) {
        let [_, b, c] = *rows;
        match self {
            Self::None => {}
            Self::Quarter => (rows[1], rows[2]) = (c.opposite(), b),
            Self::Half => (rows[1], rows[2]) = (b.opposite(), c.opposite()),
            Self::QuarterBack => (rows[1], rows[2]) = (c, b.opposite()),
            Self::Any(Turn { cos, sin }) => {
                (rows[1], rows[2]) = (Row::blend(cos, &b, -sin, &c), Row::blend(sin, &b, cos, &c));
            }
        }
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
