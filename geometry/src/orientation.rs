//! Tool orientation along a path: constant, through given orientations, or following the tangent.

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use crate::arc_length::ArcLengthCurve;
use crate::error::GeometryError;
use crate::spline::CubicSpline;

/// Most knots a heading is given before it is refused as too rough.
const MAX_HEADING_KNOTS: usize = 100_000;

/// An orientation with its angular rate and the rate's derivatives, all by arc length and in base axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientationJet {
    /// Rotation from tool axes to base axes.
    pub rotation: UnitQuaternion<f64>,
    /// Rotation vector per unit of arc length (rad/m): times the feed rate, the angular velocity.
    pub rate: Vector3<f64>,
    /// First derivative of the rate by arc length (rad/m^2).
    pub d_rate: Vector3<f64>,
    /// Second derivative of the rate by arc length (rad/m^3).
    pub dd_rate: Vector3<f64>,
}

/// Orientation of the tool as a function of arc length.
#[derive(Debug, Clone)]
pub enum OrientationPath {
    /// The same orientation everywhere.
    Constant(UnitQuaternion<f64>),
    /// Through given orientations; see [`OrientationPath::through`].
    Through(Through),
    /// Turning about a fixed axis to follow the tangent; see [`OrientationPath::following_tangent`].
    Heading(Heading),
}

/// Orientation `first * exp(phi(s))` with a spline `phi` of rotation vectors.
#[derive(Debug, Clone)]
pub struct Through {
    first: UnitQuaternion<f64>,
    phi: CubicSpline<3>,
}

/// Orientation `rot(axis, psi(s)) * reference` with a spline `psi` of angles.
#[derive(Debug, Clone)]
pub struct Heading {
    axis: Unit<Vector3<f64>>,
    reference: UnitQuaternion<f64>,
    psi: CubicSpline<1>,
    deviation: f64,
}

impl Heading {
    /// Largest measured angle between the tangent and the heading, rad.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }
}

impl OrientationPath {
    /// Through the orientations `keys`, pairs of arc length and orientation with increasing arc length.
    ///
    /// Two keys give the spherical linear interpolation ("slerp") in step with `s`, on the shorter arc, with a constant
    /// angular rate. More keys give a natural cubic spline of rotation vectors relative to the first key: it passes
    /// through every key with a continuous angular acceleration, where a chain of slerps would have the rate jump.
    /// Before the first and after the last key the orientation goes on as the spline does.
    ///
    /// # Errors
    /// When there are fewer than two keys, or their arc lengths do not increase.
    pub fn through(keys: &[(f64, UnitQuaternion<f64>)]) -> Result<Self, GeometryError> {
        if keys.len() < 2 {
            return Err(GeometryError::TooFewPoints { points: keys.len(), degree: 1 });
        }
        for (index, key) in keys.iter().enumerate() {
            let previous = if index > 0 { keys[index - 1].0 } else { f64::NEG_INFINITY };
            // Written so that NaN fails.
            if !(key.0.is_finite() && key.0 > previous) {
                let start = if index > 0 { previous } else { 0.0 };
                return Err(GeometryError::OrientationKey { index, value: key.0, start, end: f64::INFINITY });
            }
        }
        let first = keys[0].1;
        let mut phi = vec![[0.0; 3]];
        for pair in keys.windows(2) {
            let last = Vector3::from(phi[phi.len() - 1]);
            // Step from the key before, so that each stretch turns by less than half a turn; then the representative of
            // the rotation vector (they differ by full turns about their axis) nearest to the one before.
            let turned = (first.inverse() * pair[1].1).scaled_axis();
            let angle = turned.norm();
            let full = std::f64::consts::TAU;
            let nearest = if angle > 1e-9 {
                let axis = turned / angle;
                let turns = ((last.dot(&axis) - angle) / full).round();
                axis * (angle + turns * full)
            } else if last.norm() > 0.5 * full {
                last * ((last.norm() / full).round() * full / last.norm())
            } else {
                turned
            };
            phi.push(nearest.into());
        }
        let s = keys.iter().map(|k| k.0).collect();
        Ok(Self::Through(Through { first, phi: CubicSpline::natural(s, phi) }))
    }

    /// From `from` at the start of a path of length `length` to `to` at its end, in step with arc length (slerp).
    ///
    /// # Errors
    /// When the length is not above 0.
    pub fn slerp(length: f64, from: UnitQuaternion<f64>, to: UnitQuaternion<f64>) -> Result<Self, GeometryError> {
        if !(length.is_finite() && length > 0.0) {
            return Err(GeometryError::NotPositive { what: "length", value: length });
        }
        Self::through(&[(0.0, from), (length, to)])
    }

