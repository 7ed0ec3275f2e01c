//! Tool orientation along a path: constant, through given orientations, or following the tangent.

use nalgebra::{Matrix3, Quaternion, Unit, UnitQuaternion, Vector3};

use crate::arc_length::ArcLengthCurve;
use crate::error::GeometryError;
use crate::spline::CubicSpline;

/// Most knots a heading is given; where they do not suffice for its tolerance, [`Heading::deviation`] tells.
const MAX_HEADING_KNOTS: usize = 100_000;
/// Most rounds of the iteration that makes angular acceleration continuous. Nearly all keys need ten; of random keys two
/// radians apart one set in ten thousand needs more than thirty, and three in a hundred thousand end here.
const MAX_ROUNDS: usize = 200;

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

/// From key to key the orientation is `key * exp(phi(s))` with a cubic `phi` of rotation vectors. Where no cubics with a
/// continuous angular acceleration are found, `phi` is of degree five.
///
/// A spline on the rotation group in the sense of Park and Ravani, "Smooth invariant interpolation of rotations" (ACM
/// Trans. Graphics 16, 1997), with the rates at the keys solved for all at once. Each stretch has its own chart, so that
/// nothing happens at a full turn, and neither the base nor the tool frame matters.
#[derive(Debug, Clone)]
pub struct Through {
    s: Vec<f64>,
    stretches: Vec<Stretch>,
}

/// `phi(x) = first + c[0] x + c[1] x^2 + ... + c[4] x^5` about the key, with the arc length `x` since the start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    pub key: UnitQuaternion<f64>,
    pub first: Vector3<f64>,
    pub c: [Vector3<f64>; 5],
}

impl Stretch {
    /// `phi` and its first three derivatives at `x`.
    #[inline]
    fn phi(&self, x: f64) -> [Vector3<f64>; 4] {
        let c = &self.c;
        [
            self.first + (c[0] + (c[1] + (c[2] + (c[3] + c[4] * x) * x) * x) * x) * x,
            c[0] + (c[1] * 2.0 + (c[2] * 3.0 + (c[3] * 4.0 + c[4] * (5.0 * x)) * x) * x) * x,
            c[1] * 2.0 + (c[2] * 6.0 + (c[3] * 12.0 + c[4] * (20.0 * x)) * x) * x,
            c[2] * 6.0 + (c[3] * 24.0 + c[4] * (60.0 * x)) * x,
        ]
    }
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
    #[inline]
    fn jet(&self, (v, d1, d2, d3): ([f64; 1], [f64; 1], [f64; 1], [f64; 1])) -> OrientationJet {
        let axis = self.axis.into_inner();
        OrientationJet {
            rotation: UnitQuaternion::from_axis_angle(&self.axis, v[0]) * self.reference,
            rate: axis * d1[0],
            d_rate: axis * d2[0],
            dd_rate: axis * d3[0],
        }
    }

    /// Largest measured angle between the tangent and the heading, rad.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }
}

