//! Motions slowed down to their limits: how much a section exceeds them, and what of it is made slower.

use super::SECTIONS;
use super::program::Program;
use super::rows::{ROWS, Rows, combine, ends, order};
#[cfg(not(feature = "std"))]
use num_traits::Float;

impl<const N: usize> Program<N> {
    /// Returns to the motion kept apart, slowed down to its limits.
    pub fn take_best(&mut self) {
        (self.nodes, self.durations) = (self.best.nodes, self.best.durations);
        let factor = ROUND_UP * self.worst().max(1.0);
        self.scale(&[factor; SECTIONS]);
    }

    /// Slows the motion down until it keeps the limits, but for what the ends demand: where it does
    /// not first, and all of it at last.
    pub fn slow_down(&mut self) {
        let mut factors = [1.0; SECTIONS];
        for _ in 0..SWEEPS {
            for (i, factor) in factors[..self.sections].iter_mut().enumerate() {
                *factor = self.excess(i).max(1.0);
            }
            self.scale(&factors);
        }
        let all = MARGIN * self.worst().max(1.0);
        self.scale(&[all; SECTIONS]);
        for i in 0..self.sections {
            for _ in 0..SHORTENINGS {
                let was = self.durations[i];
                self.durations[i] = (SHORTER * was).max(self.least[i] * ROUND_UP);
                if self.excess(i) > FILLED {
                    self.durations[i] = was;
                    break;
                }
            }
        }
    }

    /// Makes sections slower by factors.
    fn scale(&mut self, factors: &[f64; SECTIONS]) {
        let n = self.sections;
        let at = |node: usize| match node {
            0 => factors[0],
            node if node == n => factors[n - 1],
            node => factors[node - 1].max(factors[node]),
        };
        for i in 0..n {
            self.durations[i] *= at(i).max(at(i + 1));
        }
        for node in 1..n {
            let factor = at(node);
            for k in 0..N {
                self.nodes[node][1][k] /= if self.free[node][k] { factor } else { 1.0 };
                self.nodes[node][2][k] /= factor * factor;
            }
        }
    }

    /// The factor by which a section must be slower to keep its limits, if it began and ended at
    /// rest where the motion does.
    pub fn excess(&self, i: usize) -> f64 {
        let mut most = [0.0; 3];
        self.gather_excess(i, &mut most);
        slower(most)
    }

    /// The largest values of a section relative to their bounds, by the order of the derivative.
    fn gather_excess(&self, i: usize, most: &mut [f64; 3]) {
        let rows = Rows::new(self.durations[i]);
        let zero = [0.0; N];
        let at = |node: usize| {
            let [p, v, a] = self.nodes[node];
            if node == 0 || node == self.sections { [p, zero, zero] } else { [p, v, a] }
        };
        let ends = ends(&at(i), &at(i + 1));
        for r in 0..ROWS {
            let n = order(r) - 1;
            let value = combine(&rows.values[r], &ends);
            let (inverse, inv) = (&self.inverse_bounds[i][n], 1.0 / rows.scales[n].0);
            for k in 0..N {
                let ratio = (value[k] * inverse[0][k]).max(value[k] * inverse[1][k]);
                most[n] = most[n].max(ratio * inv);
            }
        }
    }

    /// The factor by which the motion must be slower to keep its limits.
    pub fn worst(&self) -> f64 {
        let mut most = [0.0_f64; 3];
        for i in 0..self.sections {
            self.gather_excess(i, &mut most);
        }
        slower(most)
    }
}

/// The factor of time that brings velocity, acceleration and jerk to their bounds.
fn slower([v, a, j]: [f64; 3]) -> f64 {
    v.max(a.sqrt()).max(j.cbrt())
}

/// Sweeps that slow down single sections, and the margin that all of them get.
const SWEEPS: usize = 6;
const MARGIN: f64 = 1.1;

/// Trials to make a section shorter at the begin, how much shorter, and the excess that is left.
const SHORTENINGS: usize = 12;
const SHORTER: f64 = 0.88;
const FILLED: f64 = 0.95;

/// More than the round-off of a factor.
const ROUND_UP: f64 = 1.0 + 1e-9;
