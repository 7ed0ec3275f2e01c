//! The map from arc length to the parameter of a curve, built piece by piece.

use super::chebyshev::{Chebyshev, clenshaw};
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// Degree of the polynomials in which `u(s)` is stored. Lower degrees need more pieces, higher ones more arithmetic;
/// at 1e-12 mm on common test curves 13 is fastest.
const DEGREE: usize = 13;
/// Chebyshev nodes at which `|C'|` is sampled while the map is built.
const SPEED_NODES: usize = 20;
/// A piece is resolved when Newton's method inverts it in this many steps; from a straight line it takes four or five.
pub(super) const MOST_STEPS: usize = 10;
/// On one piece of the map the speed `|C'|` drops by this factor at most. Where a curve stands still it never gets there:
/// some node or end is nearer to the place than a tenth of the piece.
const SLOWEST: f64 = 0.1;

/// On `[start, end]` of arc length the curve's piece `piece` is run through by the local parameter
/// `t(x) = sum c_k x^k`, `x = (s - middle) * scale` in [-1, 1].
#[derive(Debug, Clone, Copy)]
pub(super) struct MapPiece {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) middle: f64,
    pub(super) scale: f64,
    pub(super) c: [f64; DEGREE + 1],
    pub(super) piece: u32,
}

impl MapPiece {
    #[inline]
    pub(super) fn x(&self, s: f64) -> f64 {
        ((s - self.middle) * self.scale).max(-1.0).min(1.0)
    }

    /// Local parameter of the curve's piece, by Estrin's scheme (short dependency chains).
    #[inline]
    pub(super) fn local(&self, s: f64) -> f64 {
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
    pub(super) fn local_and_slope(&self, s: f64) -> (f64, f64) {
        let x = self.x(s);
        let (mut t, mut slope) = (0.0, 0.0);
        for c in self.c.iter().rev() {
            slope = slope * x + t;
            t = t * x + c;
        }
        (t, slope * self.scale)
    }
}

/// Builds the map piece by piece.
pub(super) struct Builder<'a, const D: usize> {
    pub(super) curve: &'a NurbsCurve<D>,
    pub(super) tolerance: f64,
    pub(super) rough: f64,
    pub(super) pieces: Vec<MapPiece>,
    pub(super) length: f64,
    /// The error that the running sum `length` gained by rounding (Kahan's summation).
    pub(super) lost: f64,
    pub(super) speed_nodes: Chebyshev<SPEED_NODES>,
    pub(super) map_nodes: Chebyshev<{ DEGREE + 1 }>,
}

impl<const D: usize> Builder<'_, D> {
    /// Covers the local parameters `[t0, t1]` of a curve piece, halving until both `s(t)` and `t(s)` are resolved.
    pub(super) fn add(&mut self, piece: usize, t0: f64, t1: f64, halvings: u32) -> Result<(), GeometryError> {
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
    pub(super) fn fit(&self, piece: usize, t0: f64, t1: f64) -> Option<(f64, [f64; DEGREE + 1])> {
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
