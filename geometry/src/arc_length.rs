//! Curves by arc length: s -> u to near machine precision at sampling speed.

use nalgebra::SVector;

use crate::curve::{Curve, Jet};
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;
use crate::quadrature::check_tolerance;

/// Degree of the polynomials in which `u(s)` is stored. Lower degrees need more pieces, higher ones more arithmetic;
/// at 1e-12 mm on common test curves 13 is fastest.
const DEGREE: usize = 13;
/// Chebyshev nodes at which `|C'|` is sampled while the map is built.
const SPEED_NODES: usize = 18;
/// A knot span is halved at most this often before the curve is said to stand still.
const MAX_HALVINGS: u32 = 36;

/// A NURBS curve by arc length.
///
/// Holds a map `s -> u` in Chebyshev-fitted polynomial pieces, built once to a tolerance; looking a point up takes one
/// polynomial and one curve evaluation, without iteration or allocation, and derivatives come by arc length: `d1` is the
/// unit tangent, `d2` the curvature vector. This replaces the Taylor steps of Liu et al. 2023, eqs. 33-38, which
/// accumulate error, and solves their eq. 39 (corrected: `(S(u) - s)^2`) in advance.
///
/// ```
/// use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, nalgebra::vector};
///
/// let curve = NurbsCurve::bspline(
///     2,
///     vec![vector![0.0, 0.0], vector![1.0, 2.0], vector![3.0, 0.0]],
///     vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
/// )?;
/// let path = ArcLengthCurve::new(curve, 1e-12)?;
/// let middle = path.jet(0.5 * path.length());
/// assert!((middle.d1.norm() - 1.0).abs() < 1e-12);
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ArcLengthCurve<const D: usize> {
    curve: NurbsCurve<D>,
    pieces: Vec<MapPiece>,
    buckets: Vec<u32>,
    bucket_scale: f64,
    length: f64,
}

/// On `[start, end]` of arc length the curve's piece `piece` is run through by the local parameter
/// `t(x) = sum c_k x^k`, `x = (s - middle) * scale` in [-1, 1].
#[derive(Debug, Clone, Copy)]
struct MapPiece {
    start: f64,
    end: f64,
    middle: f64,
    scale: f64,
    c: [f64; DEGREE + 1],
    piece: u32,
}

impl MapPiece {
    #[inline]
    fn x(&self, s: f64) -> f64 {
        ((s - self.middle) * self.scale).max(-1.0).min(1.0)
    }

    /// Local parameter of the curve's piece, by Estrin's scheme (short dependency chains).
    #[inline]
    fn local(&self, s: f64) -> f64 {
        const { assert!(DEGREE == 13) };
        let c = &self.c;
        let x = self.x(s);
        let x2 = x * x;
        let x4 = x2 * x2;
        let x8 = x4 * x4;
        let p = |i: usize| c[i] + c[i + 1] * x;
        let q0 = p(0) + p(2) * x2;
        let q1 = p(4) + p(6) * x2;
        let q2 = p(8) + p(10) * x2;
        let q3 = p(12);
        (q0 + q1 * x4) + (q2 + q3 * x4) * x8
    }
}

/// A place where the direction of the path jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Arc length of the place.
    pub s: f64,
    /// Angle between the tangents before and after, rad.
    pub angle: f64,
}

impl<const D: usize> ArcLengthCurve<D> {
    /// Prepares `curve` for evaluation by arc length, with positions good to `tolerance` (in the curve's unit).
    ///
    /// Below about 1e-15 of the curve's size the tolerance is without effect: double precision ends there.
    ///
    /// # Errors
    /// When the tolerance is not above 0, the curve has no length, or it stands still somewhere (cusp, coincident
    /// control points), so that no derivative by arc length exists there.
    pub fn new(curve: NurbsCurve<D>, tolerance: f64) -> Result<Self, GeometryError> {
        check_tolerance(tolerance)?;
        let size = curve.control_points().iter().fold(0.0f64, |m, p| m.max(p.norm()));
        // A first, rough length: for the floor of the tolerance, for messages, and to find curves without any.
        let rough = curve.arc_length(tolerance.max(1e-9 * size).max(f64::MIN_POSITIVE))?;
        if rough <= 1e-14 * size || rough == 0.0 {
            return Err(GeometryError::ZeroLength { length: rough });
        }
        let tolerance = tolerance.max(2.0 * f64::EPSILON * (size + rough));
        let mut builder = Builder { curve: &curve, tolerance, rough, pieces: Vec::new(), length: 0.0, rest: 0.0 };
        for piece in 0..curve.pieces().frames.len() {
            builder.add(piece, -1.0, 1.0, MAX_HALVINGS)?;
        }
        let (pieces, length) = (builder.pieces, builder.length);

        let count = 8 * pieces.len();
        let bucket_scale = count as f64 / length;
        let mut buckets = Vec::with_capacity(count);
        let mut i = 0;
        for b in 0..count {
            // Half a bucket early: rounding must never start the search behind the place.
            let s = (b as f64 - 0.5) / bucket_scale;
            while i + 1 < pieces.len() && pieces[i].end <= s {
                i += 1;
            }
            buckets.push(i as u32);
        }
        Ok(Self { curve, pieces, buckets, bucket_scale, length })
    }

