//! Natural cubic splines of small vectors, the workhorse of orientation profiles.

/// A twice continuously differentiable cubic spline through values of dimension `K`, with zero second derivative at
/// both ends; two knots give a straight line.
#[derive(Debug, Clone)]
pub(crate) struct CubicSpline<const K: usize> {
    x: Vec<f64>,
    y: Vec<[f64; K]>,
    /// Second derivatives at the knots.
    m: Vec<[f64; K]>,
}

impl<const K: usize> CubicSpline<K> {
    /// Through `y[i]` at `x[i]`; the caller has checked that `x` increases and that there are at least two.
    pub fn natural(x: Vec<f64>, y: Vec<[f64; K]>) -> Self {
        let n = x.len();
        let mut m = vec![[0.0; K]; n];
        // Thomas' algorithm on h[i-1] m[i-1] + 2 (h[i-1] + h[i]) m[i] + h[i] m[i+1] = 6 (slope[i] - slope[i-1]).
        let mut upper = vec![0.0; n];
        for i in 1..n.saturating_sub(1) {
            let (h0, h1) = (x[i] - x[i - 1], x[i + 1] - x[i]);
            let pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
            upper[i] = h1 / pivot;
            #[allow(clippy::needless_range_loop)] // three arrays run in step
            for k in 0..K {
                let jump = (y[i + 1][k] - y[i][k]) / h1 - (y[i][k] - y[i - 1][k]) / h0;
                m[i][k] = (6.0 * jump - h0 * m[i - 1][k]) / pivot;
            }
        }
        for i in (1..n.saturating_sub(1)).rev() {
            let after = m[i + 1];
            for (value, next) in m[i].iter_mut().zip(after) {
                *value -= upper[i] * next;
            }
        }
        Self { x, y, m }
    }

    pub fn knots(&self) -> &[f64] {
        &self.x
    }

    /// Value and three derivatives at `x`, at a knot the third one from the right; beyond the ends the outer pieces go on.
    #[inline]
    pub fn at(&self, x: f64) -> ([f64; K], [f64; K], [f64; K], [f64; K]) {
        self.on(self.x[1..self.x.len() - 1].partition_point(|&k| k <= x), x)
    }

    /// Like [`CubicSpline::at`], with the third derivative from the left.
    pub fn at_left(&self, x: f64) -> ([f64; K], [f64; K], [f64; K], [f64; K]) {
        self.on(self.x[1..self.x.len() - 1].partition_point(|&k| k < x), x)
    }

    /// Value and three derivatives of piece `i`.
    #[inline]
    fn on(&self, i: usize, x: f64) -> ([f64; K], [f64; K], [f64; K], [f64; K]) {
        let h = self.x[i + 1] - self.x[i];
        let d = x - self.x[i];
        let mut out = ([0.0; K], [0.0; K], [0.0; K], [0.0; K]);
        for k in 0..K {
            let (m0, m1) = (self.m[i][k], self.m[i + 1][k]);
            let c3 = (m1 - m0) / (6.0 * h);
            let c1 = (self.y[i + 1][k] - self.y[i][k]) / h - h * (2.0 * m0 + m1) / 6.0;
            out.0[k] = self.y[i][k] + d * (c1 + d * (0.5 * m0 + d * c3));
            out.1[k] = c1 + d * (m0 + 3.0 * d * c3);
            out.2[k] = m0 + 6.0 * d * c3;
            out.3[k] = 6.0 * c3;
        }
        out
    }
}
