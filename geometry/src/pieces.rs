//! Evaluation of a spline: power-basis pieces, one or more to a knot span.

use nalgebra::SVector;

use crate::bezier::{self, Homogeneous};
use crate::curve::Jet;
use crate::knots::KnotVector;
use crate::span::part_powers;

/// Up to this degree a knot span is one polynomial piece; above it the span is halved, so that the centred power basis
/// stays accurate to a few units in the last place whatever the degree.
const DEGREE_OF_ONE_PIECE: usize = 5;

/// Entries of the table that finds the piece of a parameter, per piece.
const BUCKETS_PER_PIECE: usize = 16;

/// The place of a piece in the curve's parameter: `t = (u - middle - rest) * scale` runs over [-1, 1].
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
    pub rational: bool,
    buckets: Vec<u32>,
    bucket_scale: f64,
    /// First and last parameter.
    pub domain: (f64, f64),
}

impl Pieces {
    pub fn build(knots: &KnotVector, points: &[Homogeneous], rational: bool) -> Self {
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
    pub fn ends<const D: usize>(&self, knots: &KnotVector, points: &[SVector<f64, D>]) -> [SVector<f64, D>; 2] {
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
