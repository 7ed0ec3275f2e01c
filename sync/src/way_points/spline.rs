//! Where the program begins: cubic splines, whose acceleration is continuous, in durations in which
//! they keep the limits.

use super::excess::{most, slower, take_largest};
use super::program::Program;
use super::rows::shape;
use super::{NODES, SECTIONS};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Changes of the durations towards the excess of their sections, the power of it that is taken, and
/// the least excess that counts. More changes lead the splines of a few axes away from good ones.
const SWEEPS: usize = 3;
const POWER: f64 = 0.7;
const LEAST_FACTOR: f64 = 0.6;

/// Durations at the begin relative to those that keep the limits.
const MARGIN: f64 = 1.1;

/// The outer parts of a section last that many times the rise of the acceleration to its limit, but
/// at least that share of the section.
const RISES: f64 = 1.0;
const LEAST_OUTER: f64 = 0.2;

/// Durations stay above the least ones by that factor.
const ABOVE_LEAST: f64 = 1.0 + 1e-6;

impl<const N: usize> Program<N> {
    /// Changes the durations until a spline keeps the limits, and takes its states.
    ///
    /// Velocities that are given count as 0: they do not become smaller with longer durations.
    pub fn begin_with_spline(&mut self) {
        self.keep_round();
        let n = self.sections;
        for node in 0..=n {
            for k in 0..N {
                if node == 0 || node == n || !self.free[node][k] {
                    (self.nodes[node][1][k], self.nodes[node][2][k]) = (0.0, 0.0);
                }
            }
        }
        self.find_durations();
        for node in 0..=n {
            for k in 0..N {
                let [_, v, a] = self.from.nodes[node].map(|x| x[k]);
                if node == 0 || node == n {
                    (self.nodes[node][1][k], self.nodes[node][2][k]) = (v, a);
                } else if !self.free[node][k] {
                    self.nodes[node][1][k] = v;
                }
            }
        }
    }

    fn find_durations(&mut self) {
        let n = self.sections;
        self.shapes[..n].fill(shape(1.0 / 3.0));
        let worst = self.worst();
        let guess = worst * self.total();
        let (mut best, mut kept) = (f64::INFINITY, self.durations);
        for sweep in 0..=SWEEPS {
            self.take_spline();
            let mut factors = [1.0; SECTIONS];
            let mut all = [[0.0; N]; 3];
            for i in 0..n {
                let ratios = self.ratios(i);
                factors[i] = slower(ratios.map(|x| most(&x)));
                take_largest(&mut all, &ratios);
            }
            let worst = slower(all.map(|x| most(&x)));
            if worst * self.total() < best {
                best = worst * self.total();
                kept = self.durations.map(|t| t * worst);
            }
            if sweep < SWEEPS {
                for i in 0..n {
                    let factor = factors[i].max(LEAST_FACTOR).powf(POWER);
                    self.durations[i] = (factor * self.durations[i]).max(ABOVE_LEAST * self.least[i]);
                }
            }
        }
        if guess < best {
            (self.nodes, self.durations) = (self.from.nodes, self.from.durations);
            self.slow_down(worst);
            self.choose_shapes();
            self.slow_down(MARGIN * self.worst());
        } else {
            self.durations = kept;
            self.take_spline();
            self.choose_shapes();
            self.slow_down(MARGIN * self.worst());
            self.take_spline();
        }
        for i in 0..n {
            self.durations[i] = self.durations[i].max(ABOVE_LEAST * self.least[i]);
        }
    }

    /// The outer parts of a section are as long as its most loaded axis needs to build up its
    /// acceleration.
    fn choose_shapes(&mut self) {
        for i in 0..self.sections {
            let [v, a, j] = self.ratios(i);
            let (mut load, mut outer) = (0.0, 1.0);
            for k in 0..N {
                let own = slower([v[k], a[k], j[k]]);
                if own > load {
                    load = own;
                    let [_, a, j] = self.inverse_bounds[i].map(|inverse| inverse[1][k]);
                    outer = RISES * j / (a * self.durations[i]);
                }
            }
            self.shapes[i] = shape(outer.max(LEAST_OUTER).min(1.0 / 3.0));
        }
    }

    /// The states at the points of the motion whose sections have constant jerk, in the durations as
    /// they are. Where a velocity is given, the acceleration is the mean of both sides.
    fn take_spline(&mut self) {
        let n = self.sections;
        // Downwards: v[i] = side[i] - upper[i] v[i + 1].
        let mut upper = [[0.0; N]; NODES];
        for i in 1..n {
            let (x, y) = (1.0 / self.durations[i - 1], 1.0 / self.durations[i]);
            let (before, after) = (3.0 * x * x, 3.0 * y * y);
            for k in 0..N {
                if self.free[i][k] {
                    let [p0, p, p1] = [i - 1, i, i + 1].map(|at| self.nodes[at][0][k]);
                    let inverse = 1.0 / (2.0 * (x + y) - x * upper[i - 1][k]);
                    let side = before * (p - p0) + after * (p1 - p) - x * self.nodes[i - 1][1][k];
                    self.nodes[i][1][k] = side * inverse;
                    upper[i][k] = y * inverse;
                }
            }
        }
        for i in (1..n).rev() {
            for k in 0..N {
                self.nodes[i][1][k] -= upper[i][k] * self.nodes[i + 1][1][k];
            }
        }
        for i in 1..n {
            let (x, y) = (1.0 / self.durations[i - 1], 1.0 / self.durations[i]);
            for k in 0..N {
                let [p0, p, p1] = [i - 1, i, i + 1].map(|at| self.nodes[at][0][k]);
                let [v0, v, v1] = [i - 1, i, i + 1].map(|at| self.nodes[at][1][k]);
                let before = x * (2.0 * v0 + 4.0 * v - 6.0 * x * (p - p0));
                let after = y * (6.0 * y * (p1 - p) - 4.0 * v - 2.0 * v1);
                self.nodes[i][2][k] = 0.5 * (before + after);
            }
        }
    }
}
