//! The two recursions of rigid-body dynamics, in the frames of the links.
//!
//! Both run over the chain in the form of [`Normalised`]: every joint turns about or slides along its own z, and
//! successive frames differ by a turn about x, so a vector changes frame for 8 multiplications.

use super::inertial::{Moments, Second};
use crate::{
    joint::{JointKind, Joints},
    normalised::{Link, Normalised},
};
use nalgebra::{SMatrix, Vector3};

/// The change of frame at one joint for one joint value.
#[derive(Clone, Copy)]
struct Step {
    sin: f64,
    cos: f64,
    sin_alpha: f64,
    cos_alpha: f64,
    /// From the frame before to this one, m, in the frame before.
    offset: Vector3<f64>,
}

impl Step {
    /// `slide` is the value of a prismatic joint, m.
    #[inline(always)]
    fn new(link: &Link, sin: f64, cos: f64, slide: f64) -> Self {
        let (sin_alpha, cos_alpha) = (link.sin_alpha, link.cos_alpha);
        let mut offset = link.translation;
        if link.kind == JointKind::Prismatic {
            offset.y -= sin_alpha * slide;
            offset.z += cos_alpha * slide;
        }
        Self { sin, cos, sin_alpha, cos_alpha, offset }
    }

    /// A vector of the frame before, in this frame.
    #[inline(always)]
    fn inwards(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let y = self.cos_alpha * v.y + self.sin_alpha * v.z;
        let z = self.cos_alpha * v.z - self.sin_alpha * v.y;
        Vector3::new(self.cos * v.x + self.sin * y, self.cos * y - self.sin * v.x, z)
    }

    /// A vector of this frame, in the frame before.
    #[inline(always)]
    fn outwards(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let x = self.cos * v.x - self.sin * v.y;
        let y = self.sin * v.x + self.cos * v.y;
        Vector3::new(x, self.cos_alpha * y - self.sin_alpha * v.z, self.sin_alpha * y + self.cos_alpha * v.z)
    }

    /// A force and its moment about the origin of this frame, in the frame before and about its origin.
    #[inline(always)]
    fn inboard(&self, v: &Wrench) -> Wrench {
        let blend = |a: f64, u: &[f64; 2], b: f64, v: &[f64; 2]| [a * u[0] + b * v[0], a * u[1] + b * v[1]];
        let x = blend(self.cos, &v.x, -self.sin, &v.y);
        let turned = blend(self.sin, &v.x, self.cos, &v.y);
        let y = blend(self.cos_alpha, &turned, -self.sin_alpha, &v.z);
        let z = blend(self.sin_alpha, &turned, self.cos_alpha, &v.z);
        let t = &self.offset;
        Wrench {
            x: [x[0], x[1] + (t.y * z[0] - t.z * y[0])],
            y: [y[0], y[1] + (t.z * x[0] - t.x * z[0])],
            z: [z[0], z[1] + (t.x * y[0] - t.y * x[0])],
        }
    }

    /// The z of [`Step::inboard`].
    #[inline(always)]
    fn inboard_z(&self, v: &Wrench) -> [f64; 2] {
        let y = [self.sin * v.x[0] + self.cos * v.y[0], self.sin * v.x[1] + self.cos * v.y[1]];
        let force_x = self.cos * v.x[0] - self.sin * v.y[0];
        let force_y = self.cos_alpha * y[0] - self.sin_alpha * v.z[0];
        let z = [self.sin_alpha * y[0] + self.cos_alpha * v.z[0], self.sin_alpha * y[1] + self.cos_alpha * v.z[1]];
        [z[0], z[1] + (self.offset.x * force_y - self.offset.y * force_x)]
    }

    /// Moments of a body of this frame, in the frame before.
    #[inline(always)]
    fn carried(&self, body: &Moments) -> Moments {
        let s = &body.second;
        // Turned about z, ...
        let (c, n) = (self.cos, self.sin);
        let (xx, xy, yy) = turned_plane(s.xx, s.xy, s.yy, c, n);
        let (xz, yz) = (c * s.xz - n * s.yz, n * s.xz + c * s.yz);
        // ... about x, ...
        let (c, n) = (self.cos_alpha, self.sin_alpha);
        let (yy, yz, zz) = turned_plane(yy, yz, s.zz, c, n);
        let turned = Second { xx, xy: c * xy - n * xz, xz: n * xy + c * xz, yy, yz, zz };
        // ... and moved: J + t h^T + h t^T + m t t^T, with half of the last term in each product.
        let (t, h) = (&self.offset, self.outwards(&body.first));
        let g = h + t * (0.5 * body.mass);
        Moments {
            mass: body.mass,
            first: h + t * body.mass,
            second: Second {
                xx: turned.xx + 2.0 * t.x * g.x,
                xy: turned.xy + t.x * g.y + t.y * g.x,
                xz: turned.xz + t.x * g.z + t.z * g.x,
                yy: turned.yy + 2.0 * t.y * g.y,
                yz: turned.yz + t.y * g.z + t.z * g.y,
                zz: turned.zz + 2.0 * t.z * g.z,
            },
        }
    }
}

/// The entries xx, xy, yy of a symmetric matrix after a turn with cosine `c` and sine `n` in the plane of x and y.
#[inline(always)]
fn turned_plane(xx: f64, xy: f64, yy: f64, c: f64, n: f64) -> (f64, f64, f64) {
    let k = n * (yy - xx) - c * (xy + xy);
    (xx + n * k, -xy - c * k, yy - n * k)
}

/// A force and a moment, side by side: the processor turns both at once.
#[derive(Clone, Copy)]
struct Wrench {
    x: [f64; 2],
    y: [f64; 2],
    z: [f64; 2],
}

