//! Linear equations whose coefficients stand near the diagonal.

use nalgebra::SVector;

/// A square matrix with entries on the main diagonal, on `lower` diagonals below it and on `upper` above it.
///
/// It is eliminated without exchanging rows. That is as accurate as with exchanges for the two kinds of matrices that fits
/// have: the collocation matrix of a B-spline is totally positive (de Boor and Pinkus, "Backward error analysis for totally
/// positive linear systems", 1977), and normal equations are symmetric and positive definite. No entry grows, and every
/// pivot is above 0, in either.
#[derive(Debug, Clone)]
pub(crate) struct Banded {
    size: usize,
    lower: usize,
    upper: usize,
    /// Row by row, the main diagonal in column `lower`. What sticks out at the corners stays 0.
    values: Vec<f64>,
}

impl Banded {
    pub fn zeros(size: usize, lower: usize, upper: usize) -> Self {
        Self { size, lower, upper, values: vec![0.0; size * (lower + upper + 1)] }
    }

    /// Adds to an entry inside the band.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.values[row * (self.lower + self.upper + 1) + self.lower + column - row] += value;
    }

    /// Solves for several right sides, each a coordinate of the vectors: they turn into the solution. `None` where a pivot
    /// is not above 0, as of a matrix that is singular to rounding.
    pub fn solve<const D: usize>(self, mut right: Vec<SVector<f64, D>>) -> Option<Vec<SVector<f64, D>>> {
        let Self { size, lower, upper, mut values } = self;
        let width = lower + upper + 1;
        for k in 0..size {
            let (above, below) = values.split_at_mut((k + 1) * width);
            let (pivot, beside) = above[k * width + lower..].split_first()?;
            // NaN fails too.
            if !(*pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            for (i, row) in below.chunks_exact_mut(width).take(lower).enumerate() {
                // The next row has one entry more to the left of its diagonal.
                let (first, rest) = row[lower - 1 - i..].split_first_mut()?;
                let factor = *first / pivot;
                if factor == 0.0 {
                    continue;
                }
                rest.iter_mut().zip(beside).for_each(|(entry, b)| *entry -= factor * b);
                let known = right[k];
                right[k + 1 + i] -= known * factor;
            }
        }
        for k in (0..size).rev() {
            let (pivot, beside) = values[k * width + lower..(k + 1) * width].split_first()?;
            let known = beside.iter().zip(&right[k + 1..]).fold(right[k], |sum, (b, x)| sum - x * *b);
            right[k] = known / *pivot;
        }
        Some(right)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{KnotVector, basis_functions};
    use nalgebra::DMatrix;

    /// Numbers from -1 to 1 that are the same in every run.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    /// Row, column and value of all entries inside the matrix.
    fn entries(m: &Banded) -> Vec<(usize, usize, f64)> {
        let in_row = |i: usize| (i.saturating_sub(m.lower)..=(i + m.upper).min(m.size - 1)).map(move |j| (i, j));
        let value = |i: usize, j: usize| m.values[i * (m.lower + m.upper + 1) + m.lower + j - i];
        (0..m.size).flat_map(in_row).map(|(i, j)| (i, j, value(i, j))).collect()
    }

    fn difference(a: &[SVector<f64, 2>], b: impl Fn(usize, usize) -> f64) -> f64 {
        let size = a.iter().fold(0.0f64, |m, v| m.max(v.amax()));
        let apart = |(i, v): (usize, &SVector<f64, 2>)| (v[0] - b(i, 0)).abs().max((v[1] - b(i, 1)).abs());
        a.iter().enumerate().map(apart).fold(0.0, f64::max) / size
    }

    /// Collocation of a spline on random knots, each row in the middle of what its basis function covers; and its normal
    /// equations.
    fn of_a_spline(n: usize, degree: usize, random: &mut impl FnMut() -> f64) -> (Banded, Banded) {
        let mut t = vec![0.0; n + degree + 1];
        for i in degree + 1..n + degree + 1 {
            t[i] = if i <= n { t[i - 1] + 1.1 + random() } else { t[n] };
        }
        let knots = KnotVector::new(degree, t.clone()).unwrap();
        let mut collocation = Banded::zeros(n, degree, degree);
        let mut normal = Banded::zeros(n, degree, degree);
        let mut values = Vec::new();
        for row in 0..n {
            let u = t[row + 1..=row + degree].iter().sum::<f64>() / degree as f64;
            let first = basis_functions(&knots, u, &mut values);
            for (j, &v) in values.iter().enumerate() {
                collocation.add(row, first + j, v);
                values.iter().enumerate().for_each(|(k, &w)| normal.add(first + j, first + k, v * w));
            }
        }
        (collocation, normal)
    }

    #[test]
    fn agrees_with_dense_elimination() {
        let mut random = numbers(1);
        for case in 0..300 {
            let (n, lower, upper) = (1 + case % 40, case % 5, case / 5 % 4);
            // Heavy on the diagonal: no exchange of rows would be made.
            let mut heavy = Banded::zeros(n, lower, upper);
            for (i, j, _) in entries(&heavy.clone()) {
                heavy.add(i, j, if i == j { 8.0 + random() } else { random() });
            }
            let degree = 1 + case % 5;
            let (collocation, normal) = of_a_spline(degree + 1 + case % 30, degree, &mut random);
            for (matrix, least) in [(heavy, 1e-15), (collocation, 1e-12), (normal, 1e-10)] {
                let right: Vec<_> = (0..matrix.size).map(|_| SVector::from([random(), random()])).collect();
                let mut dense = DMatrix::zeros(matrix.size, matrix.size);
                entries(&matrix).into_iter().for_each(|(i, j, v)| dense[(i, j)] = v);
                let expected = dense.lu().solve(&DMatrix::from_fn(matrix.size, 2, |i, l| right[i][l])).unwrap();
                let apart = difference(&matrix.solve(right).unwrap(), |i, l| expected[(i, l)]);
                assert!(apart <= least, "case {case}: {apart}");
            }
        }
    }

    #[test]
    fn a_singular_matrix_has_no_solution() {
        let mut matrix = Banded::zeros(3, 1, 1);
        [(0, 0), (0, 1), (1, 0), (1, 1), (2, 2)].iter().for_each(|&(i, j)| matrix.add(i, j, 1.0));
        assert!(matrix.solve(vec![SVector::from([1.0]); 3]).is_none());
        assert!(Banded::zeros(1, 0, 0).solve(vec![SVector::from([1.0])]).is_none());
    }
}
