//! Adaptive Gauss-Legendre quadrature and the arc length of curves.

use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// Positive nodes and weights of the 12-point Gauss-Legendre rule on [-1, 1] (exact for polynomials of degree 23).
const NODES: [(f64, f64); 6] = [
    (0.125_233_408_511_468_9, 0.249_147_045_813_402_8),
    (0.367_831_498_998_180_2, 0.233_492_536_538_354_8),
    (0.587_317_954_286_617_4, 0.203_167_426_723_065_92),
    (0.769_902_674_194_304_7, 0.160_078_328_543_346_23),
    (0.904_117_256_370_474_9, 0.106_939_325_995_318_43),
    (0.981_560_634_246_719_3, 0.047_175_336_386_511_83),
];

/// A piece is halved at most this often; what remains at a cusp is then shorter than 1e-13 of the piece.
const MAX_HALVINGS: u32 = 44;
/// At most this many intervals are halved in one integral.
const MOST_INTERVALS: u32 = 4096;

/// Integral of `f` over `[a, b]` by one 12-point Gauss-Legendre rule.
pub fn gauss_legendre(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let sum: f64 = NODES.iter().map(|&(x, w)| w * (f(middle - half * x) + f(middle + half * x))).sum();
    half * sum
}

/// Integral of a smooth `f` over `[a, b]` to the absolute `tolerance`, halving where a rule and its two halves disagree.
///
/// The tolerance is shared out by interval length. `noise` is the error of a single value of `f`: differences it explains
/// are not chased. The number of halvings is bounded whatever the function.
pub fn adaptive_gauss_legendre(f: &impl Fn(f64) -> f64, a: f64, b: f64, tolerance: f64, noise: f64) -> f64 {
    let mut rest = MOST_INTERVALS;
    let whole = gauss_legendre(f, a, b);
    refine(f, (a, b), whole, tolerance, noise, MAX_HALVINGS, &mut rest)
}

fn refine(
    f: &impl Fn(f64) -> f64,
    (a, b): (f64, f64),
    whole: f64,
    tolerance: f64,
    noise: f64,
    depth: u32,
    rest: &mut u32,
) -> f64 {
    let m = 0.5 * (a + b);
    let (left, right) = (gauss_legendre(f, a, m), gauss_legendre(f, m, b));
    let sum = left + right;
    // On a resolved piece the halves are about 2^24 times closer to the truth than the whole; beside a sharp bend they
    // are not, so a margin of ten is all that is taken of it.
    let agreed = (whole - sum).abs() <= (10.0 * tolerance).max(noise * (b - a)).max(4.0 * f64::EPSILON * sum.abs());
    if agreed || depth == 0 || *rest == 0 || !sum.is_finite() {
        return sum;
    }
    *rest -= 1;
    refine(f, (a, m), left, 0.5 * tolerance, noise, depth - 1, rest)
        + refine(f, (m, b), right, 0.5 * tolerance, noise, depth - 1, rest)
}

impl<const D: usize> NurbsCurve<D> {
    /// Length of the curve, in its unit, to the absolute `tolerance`.
    ///
    /// Adaptive 12-point Gauss-Legendre quadrature of `|C'|` on every Bezier piece. Tolerances below about 1e-15 of the
    /// length cannot be met in double precision; asking for less costs time and gains nothing.
    ///
    /// # Errors
    /// When the tolerance is not a finite number above 0.
    pub fn arc_length(&self, tolerance: f64) -> Result<f64, GeometryError> {
        let (a, b) = self.domain();
        self.arc_length_between(a, b, tolerance)
    }

    /// Length of the part between the parameters `u0` and `u1`, negative where `u1 < u0`; parameters outside the domain
    /// are taken to its ends.
    ///
    /// # Errors
    /// When the tolerance is not a finite number above 0.
    pub fn arc_length_between(&self, u0: f64, u1: f64, tolerance: f64) -> Result<f64, GeometryError> {
        check_tolerance(tolerance)?;
        if u1 < u0 {
            return Ok(-self.arc_length_between(u1, u0, tolerance)?);
        }
        let pieces = self.pieces();
        let (first, last) = (pieces.find(u0), pieces.find(u1));
        let share = tolerance / (last - first + 1) as f64;
        let mut sum = 0.0;
        for i in first..=last {
            let start = if i == first { pieces.local(i, u0) } else { -1.0 };
            let end = if i == last { pieces.local(i, u1) } else { 1.0 };
            if start < end {
                let speed = |t| pieces.local_speed(i, t);
                sum += adaptive_gauss_legendre(&speed, start, end, share, pieces.speed_noise(i));
            }
        }
        Ok(sum)
    }
}

/// Tolerances are finite and above 0.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), GeometryError> {
    if tolerance.is_finite() && tolerance > 0.0 {
        Ok(())
    } else {
        Err(GeometryError::NotPositive { what: "tolerance", value: tolerance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_is_exact_for_degree_23() {
        let integral = gauss_legendre(&|x: f64| x.powi(22) + x.powi(23), 0.0, 2.0);
        let exact = 2f64.powi(23) / 23.0 + 2f64.powi(24) / 24.0;
        assert!((integral / exact - 1.0).abs() < 1e-14, "{integral} against {exact}");
    }

    #[test]
    fn a_narrow_peak_is_resolved() {
        // 1 / (1 + (1000 x)^2) has its poles 0.001 beside the interval.
        let integral = adaptive_gauss_legendre(&|x: f64| 1.0 / (1.0 + 1e6 * x * x), -1.0, 1.0, 1e-15, 0.0);
        let exact = 2e-3 * 1000f64.atan();
        assert!((integral - exact).abs() < 1e-15, "{integral} against {exact}");
    }

    #[test]
    fn a_function_that_is_all_noise_ends() {
        let calls = std::cell::Cell::new(0u64);
        let noise = |x: f64| {
            calls.set(calls.get() + 1);
            (x.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 12) as f64
        };
        assert!(adaptive_gauss_legendre(&noise, 0.0, 1.0, 1e-300, 0.0).is_finite());
        assert!(calls.get() < 250_000, "{} calls", calls.get());
    }
}
