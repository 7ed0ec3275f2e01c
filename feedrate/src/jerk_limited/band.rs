//! Symmetric positive definite systems with two diagonals beside the main one.

/// The lower half of a pentadiagonal matrix, overwritten by its factors `L D L^T`.
#[derive(Debug, Clone, Default)]
pub(super) struct Pentadiagonal {
    /// Main diagonal, first and second subdiagonal: `rows[i] = [a(i, i), a(i+1, i), a(i+2, i)]`.
    pub rows: Vec<[f64; 3]>,
}

impl Pentadiagonal {
    pub fn clear(&mut self, n: usize) {
        self.rows.clear();
        self.rows.resize(n, [0.0; 3]);
    }

    /// Factors in place. A pivot that round-off has made non-positive becomes infinite, which
    /// freezes its variable.
    pub fn factor(&mut self) {
        let n = self.rows.len();
        for i in 0..n {
            let [d, e, f] = self.rows[i];
            let pivot = if d > 0.0 { d } else { f64::INFINITY };
            let inverse = 1.0 / pivot;
            let (l1, l2) = (e * inverse, f * inverse);
            self.rows[i] = [inverse, l1, l2];
            if i + 1 < n {
                self.rows[i + 1][0] -= l1 * e;
                self.rows[i + 1][1] -= l1 * f;
            }
            if i + 2 < n {
                self.rows[i + 2][0] -= l2 * f;
            }
        }
    }

    /// Solves for one right side, in place.
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.rows.len();
        for i in 0..n {
            let [_, l1, l2] = self.rows[i];
            let value = b[i];
            if i + 1 < n {
                b[i + 1] -= l1 * value;
            }
            if i + 2 < n {
                b[i + 2] -= l2 * value;
            }
        }
        for i in (0..n).rev() {
            let [inverse, l1, l2] = self.rows[i];
            let mut value = b[i] * inverse;
            if i + 1 < n {
                value -= l1 * b[i + 1];
            }
            if i + 2 < n {
                value -= l2 * b[i + 2];
            }
            b[i] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_it_multiplies() {
        let n = 12;
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 9.0 + i as f64,
            1 => 1.5 - 0.3 * i.min(j) as f64,
            2 => -0.7 + 0.1 * i.min(j) as f64,
            _ => 0.0,
        };
        let x: Vec<f64> = (0..n).map(|i| (i as f64 * 1.7).sin()).collect();
        let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum()).collect();
        let mut matrix = Pentadiagonal::default();
        matrix.clear(n);
        for i in 0..n {
            matrix.rows[i] = [
                entry(i, i),
                if i + 1 < n { entry(i + 1, i) } else { 0.0 },
                if i + 2 < n { entry(i + 2, i) } else { 0.0 },
            ];
        }
        matrix.factor();
        matrix.solve(&mut b);
        for (got, expected) in b.iter().zip(&x) {
            assert!((got - expected).abs() < 1e-13);
        }
    }
}