impl OrientationPath {
    /// Through the orientations `keys`, pairs of arc length and orientation with increasing arc length.
    ///
    /// Two keys give the spherical linear interpolation ("slerp") in step with `s`, on the shorter arc, with a constant
    /// angular rate. More keys give the rotational counterpart of a natural cubic spline: through every key, on the shorter
    /// way from one to the next, with a continuous angular acceleration, where a chain of slerps would have the rate jump.
    /// Before the first and after the last key the orientation goes on as the spline does.
    ///
    /// # Errors
    /// Fails when there are fewer than two keys, their arc lengths do not increase, or a quaternion is not finite.
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
            if let Some(&value) = key.1.coords.iter().find(|x| !x.is_finite()) {
                return Err(GeometryError::QuaternionNotFinite { index, value });
            }
        }
        Ok(Self::Through(Through::new(keys)))
    }

    /// From `from` at the start of a path of length `length` to `to` at its end, in step with arc length (slerp).
    ///
    /// # Errors
    /// Fails when the length is not above 0.
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
    /// A tolerance out of reach of double precision, or of 100 000 knots, ends the refinement early; [`Heading::deviation`]
    /// tells what was reached.
    ///
    /// # Errors
    /// Fails when the tolerance is not above 0, the path runs along the axis somewhere, or it has a corner.
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
        // Refine until the spline is close to the heading between its knots too. Five places in each interval find the
        // largest deviation but for a tenth or so.
        let limit = 0.8 * tolerance;
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
                for f in [0.12, 0.3, 0.5, 0.7, 0.88] {
                    let x = s[i] + f * (s[i + 1] - s[i]);
                    let h = heading(x)?;
                    if f == 0.5 {
                        at_middle = h;
                    }
                    let d = spline.at(x).0[0] - h;
                    worst = worst.max(d.sin().atan2(d.cos()).abs());
                }
                deviation = deviation.max(worst);
                if worst > limit {
                    finer_s.push(0.5 * (s[i] + s[i + 1]));
                    finer_psi.push(at_middle);
                }
                finer_s.push(s[i + 1]);
                finer_psi.push(psi[i + 1]);
            }
            if deviation <= limit || finer_s.len() > MAX_HEADING_KNOTS {
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
            Self::Through(t) => t.jet(t.find(s), s),
            Self::Heading(h) => h.jet(h.psi.at(s)),
        }
    }

    /// Like [`OrientationPath::jet`], with the third derivative from the left where it jumps.
    pub fn jet_left(&self, s: f64) -> OrientationJet {
        match self {
            Self::Constant(_) => self.jet(s),
            Self::Through(t) => {
                let i = t.find(s);
                t.jet(if i > 0 && s <= t.s[i] { i - 1 } else { i }, s)
            }
            Self::Heading(h) => h.jet(h.psi.at_left(s)),
        }
    }

    /// Moves knots that are within `tolerance` of one of `places` (sorted) onto it, so that both count as one.
    pub(crate) fn snap_knots(&mut self, places: &[f64], tolerance: f64) {
        let Self::Through(t) = self else { return };
        for k in &mut t.s {
            let i = places.partition_point(|&p| p < *k - tolerance);
            if let Some(&place) = places.get(i).filter(|&&p| p <= *k + tolerance) {
                *k = place;
            }
        }
    }

    /// Arc lengths where the third derivative of the orientation may jump.
    pub fn knots(&self) -> &[f64] {
        match self {
            Self::Constant(_) => &[],
            Self::Through(t) => &t.s,
            Self::Heading(h) => h.psi.knots(),
        }
    }
}

impl Through {
    /// Stretches that join on their own, each over the arc lengths from `s[i]` to `s[i + 1]`.
    pub(crate) fn from_stretches(s: Vec<f64>, stretches: Vec<Stretch>) -> Self {
        Self { s, stretches }
    }

