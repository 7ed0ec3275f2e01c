//! The shortest motion through way-points whose sections have three equal parts of constant jerk:
//! an interior-point method on velocities, accelerations and durations.

use arcfeed_feedrate::{AxisLimits, AxisState};

use super::bounded::Bounded;
use super::equations::Equations;
use super::rows::{Lanes, ROWS, Rows, combine, ends, order};
use super::sums::Sums;
use super::{NODES, SECTIONS};

/// A duration may change by this part of itself in one step.
const TRUST: f64 = 0.4;

/// Lower and upper bound of velocity, acceleration and jerk.
pub(super) type Bounds<const N: usize> = [[Lanes<N>; 2]; 3];

/// Nodes, durations, and the state of the method.
pub(super) struct Program<const N: usize> {
    pub sections: usize,
    /// Position, velocity and acceleration of the nodes.
    pub nodes: [[Lanes<N>; 3]; NODES],
    /// Velocities of inner nodes that may change.
    pub free: [[bool; N]; NODES],
    pub durations: [f64; SECTIONS],
    /// The least durations.
    pub least: [f64; SECTIONS],
    bounds: [Bounds<N>; SECTIONS],
    pub(super) inverse_bounds: [Bounds<N>; SECTIONS],
    rows: [[Bounded<N>; ROWS]; SECTIONS],
    /// The distances of the rows to their bounds.
    now: [[[Lanes<N>; 2]; ROWS]; SECTIONS],
    /// Their derivatives by the duration, and their changes in a full step.
    by_duration: [[[Lanes<N>; 2]; ROWS]; SECTIONS],
    changes: [[[Lanes<N>; 2]; ROWS]; SECTIONS],
    /// Velocity and acceleration at the nodes.
    node_rows: [[Bounded<N>; 2]; NODES],
    duration_rows: [Bounded<1>; SECTIONS],
    equations: Equations<N>,
    pub(super) best: Best<N>,
}

/// A motion that is kept apart.
pub(super) struct Best<const N: usize> {
    pub nodes: [[Lanes<N>; 3]; NODES],
    pub durations: [f64; SECTIONS],
    /// Duration of the whole, slowed down to its limits (s).
    slowed: f64,
}

impl<const N: usize> Program<N> {
    pub const fn new() -> Self {
        let zero = [0.0; N];
        Self {
            sections: 0,
            nodes: [[zero; 3]; NODES],
            free: [[true; N]; NODES],
            durations: [1.0; SECTIONS],
            least: [0.0; SECTIONS],
            bounds: [[[zero; 2]; 3]; SECTIONS],
            inverse_bounds: [[[zero; 2]; 3]; SECTIONS],
            rows: [[Bounded::NONE; ROWS]; SECTIONS],
            now: [[[zero; 2]; ROWS]; SECTIONS],
            by_duration: [[[zero; 2]; ROWS]; SECTIONS],
            changes: [[[zero; 2]; ROWS]; SECTIONS],
            node_rows: [[Bounded::NONE; 2]; NODES],
            duration_rows: [Bounded::NONE; SECTIONS],
            equations: Equations::new(),
            best: Best { nodes: [[zero; 3]; NODES], durations: [1.0; SECTIONS], slowed: f64::INFINITY },
        }
    }

    /// Sets the state of a node.
    pub fn set_node(&mut self, node: usize, axis: usize, s: &AxisState) {
        for (x, value) in self.nodes[node].iter_mut().zip([s.p, s.v, s.a]) {
            x[axis] = value;
        }
    }

    /// The state of a node.
    pub fn node(&self, node: usize, axis: usize) -> AxisState {
        let [p, v, a] = self.nodes[node].map(|x| x[axis]);
        AxisState::new(p, v, a)
    }

    /// Sets the limits of a section.
    pub fn set_limits(&mut self, section: usize, axis: usize, l: &AxisLimits) {
        let all = [[l.v_min(), l.v_max()], [l.a_min(), l.a_max()], [l.j_min(), l.j_max()]];
        for (order, values) in all.iter().enumerate() {
            for (side, value) in values.iter().enumerate() {
                self.bounds[section][order][side][axis] = *value;
                self.inverse_bounds[section][order][side][axis] = 1.0 / value;
            }
        }
    }

