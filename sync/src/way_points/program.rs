//! The shortest motion through way-points whose sections have three parts of constant jerk: an
//! interior-point method on velocities, accelerations and durations.

use arcfeed_feedrate::{AxisLimits, AxisState};

use super::bounded::Bounded;
use super::equations::Equations;
use super::rows::{Lanes, Polynomial, ROWS, Shape, ends, order, powers};
use super::sums::{Derivatives, Sums};
use super::{NODES, SECTIONS};

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
    /// The rows of the sections.
    pub shapes: [Shape; SECTIONS],
    bounds: [Bounds<N>; SECTIONS],
    pub(super) inverse_bounds: [Bounds<N>; SECTIONS],
    pub(super) rows: [[Bounded<N>; ROWS]; SECTIONS],
    /// The distances of the rows to their bounds.
    pub(super) now: [[[Lanes<N>; 2]; ROWS]; SECTIONS],
    /// Their derivatives by the duration, and their changes in a full step.
    pub(super) by_duration: [[[Lanes<N>; 2]; ROWS]; SECTIONS],
    pub(super) changes: [[[Lanes<N>; 2]; ROWS]; SECTIONS],
    /// Velocity and acceleration at the nodes.
    pub(super) node_rows: [[Bounded<N>; 2]; NODES],
    pub(super) duration_rows: [Bounded<1>; SECTIONS],
    pub(super) equations: Equations<N>,
    /// Where the round began.
    pub(super) from: Motion<N>,
    pub(super) best: Motion<N>,
    /// Duration of the best motion, slowed down to its limits (s).
    slowed: f64,
}

/// States and durations apart from those of the program.
pub(super) struct Motion<const N: usize> {
    pub nodes: [[Lanes<N>; 3]; NODES],
    pub durations: [f64; SECTIONS],
}

impl<const N: usize> Motion<N> {
    const NONE: Self = Self { nodes: [[[0.0; N]; 3]; NODES], durations: [1.0; SECTIONS] };
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
            shapes: [[[0.0; 5]; ROWS]; SECTIONS],
            bounds: [[[zero; 2]; 3]; SECTIONS],
            inverse_bounds: [[[zero; 2]; 3]; SECTIONS],
            rows: [[Bounded::NONE; ROWS]; SECTIONS],
            now: [[[zero; 2]; ROWS]; SECTIONS],
            by_duration: [[[zero; 2]; ROWS]; SECTIONS],
            changes: [[[zero; 2]; ROWS]; SECTIONS],
            node_rows: [[Bounded::NONE; 2]; NODES],
            duration_rows: [Bounded::NONE; SECTIONS],
            equations: Equations::new(),
            from: Motion::NONE,
            best: Motion::NONE,
            slowed: f64::INFINITY,
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

    /// Begins with the motion as it is. Returns the products of slacks and multipliers to aim at.
    pub fn start(&mut self) -> f64 {
        self.slowed = f64::INFINITY;
        self.begin()
    }

    /// Improves the motion in at most so many rounds, each of which costs the same, with products to aim
    /// at. Keeps apart the motion that is shortest once it is slowed down to its limits. Returns the
    /// products with which it can go on; `None` if it has converged, or cannot.
    pub fn improve(&mut self, rounds: usize, mut mu: f64) -> Option<f64> {
        let mut excess = self.worst();
        self.remember(excess);
        for _ in 0..rounds {
            self.keep_round();
            self.assemble(mu);
            if !self.equations.solve(self.sections) {
                return None;
            }
            self.find_changes();
            let mut step = self.longest_step();
            let was = excess;
            for halvings in 0..=HALVINGS {
                self.move_to(step);
                excess = self.worst();
                if excess <= was.max(ALLOWED) || halvings == HALVINGS {
                    break;
                }
                step *= 0.5;
            }
            self.advance(mu, step);
            self.remember(excess);
            let mean = self.mean_product();
            if excess < SETTLED && mean * self.count_products() < CLOSE * self.total() {
                return None;
            }
            mu = if step > LONG { QUICK } else { SLOW } * mean;
        }
        Some(mu)
    }

    pub(super) fn keep_round(&mut self) {
        let n = self.sections;
        self.from.nodes[..=n].copy_from_slice(&self.nodes[..=n]);
        self.from.durations[..n].copy_from_slice(&self.durations[..n]);
    }

    /// Goes back to where the round began.
    pub(super) fn return_to_round(&mut self) {
        (self.nodes, self.durations) = (self.from.nodes, self.from.durations);
    }

    /// Keeps the motion apart if it is the shortest once it is slower by its excess.
    fn remember(&mut self, excess: f64) {
        let slowed = self.total() * excess.max(1.0);
        if slowed < self.slowed {
            let n = self.sections;
            self.best.nodes[..=n].copy_from_slice(&self.nodes[..=n]);
            self.best.durations[..n].copy_from_slice(&self.durations[..n]);
            self.slowed = slowed;
        }
    }

    /// The duration of the motion kept apart, slowed down to its limits (s).
    pub fn best_total(&self) -> f64 {
        self.slowed
    }

    pub fn total(&self) -> f64 {
        self.durations[..self.sections].iter().sum()
    }

    /// The bounds of velocity (1) or acceleration (2) at an inner node: those of both sections.
    fn node_bounds(&self, node: usize, derivative: usize) -> [Lanes<N>; 2] {
        let (x, y) = (&self.bounds[node - 1][derivative - 1], &self.bounds[node][derivative - 1]);
        [std::array::from_fn(|k| x[0][k].max(y[0][k])), std::array::from_fn(|k| x[1][k].min(y[1][k]))]
    }