    /// Length of the curve.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The curve itself, by its own parameter.
    pub fn curve(&self) -> &NurbsCurve<D> {
        &self.curve
    }

    /// Number of polynomial pieces of the map `s -> u`.
    pub fn map_pieces(&self) -> usize {
        self.pieces.len()
    }

    #[inline]
    fn find(&self, s: f64) -> usize {
        let b = (s * self.bucket_scale) as usize;
        let mut i = self.buckets[b.min(self.buckets.len() - 1)] as usize;
        while i + 1 < self.pieces.len() && s >= self.pieces[i].end {
            i += 1;
        }
        i
    }

    /// The curve's own parameter at the arc length `s` (taken to the nearest end outside `[0, length]`).
    pub fn parameter(&self, s: f64) -> f64 {
        let m = &self.pieces[self.find(s)];
        let f = &self.curve.pieces().frames[m.piece as usize];
        (f.middle + m.local(s) / f.scale).max(f.start).min(f.end)
    }

    /// Arc length from the start to the curve's own parameter `u`: the inverse of [`ArcLengthCurve::parameter`].
    pub fn arc_length_at(&self, u: f64) -> f64 {
        let (a, b) = self.curve.domain();
        let u = u.max(a).min(b);
        let piece = self.curve.pieces().find(u);
        let t = self.curve.pieces().local(piece, u);
        // Map pieces are in order of (curve piece, local parameter); `local` at their end tells which one holds t.
        let i = self
            .pieces
            .partition_point(|m| (m.piece as usize) < piece || (m.piece as usize == piece && m.local(m.end) < t));
        let m = &self.pieces[i.min(self.pieces.len() - 1)];
        // t(s) increases on the piece: a bracketed Newton search cannot fail and needs two or three steps.
        let (mut low, mut high) = (m.start, m.end);
        let mut s = 0.5 * (low + high);
        for _ in 0..60 {
            let error = m.local(s) - t;
            if error > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let slope = 1.0 / self.curve.pieces().local_speed(piece, m.local(s));
            let newton = s - error / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - s).abs() <= f64::EPSILON * self.length {
                return next;
            }
            s = next;
        }
        s
    }

    /// Position and derivatives by arc length; `s` outside `[0, length]` is taken to the nearest end. Where
    /// derivatives jump (at knots), those from the right.
    #[inline]
    pub fn jet(&self, s: f64) -> Jet<D> {
        let m = &self.pieces[self.find(s)];
        self.curve.pieces().jet(m.piece as usize, m.local(s)).by_arc_length()
    }

    /// Like [`ArcLengthCurve::jet`], with the derivatives from the left where they jump.
    pub fn jet_left(&self, s: f64) -> Jet<D> {
        let mut i = self.find(s);
        if i > 0 && s <= self.pieces[i].start {
            i -= 1;
        }
        let m = &self.pieces[i];
        self.curve.pieces().jet(m.piece as usize, m.local(s)).by_arc_length()
    }

    /// Position at the arc length `s`.
    #[inline]
    pub fn point(&self, s: f64) -> SVector<f64, D> {
        let m = &self.pieces[self.find(s)];
        self.curve.pieces().point(m.piece as usize, m.local(s))
    }

    /// Arc lengths of the curve's distinct knots, from 0 to the length: where higher derivatives may jump.
    pub fn knots(&self) -> Vec<f64> {
        let mut out = vec![0.0];
        for pair in self.pieces.windows(2) {
            let frames = &self.curve.pieces().frames;
            let (a, b) = (pair[0].piece as usize, pair[1].piece as usize);
            if a != b && self.curve.knots().as_slice().contains(&frames[b].start) {
                out.push(pair[1].start);
            }
        }
        out.push(self.length);
        out
    }

    /// Places inside the path where its direction turns by more than `angle` (rad) at once.
    pub fn corners(&self, angle: f64) -> Vec<Corner> {
        let knots = self.knots();
        knots[1..knots.len() - 1]
            .iter()
            .filter_map(|&s| {
                let (before, after) = (self.jet_left(s).d1, self.jet(s).d1);
                // atan2 of the chord of two unit vectors keeps its accuracy for small angles, unlike acos.
                let turn = 2.0 * ((after - before).norm()).atan2((after + before).norm());
                (turn > angle).then_some(Corner { s, angle: turn })
            })
            .collect()
    }
}

