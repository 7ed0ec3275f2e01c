//! The equations of one Newton step: a chain of nodes for each axis, coupled by the durations.
//!
//! Every axis has a block tridiagonal matrix with a block of velocity and acceleration for
//! each node. The durations are shared by all axes. The chain is factored node by node, what is
//! left of the durations is solved densely, and the nodes follow.

use super::rows::Lanes;
use super::{NODES, SECTIONS};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Additions to the diagonal of the durations, relative to `scale`: the first one, the factor to the
/// next, and the last.
const FIRST_SHIFT: f64 = 1e-3;
const SHIFT_GROWTH: f64 = 4.0;
const MOST_SHIFT: f64 = 1e5;

/// Pivots below that part of `scale` count as negative.
const LEAST_PIVOT: f64 = 1e-9;

type Vector<const N: usize> = [Lanes<N>; 2];
type Matrix<const N: usize> = [[Lanes<N>; 2]; 2];

/// Matrix and right-hand side, and the solution once it is there.
pub(super) struct Equations<const N: usize> {
    /// Blocks of the nodes: the lower triangle counts.
    pub diagonal: [Matrix<N>; NODES],
    /// Blocks between a node and the next one.
    pub next: [Matrix<N>; NODES],
    /// Coupling of a duration with the nodes before and after its section.
    pub by_duration: [[Vector<N>; 2]; SECTIONS],
    /// The durations among themselves: diagonal only.
    pub durations: [f64; SECTIONS],
    pub node_side: [Vector<N>; NODES],
    pub duration_side: [f64; SECTIONS],
    /// What the bounds alone contribute to `durations`: the measure of its diagonal.
    pub scale: [f64; SECTIONS],
    dense: [[f64; SECTIONS]; SECTIONS],
    columns: [Vector<N>; SECTIONS],
}

impl<const N: usize> Equations<N> {
    pub const fn new() -> Self {
        let zero = [0.0; N];
        Self {
            diagonal: [[[zero; 2]; 2]; NODES],
            next: [[[zero; 2]; 2]; NODES],
            by_duration: [[[zero; 2]; 2]; SECTIONS],
            durations: [0.0; SECTIONS],
            node_side: [[zero; 2]; NODES],
            duration_side: [0.0; SECTIONS],
            scale: [0.0; SECTIONS],
            dense: [[0.0; SECTIONS]; SECTIONS],
            columns: [[zero; 2]; SECTIONS],
        }
    }

    /// Sets everything to zero for a number of sections.
    pub fn clear(&mut self, sections: usize) {
        let zero = [0.0; N];
        for i in 0..=sections {
            self.diagonal[i] = [[zero; 2]; 2];
            self.next[i] = [[zero; 2]; 2];
            self.node_side[i] = [zero; 2];
        }
        for i in 0..sections {
            self.by_duration[i] = [[zero; 2]; 2];
            self.durations[i] = 0.0;
            self.duration_side[i] = 0.0;
        }
    }

    /// Adds a section: matrix, coupling with its duration, and side, in the order velocity before and
    /// after, acceleration before and after.
    pub fn add_section(
        &mut self,
        i: usize,
        square: &[[Lanes<N>; 4]; 4],
        coupling: &[Lanes<N>; 4],
        side: &[Lanes<N>; 4],
    ) {
        for node in 0..2 {
            for c in 0..2 {
                let x = 2 * c + node;
                for k in 0..N {
                    self.by_duration[i][node][c][k] += coupling[x][k];
                    self.node_side[i + node][c][k] += side[x][k];
                }
                for d in 0..=c {
                    for k in 0..N {
                        self.diagonal[i + node][c][d][k] += square[x][2 * d + node][k];
                    }
                }
            }
        }
        for c in 0..2 {
            for d in 0..2 {
                let (x, y) = (2 * c, 2 * d + 1);
                for k in 0..N {
                    self.next[i][c][d][k] += square[x.max(y)][x.min(y)][k];
                }
            }
        }
    }

