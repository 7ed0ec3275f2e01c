//! Quadratic B-splines over a stretch of grid: coefficients, and what they are at the knots.

use super::band::Pentadiagonal;

/// The beginning or the end of a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum End {
    /// At rest, beyond one interval of length `h` with constant jerk.
    Rest {
        /// Length of that interval.
        h: f64,
    },
    /// At this squared speed and acceleration.
    Moving {
        /// Squared speed.
        x: f64,
        /// Acceleration at the start; at the end of the path it is 0.
        u: f64,
    },
}

impl End {
    /// Grid intervals outside the spline at this end.
    pub fn rest_intervals(self) -> usize {
        match self {
            Self::Rest { .. } => 1,
            Self::Moving { .. } => 0,
        }
    }

    /// `c[1] / c[0]` of the spline. Behind a rest interval its slope continues that of the interval,
    /// `u = 2 x / 3 h`.
    pub fn ratio(self, h_next: f64) -> f64 {
        match self {
            Self::Rest { h } => 1.0 + 2.0 * h_next / (3.0 * h),
            Self::Moving { x, u } => 1.0 + u * h_next / x,
        }
    }
}

/// Knots of the spline `x(s)`: on interval `k` its Bernstein coefficients are `x_k`, `c[k + 1]`,
/// `x_k+1`.
#[derive(Debug, Clone, Default)]
pub(super) struct Knots {
    /// Lengths of the intervals.
    pub h: Vec<f64>,
    /// Per knot: `x = pa c[k] + pb c[k+1]` and `u = q (c[k+1] - c[k])`.
    pub weights: Vec<[f64; 3]>,
}

/// Values of the spline at the knots (`x`, `u`) and on the intervals (`w`, the value in the
/// middle), and `1 / sqrt(x)` at the knots and in the middles. Changes of a spline have none of the latter.
#[derive(Debug, Clone, Default)]
pub(super) struct Values {
    pub x: Vec<f64>,
    pub u: Vec<f64>,
    pub w: Vec<f64>,
    pub middle: Vec<f64>,
    pub y: Vec<f64>,
    pub middle_y: Vec<f64>,
}

impl Knots {
    pub fn new(h: Vec<f64>) -> Self {
        let m = h.len();
        let weights = (0..=m)
            .map(|k| {
                let before = if k == 0 { 0.0 } else { h[k - 1] };
                let after = if k == m { 0.0 } else { h[k] };
                let q = 1.0 / (before + after);
                [after * q, before * q, q]
            })
            .collect();
        Self { h, weights }
    }

    pub fn intervals(&self) -> usize {
        self.h.len()
    }

    pub fn coefficients(&self) -> usize {
        self.h.len() + 2
    }

    /// `w` and the value in the middle of interval `k` as combinations of `c[k]`, `c[k + 1]`,
    /// `c[k + 2]`.
    pub fn on_interval(&self, k: usize) -> ([f64; 3], [f64; 3]) {
        let ([pa, pb, q0], [na, nb, q1]) = (self.weights[k], self.weights[k + 1]);
        let inverse = 1.0 / self.h[k];
        let w = [q0 * inverse, -(q0 + q1) * inverse, q1 * inverse];
        (w, [0.25 * pa, 0.25 * (pb + 2.0 + na), 0.25 * nb])
    }

    pub fn evaluate(&self, c: &[f64], values: &mut Values) {
        self.evaluate_change(c, values);
        let Values { x, middle, y, middle_y, .. } = values;
        for (y, x) in [(y, x), (middle_y, middle)] {
            y.clear();
            y.extend(x.iter().map(|x| 1.0 / x.sqrt()));
        }
    }

    /// The same for a change of the spline.
    pub fn evaluate_change(&self, c: &[f64], values: &mut Values) {
        values.x.clear();
        values.u.clear();
        values.w.clear();
        values.middle.clear();
        for (k, &[pa, pb, q]) in self.weights.iter().enumerate() {
            values.x.push(pa * c[k] + pb * c[k + 1]);
            values.u.push(q * (c[k + 1] - c[k]));
        }
        for (k, h) in self.h.iter().enumerate() {
            values.w.push((values.u[k + 1] - values.u[k]) / h);
            values.middle.push(0.25 * (values.x[k] + 2.0 * c[k + 1] + values.x[k + 1]));
        }
    }
}

/// Second and first derivatives of a function of the values at one knot: xx, xu, uu and x, u.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct AtKnot {
    pub xx: f64,
    pub xu: f64,
    pub uu: f64,
    pub x: f64,
    pub u: f64,
}