/// Builds the map piece by piece.
struct Builder<'a, const D: usize> {
    curve: &'a NurbsCurve<D>,
    tolerance: f64,
    rough: f64,
    pieces: Vec<MapPiece>,
    length: f64,
    /// What the running sum `length` lost to rounding (Kahan's summation).
    rest: f64,
}

impl<const D: usize> Builder<'_, D> {
    /// Covers the local parameters `[t0, t1]` of a curve piece, halving until both `s(t)` and `t(s)` are resolved.
    fn add(&mut self, piece: usize, t0: f64, t1: f64, halvings: u32) -> Result<(), GeometryError> {
        if let Some(map) = self.fit(piece, t0, t1) {
            self.length = map.end;
            self.pieces.push(map);
            return Ok(());
        }
        let middle = 0.5 * (t0 + t1);
        if halvings == 0 {
            let frame = &self.curve.pieces().frames[piece];
            let (a, b) = self.curve.domain();
            return Err(GeometryError::StandsStill {
                u: frame.middle + middle / frame.scale,
                speed: self.curve.pieces().local_speed(piece, middle) * frame.scale,
                mean: self.rough / (b - a),
            });
        }
        self.add(piece, t0, middle, halvings - 1)?;
        self.add(piece, middle, t1, halvings - 1)
    }

    /// One map piece for `[t0, t1]`, or `None` where its polynomials do not resolve the curve to the tolerance.
    fn fit(&mut self, piece: usize, t0: f64, t1: f64) -> Option<MapPiece> {
        let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
        let nodes = chebyshev::<SPEED_NODES>();
        let mut speed = [0.0; SPEED_NODES];
        for (v, x) in speed.iter_mut().zip(&nodes.points) {
            *v = half * self.curve.pieces().local_speed(piece, middle + half * x);
        }
        let f = nodes.coefficients(&speed);
        let slowest = speed.iter().fold(f64::INFINITY, |m, &v| m.min(v));
        if slowest.is_nan() || slowest <= 0.0 {
            return None;
        }
        // Resolved when the last coefficients are below the tolerance or drowned in rounding.
        let noise = 4.0 * f64::EPSILON * f[0].abs();
        if f[SPEED_NODES - 3..].iter().any(|c| c.abs() > (0.1 * self.tolerance).max(noise)) {
            return None;
        }
        // Integral of the series: s(x) with s(-1) = 0; b_k = (f_{k-1} - f_{k+1}) / 2k.
        let mut b = [0.0; SPEED_NODES + 1];
        for k in 1..=SPEED_NODES {
            let above = if k + 1 < SPEED_NODES { f[k + 1] } else { 0.0 };
            let below = if k == 1 { 2.0 * f[0] } else { f[k - 1] };
            b[k] = (below - above) / (2 * k) as f64;
        }
        b[0] = -(1..=SPEED_NODES).map(|k| if k % 2 == 0 { b[k] } else { -b[k] }).sum::<f64>();
        let total = clenshaw(&b, 1.0);
        if total.is_nan() || total <= 0.0 {
            return None;
        }

        // Invert at Chebyshev nodes of s.
        let out = chebyshev::<{ DEGREE + 1 }>();
        let mut x_at = [0.0; DEGREE + 1];
        for (x, y) in x_at.iter_mut().zip(&out.points) {
            *x = solve_increasing(&b, &f, 0.5 * total * (1.0 + y), *y)?;
        }
        let mut c = out.coefficients(&x_at);
        // An error of c in x moves the point along the curve by about |ds/dx| times as much.
        let fastest = speed.iter().fold(0.0f64, |m, &v| m.max(v));
        let limit = (self.tolerance / fastest).max(4.0 * f64::EPSILON);
        if c[DEGREE - 1].abs() + c[DEGREE].abs() > limit {
            return None;
        }
        // Make the ends exact: x(-1) = -1, x(1) = 1 take up the last rounding, so that pieces join without a gap.
        let (at_end, at_start) = (clenshaw(&c, 1.0), clenshaw(&c, -1.0));
        c[0] -= 0.5 * ((at_end - 1.0) + (at_start + 1.0));
        c[1] -= 0.5 * ((at_end - 1.0) - (at_start + 1.0));
        let mut powers = to_powers(&c);
        powers.iter_mut().for_each(|p| *p *= half);
        powers[0] += middle;

        let start = self.length;
        let add = total - self.rest;
        let end = start + add;
        self.rest = (end - start) - add;
        if end <= start {
            return None;
        }
        Some(MapPiece {
            start,
            end,
            middle: 0.5 * (start + end),
            scale: 2.0 / (end - start),
            c: powers,
            piece: piece as u32,
        })
    }
}