/// The acceleration of the points of a link about its origin: A r at r, A = [w']x + [w]x [w]x.
struct Swirl([[f64; 3]; 3]);

impl Swirl {
    #[inline(always)]
    fn new(w: &Vector3<f64>, a: &Vector3<f64>) -> Self {
        let (xx, yy, zz) = (w.x * w.x, w.y * w.y, w.z * w.z);
        let (xy, xz, yz) = (w.x * w.y, w.x * w.z, w.y * w.z);
        Self([[-yy - zz, xy - a.z, xz + a.y], [xy + a.z, -xx - zz, yz - a.x], [xz - a.y, yz + a.x, -xx - yy]])
    }

    #[inline(always)]
    fn times(&self, r: &Vector3<f64>) -> Vector3<f64> {
        let row = |a: &[f64; 3]| a[0] * r.x + a[1] * r.y + a[2] * r.z;
        Vector3::new(row(&self.0[0]), row(&self.0[1]), row(&self.0[2]))
    }

    /// The moment about the origin that the acceleration of a body asks for: the skew part of A J.
    #[inline(always)]
    fn moment(&self, s: &Second) -> Vector3<f64> {
        let [a, b, c] = &self.0;
        let by_x = |r: &[f64; 3]| r[0] * s.xx + r[1] * s.xy + r[2] * s.xz;
        let by_y = |r: &[f64; 3]| r[0] * s.xy + r[1] * s.yy + r[2] * s.yz;
        let by_z = |r: &[f64; 3]| r[0] * s.xz + r[1] * s.yz + r[2] * s.zz;
        Vector3::new(by_y(c) - by_z(b), by_z(a) - by_x(c), by_x(b) - by_y(a))
    }
}

/// Recursive Newton-Euler: the joint torques (forces) of a motion. `lift` is the acceleration of the base, against
/// gravity, along the axes of the chain's start frame.
pub(super) fn newton_euler<const N: usize>(
    chain: &Normalised<N>,
    bodies: &[Moments; N],
    turns: &([f64; N], [f64; N]),
    (q, qd, qdd): (&Joints<N>, &Joints<N>, &Joints<N>),
    lift: &Vector3<f64>,
) -> Joints<N> {
    let zero = Vector3::zeros();
    let mut steps = [Step { sin: 0.0, cos: 1.0, sin_alpha: 0.0, cos_alpha: 1.0, offset: zero }; N];
    let (mut forces, mut moments) = ([zero; N], [zero; N]);
    let (mut w, mut a, mut lin) = (zero, zero, *lift);
    let mut before = Swirl([[0.0; 3]; 3]);
    for i in 0..N {
        let link = &chain.links[i];
        let step = Step::new(link, turns.0[i], turns.1[i], q[i]);
        lin = step.inwards(&(lin + before.times(&step.offset)));
        w = step.inwards(&w);
        a = step.inwards(&a);
        match link.kind {
            JointKind::Revolute => {
                a.x += w.y * qd[i];
                a.y -= w.x * qd[i];
                a.z += qdd[i];
                w.z += qd[i];
            }
            JointKind::Prismatic => {
                lin.x += 2.0 * w.y * qd[i];
                lin.y -= 2.0 * w.x * qd[i];
                lin.z += qdd[i];
            }
        }
        let body = &bodies[i];
        let swirl = Swirl::new(&w, &a);
        forces[i] = lin * body.mass + swirl.times(&body.first);
        moments[i] = swirl.moment(&body.second) + body.first.cross(&lin);
        steps[i] = step;
        before = swirl;
    }
    let mut torque = Joints::zeros();
    let (mut force, mut moment) = (zero, zero);
    for i in (0..N).rev() {
        force += forces[i];
        moment += moments[i];
        torque[i] = match chain.links[i].kind {
            JointKind::Revolute => moment.z,
            JointKind::Prismatic => force.z,
        };
        if i > 0 {
            force = steps[i].outwards(&force);
            moment = steps[i].outwards(&moment) + steps[i].offset.cross(&force);
        }
    }
    torque
}

/// Composite rigid bodies: the mass matrix, without rotors.
pub(super) fn composite_bodies<const N: usize>(
    chain: &Normalised<N>,
    bodies: &[Moments; N],
    turns: &([f64; N], [f64; N]),
    q: &Joints<N>,
) -> SMatrix<f64, N, N> {
    let mut matrix = SMatrix::<f64, N, N>::zeros();
    let Some(mut composite) = bodies.last().copied() else { return matrix };
    let steps: [Step; N] = std::array::from_fn(|i| Step::new(&chain.links[i], turns.0[i], turns.1[i], q[i]));
    for i in (0..N).rev() {
        let h = &composite.first;
        let s = &composite.second;
        // Force and moment that a unit acceleration of joint i asks for, carried inwards.
        let mut wrench = match chain.links[i].kind {
            JointKind::Revolute => Wrench { x: [-h.y, -s.xz], y: [h.x, -s.yz], z: [0.0, s.xx + s.yy] },
            JointKind::Prismatic => Wrench { x: [0.0, h.y], y: [0.0, -h.x], z: [composite.mass, 0.0] },
        };
        for j in (0..=i).rev() {
            let entry = wrench.z[usize::from(chain.links[j].kind == JointKind::Revolute)];
            matrix[(i, j)] = entry;
            matrix[(j, i)] = entry;
            if j > 1 {
                wrench = steps[j].inboard(&wrench);
            } else if j == 1 {
                // Nothing follows the first joint: only its own entry is wanted.
                wrench.z = steps[1].inboard_z(&wrench);
            }
        }
        if i > 0 {
            composite = bodies[i - 1].plus(&steps[i].carried(&composite));
        }
    }
    matrix
}
