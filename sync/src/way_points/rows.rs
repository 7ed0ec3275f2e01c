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