/// Solves `s(x) = target` on [-1, 1] for an increasing series `s` with derivative `f`, by Newton's method inside a
/// bracket.
fn solve_increasing(s: &[f64], f: &[f64], target: f64, guess: f64) -> Option<f64> {
    let (mut low, mut high) = (-1.0, 1.0);
    let mut x = guess;
    for _ in 0..60 {
        let error = clenshaw(s, x) - target;
        if error > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - error / clenshaw(f, x);
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 2.0 * f64::EPSILON {
            return Some(next);
        }
        x = next;
    }
    // The series is not increasing to the last digit: not resolved.
    None
}

/// Chebyshev points of the first kind, with the cosines that turn values into coefficients.
struct Chebyshev<const N: usize> {
    points: [f64; N],
    cosines: [[f64; N]; N],
}

impl<const N: usize> Chebyshev<N> {
    fn coefficients(&self, values: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|k| {
            let sum: f64 = (0..N).map(|j| values[j] * self.cosines[k][j]).sum();
            sum * if k == 0 { 1.0 } else { 2.0 } / N as f64
        })
    }
}

fn chebyshev<const N: usize>() -> Chebyshev<N> {
    let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / N as f64;
    Chebyshev {
        points: std::array::from_fn(|j| angle(j).cos()),
        cosines: std::array::from_fn(|k| std::array::from_fn(|j| (k as f64 * angle(j)).cos())),
    }
}

/// Value of a Chebyshev series.
fn clenshaw(c: &[f64], x: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for &ck in c[1..].iter().rev() {
        (b1, b2) = (2.0 * x * b1 - b2 + ck, b1);
    }
    x * b1 - b2 + c[0]
}

/// A Chebyshev series in powers of x.
fn to_powers<const N: usize>(c: &[f64; N]) -> [f64; N] {
    let mut out = [0.0; N];
    // T_0 = 1, T_1 = x, T_{k+1} = 2 x T_k - T_{k-1}.
    let (mut before, mut now) = ([0.0; N], [0.0; N]);
    before[0] = 1.0;
    now[1] = 1.0;
    out[0] = c[0];
    for (k, ck) in c.iter().enumerate().skip(1) {
        for (o, n) in out.iter_mut().zip(&now) {
            *o += ck * n;
        }
        if k + 1 < N {
            let mut next = [0.0; N];
            for i in 0..N {
                let shifted = if i > 0 { now[i - 1] } else { 0.0 };
                next[i] = 2.0 * shifted - before[i];
            }
            (before, now) = (now, next);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chebyshev_series_and_powers_agree_with_the_function() {
        let nodes = chebyshev::<14>();
        let values = nodes.points.map(|x: f64| (0.3 * x).exp());
        let c = nodes.coefficients(&values);
        let p = to_powers(&c);
        for x in [-1.0, -0.37, 0.0, 0.81, 1.0] {
            let exact = (0.3 * x as f64).exp();
            assert!((clenshaw(&c, x) - exact).abs() < 4e-15);
            assert!((p.iter().rev().fold(0.0, |s, &k| s * x + k) - exact).abs() < 4e-15);
        }
    }
}