    /// Improves the motion in at most so many rounds, each of which costs the same. Keeps apart the
    /// motion that is shortest once it is slowed down to its limits.
    pub fn improve(&mut self, rounds: usize) {
        let mut mu = START * self.total() / self.sections as f64;
        self.begin(mu);
        self.best.slowed = f64::INFINITY;
        let mut excess = self.worst();
        self.remember(excess);
        for _ in 0..rounds {
            self.assemble(mu);
            if !self.equations.solve(self.sections) {
                return;
            }
            self.find_changes();
            let longest = self.longest_step();
            let mut step = longest;
            let was = excess;
            for halvings in 0..=HALVINGS {
                self.move_by(step);
                excess = self.worst();
                if excess <= was.max(ALLOWED) || halvings == HALVINGS {
                    break;
                }
                self.move_by(-step);
                step *= 0.5;
            }
            // The bounds step from where they were.
            self.move_by(-step);
            self.advance(mu, step);
            self.move_by(step);
            self.remember(excess);
            let mean = self.mean_product();
            let least = END * self.total() / self.sections as f64;
            if step == 1.0 && mean <= 2.0 * least {
                return;
            }
            let factor = if step > LONG { QUICK } else { SLOW };
            mu = (factor * mean).max(least);
        }
    }

    /// Keeps the motion apart if it is the shortest once it is slower by its excess.
    fn remember(&mut self, excess: f64) {
        let slowed = self.total() * excess.max(1.0);
        if slowed < self.best.slowed {
            let n = self.sections;
            self.best.nodes[..=n].copy_from_slice(&self.nodes[..=n]);
            self.best.durations[..n].copy_from_slice(&self.durations[..n]);
            self.best.slowed = slowed;
        }
    }

    /// The duration of the motion kept apart, slowed down to its limits (s).
    pub fn best_total(&self) -> f64 {
        self.best.slowed
    }

    pub fn total(&self) -> f64 {
        self.durations[..self.sections].iter().sum()
    }

    /// The bounds of velocity (1) or acceleration (2) at an inner node: those of both sections.
    fn node_bounds(&self, node: usize, derivative: usize) -> [Lanes<N>; 2] {
        let (x, y) = (&self.bounds[node - 1][derivative - 1], &self.bounds[node][derivative - 1]);
        [std::array::from_fn(|k| x[0][k].max(y[0][k])), std::array::from_fn(|k| x[1][k].min(y[1][k]))]
    }

    fn begin(&mut self, mu: f64) {
        for i in 0..self.sections {
            let rows = Rows::new(self.durations[i]);
            let ends = ends(&self.nodes[i], &self.nodes[i + 1]);
            for r in 0..ROWS {
                let distances = self.distances(i, r, &rows, &ends);
                self.rows[i][r] = Bounded::new(&distances, 0.1, mu);
            }
            self.duration_rows[i] = Bounded::new(&self.duration_distances(i), 0.0, mu);
        }
        for node in 1..self.sections {
            for derivative in 1..3 {
                let distances = self.node_distances(node, derivative);
                self.node_rows[node][derivative - 1] = Bounded::new(&distances, 0.1, mu);
            }
        }
    }

    fn distances(&self, i: usize, r: usize, rows: &Rows, ends: &[Lanes<N>; 5]) -> [Lanes<N>; 2] {
        let value = combine(&rows.values[r], ends);
        let (scale, _) = rows.scales[order(r) - 1];
        let bounds = &self.bounds[i][order(r) - 1];
        [
            std::array::from_fn(|k| value[k] - scale * bounds[0][k]),
            std::array::from_fn(|k| scale * bounds[1][k] - value[k]),
        ]
    }

    /// The derivatives of the distances by the duration.
    fn distances_by_duration(&self, i: usize, r: usize, rows: &Rows, ends: &[Lanes<N>; 5]) -> [Lanes<N>; 2] {
        let value = combine(&rows.by_duration[r], ends);
        let (_, scale) = rows.scales[order(r) - 1];
        let bounds = &self.bounds[i][order(r) - 1];
        [
            std::array::from_fn(|k| value[k] - scale * bounds[0][k]),
            std::array::from_fn(|k| scale * bounds[1][k] - value[k]),
        ]
    }

    fn node_distances(&self, node: usize, derivative: usize) -> [Lanes<N>; 2] {
        let (bounds, value) = (self.node_bounds(node, derivative), &self.nodes[node][derivative]);
        [std::array::from_fn(|k| value[k] - bounds[0][k]), std::array::from_fn(|k| bounds[1][k] - value[k])]
    }

    fn duration_distances(&self, i: usize) -> [Lanes<1>; 2] {
        [[self.durations[i] - self.least[i]], [FAR - self.durations[i]]]
    }

