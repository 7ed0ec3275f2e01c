//! LU factors of a 6 x 6 matrix with row pivoting, on the stack.

use nalgebra::{Matrix6, Vector6};

/// P A = L U. The diagonal holds the reciprocals of U's.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lu6 {
    rows: [[f64; 6]; 6],
    order: [usize; 6],
}

impl Lu6 {
    /// The factors of `matrix`, or none if a pivot is 0 or not finite.
    pub(crate) fn new(matrix: &Matrix6<f64>) -> Option<Self> {
        let mut rows: [[f64; 6]; 6] = std::array::from_fn(|r| std::array::from_fn(|c| matrix[(r, c)]));
        let mut order = [0, 1, 2, 3, 4, 5];
        for k in 0..6 {
            let mut pivot = k;
            for r in k + 1..6 {
                if rows[r][k].abs() > rows[pivot][k].abs() {
                    pivot = r;
                }
            }
            rows.swap(k, pivot);
            order.swap(k, pivot);
            let reciprocal = 1.0 / rows[k][k];
            if !reciprocal.is_finite() {
                return None;
            }
            rows[k][k] = reciprocal;
            let pivot_row = rows[k];
            for row in &mut rows[k + 1..] {
                let factor = row[k] * reciprocal;
                row[k] = factor;
                for c in k + 1..6 {
                    row[c] -= factor * pivot_row[c];
                }
            }
        }
        Some(Self { rows, order })
    }

    /// x of A x = `b`.
    pub(crate) fn solve(&self, b: &Vector6<f64>) -> Vector6<f64> {
        let mut x: [f64; 6] = std::array::from_fn(|r| b[self.order[r]]);
        for r in 1..6 {
            for c in 0..r {
                x[r] -= self.rows[r][c] * x[c];
            }
        }
        for r in (0..6).rev() {
            for c in r + 1..6 {
                x[r] -= self.rows[r][c] * x[c];
            }
            x[r] *= self.rows[r][r];
        }
        Vector6::from(x)
    }

    /// A lower bound of A's smallest singular value, 1 / (|L^-1| |U^-1|) in the Frobenius norm: cheap and safe, but up
    /// to some tens of times too small.
    pub(crate) fn smallest_singular_value_at_least(&self) -> f64 {
        let (mut lower, mut upper) = (6.0, 0.0);
        for k in 0..6 {
            // Column k of L^-1 below its unit diagonal, and of U^-1.
            let mut l = [0.0; 6];
            l[k] = 1.0;
            for r in k + 1..6 {
                for c in k..r {
                    l[r] -= self.rows[r][c] * l[c];
                }
                lower += l[r] * l[r];
            }
            let mut u = [0.0; 6];
            u[k] = self.rows[k][k];
            upper += u[k] * u[k];
            for r in (0..k).rev() {
                for c in r + 1..=k {
                    u[r] -= self.rows[r][c] * u[c];
                }
                u[r] *= self.rows[r][r];
                upper += u[r] * u[r];
            }
        }
        1.0 / (lower * upper).sqrt()
    }
}