    /// Turns the tool about the fixed `axis` (base axes) so that it follows the tangent of `curve`: with `start` as the
    /// orientation at the beginning of the path, the tool turns by as much as the tangent, seen along the axis, does.
    ///
    /// The angle is a cubic spline through the true heading, refined until it is within `tolerance` (rad) of it, so that
    /// angular acceleration is continuous even where the curvature of the path has kinks (at its knots).
    ///
    /// # Errors
    /// When the tolerance is not above 0, the path runs along the axis somewhere, or it has a corner.
    pub fn following_tangent(
        curve: &ArcLengthCurve<3>,
        axis: Unit<Vector3<f64>>,
        start: UnitQuaternion<f64>,
        tolerance: f64,
    ) -> Result<Self, GeometryError> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(GeometryError::NotPositive { what: "tolerance", value: tolerance });
        }
        if let Some(corner) = curve.corners(tolerance).first() {
            return Err(GeometryError::HeadingJump { s: corner.s, angle: corner.angle });
        }
        // Two directions across the axis, from the first tangent.
        let across = |t: Vector3<f64>| t - axis.as_ref() * axis.dot(&t);
        let e1 = across(curve.jet(0.0).d1).try_normalize(1e-6).ok_or(GeometryError::NoHeading { s: 0.0 })?;
        let e2 = axis.cross(&e1);
        let heading = |s: f64| {
            let t = across(curve.jet(s).d1);
            if t.norm() < 1e-6 { Err(GeometryError::NoHeading { s }) } else { Ok(t.dot(&e2).atan2(t.dot(&e1))) }
        };
        // Knots: those of the curve, and enough between them that the heading turns little from one to the next.
        let mut s = curve.knots();
        let mut psi = Vec::with_capacity(s.len());
        for &x in &s {
            psi.push(heading(x)?);
        }
        let step = 0.2;
        let mut i = 0;
        while i + 1 < s.len() {
            let middle = 0.5 * (s[i] + s[i + 1]);
            let h = heading(middle)?;
            let turn = |a: f64, b: f64| (b - a).sin().atan2((b - a).cos()).abs();
            if turn(psi[i], h) + turn(h, psi[i + 1]) > step && s.len() < MAX_HEADING_KNOTS {
                s.insert(i + 1, middle);
                psi.insert(i + 1, h);
            } else {
                i += 1;
            }
        }
        // Refine until the spline is close to the heading between its knots too.
        loop {
            let mut unwrapped = Vec::with_capacity(psi.len());
            let mut last = 0.0;
            for &h in &psi {
                last += (h - last).sin().atan2((h - last).cos());
                unwrapped.push([last]);
            }
            let spline = CubicSpline::natural(s.clone(), unwrapped);
            let mut deviation = 0.0f64;
            let (mut finer_s, mut finer_psi) = (vec![s[0]], vec![psi[0]]);
            for i in 0..s.len() - 1 {
                let mut worst = 0.0f64;
                let mut at_middle = 0.0;
                for f in [0.2, 0.5, 0.8] {
                    let x = s[i] + f * (s[i + 1] - s[i]);
                    let h = heading(x)?;
                    if f == 0.5 {
                        at_middle = h;
                    }
                    let d = spline.at(x).0[0] - h;
                    worst = worst.max(d.sin().atan2(d.cos()).abs());
                }
                deviation = deviation.max(worst);
                if worst > tolerance {
                    finer_s.push(0.5 * (s[i] + s[i + 1]));
                    finer_psi.push(at_middle);
                }
                finer_s.push(s[i + 1]);
                finer_psi.push(psi[i + 1]);
            }
            if deviation <= tolerance || finer_s.len() > MAX_HEADING_KNOTS {
                return Ok(Self::Heading(Heading { axis, reference: start, psi: spline, deviation }));
            }
            (s, psi) = (finer_s, finer_psi);
        }
    }

    /// Orientation, rate and the rate's derivatives at the arc length `s`.
    #[inline]
    pub fn jet(&self, s: f64) -> OrientationJet {
        match self {
            Self::Constant(rotation) => OrientationJet {
                rotation: *rotation,
                rate: Vector3::zeros(),
                d_rate: Vector3::zeros(),
                dd_rate: Vector3::zeros(),
            },
            Self::Through(t) => t.jet(s),
            Self::Heading(h) => {
                let (v, d1, d2, d3) = h.psi.at(s);
                let axis = h.axis.into_inner();
                OrientationJet {
                    rotation: UnitQuaternion::from_axis_angle(&h.axis, v[0]) * h.reference,
                    rate: axis * d1[0],
                    d_rate: axis * d2[0],
                    dd_rate: axis * d3[0],
                }
            }
        }
    }

    /// Arc lengths where the third derivative of the orientation may jump.
    pub fn knots(&self) -> &[f64] {
        match self {
            Self::Constant(_) => &[],
            Self::Through(t) => t.phi.knots(),
            Self::Heading(h) => h.psi.knots(),
        }
    }
}

