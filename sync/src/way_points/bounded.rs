//! A quantity between two bounds, as the interior-point method sees it.

use super::rows::Lanes;

/// Part of the way to the nearest bound that a step may go.
const FRACTION: f64 = 0.95;

/// The product of slack and multiplier stays within this factor of `mu`.
const KAPPA: f64 = 10.0;

/// Distances of a quantity to its bounds, and the multipliers of both.
#[derive(Clone, Copy)]
pub(super) struct Bounded<const N: usize> {
    slack: [Lanes<N>; 2],
    multiplier: [Lanes<N>; 2],
}

/// What the bounds add to the equations: for each side curvature, and force towards the inside.
pub(super) struct Pull<const N: usize> {
    pub weight: [Lanes<N>; 2],
    pub force: [Lanes<N>; 2],
}

impl<const N: usize> Bounded<N> {
    pub const NONE: Self = Self { slack: [[1.0; N]; 2], multiplier: [[0.0; N]; 2] };

    /// At distances to the bounds, with products of slack and multiplier `mu`. A slack is not below
    /// `least`.
    pub fn new(distances: &[Lanes<N>; 2], least: f64, mu: f64) -> Self {
        let mut all = Self::NONE;
        for side in 0..2 {
            for k in 0..N {
                let least = least * (distances[0][k] + distances[1][k]);
                all.slack[side][k] = distances[side][k].max(least);
                all.multiplier[side][k] = mu / all.slack[side][k];
            }
        }
        all
    }

    /// Takes the true distances where they are not much below the ones assumed, and returns what
    /// the bounds add to the equations.
    pub fn pull(&mut self, distances: &[Lanes<N>; 2], mu: f64) -> Pull<N> {
        let mut pull = Pull { weight: [[0.0; N]; 2], force: [[0.0; N]; 2] };
        for side in 0..2 {
            for k in 0..N {
                let s = &mut self.slack[side][k];
                let distance = distances[side][k];
                *s = if distance > 1e-3 * *s { distance } else { *s };
                let inv = 1.0 / *s;
                let weight = self.multiplier[side][k] * inv;
                pull.weight[side][k] = weight;
                pull.force[side][k] = mu * inv - weight * (distance - *s);
            }
        }
        pull
    }

    /// Multiplies the multipliers.
    pub fn scale_multipliers(&mut self, factor: f64) {
        self.multiplier.iter_mut().flatten().for_each(|z| *z *= factor);
    }

    /// The multipliers of the lower and of the upper bound.
    pub const fn multipliers(&self) -> &[Lanes<N>; 2] {
        &self.multiplier
    }

    /// Sum of the products of slack and multiplier.
    pub fn products(&self) -> f64 {
        let mut sum = 0.0;
        for side in 0..2 {
            for k in 0..N {
                sum += self.slack[side][k] * self.multiplier[side][k];
            }
        }
        sum
    }

    /// Turns changes of the distances into those of slacks and multipliers.
    fn changes(&self, side: usize, k: usize, (distance, change, mu): (f64, f64, f64)) -> (f64, f64) {
        let (s, z) = (self.slack[side][k], self.multiplier[side][k]);
        let ds = change + distance - s;
        (ds, (mu - z * ds) / s - z)
    }

    /// The longest step for changes of the distances, at most 1.
    pub fn longest_step(&self, distances: &[Lanes<N>; 2], changes: &[Lanes<N>; 2]) -> f64 {
        let mut fastest = [FRACTION; N];
        for side in 0..2 {
            for k in 0..N {
                let rate = 1.0 - (changes[side][k] + distances[side][k]) / self.slack[side][k];
                fastest[k] = if rate > fastest[k] { rate } else { fastest[k] };
            }
        }
        FRACTION / fastest.iter().fold(FRACTION, |most, x| most.max(*x))
    }

    /// Makes a step.
    pub fn advance(&mut self, distances: &[Lanes<N>; 2], changes: &[Lanes<N>; 2], (mu, step): (f64, f64)) {
        for side in 0..2 {
            for k in 0..N {
                let (ds, dz) = self.changes(side, k, (distances[side][k], changes[side][k], mu));
                self.slack[side][k] += step * ds;
                let (s, z) = (self.slack[side][k], self.multiplier[side][k] + dz);
                self.multiplier[side][k] = z.max(mu / (KAPPA * s)).min(KAPPA * mu / s);
            }
        }
    }
}