/// The same for one interval: cross terms of `w` with both ends, `w` itself, the middle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OnInterval {
    pub start: [f64; 2],
    pub end: [f64; 2],
    pub ww: f64,
    pub w: f64,
    pub mm: f64,
    pub m: f64,
}

/// Carries second derivatives by values over to second derivatives by coefficients.
pub(super) fn to_coefficients(knots: &Knots, at: &[AtKnot], on: &[OnInterval], matrix: &mut Pentadiagonal) {
    matrix.clear(knots.coefficients());
    for (k, (&[pa, pb, q], d)) in knots.weights.iter().zip(at).enumerate() {
        let (xa, xb) = (d.xx * pa - d.xu * q, d.xx * pb + d.xu * q);
        let (ua, ub) = (d.xu * pa - d.uu * q, d.xu * pb + d.uu * q);
        matrix.rows[k][0] += pa * xa - q * ua;
        matrix.rows[k][1] += pa * xb - q * ub;
        matrix.rows[k + 1][0] += pb * xb + q * ub;
    }
    for (k, d) in on.iter().enumerate() {
        let ([pa, pb, q0], [na, nb, q1]) = (knots.weights[k], knots.weights[k + 1]);
        let (w, m) = knots.on_interval(k);
        let ([sx, su], [ex, eu]) = (d.start, d.end);
        let v = [sx * pa - su * q0, sx * pb + su * q0 + ex * na - eu * q1, ex * nb + eu * q1];
        let entry = |i: usize, j: usize| v[i] * w[j] + w[i] * v[j] + d.ww * w[i] * w[j] + d.mm * m[i] * m[j];
        for i in 0..3 {
            for j in i..3 {
                matrix.rows[k + i][j - i] += entry(i, j);
            }
        }
    }
}

/// Carries first derivatives by values over to first derivatives by coefficients.
pub(super) fn gradient_to_coefficients(knots: &Knots, at: &[AtKnot], on: &[OnInterval], gradient: &mut Vec<f64>) {
    gradient.clear();
    gradient.resize(knots.coefficients(), 0.0);
    for (k, (&[pa, pb, q], d)) in knots.weights.iter().zip(at).enumerate() {
        gradient[k] += pa * d.x - q * d.u;
        gradient[k + 1] += pb * d.x + q * d.u;
    }
    for (k, d) in on.iter().enumerate() {
        let (w, m) = knots.on_interval(k);
        for i in 0..3 {
            gradient[k + i] += d.w * w[i] + d.m * m[i];
        }
    }
}

/// Ties the coefficients at both ends to one variable each (behind rest) or to none (at a given
/// speed); `ratio` is `c[1] / c[0]`. The tied coefficient keeps a row of its own.
pub(super) fn tie_matrix(ends: [End; 2], ratio: [f64; 2], matrix: &mut Pentadiagonal) {
    let rows = &mut matrix.rows;
    let n = rows.len();
    if let End::Rest { .. } = ends[0] {
        let f = 1.0 / ratio[0];
        let [d, e, g] = rows[0];
        rows[1][0] += f * (2.0 * e + f * d);
        rows[1][1] += f * g;
    } else {
        rows[1] = [1.0, 0.0, 0.0];
    }
    rows[0] = [1.0, 0.0, 0.0];
    if let End::Rest { .. } = ends[1] {
        let f = 1.0 / ratio[1];
        let d = rows[n - 1][0];
        rows[n - 2][0] += f * (2.0 * rows[n - 2][1] + f * d);
        rows[n - 3][1] += f * rows[n - 3][2];
    } else {
        rows[n - 2][0] = 1.0;
        rows[n - 3][1] = 0.0;
        rows[n - 4][2] = 0.0;
    }
    rows[n - 2][1] = 0.0;
    rows[n - 3][2] = 0.0;
    rows[n - 1] = [1.0, 0.0, 0.0];
}

/// The same for the right side.
pub(super) fn tie_gradient(ends: [End; 2], ratio: [f64; 2], gradient: &mut [f64]) {
    let n = gradient.len();
    for (i, (inner, outer)) in [(1, 0), (n - 2, n - 1)].into_iter().enumerate() {
        gradient[inner] =
            if let End::Rest { .. } = ends[i] { gradient[inner] + gradient[outer] / ratio[i] } else { 0.0 };
        gradient[outer] = 0.0;
    }
}
