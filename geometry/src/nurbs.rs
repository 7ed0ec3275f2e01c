//! NURBS curves: validation and evaluation.

use nalgebra::SVector;

use crate::bezier::{self, Homogeneous};
use crate::curve::{Curve, Jet};
use crate::decompose::part_powers;
use crate::error::GeometryError;
use crate::knots::{KnotVector, check_degree};

/// Up to this degree a knot span is one polynomial piece; above it the span is halved, so that the centred power basis
/// stays accurate to a few units in the last place whatever the degree.
const DEGREE_OF_ONE_PIECE: usize = 5;

/// Entries of the table that finds the piece of a parameter, per piece.
const BUCKETS_PER_PIECE: usize = 16;

/// A non-uniform rational B-spline curve in the plane (`D = 2`) or in space (`D = 3`), of any degree.
///
/// `C(u) = sum w_i N_i(u) P_i / sum w_i N_i(u)` (Liu et al. 2023, eqs. 1-3). A value that exists is valid: finite points,
/// weights above 0, non-decreasing knots. Evaluation runs on power-basis pieces that are prepared once at construction;
/// it allocates nothing. At an end where the first or last knot stands degree + 1 times the point is the control point,
/// to the last bit.
///
/// ```
/// use arcfeed_geometry::{Curve, NurbsCurve, nalgebra::vector};
///
/// // A quarter of the unit circle, exactly.
/// let quarter = NurbsCurve::new(
///     2,
///     vec![vector![1.0, 0.0], vector![1.0, 1.0], vector![0.0, 1.0]],
///     vec![1.0, std::f64::consts::FRAC_1_SQRT_2, 1.0],
///     vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
/// )?;
/// let jet = quarter.jet(0.3);
/// assert!((jet.point.norm() - 1.0).abs() < 1e-15);
/// assert!((jet.curvature() - 1.0).abs() < 1e-14);
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Clone)]
pub struct NurbsCurve<const D: usize> {
    points: Vec<SVector<f64, D>>,
    weights: Vec<f64>,
    knots: KnotVector,
    homogeneous: Vec<Homogeneous>,
    pieces: Pieces,
    /// Points at both ends of the domain.
    ends: Box<[SVector<f64, D>; 2]>,
}

/// What defines the curve, without the tables prepared for its evaluation.
impl<const D: usize> std::fmt::Debug for NurbsCurve<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NurbsCurve")
            .field("degree", &self.degree())
            .field("points", &self.points)
            .field("weights", &self.weights)
            .field("knots", &self.knots.as_slice())
            .finish_non_exhaustive()
    }
}

/// Two curves are equal when their degree, points, weights and knots are.
impl<const D: usize> PartialEq for NurbsCurve<D> {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points && self.weights == other.weights && self.knots == other.knots
    }
}

impl<const D: usize> NurbsCurve<D> {
    /// A curve from its degree, control points (not multiplied by their weights), weights and full knot vector.
    ///
    /// # Errors
    /// When the counts do not match (`knots = points + degree + 1`, one weight per point), a number is not finite, a
    /// weight is not above 0, the knots decrease or stand too often, or the curve would jump.
    pub fn new(
        degree: usize,
        points: Vec<SVector<f64, D>>,
        weights: Vec<f64>,
        knots: Vec<f64>,
    ) -> Result<Self, GeometryError> {
        const { assert!(D == 2 || D == 3, "curves live in the plane or in space") };
        check_degree(degree)?;
        if points.len() < degree + 1 {
            return Err(GeometryError::TooFewPoints { points: points.len(), degree });
        }
        if weights.len() != points.len() {
            return Err(GeometryError::WeightCount { weights: weights.len(), points: points.len() });
        }
        if knots.len() != points.len() + degree + 1 {
            return Err(GeometryError::KnotCount { knots: knots.len(), points: points.len(), degree });
        }
        check_points("control point", &points)?;
        check_weights(&weights)?;
        let knots = KnotVector::new(degree, knots)?;

        let largest = weights.iter().fold(0.0f64, |m, &w| m.max(w));
        let homogeneous: Vec<Homogeneous> = points
            .iter()
            .zip(&weights)
            .map(|(p, &w)| {
                let w = w / largest;
                let mut h = [0.0, 0.0, 0.0, w];
                for i in 0..D {
                    h[i] = p[i] * w;
                }
                h
            })
            .collect();
        let rational = weights.iter().any(|&w| w != weights[0]);
        let pieces = Pieces::build(&knots, &homogeneous, rational);
        let ends = Box::new(pieces.ends(&knots, &points));
        let this = Self { points, weights, knots, homogeneous, pieces, ends };
        this.check_jumps()?;
        Ok(this)
    }

