//! Small linear systems on the stack: LU factors of a 6 x 6 matrix with row pivoting, and Cholesky's method.

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
        let regular = eliminate::<0>(&mut rows, &mut order)
            && eliminate::<1>(&mut rows, &mut order)
            && eliminate::<2>(&mut rows, &mut order)
            && eliminate::<3>(&mut rows, &mut order)
            && eliminate::<4>(&mut rows, &mut order)
            && eliminate::<5>(&mut rows, &mut order);
        regular.then_some(Self { rows, order })
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

/// Step `K` of the elimination; false if the pivot is 0 or not finite. The step is a constant so that all loops have
/// fixed lengths and are unrolled.
#[inline]
fn eliminate<const K: usize>(rows: &mut [[f64; 6]; 6], order: &mut [usize; 6]) -> bool {
    let mut pivot = K;
    for r in K + 1..6 {
        pivot = if rows[r][K].abs() > rows[pivot][K].abs() { r } else { pivot };
    }
    rows.swap(K, pivot);
    order.swap(K, pivot);
    let pivot_row = rows[K];
    let reciprocal = 1.0 / pivot_row[K];
    for row in rows.iter_mut().skip(K + 1) {
        let factor = row[K] * reciprocal;
        row[K] = factor;
        for c in K + 1..6 {
            row[c] -= factor * pivot_row[c];
        }
    }
    rows[K][K] = reciprocal;
    reciprocal.is_finite()
}

/// x of A x = `b` for a symmetric positive definite A, of which the lower triangle is read; none if it is not.
#[inline]
#[expect(clippy::needless_range_loop, reason = "rows and columns of one array are read side by side")]
pub(crate) fn solve_positive<const K: usize>(mut a: [[f64; K]; K], b: [f64; K]) -> Option<[f64; K]> {
    // A = L D L^T, with the reciprocals of D on the diagonal.
    for j in 0..K {
        for i in j..K {
            // The upper triangle holds L D.
            let known: f64 = (0..j).map(|k| a[i][k] * a[k][j]).sum();
            a[i][j] -= known;
        }
        let pivot = a[j][j];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let reciprocal = 1.0 / pivot;
        a[j][j] = reciprocal;
        for i in j + 1..K {
            let entry = a[i][j];
            a[j][i] = entry;
            a[i][j] = entry * reciprocal;
        }
    }
    let mut x = b;
    for i in 0..K {
        for k in 0..i {
            x[i] -= a[i][k] * x[k];
        }
    }
    for i in 0..K {
        x[i] *= a[i][i];
    }
    for i in (0..K).rev() {
        for k in i + 1..K {
            x[i] -= a[k][i] * x[k];
        }
    }
    Some(x)
}