    /// The rates at the keys follow from equal angular accelerations on both sides of each key, and none at the ends.
    ///
    /// With the steps `r`, their widths `h`, the rates `w` in axes of their keys and the right Jacobian `J` of the
    /// rotation group at `r`, a stretch has the Hermite data `phi'(0) = w0`, `phi'(h) = J^-1 w1 = v`, so that its angular
    /// accelerations are `6 r / h^2 - (4 w0 + 2 v) / h` and `J (2 w0 + 4 v) / h - 6 r / h^2 + c(v)`. Without the quadratic
    /// `c` the rates follow from a block tridiagonal system; with it, from a few steps of Newton's method.
    fn new(keys: &[(f64, UnitQuaternion<f64>)]) -> Self {
        let n = keys.len();
        let h: Vec<f64> = keys.windows(2).map(|k| k[1].0 - k[0].0).collect();
        let r: Vec<Vector3<f64>> = keys.windows(2).map(|k| shorter_way(&k[0].1, &k[1].1)).collect();
        let (j, j_inverse): (Vec<_>, Vec<_>) = r.iter().map(right_jacobian).unzip();

        let fixed = |i: usize| if i + 1 < n { r[i] * (6.0 / (h[i] * h[i])) } else { Vector3::zeros() };
        // Thomas' algorithm, with `c` replaced by its tangent `c + slope (w - w_before)`.
        let solve = |c: &[Vector3<f64>], slope: &[Matrix3<f64>], before: &[Vector3<f64>]| {
            let mut w: Vec<Vector3<f64>> = Vec::with_capacity(n);
            let mut upper: Vec<Matrix3<f64>> = Vec::with_capacity(n);
            for i in 0..n {
                let mut inverse_widths = 0.0;
                let mut pivot = Matrix3::zeros();
                let mut right = fixed(i);
                if i > 0 {
                    let lower = j[i - 1] * (2.0 / h[i - 1]);
                    inverse_widths += 1.0 / h[i - 1];
                    pivot += slope[i - 1] - lower * upper[i - 1];
                    right += fixed(i - 1) - c[i - 1] + slope[i - 1] * before[i] - lower * w[i - 1];
                }
                if i + 1 < n {
                    inverse_widths += 1.0 / h[i];
                }
                pivot += Matrix3::identity() * (4.0 * inverse_widths);
                // Diagonally dominant without the slopes; a singular one leaves the rate at 0, to be found next time.
                let inverse = pivot.try_inverse().unwrap_or_else(Matrix3::zeros);
                upper.push(if i + 1 < n { inverse * j_inverse[i] * (2.0 / h[i]) } else { Matrix3::zeros() });
                w.push(inverse * right);
            }
            for i in (0..n - 1).rev() {
                w[i] = w[i] - upper[i] * w[i + 1];
            }
            w
        };
        let mut c = vec![Vector3::zeros(); n - 1];
        let mut slope = vec![Matrix3::zeros(); n - 1];
        let mut w = solve(&c, &slope, &vec![Vector3::zeros(); n]);
        // The iterate that was changed least, and by how much.
        let mut best = (f64::INFINITY, w.clone());
        for _ in 0..MAX_ROUNDS {
            for i in 0..n - 1 {
                let at = |v: Vector3<f64>| end_acceleration(&[r[i], v, Vector3::zeros(), Vector3::zeros()]);
                let v = j_inverse[i] * w[i + 1];
                c[i] = at(v);
                // It is quadratic in v: c(v + e) - c(v) - c(e) is its derivative along e, exactly.
                let along = |e: Vector3<f64>| at(v + e) - c[i] - at(e);
                let size = v.norm();
                if size > 0.0 {
                    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|e| along(e * size) / size);
                    slope[i] = Matrix3::from_columns(&[x, y, z]) * j_inverse[i];
                }
            }
            let next = solve(&c, &slope, &w);
            let change = next.iter().zip(&w).fold(0.0f64, |m, (a, b)| m.max((a - b).norm()));
            let size = next.iter().fold(0.0f64, |m, a| m.max(a.norm()));
            w = next;
            if change < best.0 {
                best = (change, w.clone());
            }
            // Sizes that are not numbers end it too: `max` above drops them.
            if change <= 1e-15 * size {
                break;
            }
        }
        // Newton's method ends at a few units in the last place; what does not come near wanders about.
        let found = best.0 <= 1e-12 * best.1.iter().fold(0.0f64, |m, a| m.max(a.norm()));
        let w = if found { w } else { best.1 };
        let mut stretches = Vec::with_capacity(n - 1);
        for i in 0..n - 1 {
            let (mean, v) = (r[i] / h[i], j_inverse[i] * w[i + 1]);
            let [c1, c2, c3] = [w[i], (mean * 3.0 - w[i] * 2.0 - v) / h[i], (w[i] + v - mean * 2.0) / (h[i] * h[i])];
            let zero = Vector3::zeros();
            stretches.push(Stretch { key: keys[i].1, first: zero, c: [c1, c2, c3, zero, zero] });
        }
        let mut path = Self { s: keys.iter().map(|k| k.0).collect(), stretches };
        if !found {
            path.join_accelerations(&j_inverse);
        }
        path
    }

    /// Gives both sides of every key the mean of their angular accelerations, by stretches of degree five with the rates
    /// they have. `j_inverse` are the inverse right Jacobians at the ends of the stretches.
    fn join_accelerations(&mut self, j_inverse: &[Matrix3<f64>]) {
        let n = self.s.len();
        let width = |i: usize| self.s[i + 1] - self.s[i];
        // In the axes of each key.
        let mean = |i: usize| {
            let before = (i > 0).then(|| end_acceleration(&self.stretches[i - 1].phi(width(i - 1))));
            let after = (i + 1 < n).then(|| self.stretches[i].c[1] * 2.0);
            match (before, after) {
                (Some(a), Some(b)) => (a + b) * 0.5,
                (one, other) => one.or(other).unwrap_or_else(Vector3::zeros),
            }
        };
        let accelerations: Vec<Vector3<f64>> = (0..n).map(mean).collect();
        for i in 0..n - 1 {
            let h = width(i);
            let [r, v, ..] = self.stretches[i].phi(h);
            let without = end_acceleration(&[r, v, Vector3::zeros(), Vector3::zeros()]);
            let (start, end) = (accelerations[i], j_inverse[i] * (accelerations[i + 1] - without));
            // What is left to the powers three to five at the end, with the two derivatives.
            let rate = self.stretches[i].c[0];
            let d = r - rate * h - start * (0.5 * h * h);
            let e = (v - rate - start * h) * h;
            let f = (end - start) * (h * h);
            let h3 = h * h * h;
            self.stretches[i].c = [
                rate,
                start * 0.5,
                (d * 10.0 - e * 4.0 + f * 0.5) / h3,
                (e * 7.0 - d * 15.0 - f) / (h3 * h),
                (d * 6.0 - e * 3.0 + f * 0.5) / (h3 * h * h),
            ];
        }
    }

    /// Stretch that holds `s`, of two the later one.
    #[inline]
    fn find(&self, s: f64) -> usize {
        self.s[1..self.s.len() - 1].partition_point(|&k| k <= s)
    }

    #[inline]
    fn jet(&self, i: usize, s: f64) -> OrientationJet {
        let stretch = &self.stretches[i];
        rotate_along(&stretch.key, &stretch.phi(s - self.s[i]))
    }
}

