//! A section of three equal parts with constant jerk, and what its limits bound.
//!
//! Displacement, velocities and accelerations at both ends determine the three jerks. With
//! `h = T / 3` every bounded quantity is
//!
//! ```text
//! q = d h^-n (p1 - p0) + h^(1-n) (b0 v0 + b1 v1) + h^(2-n) (c0 a0 + c1 a1),
//! ```
//!
//! `n = 3` for the jerks, 2 for the accelerations between the parts and 1 for the control points of
//! the velocity. The velocity lies in the hull of its control points (a quadratic B-spline).

/// Bounded quantities of a section.
pub(super) const ROWS: usize = 8;

/// The number for each axis.
pub(super) type Lanes<const N: usize> = [f64; N];

/// One bounded quantity.
pub(super) struct Row {
    /// Exponent `n`, which is the order of the derivative.
    order: usize,
    /// Factors of displacement, velocities and accelerations.
    factors: [f64; 5],
}

const fn row(order: usize, factors: [f64; 5]) -> Row {
    Row { order, factors }
}

const TABLE: [Row; ROWS] = [
    row(3, [1.0, -2.0, -1.0, -11.0 / 6.0, 1.0 / 3.0]),
    row(3, [-2.0, 3.0, 3.0, 7.0 / 6.0, -7.0 / 6.0]),
    row(3, [1.0, -1.0, -2.0, -1.0 / 3.0, 11.0 / 6.0]),
    row(2, [1.0, -2.0, -1.0, -5.0 / 6.0, 1.0 / 3.0]),
    row(2, [-1.0, 1.0, 2.0, 1.0 / 3.0, -5.0 / 6.0]),
    row(1, [0.0, 1.0, 0.0, 0.5, 0.0]),
    row(1, [1.0, -1.0, -1.0, -1.0 / 3.0, 1.0 / 3.0]),
    row(1, [0.0, 0.0, 1.0, 0.0, -0.5]),
];

/// The order of the derivative that a row bounds, from 1 for the velocity.
pub(super) const fn order(row: usize) -> usize {
    TABLE[row].order
}

/// The rows of a section of one duration: `h^n q` as linear functions of its ends, and `h^n`.
pub(super) struct Rows {
    /// Factors of displacement, velocities and accelerations.
    pub values: [[f64; 5]; ROWS],
    /// The derivatives of these factors by the duration.
    pub by_duration: [[f64; 5]; ROWS],
    /// `h^n` and its derivative by the duration, for each order from 1.
    pub scales: [(f64, f64); 3],
}

impl Rows {
    pub fn new(duration: f64) -> Self {
        let h = duration / 3.0;
        let powers = [(1.0, 0.0), (h, 1.0 / 3.0), (h * h, 2.0 * h / 3.0)];
        let scales = [powers[1], powers[2], (h * h * h, h * h)];
        let mut rows = Self { values: [[0.0; 5]; ROWS], by_duration: [[0.0; 5]; ROWS], scales };
        for (i, row) in TABLE.iter().enumerate() {
            for (k, factor) in row.factors.iter().enumerate() {
                // Displacement, velocity, acceleration.
                let (value, by_duration) = powers[k.div_ceil(2)];
                rows.values[i][k] = factor * value;
                rows.by_duration[i][k] = factor * by_duration;
            }
        }
        rows
    }
}

/// Displacement, velocities and accelerations at the ends of a section.
pub(super) fn ends<const N: usize>(from: &[Lanes<N>; 3], to: &[Lanes<N>; 3]) -> [Lanes<N>; 5] {
    let way = std::array::from_fn(|k| to[0][k] - from[0][k]);
    [way, from[1], to[1], from[2], to[2]]
}

/// The sum of five factors times their vectors.
pub(super) fn combine<const N: usize>(factors: &[f64; 5], ends: &[Lanes<N>; 5]) -> Lanes<N> {
    std::array::from_fn(|k| {
        factors[0] * ends[0][k]
            + factors[1] * ends[1][k]
            + factors[2] * ends[2][k]
            + factors[3] * ends[3][k]
            + factors[4] * ends[4][k]
    })
}
