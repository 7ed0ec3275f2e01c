//! The shortest motion through way-points on a fine grid, by a sequence of convex programs.
//!
//! In time relative to the duration `T` of a section, with `V = v T`, `A = a T²` and `J = j T³`, the
//! motion is linear in `J`, the limit on `V` is linear, and those on `A` and `J` are bounded from
//! inside by their tangents at the last `T`. Left are the products of velocity and acceleration at
//! the way-points with the durations, which are linearised.
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// A case: states at the nodes (velocities and accelerations between are a guess) and durations.
pub struct Case<'a, const N: usize> {
    pub states: Vec<[AxisState; N]>,
    pub durations: Vec<f64>,
    pub limits: &'a [AxisLimits; N],
    /// Intervals of constant jerk in a section.
    pub pieces: usize,
}

#[derive(Default)]
struct Lines {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
    side: Vec<f64>,
}

impl Lines {
    fn add(&mut self, terms: &[(usize, f64)], side: f64) {
        for &(column, value) in terms {
            self.rows.push(self.side.len());
            self.columns.push(column);
            self.values.push(value);
        }
        self.side.push(side);
    }
}

impl<const N: usize> Case<'_, N> {
    fn sections(&self) -> usize {
        self.durations.len()
    }
    /// Variables: durations, then v and a of the inner nodes, then P, V, A, J of all pieces.
    fn node(&self, i: usize, k: usize, which: usize) -> usize {
        self.sections() + ((i - 1) * N + k) * 2 + which
    }
    fn piece(&self, i: usize, k: usize, m: usize, which: usize) -> usize {
        self.sections() + (self.sections() - 1) * N * 2 + (((i * N + k) * (self.pieces + 1)) + m) * 4 + which
    }

    /// One program; returns the total.
    pub fn round(&mut self, trust: f64) -> Option<f64> {
        let s = self.sections();
        let count = self.piece(s - 1, N - 1, self.pieces, 3) + 1;
        let (mut equal, mut below) = (Lines::default(), Lines::default());
        let d = 1.0 / self.pieces as f64;
        for i in 0..s {
            let t = self.durations[i];
            below.add(&[(i, 1.0)], t * (1.0 + trust));
            below.add(&[(i, -1.0)], -t * (1.0 - trust));
            for k in 0..N {
                let l = &self.limits[k];
                for m in 0..self.pieces {
                    let [p, v, a, j] = [0, 1, 2, 3].map(|w| self.piece(i, k, m, w));
                    let [p1, v1, a1] = [0, 1, 2].map(|w| self.piece(i, k, m + 1, w));
                    equal.add(&[(a1, 1.0), (a, -1.0), (j, -d)], 0.0);
                    equal.add(&[(v1, 1.0), (v, -1.0), (a, -d), (j, -d * d / 2.0)], 0.0);
                    equal.add(&[(p1, 1.0), (p, -1.0), (v, -d), (a, -d * d / 2.0), (j, -d * d * d / 6.0)], 0.0);
                    below.add(&[(j, 1.0), (i, -l.j_max() * 3.0 * t * t)], -2.0 * l.j_max() * t * t * t);
                    below.add(&[(j, -1.0), (i, l.j_min() * 3.0 * t * t)], 2.0 * l.j_min() * t * t * t);
                }
                equal.add(&[(self.piece(i, k, self.pieces, 3), 1.0)], 0.0);
                for m in 0..=self.pieces {
                    let [v, a] = [1, 2].map(|w| self.piece(i, k, m, w));
                    below.add(&[(v, 1.0), (i, -l.v_max())], 0.0);
                    below.add(&[(v, -1.0), (i, l.v_min())], 0.0);
                    below.add(&[(a, 1.0), (i, -l.a_max() * 2.0 * t)], -l.a_max() * t * t);
                    below.add(&[(a, -1.0), (i, l.a_min() * 2.0 * t)], l.a_min() * t * t);
                }
                for (node, m) in [(i, 0), (i + 1, self.pieces)] {
                    let x = self.states[node][k];
                    equal.add(&[(self.piece(i, k, m, 0), 1.0)], x.p);
                    let (v, a) = (self.piece(i, k, m, 1), self.piece(i, k, m, 2));
                    if node == 0 || node == s {
                        equal.add(&[(v, 1.0), (i, -x.v)], 0.0);
                        equal.add(&[(a, 1.0), (i, -x.a * 2.0 * t)], -x.a * t * t);
                    } else {
                        equal.add(&[(v, 1.0), (i, -x.v), (self.node(node, k, 0), -t)], -x.v * t);
                        equal
                            .add(&[(a, 1.0), (i, -x.a * 2.0 * t), (self.node(node, k, 1), -t * t)], -2.0 * x.a * t * t);
                    }
                }
            }
        }
        let (e, b) = (equal.side.len(), below.side.len());
        let mut rows = equal.rows;
        rows.extend(below.rows.iter().map(|r| r + e));
        let columns = [equal.columns, below.columns].concat();
        let values = [equal.values, below.values].concat();
        let side = [equal.side, below.side].concat();
        let a = CscMatrix::new_from_triplets(e + b, count, rows, columns, values);
        let mut cost = vec![0.0; count];
        cost[..s].fill(1.0);
        let cones = [SupportedConeT::ZeroConeT(e), SupportedConeT::NonnegativeConeT(b)];
        let settings = DefaultSettingsBuilder::default().verbose(false).max_iter(100).build().ok()?;
        let p = CscMatrix::zeros((count, count));
        let mut solver = DefaultSolver::new(&p, &cost, &a, &side, &cones, settings).ok()?;
        solver.solve();
        if !matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
            return None;
        }
        let x = &solver.solution.x;
        self.durations.copy_from_slice(&x[..s]);
        for i in 1..s {
            for k in 0..N {
                self.states[i][k].v = x[self.node(i, k, 0)];
                self.states[i][k].a = x[self.node(i, k, 1)];
            }
        }
        Some(self.durations.iter().sum())
    }

    /// Rounds until durations no longer change; `None` without convergence.
    pub fn solve(&mut self) -> Option<f64> {
        let (mut trust, mut last, mut failed) = (0.2, f64::INFINITY, 0);
        for round in 0..60 {
            let saved = (self.states.clone(), self.durations.clone());
            match self.round(trust) {
                None => {
                    (self.states, self.durations) = saved;
                    failed += 1;
                    // Infeasible by linearisation: leave it more time.
                    for t in &mut self.durations {
                        *t *= 1.02;
                    }
                    if failed > 8 {
                        return None;
                    }
                }
                Some(total) => {
                    if (total - last).abs() < 1e-5 * total {
                        return Some(total);
                    }
                    if total > last {
                        trust *= 0.6;
                    }
                    last = total;
                    if round > 10 {
                        trust *= 0.8;
                    }
                }
            }
        }
        Some(last)
    }
}