    /// A polynomial (not rational) curve: all weights 1.
    ///
    /// # Errors
    /// As [`NurbsCurve::new`].
    pub fn bspline(degree: usize, points: Vec<SVector<f64, D>>, knots: Vec<f64>) -> Result<Self, GeometryError> {
        let weights = vec![1.0; points.len()];
        Self::new(degree, points, weights, knots)
    }

    /// Degree of the curve.
    pub fn degree(&self) -> usize {
        self.knots.degree()
    }

    /// Control points, not multiplied by their weights.
    pub fn control_points(&self) -> &[SVector<f64, D>] {
        &self.points
    }

    /// Weights, one per control point.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Knot vector.
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// True where the weights differ, so that the curve is not a polynomial spline.
    pub fn is_rational(&self) -> bool {
        self.pieces.rational
    }

    /// True where the curve ends in the point where it starts, to `tolerance` (a length).
    pub fn is_closed(&self, tolerance: f64) -> bool {
        let (a, b) = self.domain();
        (self.point(a) - self.point(b)).norm() <= tolerance
    }

    pub(crate) fn homogeneous(&self) -> &[Homogeneous] {
        &self.homogeneous
    }

    /// Point at the first or last parameter, where `at` is no further inside than `start` or `end`.
    #[inline(always)]
    pub(crate) fn end(&self, at: f64, (start, end): (f64, f64)) -> Option<&SVector<f64, D>> {
        if at <= start {
            Some(&self.ends[0])
        } else if at >= end {
            Some(&self.ends[1])
        } else {
            None
        }
    }

    /// Evaluation pieces, for whoever walks along the curve and knows in which piece it is.
    pub(crate) fn pieces(&self) -> &Pieces {
        &self.pieces
    }

    /// A curve jumps where an interior knot stands degree + 1 times, unless the two points there coincide.
    fn check_jumps(&self) -> Result<(), GeometryError> {
        let (a, b) = self.domain();
        for (_, value, multiplicity) in self.knots.runs() {
            if multiplicity == self.degree() + 1 && a < value && value < b {
                let gap = (self.jet(value).point - self.jet_left(value).point).norm();
                let size = self.points.iter().fold(0.0f64, |m, p| m.max(p.norm()));
                if gap > 1e-14 * size {
                    return Err(GeometryError::Jump { value, gap });
                }
            }
        }
        Ok(())
    }
}

impl NurbsCurve<2> {
    /// The same curve in space, in the plane z = 0.
    pub fn lifted(&self) -> NurbsCurve<3> {
        NurbsCurve {
            points: self.points.iter().map(|p| p.push(0.0)).collect(),
            weights: self.weights.clone(),
            knots: self.knots.clone(),
            homogeneous: self.homogeneous.clone(),
            pieces: self.pieces.clone(),
            ends: Box::new(self.ends.map(|p| p.push(0.0))),
        }
    }
}

pub(crate) fn check_points<const D: usize>(
    what: &'static str,
    points: &[SVector<f64, D>],
) -> Result<(), GeometryError> {
    for (index, p) in points.iter().enumerate() {
        for axis in 0..D {
            // Not `>`: NaN has to fail too. 1e100 keeps every product of the evaluation inside the range of f64.
            if p[axis].is_nan() || p[axis].abs() >= 1e100 {
                return Err(GeometryError::PointNotFinite { what, index, axis, value: p[axis] });
            }
        }
    }
    Ok(())
}

fn check_weights(weights: &[f64]) -> Result<(), GeometryError> {
    let (mut smallest, mut largest) = (f64::INFINITY, 0.0f64);
    for (index, &value) in weights.iter().enumerate() {
        if !(value.is_finite() && value > 0.0) {
            return Err(GeometryError::Weight { index, value });
        }
        smallest = smallest.min(value);
        largest = largest.max(value);
    }
    if smallest < largest * 1e-12 {
        return Err(GeometryError::WeightRange { smallest, largest });
    }
    Ok(())
}

impl<const D: usize> Curve<D> for NurbsCurve<D> {
    fn domain(&self) -> (f64, f64) {
        self.knots.domain()
    }

    #[inline]
    fn jet(&self, u: f64) -> Jet<D> {
        let p = &self.pieces;
        let i = p.find(u);
        let jet = p.jet(i, p.local(i, u));
        match self.end(u, p.domain) {
            Some(&point) => Jet { point, ..jet },
            None => jet,
        }
    }