    /// Takes the velocity of a node out of the equations: its change is 0.
    pub fn fix(&mut self, node: usize, axis: usize) {
        for other in 0..2 {
            self.next[node][0][other][axis] = 0.0;
            self.next[node - 1][other][0][axis] = 0.0;
        }
        self.diagonal[node][0][0][axis] = 1.0;
        self.diagonal[node][1][0][axis] = 0.0;
        self.by_duration[node - 1][1][0][axis] = 0.0;
        self.by_duration[node][0][0][axis] = 0.0;
        self.node_side[node][0][axis] = 0.0;
    }

    /// Solves: the sides become the changes of nodes and durations. Returns false if the matrix is
    /// not positive definite.
    pub fn solve(&mut self, sections: usize) -> bool {
        for i in 0..sections {
            self.dense[i][..=i].fill(0.0);
            self.dense[i][i] = self.durations[i];
        }
        for node in 1..sections {
            self.eliminate(node);
        }
        if !self.solve_durations(sections) {
            return false;
        }
        // The sides of the nodes hold what was eliminated; the columns of the durations follow.
        for node in 1..sections {
            let (before, after) = (self.duration_side[node - 1], self.duration_side[node]);
            let mut y = [[0.0; N]; 2];
            for (c, y) in y.iter_mut().enumerate() {
                for k in 0..N {
                    y[k] = self.by_duration[node - 1][1][c][k] * before + self.by_duration[node][0][c][k] * after;
                }
            }
            if node > 1 {
                take_product(&mut y, &self.next[node - 1], &self.columns[0]);
            }
            forward(&self.diagonal[node], &mut y);
            self.columns[0] = y;
            for (side, y) in self.node_side[node].iter_mut().zip(&y) {
                for k in 0..N {
                    side[k] -= y[k];
                }
            }
        }
        for node in (1..sections).rev() {
            let mut x = self.node_side[node];
            if node + 1 < sections {
                let after = self.node_side[node + 1];
                for (x, row) in x.iter_mut().zip(&self.next[node]) {
                    for k in 0..N {
                        x[k] -= row[0][k] * after[0][k] + row[1][k] * after[1][k];
                    }
                }
            }
            backward(&self.diagonal[node], &mut x);
            self.node_side[node] = x;
        }
        self.node_side[1..sections].iter().flatten().flatten().all(|x| x.is_finite())
    }

    /// Factors the block of a node and takes it out of the durations.
    fn eliminate(&mut self, node: usize) {
        if node > 1 {
            // The block before, in factors: F = G^-1 E.
            let f = self.next[node - 1];
            for r in 0..2 {
                for c in 0..=r {
                    for k in 0..N {
                        self.diagonal[node][r][c][k] -= f[0][r][k] * f[0][c][k] + f[1][r][k] * f[1][c][k];
                    }
                }
            }
            let before = self.node_side[node - 1];
            take_product(&mut self.node_side[node], &f, &before);
            for column in &mut self.columns[..node] {
                let was = *column;
                *column = [[0.0; N]; 2];
                take_product(column, &f, &was);
            }
        } else {
            self.columns[0] = [[0.0; N]; 2];
        }
        self.columns[node] = [[0.0; N]; 2];
        for (column, coupling) in [(node - 1, self.by_duration[node - 1][1]), (node, self.by_duration[node][0])] {
            for (x, y) in self.columns[column].iter_mut().zip(&coupling) {
                for k in 0..N {
                    x[k] += y[k];
                }
            }
        }
        factor(&mut self.diagonal[node]);
        let g = self.diagonal[node];
        forward(&g, &mut self.node_side[node]);
        for c in 0..2 {
            let mut column = [self.next[node][0][c], self.next[node][1][c]];
            forward(&g, &mut column);
            for (row, x) in self.next[node].iter_mut().zip(&column) {
                row[c] = *x;
            }
        }
        for column in &mut self.columns[..=node] {
            forward(&g, column);
        }
        for i in 0..=node {
            self.duration_side[i] -= dot(&self.columns[i], &self.node_side[node]);
            for j in 0..=i {
                self.dense[i][j] -= dot(&self.columns[i], &self.columns[j]);
            }
        }
    }

