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
    /// The duration with itself, and its side.
    pub own: Lanes<N>,
    pub own_side: Lanes<N>,
    /// Curvature of the Lagrangian in the duration.
    pub curvature: Lanes<N>,
}

/// Derivatives of a row `T^n q`: by the variables; of its distances by the duration, and twice; and
/// those of its derivatives by the variables.
pub(super) struct Derivatives<'a, const N: usize> {
    pub factors: &'a [f64; 4],
    pub slopes: &'a [Lanes<N>; 2],
    pub curvatures: &'a [Lanes<N>; 2],
    pub factor_slopes: &'a [f64; 4],
}

impl<const N: usize> Sums<N> {
    pub const ZERO: Self = Self {
        square: [[[0.0; N]; 4]; 4],
        coupling: [[0.0; N]; 4],
        side: [[0.0; N]; 4],
        own: [0.0; N],
        own_side: [0.0; N],
        curvature: [0.0; N],
    };

    /// Adds a row with what its bounds pull, and with their multipliers.
    pub fn add(&mut self, row: &Derivatives<'_, N>, pull: &Pull<N>, multipliers: &[Lanes<N>; 2]) {
        let (weight, force) = (&pull.weight, &pull.force);
        let (mut both, mut mixed, mut net, mut multiplier) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
        for k in 0..N {
            let [s, t] = [row.slopes[0][k], row.slopes[1][k]];
            let (x, y) = (weight[0][k] * s, weight[1][k] * t);
            self.own[k] += x * s + y * t;
            self.own_side[k] += force[0][k] * s + force[1][k] * t;
            self.curvature[k] -= multipliers[0][k] * row.curvatures[0][k] + multipliers[1][k] * row.curvatures[1][k];
            both[k] = weight[0][k] + weight[1][k];
            mixed[k] = x - y;
            net[k] = force[0][k] - force[1][k];
            multiplier[k] = multipliers[0][k] - multipliers[1][k];
        }
        for x in 0..4 {
            let (factor, slope) = (row.factors[x], row.factor_slopes[x]);
            if factor == 0.0 {
                continue;
            }
            let mut weighted = [0.0; N];
            for k in 0..N {
                weighted[k] = both[k] * factor;
                self.coupling[x][k] += mixed[k] * factor - multiplier[k] * slope;
                self.side[x][k] += net[k] * factor;
            }
            for y in 0..=x {
                for k in 0..N {
                    self.square[x][y][k] += weighted[k] * row.factors[y];
                }
            }
        }
    }
}
