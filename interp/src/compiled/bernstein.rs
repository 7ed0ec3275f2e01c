//! Polynomials of degree 5 at most in Bernstein form, with a bound on what rounding did to them.
//!
//! The coefficients of a polynomial on an interval in Bernstein form enclose its values there: the polynomial is a mean of
//! them with weights that are not negative and add up to 1. The first and the last coefficient are values of the polynomial.
//! Division of the interval by de Casteljau's algorithm brings the coefficients as close to the polynomial as is wanted.

/// Number of coefficients of the largest degree.
pub(super) const SIZE: usize = 6;

/// The largest relative error of one rounding.
const ROUNDING: f64 = 0.5 * f64::EPSILON;
/// Roundings in a coefficient that comes from powers, 13 at most, and in the sum of sizes that measures them.
const CONVERTED: f64 = 16.0;
/// Roundings that one division adds to a coefficient: one for each of the means it goes through, and one to spare.
const DIVIDED: f64 = SIZE as f64;

/// A polynomial on an interval in Bernstein form.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bernstein {
    coefficients: [f64; SIZE],
    degree: usize,
    /// Sum of the sizes of the terms at the end of the whole piece: no coefficient is larger.
    size: f64,
    /// Roundings so far, each of at most `size * ROUNDING`.
    roundings: f64,
}

impl Bernstein {
    /// The polynomial `sum a[k] u^k` for `u` in 0 to 1, of degree `degree`.
    pub fn from_powers(a: &[f64; SIZE], degree: usize) -> Self {
        let mut coefficients = [0.0; SIZE];
        for (i, coefficient) in coefficients.iter_mut().enumerate().take(degree + 1) {
            // C(i, k) / C(degree, k), by whole numbers.
            let (mut above, mut below) = (1_u32, 1_u32);
            for (k, a) in a.iter().enumerate().take(i + 1) {
                *coefficient += a * (f64::from(above) / f64::from(below));
                // The factor 1 / (k + 1) of both cancels.
                above *= (i - k) as u32;
                below *= (degree - k).max(1) as u32;
            }
        }
        let size = a.iter().take(degree + 1).map(|a| a.abs()).sum();
        Self { coefficients, degree, size, roundings: CONVERTED }
    }

    /// Both ends, which the polynomial attains.
    pub fn ends(&self) -> [f64; 2] {
        [self.coefficients[0], self.coefficients[self.degree]]
    }

    /// Largest size of a coefficient.
    pub fn largest(&self) -> f64 {
        // Not `max` alone: a NaN has to show.
        let used = &self.coefficients[..=self.degree];
        used.iter().fold(0.0, |m, c| if c.abs() > m || c.is_nan() { c.abs() } else { m })
    }

    /// By how much a coefficient may be off through rounding.
    pub fn error(&self) -> f64 {
        self.roundings * ROUNDING * self.size * (1.0 + 1e-6)
    }

    /// The range that the polynomial does not leave on the interval, whatever rounding did. A NaN makes it everything.
    pub fn range(&self) -> [f64; 2] {
        let used = &self.coefficients[..=self.degree];
        if used.iter().any(|c| c.is_nan()) {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let error = self.error() * (1.0 + 2.0 * f64::EPSILON) + f64::MIN_POSITIVE;
        let low = used.iter().copied().fold(f64::INFINITY, f64::min);
        let high = used.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        [(low - error).next_down(), (high + error).next_up()]
    }

    /// Each coefficient after `map`, which has to be linear. What rounding does in it is not known here.
    pub fn mapped(&self, map: impl Fn(f64) -> f64) -> Self {
        Self { coefficients: self.coefficients.map(map), ..*self }
    }

    /// A ratio that the size of the polynomial to a positive one does not exceed on the interval: a mean of the ratios of the
    /// coefficients, whatever rounding did to those of `self`. Infinite where `other` is not known to be positive.
    pub fn largest_ratio(&self, other: &Self) -> f64 {
        let degree = self.degree.max(other.degree);
        let (above, below) = (self.elevated(degree), other.elevated(degree));
        let error = above.error();
        let mut largest = 0.0;
        for (a, b) in above.coefficients.iter().zip(&below.coefficients).take(degree + 1) {
            let ratio = (a.abs() + error) / b;
            // Not `max`: a NaN has to show.
            if *b <= 0.0 || ratio.is_nan() {
                return f64::INFINITY;
            }
            if ratio > largest {
                largest = ratio;
            }
        }
        largest
    }

    /// The same polynomial with coefficients of a higher degree.
    fn elevated(&self, degree: usize) -> Self {
        let mut out = *self;
        while out.degree < degree {
            let (n, before) = (out.degree + 1, out.coefficients);
            out.coefficients[n] = before[n - 1];
            for i in 1..n {
                let share = i as f64 / n as f64;
                out.coefficients[i] = share * before[i - 1] + (1.0 - share) * before[i];
            }
            out.degree = n;
            // Two products, a share and its complement, and a sum.
            out.roundings += 5.0;
        }
        out
    }

    /// A value that the polynomial does not exceed in size anywhere on the interval, whatever rounding did.
    pub fn bound(&self) -> f64 {
        let error = self.roundings * ROUNDING * self.size;
        (self.largest() + error * (1.0 + 1e-6)) * (1.0 + 2.0 * f64::EPSILON) + f64::MIN_POSITIVE
    }

    /// The polynomial on the first and on the second half of the interval.
    pub fn halves(&self) -> [Self; 2] {
        let n = self.degree;
        let (mut first, mut second) = (*self, *self);
        for level in 1..=n {
            for i in 0..=n - level {
                second.coefficients[i] = 0.5 * (second.coefficients[i] + second.coefficients[i + 1]);
            }
            first.coefficients[level] = second.coefficients[0];
        }
        // The means of the last level stand at 0; those of the levels before it behind.
        first.roundings += DIVIDED;
        second.roundings += DIVIDED;
        [first, second]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_same_polynomial() {
        let a = [1.0, -2.0, 0.5, 3.0, -1.0, 0.25];
        let value = |u: f64| a.iter().rev().fold(0.0, |sum, c| sum * u + c);
        let whole = Bernstein::from_powers(&a, 5);
        let [first, second] = whole.halves();
        for (part, from, to) in [(whole, 0.0, 1.0), (first, 0.0, 0.5), (second, 0.5, 1.0)] {
            let [begin, end] = part.ends();
            assert!((begin - value(from)).abs() < 1e-15 && (end - value(to)).abs() < 1e-15);
            for i in 0..=1000 {
                assert!(value(from + (to - from) * f64::from(i) / 1000.0).abs() <= part.bound());
            }
        }
    }

    #[test]
    fn lower_degrees_use_their_own_coefficients_alone() {
        let line = Bernstein::from_powers(&[1.0, -3.0, 0.0, 0.0, 0.0, 0.0], 1);
        assert_eq!(line.ends(), [1.0, -2.0]);
        assert!((line.bound() - 2.0).abs() < 1e-12);
        let constant = Bernstein::from_powers(&[-4.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0);
        assert_eq!(constant.ends(), [-4.0, -4.0]);
    }
}