    fn jet_left(&self, u: f64) -> Jet<D> {
        let p = &self.pieces;
        let mut i = p.find(u);
        if i > 0 && u <= p.frames[i].start {
            i -= 1;
        }
        let jet = p.jet(i, p.local(i, u));
        match self.end(u, p.domain) {
            Some(&point) => Jet { point, ..jet },
            None => jet,
        }
    }

    #[inline]
    fn point(&self, u: f64) -> SVector<f64, D> {
        let p = &self.pieces;
        if let Some(&end) = self.end(u, p.domain) {
            return end;
        }
        let i = p.find(u);
        p.point(i, p.local(i, u))
    }
}

/// Where a piece lies in the curve's parameter: `t = (u - middle - rest) * scale` runs over [-1, 1].
///
/// The middle is rounded, and `rest` is what it lacks: without that, a piece of a few units in the last place would not
/// reach from one knot to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub start: f64,
    pub end: f64,
    middle: f64,
    rest: f64,
    pub scale: f64,
}

impl Frame {
    fn new(start: f64, end: f64) -> Self {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        Self { start, end, middle, rest: (start - middle) + half, scale: 1.0 / half }
    }

    /// The curve's parameter at the local parameter `t`.
    #[inline(always)]
    pub fn parameter(&self, t: f64) -> f64 {
        (self.middle + (self.rest + t / self.scale)).max(self.start).min(self.end)
    }
}

/// Power-basis pieces of a curve, each about its own middle, with a table that finds the piece of a parameter in
/// constant time.
///
/// Powers and not Bernstein form: they are a third faster to evaluate and twice as fast for arc length. What they lose is
/// some 5e-15 of the size of the curve at the ends of strongly rational pieces.
#[derive(Debug, Clone)]
pub(crate) struct Pieces {
    pub frames: Vec<Frame>,
    /// `degree + 1` coefficients a piece, constant term first.
    coefficients: Vec<Homogeneous>,
    order: usize,
    rational: bool,
    buckets: Vec<u32>,
    bucket_scale: f64,
    /// First and last parameter.
    domain: (f64, f64),
}

impl Pieces {
    fn build(knots: &KnotVector, points: &[Homogeneous], rational: bool) -> Self {
        let p = knots.degree();
        let halvings = p.saturating_sub(DEGREE_OF_ONE_PIECE).div_ceil(3).min(6);
        let parts = 1usize << halvings;
        let t = knots.as_slice();
        let mut frames = Vec::new();
        let mut coefficients = Vec::new();
        for k in knots.spans() {
            let (a, b) = (t[k], t[k + 1]);
            for j in 0..parts {
                let at = |i: usize| {
                    if i == parts { b } else { a + (b - a) * (i as f64 / parts as f64) }
                };
                let (start, end) = (at(j), at(j + 1));
                if start >= end {
                    continue;
                }
                // Of the borders as they are, rounded.
                let part = ((start - a) / (b - a), (end - a) / (b - a));
                part_powers(t, points, (p, k), part, &mut coefficients);
                frames.push(Frame::new(start, end));
            }
        }
        let (bucket_start, end) = knots.domain();
        let domain = (bucket_start, end);
        // Many more buckets than pieces: a parameter that shares its bucket with a knot costs a mispredicted branch.
        let n = BUCKETS_PER_PIECE * frames.len();
        let bucket_scale = n as f64 / (end - bucket_start);
        let mut buckets = Vec::with_capacity(n);
        let mut piece = 0;
        for i in 0..n {
            // One bucket earlier than computed: rounding must never make the search start behind the parameter.
            let u = bucket_start + (i as f64 - 0.5) / bucket_scale;
            while piece + 1 < frames.len() && frames[piece].end <= u {
                piece += 1;
            }
            buckets.push(piece as u32);
        }
        Self { frames, coefficients, order: p + 1, rational, buckets, bucket_scale, domain }
    }

    /// Points at both ends: the control points there, where the ends are clamped.
    fn ends<const D: usize>(&self, knots: &KnotVector, points: &[SVector<f64, D>]) -> [SVector<f64, D>; 2] {
        let (t, last) = (knots.as_slice(), self.frames.len() - 1);
        [
            if t[0] == self.domain.0 { points[0] } else { self.point(0, -1.0) },
            if t[t.len() - 1] == self.domain.1 { points[points.len() - 1] } else { self.point(last, 1.0) },
        ]
    }

