//! By how much sections exceed their limits, and motions slowed down until they do not.

use super::program::Program;
use super::rows::{Lanes, Polynomial, ROWS, ends, order, powers};
#[cfg(not(feature = "std"))]
use num_traits::Float;

impl<const N: usize> Program<N> {
    /// Returns to the motion kept apart, slowed down to its limits.
    pub fn take_best(&mut self) {
        (self.nodes, self.durations) = (self.best.nodes, self.best.durations);
        self.slow_down(ROUND_UP * self.worst().max(1.0));
    }

    /// Makes the motion slower by a factor; velocities that are given stay.
    pub fn slow_down(&mut self, factor: f64) {
        for i in 0..self.sections {
            self.durations[i] *= factor;
        }
        for node in 1..self.sections {
            for k in 0..N {
                self.nodes[node][1][k] /= if self.free[node][k] { factor } else { 1.0 };
                self.nodes[node][2][k] /= factor * factor;
            }
        }
    }

    /// The factor by which a section must be slower to keep its limits, if it began and ended at
    /// rest where the motion does.
    pub fn excess(&self, i: usize) -> f64 {
        slower(self.ratios(i).map(|x| most(&x)))
    }

    /// The factor by which the motion must be slower to keep its limits.
    pub fn worst(&self) -> f64 {
        let mut all = [[0.0; N]; 3];
        for i in 0..self.sections {
            take_largest(&mut all, &self.ratios(i));
        }
        slower(all.map(|x| most(&x)))
    }

    /// The largest values of a section relative to their bounds, by the order of the derivative.
    pub fn ratios(&self, i: usize) -> [Lanes<N>; 3] {
        let t = self.durations[i];
        let powers = powers(t);
        let zero = [0.0; N];
        let at = |node: usize| {
            let [p, v, a] = self.nodes[node];
            if node == 0 || node == self.sections { [p, zero, zero] } else { [p, v, a] }
        };
        let ends = ends(&at(i), &at(i + 1));
        let mut all = [[0.0; N]; 3];
        for r in 0..ROWS {
            let n = order(r) - 1;
            let value = Polynomial::new(&self.shapes[i][r], &ends).value(t);
            let (below, above, scale) =
                (&self.inverse_bounds[i][n][0], &self.inverse_bounds[i][n][1], 1.0 / powers[n][0]);
            for k in 0..N {
                let ratio = scale * larger(value[k] * below[k], value[k] * above[k]);
                all[n][k] = larger(all[n][k], ratio);
            }
        }
        all
    }
}

/// The larger of two numbers, in one instruction; the second if they cannot be compared.
fn larger(x: f64, y: f64) -> f64 {
    if x > y { x } else { y }
}

/// Replaces numbers by larger ones.
pub(super) fn take_largest<const N: usize>(all: &mut [Lanes<N>; 3], others: &[Lanes<N>; 3]) {
    for (x, y) in all.iter_mut().zip(others) {
        for k in 0..N {
            x[k] = larger(y[k], x[k]);
        }
    }
}

pub(super) fn most<const N: usize>(x: &Lanes<N>) -> f64 {
    x.iter().fold(0.0, |most: f64, x| most.max(*x))
}

/// The factor of time that brings velocity, acceleration and jerk to their bounds.
pub(super) fn slower([v, a, j]: [f64; 3]) -> f64 {
    v.max(a.sqrt()).max(j.cbrt())
}

/// More than the round-off of a factor.
const ROUND_UP: f64 = 1.0 + 1e-9;
