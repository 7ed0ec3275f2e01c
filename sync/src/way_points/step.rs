//! One step of the interior-point method.

use super::program::Program;
use super::rows::{Lanes, Polynomial, ROWS};

/// A duration may change by this part of itself in one step.
const TRUST: f64 = 0.4;

impl<const N: usize> Program<N> {
    /// The changes of the distances of all sections.
    pub(super) fn find_changes(&mut self) {
        let zero = [[0.0; N]; 2];
        for i in 0..self.sections {
            let at =
                |node: usize| if node == 0 || node == self.sections { &zero } else { &self.equations.node_side[node] };
            let (from, to) = (at(i), at(i + 1));
            let change = [[0.0; N], from[0], to[0], from[1], to[1]];
            let (t, dt) = (self.durations[i], self.equations.duration_side[i]);
            for r in 0..ROWS {
                let x = Polynomial::new(&self.shapes[i][r], &change).value(t);
                let y = &self.by_duration[i][r];
                for k in 0..N {
                    self.changes[i][r][0][k] = y[0][k] * dt + x[k];
                    self.changes[i][r][1][k] = y[1][k] * dt - x[k];
                }
            }
        }
    }

    fn node_changes(&self, node: usize, derivative: usize) -> [Lanes<N>; 2] {
        let change = self.equations.node_side[node][derivative - 1];
        [change, change.map(|x| -x)]
    }

    /// The longest part of the step that stays inside all bounds.
    pub(super) fn longest_step(&self) -> f64 {
        let mut step = 1.0_f64;
        for i in 0..self.sections {
            for r in 0..ROWS {
                step = step.min(self.rows[i][r].longest_step(&self.now[i][r], &self.changes[i][r]));
            }
            let (t, dt) = (self.from.durations[i], self.equations.duration_side[i]);
            step = step.min(self.duration_rows[i].longest_step(&self.duration_distances(i), &[[dt], [-dt]]));
            step = step.min(TRUST * t / dt.abs());
        }
        for node in 1..self.sections {
            for derivative in 1..3 {
                let (distances, changes) = (self.node_distances(node, derivative), self.node_changes(node, derivative));
                step = step.min(self.node_rows[node][derivative - 1].longest_step(&distances, &changes));
            }
        }
        step
    }

    /// Moves slacks and multipliers by a part of the step.
    pub(super) fn advance(&mut self, mu: f64, step: f64) {
        for i in 0..self.sections {
            for r in 0..ROWS {
                self.rows[i][r].advance(&self.now[i][r], &self.changes[i][r], (mu, step));
            }
            let dt = self.equations.duration_side[i];
            let distances = self.duration_distances(i);
            self.duration_rows[i].advance(&distances, &[[dt], [-dt]], (mu, step));
        }
        for node in 1..self.sections {
            for derivative in 1..3 {
                let (distances, changes) = (self.node_distances(node, derivative), self.node_changes(node, derivative));
                self.node_rows[node][derivative - 1].advance(&distances, &changes, (mu, step));
            }
        }
    }

    /// Moves by a part of the step from where the round began.
    ///
    /// What moves on a straight line are the durations, velocity times duration, and acceleration
    /// times its square, with the harmonic mean of the durations on both sides of a node. The path
    /// of an axis in space is then nearly the same while the motion becomes faster: straight steps
    /// of velocities and durations would leave it by their product, and would have to be short.
    pub(super) fn move_to(&mut self, step: f64) {
        let n = self.sections;
        for i in 0..n {
            self.durations[i] = self.from.durations[i] + step * self.equations.duration_side[i];
        }
        for node in 1..n {
            let inverse = [node - 1, node].map(|i| 1.0 / self.from.durations[i]);
            let [x, y] = inverse;
            let [dx, dy] = [node - 1, node].map(|i| self.equations.duration_side[i]);
            let sum = x + y;
            let rate = (x * x * dx + y * y * dy) / sum;
            let factor = (1.0 / self.durations[node - 1] + 1.0 / self.durations[node]) / sum;
            let [_, v, a] = self.from.nodes[node];
            let [dv, da] = self.equations.node_side[node];
            for k in 0..N {
                if self.free[node][k] {
                    self.nodes[node][1][k] = factor * (v[k] + step * (dv[k] + rate * v[k]));
                }
                self.nodes[node][2][k] = factor * factor * (a[k] + step * (da[k] + 2.0 * rate * a[k]));
            }
        }
    }
}
