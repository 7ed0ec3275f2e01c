//! Rational Bezier pieces in homogeneous form: evaluation, restriction to a part, Bernstein to power basis.

use nalgebra::SVector;

/// A homogeneous control point `[w x, w y, w z, w]`; unused coordinates are 0.
///
/// Four lanes whatever the dimension, so that plane and space curves run through the same vectorised code.
pub(crate) type Homogeneous = [f64; 4];

#[inline(always)]
pub(crate) fn lerp(a: &Homogeneous, b: &Homogeneous, t: f64) -> Homogeneous {
    let s = 1.0 - t;
    [s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2], s * a[3] + t * b[3]]
}

/// The Euclidean point of a homogeneous one.
#[inline(always)]
pub(crate) fn project<const D: usize>(h: &Homogeneous) -> SVector<f64, D> {
    let iw = 1.0 / h[3];
    SVector::from_fn(|i, _| h[i] * iw)
}

/// One rational Bezier piece of a curve, with the parameter interval `[m, n]` of the curve that it covers.
///
/// By keeping the interval, derivatives of the piece can be taken by the parameter of the whole curve, and neighbouring
/// pieces stay as smooth as the curve was (Liu et al. 2023, eqs. 25-31; eq. 28, corrected: `u = (mu - m) / (n - m)`).
#[derive(Debug, Clone, PartialEq)]
pub struct RationalBezier<const D: usize> {
    interval: (f64, f64),
    homogeneous: Vec<Homogeneous>,
}

impl<const D: usize> RationalBezier<D> {
    pub(crate) fn from_homogeneous(interval: (f64, f64), homogeneous: Vec<Homogeneous>) -> Self {
        Self { interval, homogeneous }
    }

    /// Degree of the piece.
    pub fn degree(&self) -> usize {
        self.homogeneous.len() - 1
    }

    /// First and last parameter of the whole curve that the piece covers.
    pub fn interval(&self) -> (f64, f64) {
        self.interval
    }

    /// Control points, not multiplied by their weights.
    pub fn control_points(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.homogeneous.iter().map(project)
    }

    /// Weights, as they come out of the decomposition (not normalised).
    pub fn weights(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.homogeneous.iter().map(|h| h[3])
    }

    pub(crate) fn homogeneous(&self) -> &[Homogeneous] {
        &self.homogeneous
    }

    /// Point at the parameter `u` of the whole curve (de Casteljau's algorithm; allocates, meant for checks).
    pub fn point(&self, u: f64) -> SVector<f64, D> {
        let (a, b) = self.interval;
        let t = (u - a) / (b - a);
        let mut h = self.homogeneous.clone();
        for r in (1..h.len()).rev() {
            for i in 0..r {
                h[i] = lerp(&h[i], &h[i + 1], t);
            }
        }
        project(&h[0])
    }

    /// The part between the parameters `u0 < u1` of the whole curve, as a piece of its own.
    ///
    /// Parameters outside the piece's interval extrapolate.
    pub fn restricted(&self, u0: f64, u1: f64) -> Self {
        let mut out = self.homogeneous.clone();
        let (a, b) = self.interval;
        restrict(&mut out, (u0 - a) / (b - a), (u1 - a) / (b - a));
        Self { interval: (u0, u1), homogeneous: out }
    }
}

/// Restricts Bezier control points in place to the local parameters `[t0, t1]` of `[0, 1]`, by two rounds of
/// de Casteljau.
#[inline]
pub(crate) fn restrict(h: &mut [Homogeneous], t0: f64, t1: f64) {
    keep_left(h, t1);
    if t1 != 0.0 {
        keep_right(h, t0 / t1);
    }
}

/// Control points of the part `[0, t]`.
#[inline(always)]
pub(crate) fn keep_left(h: &mut [Homogeneous], t: f64) {
    let n = h.len();
    for r in 1..n {
        for i in (r..n).rev() {
            h[i] = lerp(&h[i - 1], &h[i], t);
        }
    }
}

/// Control points of the part `[t, 1]`.
#[inline(always)]
pub(crate) fn keep_right(h: &mut [Homogeneous], t: f64) {
    let n = h.len();
    for r in (1..n).rev() {
        for i in 0..r {
            h[i] = lerp(&h[i], &h[i + 1], t);
        }
    }
}

/// Coefficients in powers of `t` in [-1, 1] (the middle of the piece is 0) of Bezier control points.
///
/// About the middle the conversion loses next to nothing for the degrees in use; see `DEGREE_OF_ONE_PIECE` for higher
/// ones.
pub(crate) fn to_centred_powers(h: &[Homogeneous], out: &mut Vec<Homogeneous>) {
    let p = h.len() - 1;
    let first = out.len();
    out.resize(first + p + 1, [0.0; 4]);
    let mut binomial = 1.0;
    let scale = 0.5f64.powi(p as i32);
    // Coefficients of (1 + t)^i (1 - t)^(p - i), built for i = 0 and then updated: multiply by (1+t), divide by (1-t)
    // would lose digits, so each is multiplied out afresh; p is small.
    let mut poly = vec![0.0; p + 1];
    for (i, b) in h.iter().enumerate() {
        poly.iter_mut().for_each(|c| *c = 0.0);
        poly[0] = 1.0;
        for k in 0..p {
            let sign = if k < i { 1.0 } else { -1.0 };
            for m in (1..=k + 1).rev() {
                poly[m] += sign * poly[m - 1];
            }
        }
        for (m, c) in poly.iter().enumerate() {
            let f = scale * binomial * c;
            for lane in 0..4 {
                out[first + m][lane] += f * b[lane];
            }
        }
        binomial = binomial * (p - i) as f64 / (i + 1) as f64;
    }
}
