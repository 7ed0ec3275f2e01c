//! Chebyshev series: from values to coefficients, to powers, and back to values.

/// Chebyshev points of the first kind, with what turns values into coefficients and those into powers.
pub(super) struct Chebyshev<const N: usize> {
    pub(super) points: [f64; N],
    /// `T_k(x_j)`, by `k`.
    values: [[f64; N]; N],
    /// Coefficients of `T_k` by powers.
    powers: [[f64; N]; N],
}

impl<const N: usize> Chebyshev<N> {
    pub(super) fn new() -> Self {
        // All the cosines needed are those of multiples of pi / 2N, each to the last digit.
        let cosine = |m: usize| (std::f64::consts::PI * m as f64 / (2 * N) as f64).cos();
        let quarter: [f64; N] = std::array::from_fn(cosine);
        let cosine = |m: usize| match m % (4 * N) {
            m if m < N => quarter[m],
            m if m == N || m == 3 * N => 0.0,
            m if m < 2 * N => -quarter[2 * N - m],
            m if m == 2 * N => -1.0,
            m if m < 3 * N => -quarter[m - 2 * N],
            m => quarter[4 * N - m],
        };
        let mut powers = [[0.0; N]; N];
        powers[0][0] = 1.0;
        powers[1][1] = 1.0;
        for k in 2..N {
            // T_k = 2 x T_{k-1} - T_{k-2}.
            for i in 0..N {
                let shifted = if i > 0 { powers[k - 1][i - 1] } else { 0.0 };
                powers[k][i] = 2.0 * shifted - powers[k - 2][i];
            }
        }
        Self {
            points: std::array::from_fn(|j| cosine(2 * j + 1)),
            values: std::array::from_fn(|k| std::array::from_fn(|j| cosine(k * (2 * j + 1)))),
            powers,
        }
    }

    pub(super) fn coefficients(&self, values: &[f64; N]) -> [f64; N] {
        let mut c = self.values.each_ref().map(|row| {
            let sum: f64 = row.iter().zip(values).map(|(r, v)| r * v).sum();
            // Divided last: the coefficients of a constant are exact.
            2.0 * sum / N as f64
        });
        c[0] *= 0.5;
        c
    }

    /// A Chebyshev series in powers of x.
    pub(super) fn to_powers(&self, c: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        // The small terms first.
        for (ck, row) in c.iter().zip(&self.powers).rev() {
            for (o, p) in out.iter_mut().zip(row) {
                *o += ck * p;
            }
        }
        out
    }
}

/// Values of a Chebyshev series at several places at once: the loop over the places becomes vector instructions.
#[inline]
pub(super) fn clenshaw<const N: usize>(c: &[f64], x: &[f64; N]) -> [f64; N] {
    let (mut b1, mut b2) = ([0.0; N], [0.0; N]);
    for &ck in c[1..].iter().rev() {
        for j in 0..N {
            (b1[j], b2[j]) = (2.0 * x[j] * b1[j] - b2[j] + ck, b1[j]);
        }
    }
    std::array::from_fn(|j| x[j] * b1[j] - b2[j] + c[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chebyshev_series_and_powers_agree_with_the_function() {
        let nodes = Chebyshev::<14>::new();
        let values = nodes.points.map(|x: f64| (0.3 * x).exp());
        let c = nodes.coefficients(&values);
        let p = nodes.to_powers(&c);
        for x in [-1.0f64, -0.37, 0.0, 0.81, 1.0] {
            let exact = (0.3 * x).exp();
            assert!((clenshaw(&c, &[x])[0] - exact).abs() < 4e-15);
            assert!((p.iter().rev().fold(0.0, |s, &k| s * x + k) - exact).abs() < 4e-15);
        }
    }
}