    /// Index of the piece that holds `u`; parameters outside are taken to the first or last piece.
    #[inline(always)]
    pub fn find(&self, u: f64) -> usize {
        // A negative or NaN product becomes 0, a large one saturates.
        let b = ((u - self.domain.0) * self.bucket_scale) as usize;
        let mut i = self.buckets[b.min(self.buckets.len() - 1)] as usize;
        while i + 1 < self.frames.len() && u >= self.frames[i].end {
            i += 1;
        }
        i
    }

    /// Local parameter in [-1, 1] of `u` on piece `i` (clamped).
    #[inline(always)]
    pub fn local(&self, i: usize, u: f64) -> f64 {
        let f = &self.frames[i];
        // `max` first: NaN becomes the start of the piece.
        ((u - f.middle - f.rest) * f.scale).max(-1.0).min(1.0)
    }

    #[inline]
    fn coefficients(&self, i: usize) -> &[Homogeneous] {
        &self.coefficients[i * self.order..(i + 1) * self.order]
    }

    /// Point of piece `i` at the local parameter `t`.
    #[inline]
    pub fn point<const D: usize>(&self, i: usize, t: f64) -> SVector<f64, D> {
        let mut h = [0.0; 4];
        for c in self.coefficients(i).iter().rev() {
            for l in 0..4 {
                h[l] = h[l] * t + c[l];
            }
        }
        if self.rational { bezier::project(&h) } else { SVector::from_fn(|l, _| h[l]) }
    }

    /// Jet of piece `i` at the local parameter `t`, derivatives by the curve's parameter.
    #[inline(always)]
    pub fn jet<const D: usize>(&self, i: usize, t: f64) -> Jet<D> {
        self.jet_by(i, t, self.frames[i].scale)
    }

    /// Jet of piece `i` at the local parameter `t`, derivatives by arc length. They do not go through the curve's
    /// parameter, which may be on any scale.
    #[inline(always)]
    pub fn jet_by_arc_length<const D: usize>(&self, i: usize, t: f64) -> Jet<D> {
        self.jet_by(i, t, 1.0).by_arc_length()
    }

    /// Jet of piece `i` at the local parameter `t`, derivatives by `t / k`.
    #[inline(always)]
    fn jet_by<const D: usize>(&self, i: usize, t: f64, k: f64) -> Jet<D> {
        let c = self.coefficients(i);
        let [h0, h1, h2, h3] = match <&[Homogeneous; 4]>::try_from(c) {
            Ok(cubic) => taylor(cubic, t),
            Err(_) => taylor_of_any_degree(c, t),
        };
        let (k1, k2, k3) = (k, 2.0 * k * k, 6.0 * k * k * k);
        if !self.rational {
            return Jet {
                point: SVector::from_fn(|l, _| h0[l]),
                d1: SVector::from_fn(|l, _| h1[l] * k1),
                d2: SVector::from_fn(|l, _| h2[l] * k2),
                d3: SVector::from_fn(|l, _| h3[l] * k3),
            };
        }
        // Quotient rule, order by order: (w C)^(n) = sum binomial(n, j) w^(j) C^(n - j).
        let iw = 1.0 / h0[3];
        let (w1, w2, w3) = (h1[3] * k1, h2[3] * k2, h3[3] * k3);
        let point: SVector<f64, D> = SVector::from_fn(|l, _| h0[l] * iw);
        let d1: SVector<f64, D> = SVector::from_fn(|l, _| (h1[l] * k1 - w1 * point[l]) * iw);
        let d2: SVector<f64, D> = SVector::from_fn(|l, _| (h2[l] * k2 - 2.0 * w1 * d1[l] - w2 * point[l]) * iw);
        let d3: SVector<f64, D> =
            SVector::from_fn(|l, _| (h3[l] * k3 - 3.0 * w1 * d2[l] - 3.0 * w2 * d1[l] - w3 * point[l]) * iw);
        Jet { point, d1, d2, d3 }
    }

    /// Rounding error to be expected of [`Pieces::local_speed`] on piece `i`.
    pub fn speed_noise(&self, i: usize) -> f64 {
        let c = self.coefficients(i);
        let size: f64 = c.iter().map(|h| h[0].abs() + h[1].abs() + h[2].abs()).sum();
        let weight = c[0][3] - c[1..].iter().map(|h| h[3].abs()).sum::<f64>();
        let least = if weight > 0.1 * c[0][3] { weight } else { 0.1 * c[0][3] };
        8.0 * f64::EPSILON * size / if self.rational { least } else { 1.0 }
    }