    /// Sets slacks and multipliers, and returns their products. These hold the durations where they
    /// are, in the mean.
    fn begin(&mut self) -> f64 {
        self.keep_round();
        let mut force = 0.0;
        for i in 0..self.sections {
            let t = self.durations[i];
            let ends = ends(&self.nodes[i], &self.nodes[i + 1]);
            for r in 0..ROWS {
                let row = Polynomial::new(&self.shapes[i][r], &ends);
                let power = powers(t)[order(r) - 1];
                let distances = self.distances(i, r, &row.value(t), power[0]);
                let slopes = self.distances(i, r, &row.slope(t), power[1]);
                self.rows[i][r] = Bounded::new(&distances, LEAST_SLACK, 1.0);
                for (slopes, multipliers) in slopes.iter().zip(self.rows[i][r].multipliers()) {
                    force += slopes.iter().zip(multipliers).map(|(s, z)| s.max(0.0) * z).sum::<f64>();
                }
            }
        }
        let mean = self.total() / self.sections as f64;
        let mu = f64::max(self.sections as f64 / force, LEAST_START * mean);
        for i in 0..self.sections {
            self.rows[i].iter_mut().for_each(|row| row.scale_multipliers(mu));
            self.duration_rows[i] = Bounded::new(&self.duration_distances(i), 0.0, mu);
        }
        for node in 1..self.sections {
            for derivative in 1..3 {
                let distances = self.node_distances(node, derivative);
                self.node_rows[node][derivative - 1] = Bounded::new(&distances, LEAST_SLACK, mu);
            }
        }
        mu
    }

    /// The distances of `value` to the bounds of a row times `scale`; of derivatives, theirs.
    fn distances(&self, i: usize, r: usize, value: &Lanes<N>, scale: f64) -> [Lanes<N>; 2] {
        let bounds = &self.bounds[i][order(r) - 1];
        [
            std::array::from_fn(|k| value[k] - scale * bounds[0][k]),
            std::array::from_fn(|k| scale * bounds[1][k] - value[k]),
        ]
    }

    /// The distances of a node to its bounds at the begin of the round.
    pub(super) fn node_distances(&self, node: usize, derivative: usize) -> [Lanes<N>; 2] {
        let (bounds, value) = (self.node_bounds(node, derivative), &self.from.nodes[node][derivative]);
        [std::array::from_fn(|k| value[k] - bounds[0][k]), std::array::from_fn(|k| bounds[1][k] - value[k])]
    }

    pub(super) fn duration_distances(&self, i: usize) -> [Lanes<1>; 2] {
        [[self.from.durations[i] - self.least[i]], [FAR - self.from.durations[i]]]
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
        let t = self.durations[i];
        let ends = ends(&self.nodes[i], &self.nodes[i + 1]);
        let mut sums = Sums::ZERO;
        for r in 0..ROWS {
            let row = Polynomial::new(&self.shapes[i][r], &ends);
            let power = powers(t)[order(r) - 1];
            self.now[i][r] = self.distances(i, r, &row.value(t), power[0]);
            self.by_duration[i][r] = self.distances(i, r, &row.slope(t), power[1]);
            let curvatures = self.distances(i, r, &row.curvature(), power[2]);
            let [_, v0, v1, a0, a1] = self.shapes[i][r];
            let derivatives = Derivatives {
                factors: &[t * v0, t * v1, t * t * a0, t * t * a1],
                slopes: &self.by_duration[i][r],
                curvatures: &curvatures,
                factor_slopes: &[v0, v1, 2.0 * t * a0, 2.0 * t * a1],
            };
            let pull = self.rows[i][r].pull(&self.now[i][r], mu);
            sums.add(&derivatives, &pull, self.rows[i][r].multipliers());
        }
        let pull = self.duration_rows[i].pull(&self.duration_distances(i), mu);
        let e = &mut self.equations;
        e.scale[i] = sums.own.iter().sum::<f64>();
        let curvature = sums.curvature.iter().sum::<f64>();
        e.durations[i] += e.scale[i] + curvature + pull.weight[0][0] + pull.weight[1][0];
        e.duration_side[i] += sums.own_side.iter().sum::<f64>() + pull.force[0][0] - pull.force[1][0] - 1.0;
        e.add_section(i, &sums.square, &sums.coupling, &sums.side);
    }

    fn mean_product(&self) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.sections {
            sum += self.rows[i].iter().map(Bounded::products).sum::<f64>();
        }
        for node in 1..self.sections {
            sum += self.node_rows[node].iter().map(Bounded::products).sum::<f64>();
        }
        sum / self.count_products()
    }

    fn count_products(&self) -> f64 {
        (2 * N * (ROWS * self.sections + 2 * (self.sections - 1))) as f64
    }
}

/// No upper bound of a duration (s).
const FAR: f64 = 1e9;

/// Slacks at the begin are at least that part of the range between the bounds.
const LEAST_SLACK: f64 = 0.1;

/// The least products of slack and multiplier at the begin, relative to the mean duration.
const LEAST_START: f64 = 3e-3;

/// The rounds end if the products together are below that part of the duration, and the excess is
/// below this one.
const CLOSE: f64 = 0.02;
const SETTLED: f64 = 1.02;

/// The products become that much smaller after a step longer than `LONG`, and after another one.
const LONG: f64 = 0.7;
const QUICK: f64 = 0.1;
const SLOW: f64 = 0.4;

/// Excess that is allowed between rounds, and halvings of a step that makes more.
const ALLOWED: f64 = 1.4;
const HALVINGS: usize = 4;
