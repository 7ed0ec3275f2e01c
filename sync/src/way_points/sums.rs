//! What the rows of a section add to the equations.

use super::bounded::Pull;
use super::rows::Lanes;

/// Sums over the rows of a section. The variables are the velocity before and after, and the
/// acceleration before and after.
pub(super) struct Sums<const N: usize> {
    /// Lower triangle.
    pub square: [[Lanes<N>; 4]; 4],
    /// With the duration.
    pub coupling: [Lanes<N>; 4],
    pub side: [Lanes<N>; 4],
    /// Curvature of the Lagrangian in a variable and the duration.
    cross: [Lanes<N>; 4],
    /// The duration with itself, and its side.
    pub own: Lanes<N>,
    pub own_side: Lanes<N>,
}

/// Factors of displacement and variables, and their derivatives by the duration.
pub(super) type Factors<'a> = (&'a [f64; 5], &'a [f64; 5]);

impl<const N: usize> Sums<N> {
    pub const ZERO: Self = Self {
        square: [[[0.0; N]; 4]; 4],
        coupling: [[0.0; N]; 4],
        side: [[0.0; N]; 4],
        cross: [[0.0; N]; 4],
        own: [0.0; N],
        own_side: [0.0; N],
    };

    /// Adds a row: its factors, the derivatives of its distances by the duration, what its bounds
    /// pull, and its multiplier.
    pub fn add(
        &mut self,
        (factors, by_duration): Factors<'_>,
        by_t: &[Lanes<N>; 2],
        (pull, multiplier): (&Pull<N>, &Lanes<N>),
    ) {
        let (weight, force) = (&pull.weight, &pull.force);
        let (mut both, mut mixed, mut net) = ([0.0; N], [0.0; N], [0.0; N]);
        for k in 0..N {
            let (x, y) = (weight[0][k] * by_t[0][k], weight[1][k] * by_t[1][k]);
            self.own[k] += x * by_t[0][k] + y * by_t[1][k];
            self.own_side[k] += force[0][k] * by_t[0][k] + force[1][k] * by_t[1][k];
            both[k] = weight[0][k] + weight[1][k];
            mixed[k] = x - y;
            net[k] = force[0][k] - force[1][k];
        }
        for x in 0..4 {
            let (factor, rate) = (factors[x + 1], by_duration[x + 1]);
            if factor == 0.0 {
                continue;
            }
            let mut weighted = [0.0; N];
            for k in 0..N {
                weighted[k] = both[k] * factor;
                self.coupling[x][k] += mixed[k] * factor;
                self.side[x][k] += net[k] * factor;
                self.cross[x][k] -= multiplier[k] * rate;
            }
            for y in 0..=x {
                for k in 0..N {
                    self.square[x][y][k] += weighted[k] * factors[y + 1];
                }
            }
        }
    }

    /// Takes the curvature of the Lagrangian into the sums, with as much on the diagonal as keeps
    /// the matrix positive definite. `sizes` are the variables' for one unit of the duration.
    pub fn add_curvature(&mut self, sizes: &[Lanes<N>; 4]) {
        for x in 0..4 {
            for k in 0..N {
                let (cross, size) = (self.cross[x][k], sizes[x][k]);
                self.coupling[x][k] += cross;
                self.square[x][x][k] += cross.abs() / size;
                self.own[k] += cross.abs() * size;
            }
        }
    }
}
