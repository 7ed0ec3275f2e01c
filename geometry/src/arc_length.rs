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
const SPEED_NODES: usize = 20;
/// A piece is resolved when Newton's method inverts it in this many steps; from a straight line it takes four or five.
const MOST_STEPS: usize = 10;
/// On one piece of the map the speed `|C'|` drops by this factor at most. Where a curve stands still it never gets there:
/// some node or end is nearer to the place than a tenth of the piece.
const SLOWEST: f64 = 0.1;
/// Entries of the table that finds the piece of an arc length, per piece.
const BUCKETS_PER_PIECE: usize = 8;
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
    /// The curve's own parameter at the end of each piece.
    ends: Vec<f64>,
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

impl MapPiece {
    /// Local parameter of the curve's piece and its derivative by arc length.
    fn local_and_slope(&self, s: f64) -> (f64, f64) {
        let x = self.x(s);
        let (mut t, mut slope) = (0.0, 0.0);
        for c in self.c.iter().rev() {
            slope = slope * x + t;
            t = t * x + c;
        }
        (t, slope * self.scale)
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
    /// Fails when the tolerance is not above 0, the curve has no length, or it stands still somewhere (cusp, coincident
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
        let mut builder = Builder {
            curve: &curve,
            tolerance,
            rough,
            pieces: Vec::new(),
            length: 0.0,
            lost: 0.0,
            speed_nodes: Chebyshev::new(),
            map_nodes: Chebyshev::new(),
        };
        for piece in 0..curve.pieces().frames.len() {
            builder.add(piece, -1.0, 1.0, MAX_HALVINGS)?;
        }
        let (pieces, length) = (builder.pieces, builder.length);

        let own = |m: &MapPiece| curve.pieces().frames[m.piece as usize].parameter(m.local(m.end));
        let ends = pieces.iter().map(own).collect();
        let count = BUCKETS_PER_PIECE * pieces.len();
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
        Ok(Self { curve, pieces, ends, buckets, bucket_scale, length })
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

    /// Arc lengths at which the pieces of the map end, the last at the length.
    ///
    /// A piece is as long as the speed `|C'|` is smooth, so that the ends crowd around sharp bends: between two of them
    /// no bend hides.
    pub fn map_ends(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.pieces.iter().map(|piece| piece.end)
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
        // The ends exactly; the rest of the computation rounds.
        if s >= self.length {
            return self.curve.domain().1;
        } else if s.is_nan() || s <= 0.0 {
            return self.curve.domain().0;
        }
        let m = &self.pieces[self.find(s)];
        self.curve.pieces().frames[m.piece as usize].parameter(m.local(s))
    }

    /// Arc length from the start to the curve's own parameter `u`: the inverse of [`ArcLengthCurve::parameter`].
    pub fn arc_length_at(&self, u: f64) -> f64 {
        let (a, b) = self.curve.domain();
        // The ends exactly; the rest of the computation rounds.
        if u >= b {
            return self.length;
        } else if u.is_nan() || u <= a {
            return 0.0;
        }
        let i = self.ends.partition_point(|&end| end < u).min(self.pieces.len() - 1);
        let m = &self.pieces[i];
        let t = self.curve.pieces().local(m.piece as usize, u);
        // t(s) increases on the piece and is nearly straight: Newton's method, kept on the piece, needs a few steps.
        let mut s = m.middle;
        for _ in 0..MOST_STEPS {
            let (at, slope) = m.local_and_slope(s);
            let next = (s - (at - t) / slope).max(m.start).min(m.end);
            let step = (next - s).abs();
            s = next;
            if step <= 4.0 * f64::EPSILON * self.length {
                break;
            }
        }
        s
    }

    /// Position and derivatives by arc length; `s` outside `[0, length]` is taken to the nearest end. Where
    /// derivatives jump (at knots), those from the right.
    #[inline]
    pub fn jet(&self, s: f64) -> Jet<D> {
        let m = &self.pieces[self.find(s)];
        self.with_end(s, self.curve.pieces().jet_by_arc_length(m.piece as usize, m.local(s)))
    }

    /// Like [`ArcLengthCurve::jet`], with the derivatives from the left where they jump.
    pub fn jet_left(&self, s: f64) -> Jet<D> {
        let mut i = self.find(s);
        if i > 0 && s <= self.pieces[i].start {
            i -= 1;
        }
        let m = &self.pieces[i];
        self.with_end(s, self.curve.pieces().jet_by_arc_length(m.piece as usize, m.local(s)))
    }

    /// The jet with the exact point at the ends.
    #[inline(always)]
    fn with_end(&self, s: f64, jet: Jet<D>) -> Jet<D> {
        match self.curve.end(s, (0.0, self.length)) {
            Some(&point) => Jet { point, ..jet },
            None => jet,
        }
    }

    /// Position at the arc length `s`.
    #[inline]
    pub fn point(&self, s: f64) -> SVector<f64, D> {
        if let Some(&end) = self.curve.end(s, (0.0, self.length)) {
            return end;
        }
        let m = &self.pieces[self.find(s)];
        self.curve.pieces().point(m.piece as usize, m.local(s))
    }

    /// Arc lengths of the curve's distinct knots, from 0 to the length: where higher derivatives may jump.
    pub fn knots(&self) -> Vec<f64> {
        let mut out = vec![0.0];
        for pair in self.pieces.windows(2) {
            let frames = &self.curve.pieces().frames;
            let (a, b) = (pair[0].piece as usize, pair[1].piece as usize);
            // The knots are sorted, and pieces start at them exactly.
            if a != b && self.curve.knots().as_slice().binary_search_by(|k| k.total_cmp(&frames[b].start)).is_ok() {
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
    /// The error that the running sum `length` gained by rounding (Kahan's summation).
    lost: f64,
    speed_nodes: Chebyshev<SPEED_NODES>,
    map_nodes: Chebyshev<{ DEGREE + 1 }>,
}

impl<const D: usize> Builder<'_, D> {
    /// Covers the local parameters `[t0, t1]` of a curve piece, halving until both `s(t)` and `t(s)` are resolved.
    fn add(&mut self, piece: usize, t0: f64, t1: f64, halvings: u32) -> Result<(), GeometryError> {
        if let Some((total, c)) = self.fit(piece, t0, t1) {
            let start = self.length;
            let add = total - self.lost;
            let end = start + add;
            if end > start {
                self.lost = (end - start) - add;
                self.length = end;
                let (middle, scale) = (0.5 * (start + end), 2.0 / (end - start));
                self.pieces.push(MapPiece { start, end, middle, scale, c, piece: piece as u32 });
                return Ok(());
            }
            // Shorter than the resolution of the arc length: no place falls into it. Its length waits for the next.
            self.lost -= total;
            return Ok(());
        }
        let middle = 0.5 * (t0 + t1);
        if halvings == 0 {
            let frame = &self.curve.pieces().frames[piece];
            let (a, b) = self.curve.domain();
            return Err(GeometryError::StandsStill {
                u: frame.parameter(middle),
                speed: self.curve.pieces().local_speed(piece, middle) * frame.scale,
                mean: self.rough / (b - a),
            });
        }
        self.add(piece, t0, middle, halvings - 1)?;
        self.add(piece, middle, t1, halvings - 1)
    }

    /// Length of `[t0, t1]` and the coefficients of its map, or `None` where polynomials do not resolve it to the
    /// tolerance.
    fn fit(&self, piece: usize, t0: f64, t1: f64) -> Option<(f64, [f64; DEGREE + 1])> {
        let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
        let pieces = self.curve.pieces();
        let at = self.speed_nodes.points.map(|x| middle + half * x);
        let speed = pieces.local_speeds::<D, SPEED_NODES>(piece, &at).map(|v| half * v);
        let (slowest, fastest) = speed.iter().fold((f64::INFINITY, 0.0f64), |(a, b), &v| (a.min(v), b.max(v)));
        let ends = half * pieces.local_speed(piece, t0).min(pieces.local_speed(piece, t1));
        // NaN is dropped by `min` and `max`, and then nothing or infinity is left.
        if slowest.min(ends) <= SLOWEST * fastest || !fastest.is_finite() || fastest == 0.0 {
            return None;
        }
        let f = self.speed_nodes.coefficients(&speed);
        // Resolved when the last coefficients are below the tolerance or drowned in rounding; of the noise of the single
        // values a quarter is left in a coefficient.
        let noise = (4.0 * f64::EPSILON * f[0].abs()).max(0.25 * half * pieces.speed_noise(piece));
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
        // s(1): all T_k(1) are 1.
        let total = b.iter().rev().sum::<f64>();
        if total.is_nan() || total <= 0.0 {
            return None;
        }

        // Invert at Chebyshev nodes of s.
        let x_at = solve_increasing(&b, &f, total, &self.map_nodes.points)?;
        let mut c = self.map_nodes.coefficients(&x_at);
        // An error of c in x moves the point along the curve by about |ds/dx| times as much.
        let limit = (self.tolerance / fastest).max(4.0 * f64::EPSILON).max(noise / fastest);
        if c[DEGREE - 1].abs() + c[DEGREE].abs() > limit {
            return None;
        }
        // Make the ends exact: x(-1) = -1, x(1) = 1 take up the last rounding, so that pieces join without a gap.
        let at_end = c.iter().rev().sum::<f64>();
        let at_start = c.iter().enumerate().rev().map(|(k, c)| if k % 2 == 0 { *c } else { -c }).sum::<f64>();
        c[0] -= 0.5 * ((at_end - 1.0) + (at_start + 1.0));
        c[1] -= 0.5 * ((at_end - 1.0) - (at_start + 1.0));
        let mut powers = self.map_nodes.to_powers(&c).map(|p| p * half);
        powers[0] += middle;
        Some((total, powers))
    }
}

/// Solves `s(x) = total (1 + y) / 2` on [-1, 1] for all `y`, with an increasing series `s` from 0 to `total` and its
/// derivative `f`, by Newton's method. `None` where it does not settle: the series is not resolved then.
fn solve_increasing<const N: usize>(
    s: &[f64; SPEED_NODES + 1],
    f: &[f64; SPEED_NODES],
    total: f64,
    y: &[f64; N],
) -> Option<[f64; N]> {
    let mut x = *y;
    for _ in 0..MOST_STEPS {
        let (at, slope) = (clenshaw(s, &x), clenshaw(f, &x));
        let mut largest = 0.0f64;
        for j in 0..N {
            let next = (x[j] - (at[j] - 0.5 * total * (1.0 + y[j])) / slope[j]).max(-1.0).min(1.0);
            largest = largest.max((next - x[j]).abs());
            x[j] = next;
        }
        // The error is squared from step to step.
        if largest <= 1e-9 {
            return Some(x);
        }
    }
    None
}

/// Chebyshev points of the first kind, with what turns values into coefficients and those into powers.
struct Chebyshev<const N: usize> {
    points: [f64; N],
    /// `T_k(x_j)`, by `k`.
    values: [[f64; N]; N],
    /// Coefficients of `T_k` by powers.
    powers: [[f64; N]; N],
}

impl<const N: usize> Chebyshev<N> {
    fn new() -> Self {
        // All the cosines needed are those of multiples of pi / 2N, each to the last digit.
        let cosine = |m: usize| (std::f64::consts::PI * m as f64 / (2 * N) as f64).cos();
        let quarter: [f64; N] = std::array::from_fn(cosine);
        let cosine = |m: usize| match m % (4 * N) {
            m if m < N => quarter[m],
            m if m == N || m == 3 * N => 0.0,
            m if m < 2 * N => -quarter[2 * N - m],
            m if m == 2 * N => -1.0,
            m if m < 3 * N => -quarter[m - 2 * N],
            m => quarter[4 * N - m],
        };
        let mut powers = [[0.0; N]; N];
        powers[0][0] = 1.0;
        powers[1][1] = 1.0;
        for k in 2..N {
            // T_k = 2 x T_{k-1} - T_{k-2}.
            for i in 0..N {
                let shifted = if i > 0 { powers[k - 1][i - 1] } else { 0.0 };
                powers[k][i] = 2.0 * shifted - powers[k - 2][i];
            }
        }
        Self {
            points: std::array::from_fn(|j| cosine(2 * j + 1)),
            values: std::array::from_fn(|k| std::array::from_fn(|j| cosine(k * (2 * j + 1)))),
            powers,
        }
    }

    fn coefficients(&self, values: &[f64; N]) -> [f64; N] {
        let mut c = self.values.each_ref().map(|row| {
            let sum: f64 = row.iter().zip(values).map(|(r, v)| r * v).sum();
            // Divided last: the coefficients of a constant are exact.
            2.0 * sum / N as f64
        });
        c[0] *= 0.5;
        c
    }

    /// A Chebyshev series in powers of x.
    fn to_powers(&self, c: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        // The small terms first.
        for (ck, row) in c.iter().zip(&self.powers).rev() {
            for (o, p) in out.iter_mut().zip(row) {
                *o += ck * p;
            }
        }
        out
    }
}

/// Values of a Chebyshev series at several places at once: the loop over the places becomes vector instructions.
#[inline]
fn clenshaw<const N: usize>(c: &[f64], x: &[f64; N]) -> [f64; N] {
    let (mut b1, mut b2) = ([0.0; N], [0.0; N]);
    for &ck in c[1..].iter().rev() {
        for j in 0..N {
            (b1[j], b2[j]) = (2.0 * x[j] * b1[j] - b2[j] + ck, b1[j]);
        }
    }
    std::array::from_fn(|j| x[j] * b1[j] - b2[j] + c[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chebyshev_series_and_powers_agree_with_the_function() {
        let nodes = Chebyshev::<14>::new();
        let values = nodes.points.map(|x: f64| (0.3 * x).exp());
        let c = nodes.coefficients(&values);
        let p = nodes.to_powers(&c);
        for x in [-1.0f64, -0.37, 0.0, 0.81, 1.0] {
            let exact = (0.3 * x).exp();
            assert!((clenshaw(&c, &[x])[0] - exact).abs() < 4e-15);
            assert!((p.iter().rev().fold(0.0, |s, &k| s * x + k) - exact).abs() < 4e-15);
        }
    }
}
