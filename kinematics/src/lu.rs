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
            let (mut pivot, mut largest) = (k, rows[k][k].abs());
            for r in k + 1..6 {
                let size = rows[r][k].abs();
                (pivot, largest) = if size > largest { (r, size) } else { (pivot, largest) };
            }
            rows.swap(k, pivot);
            order.swap(k, pivot);
            let reciprocal = 1.0 / rows[k][k];
            if !reciprocal.is_finite() {
                return None;
            }
            // Whole rows, with zeros where nothing is to be subtracted: fixed lengths make vector instructions.
            let mut pivot_row = rows[k];
            pivot_row[..=k].fill(0.0);
            for row in &mut rows[k + 1..] {
                let factor = row[k] * reciprocal;
                for c in 0..6 {
                    row[c] -= factor * pivot_row[c];
                }
                row[k] = factor;
            }
            rows[k][k] = reciprocal;
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

    /// |det A|.
    pub(crate) fn determinant(&self) -> f64 {
        1.0 / (0..6).map(|k| self.rows[k][k]).product::<f64>().abs()
    }
}