    /// `|C'|` on piece `i` at the local parameter `t`, by the local parameter itself (for arc length).
    #[inline]
    pub fn local_speed(&self, i: usize, t: f64) -> f64 {
        let (mut h0, mut h1) = ([0.0; 4], [0.0; 4]);
        for c in self.coefficients(i).iter().rev() {
            for l in 0..4 {
                h1[l] = h1[l] * t + h0[l];
                h0[l] = h0[l] * t + c[l];
            }
        }
        if !self.rational {
            return (h1[0] * h1[0] + h1[1] * h1[1] + h1[2] * h1[2]).sqrt();
        }
        let iw = 1.0 / h0[3];
        let r = h1[3] * iw;
        let v: [f64; 3] = std::array::from_fn(|l| (h1[l] - r * h0[l]) * iw);
        (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
    }

    /// [`Pieces::local_speed`] at several places at once (a multiple of four), for a curve in `D` dimensions.
    #[inline]
    pub fn local_speeds<const D: usize, const N: usize>(&self, i: usize, t: &[f64; N]) -> [f64; N] {
        let c = self.coefficients(i);
        let mut out = [0.0; N];
        for (out, t) in out.as_chunks_mut().0.iter_mut().zip(t.as_chunks().0) {
            *out = match (<&[Homogeneous; 4]>::try_from(c), self.rational) {
                (Ok(cubic), true) => four_speeds::<D, true>(cubic, t),
                (Ok(cubic), false) => four_speeds::<D, false>(cubic, t),
                (Err(_), true) => four_speeds::<D, true>(c, t),
                (Err(_), false) => four_speeds::<D, false>(c, t),
            };
        }
        out
    }
}

/// `|C'|` by the local parameter, at four places at once: the loops over the places become vector instructions.
#[inline(always)]
fn four_speeds<const D: usize, const RATIONAL: bool>(c: &[Homogeneous], t: &[f64; 4]) -> [f64; 4] {
    // Value and derivative of one homogeneous coordinate.
    let horner = |l: usize| {
        let (mut h0, mut h1) = ([0.0; 4], [0.0; 4]);
        for c in c.iter().rev() {
            for j in 0..4 {
                h1[j] = h1[j] * t[j] + h0[j];
                h0[j] = h0[j] * t[j] + c[l];
            }
        }
        (h0, h1)
    };
    let (w, w1) = if RATIONAL { horner(3) } else { ([1.0; 4], [0.0; 4]) };
    let ratio: [f64; 4] = std::array::from_fn(|j| w1[j] / w[j]);
    let mut sum = [0.0; 4];
    for l in 0..D {
        let (h0, h1) = horner(l);
        for j in 0..4 {
            let v = if RATIONAL { h1[j] - ratio[j] * h0[j] } else { h1[j] };
            sum[j] += v * v;
        }
    }
    std::array::from_fn(|j| if RATIONAL { sum[j].sqrt() / w[j] } else { sum[j].sqrt() })
}

/// Value and Taylor coefficients of orders 1 to 3 of a polynomial of degree `N - 1 >= 3`, by Horner's scheme, unrolled.
#[inline(always)]
fn taylor<const N: usize>(c: &[Homogeneous; N], t: f64) -> [Homogeneous; 4] {
    let mut h = [c[N - 1], [0.0; 4], [0.0; 4], [0.0; 4]];
    for step in 0..N - 1 {
        for order in (1..4).rev() {
            if order == step + 1 {
                h[order] = h[order - 1];
            } else if order <= step {
                h[order] = times_plus(&h[order], t, &h[order - 1]);
            }
        }
        h[0] = times_plus(&h[0], t, &c[N - 2 - step]);
    }
    h
}

#[inline(always)]
fn times_plus(a: &Homogeneous, t: f64, b: &Homogeneous) -> Homogeneous {
    [a[0] * t + b[0], a[1] * t + b[1], a[2] * t + b[2], a[3] * t + b[3]]
}

/// As [`taylor`], for any degree.
#[inline(never)]
fn taylor_of_any_degree(c: &[Homogeneous], t: f64) -> [Homogeneous; 4] {
    let mut h = [[0.0; 4]; 4];
    for c in c.iter().rev() {
        h[3] = times_plus(&h[3], t, &h[2]);
        h[2] = times_plus(&h[2], t, &h[1]);
        h[1] = times_plus(&h[1], t, &h[0]);
        h[0] = times_plus(&h[0], t, c);
    }
    h
}