/// Rotation vector from `a` to `b` in the axes of `a`, at most half a turn long.
pub(crate) fn shorter_way(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = (a.inverse() * b).into_inner();
    let (sin, cos) = (q.imag().norm(), q.w.abs());
    if sin == 0.0 {
        return Vector3::zeros();
    }
    q.imag() * (2.0 * sin.atan2(cos) / if q.w < 0.0 { -sin } else { sin })
}

/// The right Jacobian of the rotation group at the rotation vector `r`, and its inverse: the angular rate in the turned
/// axes is `J(phi) phi'`.
fn right_jacobian(r: &Vector3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    let cross = r.cross_matrix();
    let square = cross * cross;
    let angle = r.norm();
    let (a, b, c) = if angle < 1e-2 {
        let x = angle * angle;
        (0.5 - x / 24.0, 1.0 / 6.0 - x / 120.0, 1.0 / 12.0 + x / 720.0)
    } else {
        let (sin, cos) = (0.5 * angle).sin_cos();
        let x = angle * angle;
        (2.0 * sin * sin / x, (angle - angle.sin()) / (x * angle), (1.0 - 0.5 * angle * cos / sin) / x)
    };
    let one = Matrix3::identity();
    (one - cross * a + square * b, one + cross * 0.5 + square * c)
}

/// The angular acceleration at the end of `exp(phi)`, seen in the axes there, given `phi` and three derivatives.
fn end_acceleration(phi: &[Vector3<f64>; 4]) -> Vector3<f64> {
    let end = rotate_along(&UnitQuaternion::identity(), phi);
    end.rotation.inverse() * end.d_rate
}

/// Orientation `first * exp(phi)` and its rates, given `phi` and three derivatives.
///
/// With the quaternion `q = exp(phi / 2)` and its derivatives: rate = 2 vec(q' q*), and so on by the product rule.
fn rotate_along(first: &UnitQuaternion<f64>, phi: &[Vector3<f64>; 4]) -> OrientationJet {
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
    let q3 = part(cos[3], phi[0] * sinc[3] + phi[1] * (3.0 * sinc[2]) + phi[2] * (3.0 * sinc[1]) + phi[3] * sinc[0]);
    let (c0, c1, c2) = (q0.conjugate(), q1.conjugate(), q2.conjugate());
    let rate = (q1 * c0).imag() * 2.0;
    let d_rate = (q2 * c0 + q1 * c1).imag() * 2.0;
    let dd_rate = (q3 * c0 + q2 * c1 * 2.0 + q1 * c2).imag() * 2.0;
    OrientationJet {
        rotation: first * UnitQuaternion::new_normalize(q0),
        rate: first * rate,
        d_rate: first * d_rate,
        dd_rate: first * dd_rate,
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