    fn assemble(&mut self, mu: f64) {
        self.equations.clear(self.sections);
        for i in 0..self.sections {
            self.assemble_section(i, mu);
        }
        for node in 1..self.sections {
            for derivative in 1..3 {
                let distances = self.node_distances(node, derivative);
                let pull = self.node_rows[node][derivative - 1].pull(&distances, mu);
                for k in 0..N {
                    self.equations.diagonal[node][derivative - 1][derivative - 1][k] +=
                        pull.weight[0][k] + pull.weight[1][k];
                    self.equations.node_side[node][derivative - 1][k] += pull.force[0][k] - pull.force[1][k];
                }
            }
            for k in 0..N {
                if !self.free[node][k] {
                    self.equations.fix(node, k);
                }
            }
        }
    }

    fn assemble_section(&mut self, i: usize, mu: f64) {
        let rows = Rows::new(self.durations[i]);
        let ends = ends(&self.nodes[i], &self.nodes[i + 1]);
        let mut sums = Sums::ZERO;
        for r in 0..ROWS {
            let distances = self.distances(i, r, &rows, &ends);
            let by_t = self.distances_by_duration(i, r, &rows, &ends);
            self.now[i][r] = distances;
            self.by_duration[i][r] = by_t;
            let pull = self.rows[i][r].pull(&distances, mu);
            let multiplier = self.rows[i][r].net();
            sums.add((&rows.values[r], &rows.by_duration[r]), &by_t, (&pull, &multiplier));
        }
        let inv = 0.5 / self.durations[i];
        let size = |derivative: usize| {
            let bounds = &self.bounds[i][derivative - 1];
            std::array::from_fn(|k| (bounds[1][k] - bounds[0][k]) * inv)
        };
        let (v, a) = (size(1), size(2));
        sums.add_curvature(&[v, v, a, a]);
        let pull = self.duration_rows[i].pull(&self.duration_distances(i), mu);
        let e = &mut self.equations;
        e.durations[i] += sums.own.iter().sum::<f64>() + pull.weight[0][0] + pull.weight[1][0];
        e.duration_side[i] += sums.own_side.iter().sum::<f64>() + pull.force[0][0] - pull.force[1][0] - 1.0;
        e.add_section(i, &sums.square, &sums.coupling, &sums.side);
    }

    /// The changes of the distances of all sections.
    fn find_changes(&mut self) {
        let zero = [[0.0; N]; 2];
        for i in 0..self.sections {
            let rows = Rows::new(self.durations[i]);
            let at =
                |node: usize| if node == 0 || node == self.sections { &zero } else { &self.equations.node_side[node] };
            let (from, to) = (at(i), at(i + 1));
            let change = [[0.0; N], from[0], to[0], from[1], to[1]];
            let dt = self.equations.duration_side[i];
            for r in 0..ROWS {
                let x = combine(&rows.values[r], &change);
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

    fn longest_step(&self) -> f64 {
        let mut step = 1.0_f64;
        for i in 0..self.sections {
            for r in 0..ROWS {
                step = step.min(self.rows[i][r].longest_step(&self.now[i][r], &self.changes[i][r]));
            }
            let (t, dt) = (self.durations[i], self.equations.duration_side[i]);
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

    fn advance(&mut self, mu: f64, step: f64) {
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

    fn move_by(&mut self, primal: f64) {
        for i in 0..self.sections {
            self.durations[i] += primal * self.equations.duration_side[i];
        }
        for node in 1..self.sections {
            for (x, change) in self.nodes[node][1..].iter_mut().zip(&self.equations.node_side[node]) {
                for k in 0..N {
                    x[k] += primal * change[k];
                }
            }
        }
    }

    fn mean_product(&self) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.sections {
            sum += self.rows[i].iter().map(Bounded::products).sum::<f64>();
        }
        for node in 1..self.sections {
            sum += self.node_rows[node].iter().map(Bounded::products).sum::<f64>();
        }
        let count = 2 * N * (ROWS * self.sections + 2 * (self.sections - 1));
        sum / count as f64
    }
}

/// No upper bound of a duration (s).
const FAR: f64 = 1e9;

/// Products of slack and multiplier at the begin, and at the end, relative to the mean duration.
const START: f64 = 0.1;
const END: f64 = 1e-5;

/// The products become that much smaller after a step longer than `LONG`, and after another one.
const LONG: f64 = 0.7;
const QUICK: f64 = 0.1;
const SLOW: f64 = 0.4;

/// Excess that is allowed between rounds, and halvings of a step that makes more.
const ALLOWED: f64 = 1.15;
const HALVINGS: usize = 4;