impl Through {
    /// With the quaternion `q = exp(phi / 2)` and its derivatives: rate = 2 vec(q' q*), and so on by the product rule.
    fn jet(&self, s: f64) -> OrientationJet {
        let (v, d1, d2, d3) = self.phi.at(s);
        let phi = [Vector3::from(v), Vector3::from(d1), Vector3::from(d2), Vector3::from(d3)];
        // x = |phi|^2 and its derivatives.
        let x = [
            phi[0].dot(&phi[0]),
            2.0 * phi[0].dot(&phi[1]),
            2.0 * (phi[0].dot(&phi[2]) + phi[1].dot(&phi[1])),
            2.0 * (phi[0].dot(&phi[3]) + 3.0 * phi[1].dot(&phi[2])),
        ];
        let f = half_sinc(x[0]);
        // Chain rule for g(x(s)), given g and its derivatives by x.
        let chain = |g: [f64; 4]| {
            [
                g[0],
                g[1] * x[1],
                g[2] * x[1] * x[1] + g[1] * x[2],
                g[3] * x[1] * x[1] * x[1] + 3.0 * g[2] * x[1] * x[2] + g[1] * x[3],
            ]
        };
        let sinc = chain(f);
        // cos(sqrt(x) / 2) has the derivative -half_sinc / 4.
        let cos = chain([(0.5 * x[0].sqrt()).cos(), -0.25 * f[0], -0.25 * f[1], -0.25 * f[2]]);
        let part = |w: f64, v: Vector3<f64>| Quaternion::from_parts(w, v);
        let q0 = part(cos[0], phi[0] * sinc[0]);
        let q1 = part(cos[1], phi[0] * sinc[1] + phi[1] * sinc[0]);
        let q2 = part(cos[2], phi[0] * sinc[2] + phi[1] * (2.0 * sinc[1]) + phi[2] * sinc[0]);
        let q3 =
            part(cos[3], phi[0] * sinc[3] + phi[1] * (3.0 * sinc[2]) + phi[2] * (3.0 * sinc[1]) + phi[3] * sinc[0]);
        let (c0, c1, c2) = (q0.conjugate(), q1.conjugate(), q2.conjugate());
        let rate = (q1 * c0).imag() * 2.0;
        let d_rate = (q2 * c0 + q1 * c1).imag() * 2.0;
        let dd_rate = (q3 * c0 + q2 * c1 * 2.0 + q1 * c2).imag() * 2.0;
        OrientationJet {
            rotation: self.first * UnitQuaternion::new_normalize(q0),
            rate: self.first * rate,
            d_rate: self.first * d_rate,
            dd_rate: self.first * dd_rate,
        }
    }
}

/// `sin(sqrt(x) / 2) / sqrt(x)` and its first three derivatives by `x`.
fn half_sinc(x: f64) -> [f64; 4] {
    if x < 1.0 {
        // Series sum (-1)^k x^k / (2^(2k+1) (2k+1)!): the closed forms below cancel here.
        let mut out = [0.0; 4];
        let mut c = 0.5;
        for k in 0..12i32 {
            let kf = k as f64;
            out[0] += c * x.powi(k);
            if k >= 1 {
                out[1] += c * kf * x.powi(k - 1);
            }
            if k >= 2 {
                out[2] += c * kf * (kf - 1.0) * x.powi(k - 2);
            }
            if k >= 3 {
                out[3] += c * kf * (kf - 1.0) * (kf - 2.0) * x.powi(k - 3);
            }
            c *= -1.0 / (4.0 * (2.0 * kf + 2.0) * (2.0 * kf + 3.0));
        }
        return out;
    }
    let root = x.sqrt();
    let (sin, cos) = (0.5 * root).sin_cos();
    let s = sin / root;
    let s1 = (0.5 * cos - s) / (2.0 * x);
    let s2 = (-0.125 * s - 3.0 * s1) / (2.0 * x);
    let s3 = (-0.125 * s1 - 5.0 * s2) / (2.0 * x);
    [s, s1, s2, s3]
}