    /// Solves for the durations. Their matrix may have negative eigenvalues, as the limits are not
    /// convex in them: it gets a larger diagonal then, so that the step goes downwards.
    fn solve_durations(&mut self, n: usize) -> bool {
        let mut diagonal = [0.0; SECTIONS];
        for i in 0..n {
            diagonal[i] = self.dense[i][i];
            for j in 0..i {
                self.dense[j][i] = self.dense[i][j];
            }
        }
        let mut shift = 0.0;
        while !self.factor_durations(n, &diagonal, shift) {
            if shift > MOST_SHIFT {
                return false;
            }
            shift = if shift == 0.0 { FIRST_SHIFT } else { SHIFT_GROWTH * shift };
        }
        for i in 0..n {
            let sum: f64 = self.dense[i][..i].iter().zip(&self.duration_side).map(|(x, y)| x * y).sum();
            self.duration_side[i] = (self.duration_side[i] - sum) / self.dense[i][i];
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|j| self.dense[j][i] * self.duration_side[j]).sum();
            self.duration_side[i] = (self.duration_side[i] - sum) / self.dense[i][i];
        }
        self.duration_side[..n].iter().all(|x| x.is_finite())
    }

    /// Factors the matrix of the durations with a larger diagonal: lower triangle from the upper one.
    fn factor_durations(&mut self, n: usize, diagonal: &[f64; SECTIONS], shift: f64) -> bool {
        for i in 0..n {
            for j in 0..i {
                let (above, below) = self.dense.split_at_mut(i);
                let row = &mut below[0];
                let sum: f64 = row[..j].iter().zip(&above[j][..j]).map(|(x, y)| x * y).sum();
                row[j] = (above[j][i] - sum) / above[j][j];
            }
            let row = &mut self.dense[i];
            let square = diagonal[i] + shift * self.scale[i] - row[..i].iter().map(|x| x * x).sum::<f64>();
            if square.is_nan() || square <= LEAST_PIVOT * self.scale[i] {
                return false;
            }
            row[i] = square.sqrt();
        }
        true
    }
}

/// `y -= F^T x`.
fn take_product<const N: usize>(y: &mut Vector<N>, f: &Matrix<N>, x: &Vector<N>) {
    for (c, y) in y.iter_mut().enumerate() {
        for k in 0..N {
            y[k] -= f[0][c][k] * x[0][k] + f[1][c][k] * x[1][k];
        }
    }
}

/// The lower Cholesky factor in place, with the inverse of its diagonal on the diagonal.
fn factor<const N: usize>(m: &mut Matrix<N>) {
    for k in 0..N {
        let x = 1.0 / m[0][0][k].sqrt();
        let y = m[1][0][k] * x;
        let z = 1.0 / (m[1][1][k] - y * y).sqrt();
        (m[0][0][k], m[1][0][k], m[1][1][k]) = (x, y, z);
    }
}

/// Solves with the lower factor in place.
fn forward<const N: usize>(g: &Matrix<N>, x: &mut Vector<N>) {
    for k in 0..N {
        x[0][k] *= g[0][0][k];
        x[1][k] = (x[1][k] - g[1][0][k] * x[0][k]) * g[1][1][k];
    }
}

/// Solves with the transpose of the lower factor in place.
fn backward<const N: usize>(g: &Matrix<N>, x: &mut Vector<N>) {
    for k in 0..N {
        x[1][k] *= g[1][1][k];
        x[0][k] = (x[0][k] - g[1][0][k] * x[1][k]) * g[0][0][k];
    }
}

fn dot<const N: usize>(x: &Vector<N>, y: &Vector<N>) -> f64 {
    let mut sum = 0.0;
    for (x, y) in x.iter().zip(y) {
        for k in 0..N {
            sum += x[k] * y[k];
        }
    }
    sum
}
