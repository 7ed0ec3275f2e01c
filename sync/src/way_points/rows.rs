//! A section of three parts with constant jerk, and what its limits bound.
//!
//! The outer parts last the same share of the section. Displacement, velocities and accelerations at
//! both ends determine the three jerks. With the duration `T` every bounded quantity is
//!
//! ```text
//! q = T^-n (f0 (p1 - p0) + T (f1 v0 + f2 v1) + T² (f3 a0 + f4 a1)),
//! ```
//!
//! `n = 3` for the jerks, 2 for the accelerations between the parts and 1 for velocities: after the
//! first acceleration and before the last one are brought to zero within half an outer part, and in
//! the middle of the section. Between them the velocity may exceed its limit by a little: the
//! sections that are handed out are computed and checked exactly.

/// Bounded quantities of a section.
pub(super) const ROWS: usize = 8;

/// The number for each axis.
pub(super) type Lanes<const N: usize> = [f64; N];

/// The factors `f0` to `f4` of the rows of a section.
pub(super) type Shape = [[f64; 5]; ROWS];

/// The order of the derivative that a row bounds, from 1 for the velocity.
pub(super) const fn order(row: usize) -> usize {
    [3, 3, 3, 2, 2, 1, 1, 1][row]
}

/// The rows of a section whose outer parts last a share `outer` of it each, below one half.
pub(super) fn shape(outer: f64) -> Shape {
    let (x, y) = (outer, 1.0 - 2.0 * outer);
    // A piecewise linear acceleration is a sum of hats over its four knots: their integrals, and
    // their first moments.
    let hat = 0.5 * (x + y);
    let moment = x * x / 3.0 + 0.5 * x * y + y * y / 6.0;
    // Inner accelerations: their sum from the change of velocity, the first from the displacement.
    let sum = [0.0, -1.0, 1.0, -0.5 * x, -0.5 * x].map(|f| f / hat);
    let way = [1.0, -1.0, 0.0, x * x / 6.0 - 0.5 * x, -x * x / 6.0];
    let first: [f64; 5] = std::array::from_fn(|i| (way[i] - moment * sum[i]) / (hat - 2.0 * moment));
    let second: [f64; 5] = std::array::from_fn(|i| sum[i] - first[i]);
    let (begin, end) = ([0.0, 0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]);
    let slope = |from: &[f64; 5], to: &[f64; 5], time: f64| std::array::from_fn(|i| (to[i] - from[i]) / time);
    let middle = std::array::from_fn(|i| {
        let [v0, v1] = [f64::from(i == 1), f64::from(i == 2)];
        let (inner, outer) = (first[i] - second[i], begin[i] - end[i]);
        0.5 * (v0 + v1) + 0.25 * x * outer + (0.25 * x + 0.125 * y) * inner
    });
    [
        slope(&begin, &first, x),
        slope(&first, &second, y),
        slope(&second, &end, x),
        first,
        second,
        [0.0, 1.0, 0.0, 0.5 * x, 0.0],
        middle,
        [0.0, 0.0, 1.0, 0.0, -0.5 * x],
    ]
}

/// Displacement, velocities and accelerations at the ends of a section.
pub(super) fn ends<const N: usize>(from: &[Lanes<N>; 3], to: &[Lanes<N>; 3]) -> [Lanes<N>; 5] {
    let mut way = [0.0; N];
    for k in 0..N {
        way[k] = to[0][k] - from[0][k];
    }
    [way, from[1], to[1], from[2], to[2]]
}

/// A row `T^n q` as a polynomial of the duration.
pub(super) struct Polynomial<const N: usize> {
    constant: Lanes<N>,
    linear: Lanes<N>,
    square: Lanes<N>,
}

impl<const N: usize> Polynomial<N> {
    pub fn new(factors: &[f64; 5], ends: &[Lanes<N>; 5]) -> Self {
        let mut all = Self { constant: [0.0; N], linear: [0.0; N], square: [0.0; N] };
        for k in 0..N {
            all.constant[k] = factors[0] * ends[0][k];
            all.linear[k] = factors[1] * ends[1][k] + factors[2] * ends[2][k];
            all.square[k] = factors[3] * ends[3][k] + factors[4] * ends[4][k];
        }
        all
    }

    pub fn value(&self, t: f64) -> Lanes<N> {
        std::array::from_fn(|k| self.constant[k] + t * (self.linear[k] + t * self.square[k]))
    }

    /// The derivative by the duration.
    pub fn slope(&self, t: f64) -> Lanes<N> {
        std::array::from_fn(|k| self.linear[k] + 2.0 * t * self.square[k])
    }

    /// The second derivative by the duration.
    pub fn curvature(&self) -> Lanes<N> {
        std::array::from_fn(|k| 2.0 * self.square[k])
    }
}

/// `T^n` with its first and second derivative, for the orders from 1.
pub(super) fn powers(t: f64) -> [[f64; 3]; 3] {
    [[t, 1.0, 0.0], [t * t, 2.0 * t, 2.0], [t * t * t, 3.0 * t * t, 6.0 * t]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The jerks of the rows, integrated, lead from one end to the other; the other rows are read on
    /// the way.
    #[test]
    fn rows_are_those_of_three_phases() {
        let (begin, end) = ([0.3, -0.7, 1.1], [0.9, 0.4, -2.0]);
        for (outer, t) in [(1.0 / 3.0, 1.0), (0.2, 0.7), (0.27, 2.5)] {
            let ends = ends(&begin.map(|x| [x]), &end.map(|x| [x]));
            let shape = shape(outer);
            let row = |r: usize| Polynomial::new(&shape[r], &ends).value(t)[0] / powers(t)[order(r) - 1][0];
            let [mut p, mut v, mut a] = begin;
            let mut advance = |j: f64, dt: f64| {
                p += dt * (v + dt * (a / 2.0 + dt * j / 6.0));
                v += dt * (a + dt * j / 2.0);
                a += dt * j;
                [p, v, a]
            };
            let close = |x: f64, y: f64| assert!((x - y).abs() < 1e-11 * (1.0 + x.abs()), "{x} {y}");
            let (x, y) = (outer * t, (1.0 - 2.0 * outer) * t);
            close(row(5), begin[1] + 0.5 * x * begin[2]);
            close(row(3), advance(row(0), x)[2]);
            close(row(6), advance(row(1), 0.5 * y)[1]);
            close(row(4), advance(row(1), 0.5 * y)[2]);
            close(row(7), end[1] - 0.5 * x * end[2]);
            for (reached, wanted) in advance(row(2), x).into_iter().zip(end) {
                close(reached, wanted);
            }
        }
    }

    #[test]
    fn slopes_are_differences() {
        let ends = [[0.6], [-0.7], [0.4], [1.1], [-2.0]];
        for factors in shape(0.25) {
            let row = Polynomial::new(&factors, &ends);
            let at = |t: f64| row.value(t)[0];
            let (t, h) = (0.8, 1e-4);
            assert!((row.slope(t)[0] - (at(t + h) - at(t - h)) / (2.0 * h)).abs() < 1e-8);
            assert!((row.curvature()[0] - (at(t + h) - 2.0 * at(t) + at(t - h)) / (h * h)).abs() < 1e-5);
        }
    }
}
