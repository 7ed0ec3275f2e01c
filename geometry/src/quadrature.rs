//! Adaptive Gauss-Legendre quadrature and the arc length of curves.

use std::collections::BinaryHeap;

use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// Number of nodes of the rule.
const N: usize = 16;
/// Positive nodes and their weights of the 16-point Gauss-Legendre rule on [-1, 1] (exact for polynomials of degree 31).
const NODES: [(f64, f64); N / 2] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_58),
    (0.458_016_777_657_227_37, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_8, 0.149_595_988_816_576_74),
    (0.755_404_408_355_003, 0.124_628_971_255_533_88),
    (0.865_631_202_387_831_8, 0.095_158_511_682_492_79),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_894),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_096),
];
/// Orders of the Legendre coefficients that show how fast they fall: three from the middle, then the last three.
const ORDERS: [usize; 6] = [N / 2 - 2, N / 2 - 1, N / 2, N - 3, N - 2, N - 1];
/// The contribution of a pair of values to these coefficients: `(2 k + 1) / 2 w_j P_k(x_j)`.
const PROJECTIONS: [[f64; N / 2]; 6] = projections();

/// Values of the polynomial through the nodes at the ends of [-1, 1]: its weights at -1 on the nodes below the middle and
/// above it, from the middle outwards. At 1 they change places.
const AT_END: [[f64; N / 2]; 2] = end_weights();

/// An integral is halved at most this often; what remains at a cusp is then shorter than 1e-13 of the whole.
const MAX_HALVINGS: u32 = 44;
/// An integral consists of so many intervals at most.
const MOST_INTERVALS: usize = 2048;

const fn projections() -> [[f64; N / 2]; 6] {
    let mut out = [[0.0; N / 2]; 6];
    let mut j = 0;
    while j < N / 2 {
        let (x, w) = NODES[j];
        let mut row = 0;
        while row < ORDERS.len() {
            // k P_k = (2 k - 1) x P_(k-1) - (k - 1) P_(k-2).
            let (mut before, mut p) = (1.0, x);
            let mut k = 2;
            while k <= ORDERS[row] {
                let n = k as f64;
                let next = ((2.0 * n - 1.0) * x * p - (n - 1.0) * before) / n;
                before = p;
                p = next;
                k += 1;
            }
            out[row][j] = 0.5 * (2 * ORDERS[row] + 1) as f64 * w * p;
            row += 1;
        }
        j += 1;
    }
    out
}

const fn end_weights() -> [[f64; N / 2]; 2] {
    // sum over k of (2 k + 1) / 2 w_j P_k(x_j) P_k(-1); the rule is exact for the products of these polynomials.
    let mut out = [[0.0; N / 2]; 2];
    let mut j = 0;
    while j < N / 2 {
        let (x, w) = NODES[j];
        let (mut before, mut p) = (1.0, x);
        // P_k(-x) is P_k(x) with the sign of P_k(-1).
        let (mut below, mut above) = (1.0 + 3.0 * x, 1.0 - 3.0 * x);
        let mut k = 2;
        while k < N {
            let n = k as f64;
            let next = ((2.0 * n - 1.0) * x * p - (n - 1.0) * before) / n;
            before = p;
            p = next;
            let term = (2 * k + 1) as f64 * p;
            below += term;
            above += if k % 2 == 0 { term } else { -term };
            k += 1;
        }
        out[0][j] = 0.5 * w * below;
        out[1][j] = 0.5 * w * above;
        j += 1;
    }
    out
}

/// How far the polynomial through the values at the nodes misses the function's values at the two ends, at most.
///
/// A rational curve whose weights differ much is fast in a narrow stretch beside an end, where no node lies; the values at
/// the nodes are smooth then.
#[inline]
fn miss_at_ends(values: &[f64; N], (first, last): (f64, f64)) -> f64 {
    let (mut below, mut above) = (-first, -last);
    for j in 0..N / 2 {
        below += AT_END[0][j] * values[j] + AT_END[1][j] * values[j + N / 2];
        above += AT_END[1][j] * values[j] + AT_END[0][j] * values[j + N / 2];
    }
    // An integrable pole at an end has no value there: the rule does without.
    let miss = below.abs().max(above.abs());
    if miss.is_finite() { miss } else { 0.0 }
}

/// The nodes of the rule on `[a, b]`: below the middle, then above it, from the middle outwards.
#[inline]
fn nodes(a: f64, b: f64) -> [f64; N] {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    std::array::from_fn(|j| if j < N / 2 { middle - half * NODES[j].0 } else { middle + half * NODES[j - N / 2].0 })
}

/// Integral over an interval of length `width`, given the values at its nodes.
#[inline]
fn weighted_sum(values: &[f64; N], width: f64) -> f64 {
    let mut sum = 0.0;
    for (j, &(_, w)) in NODES.iter().enumerate() {
        sum += w * (values[j] + values[j + N / 2]);
    }
    0.5 * width * sum
}

/// Estimated error of [`weighted_sum`], from how fast the Legendre coefficients of the function fall.
///
/// From the orders N / 2 to N the coefficients fall by some factor. At the same pace they fall by its square from N to
/// 2 N, where the error of the rule begins; only its root is counted on, since a small sharp feature on a smooth
/// function slows the fall down. Where they do not fall (a kink, rounding) the last ones themselves count. What the
/// polynomial misses at the ends counts as much as the last coefficients.
#[inline]
fn error_estimate(values: &[f64; N], ends: (f64, f64), width: f64) -> f64 {
    let even: [f64; N / 2] = std::array::from_fn(|j| values[j + N / 2] + values[j]);
    let odd: [f64; N / 2] = std::array::from_fn(|j| values[j + N / 2] - values[j]);
    let coefficient = |row: usize| {
        let parts = if ORDERS[row].is_multiple_of(2) { &even } else { &odd };
        let mut sum = 0.0;
        for j in 0..N / 2 {
            sum += PROJECTIONS[row][j] * parts[j];
        }
        sum.abs()
    };
    // The largest of three: single coefficients vanish by symmetry or chance.
    let middle = coefficient(0).max(coefficient(1)).max(coefficient(2));
    let last = coefficient(3).max(coefficient(4)).max(coefficient(5)).max(END_SHARE * miss_at_ends(values, ends));
    let fall = if last < middle { last / middle } else { 1.0 };
    MARGIN * width * last * fall.sqrt()
}

/// Safety factor on the estimated error.
const MARGIN: f64 = 10.0;
/// The miss at an end is the sum of all coefficients that the rule does not see, the first of which is near the last that
/// it sees.
const END_SHARE: f64 = 0.1;

/// Integral of `f` over `[a, b]` by one 16-point Gauss-Legendre rule.
pub fn gauss_legendre(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    weighted_sum(&nodes(a, b).map(f), b - a)
}

/// Integral of a smooth `f` over `[a, b]` to the absolute `tolerance`, halving where the rule does not resolve `f`.
///
/// The interval with the largest error is halved first. `noise` is the error of a single value of `f`: errors it explains are
/// not chased. The number of halvings is bounded whatever the function.
///
/// ```
/// use arcfeed_geometry::adaptive_gauss_legendre;
///
/// let quarter = adaptive_gauss_legendre(&|x: f64| 1.0 / (1.0 + x * x), 0.0, 1.0, 1e-14, 0.0);
/// assert!((quarter - std::f64::consts::FRAC_PI_4).abs() < 1e-14);
/// ```
pub fn adaptive_gauss_legendre(f: &impl Fn(f64) -> f64, a: f64, b: f64, tolerance: f64, noise: f64) -> f64 {
    Integral { many: |t: &[f64; N]| t.map(f), one: f, noise }.over(a, b, tolerance)
}

/// A function to integrate: at all nodes of the rule at once, and at one place.
struct Integral<M, O> {
    many: M,
    one: O,
    /// Error of a single value.
    noise: f64,
}

/// An interval with the values at its ends, its integral and the estimated error of that.
struct Part {
    interval: (f64, f64),
    ends: (f64, f64),
    sum: f64,
    error: f64,
    /// How often it may still be halved.
    halvings: u32,
}

impl<M: Fn(&[f64; N]) -> [f64; N], O: Fn(f64) -> f64> Integral<M, O> {
    fn part(&self, interval: (f64, f64), ends: (f64, f64), halvings: u32) -> Part {
        let (a, b) = interval;
        let values = (self.many)(&nodes(a, b));
        // What cannot be halved any more has no error that could be mended.
        let error = if halvings == 0 { 0.0 } else { error_estimate(&values, ends, b - a).abs() };
        // Nor has one whose values are not finite.
        let error = if error.is_finite() { error } else { 0.0 };
        Part { interval, ends, sum: weighted_sum(&values, b - a), error, halvings }
    }

    /// The integral over `[a, b]`: the part with the largest error is halved until all errors together are small enough.
    fn over(&self, a: f64, b: f64, tolerance: f64) -> f64 {
        let whole = self.part((a, b), ((self.one)(a), (self.one)(b)), MAX_HALVINGS);
        let limit = tolerance.max(self.noise * (b - a).abs());
        if whole.error <= limit {
            return whole.sum;
        }
        let mut error = whole.error;
        let mut parts = BinaryHeap::from([whole]);
        loop {
            // The running sum of the errors loses digits while they fall: it is added up anew now and then, and before the end.
            let anew = error <= limit || parts.len() < 16 || parts.len().is_multiple_of(16);
            let mut limit = limit;
            if anew {
                error = parts.iter().map(|part| part.error).sum();
                let sum: f64 = parts.iter().map(|part| part.sum).sum();
                limit = limit.max(4.0 * f64::EPSILON * sum.abs());
            }
            let small = anew && error <= limit;
            let worst = match parts.peek() {
                Some(worst) if !small && worst.error > 0.0 && parts.len() < MOST_INTERVALS => parts.pop(),
                _ => None,
            };
            let Some(Part { interval: (a, b), ends, error: worst, halvings, .. }) = worst else {
                return parts.iter().map(|part| part.sum).sum();
            };
            let middle = 0.5 * (a + b);
            let at_middle = (self.one)(middle);
            for (interval, ends) in [((a, middle), (ends.0, at_middle)), ((middle, b), (at_middle, ends.1))] {
                let half = self.part(interval, ends, halvings - 1);
                error += half.error;
                parts.push(half);
            }
            error -= worst;
        }
    }
}

/// By the error.
impl Ord for Part {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.error.total_cmp(&other.error)
    }
}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Part {}

impl<const D: usize> NurbsCurve<D> {
    /// Length of the curve, in its unit, to the absolute `tolerance`.
    ///
    /// Adaptive 16-point Gauss-Legendre quadrature of `|C'|` on every Bezier piece. Tolerances below about 1e-15 of the
    /// length cannot be met in double precision; asking for less costs time and gains nothing. Where the weights of one
    /// piece differ by a factor of 10^k, k more digits are lost to rounding.
    ///
    /// # Errors
    /// Fails when the tolerance is not a finite number above 0.
    pub fn arc_length(&self, tolerance: f64) -> Result<f64, GeometryError> {
        let (a, b) = self.domain();
        self.arc_length_between(a, b, tolerance)
    }

    /// Length of the part between the parameters `u0` and `u1`, negative where `u1 < u0`; parameters outside the domain
    /// are taken to its ends.
    ///
    /// # Errors
    /// Fails when the tolerance is not a finite number above 0.
    pub fn arc_length_between(&self, u0: f64, u1: f64, tolerance: f64) -> Result<f64, GeometryError> {
        check_tolerance(tolerance)?;
        if u1 < u0 {
            return Ok(-self.arc_length_between(u1, u0, tolerance)?);
        }
        let pieces = self.pieces();
        let (first, last) = (pieces.find(u0), pieces.find(u1));
        let share = tolerance / (last - first + 1) as f64;
        // Kahan's sum: `lost` is what rounding took from `sum`.
        let (mut sum, mut lost) = (0.0, 0.0);
        for i in first..=last {
            let start = if i == first { pieces.local(i, u0) } else { -1.0 };
            let end = if i == last { pieces.local(i, u1) } else { 1.0 };
            if start < end {
                let speeds = |t: &[f64; N]| pieces.local_speeds::<D, N>(i, t);
                let speed = |t: f64| pieces.local_speed(i, t);
                let noise = pieces.speed_noise(i);
                let add = Integral { many: speeds, one: speed, noise }.over(start, end, share) - lost;
                let next = sum + add;
                lost = (next - sum) - add;
                sum = next;
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
    fn rule_is_exact_for_degree_31() {
        let integral = gauss_legendre(&|x: f64| x.powi(30) + x.powi(31), 0.0, 2.0);
        let exact = 2f64.powi(31) / 31.0 + 2f64.powi(32) / 32.0;
        assert!((integral / exact - 1.0).abs() < 1e-14, "{integral} against {exact}");
    }

    #[test]
    fn the_end_weights_are_those_of_the_polynomial_through_the_nodes() {
        let f = |x: f64| 1.0 + x - 2.0 * x.powi(4) + 3.0 * x.powi(15);
        let miss = |ends| miss_at_ends(&nodes(-1.0, 1.0).map(f), ends);
        assert!(miss((f(-1.0), f(1.0))) < 1e-13);
        assert!((miss((f(-1.0) + 0.25, f(1.0))) - 0.25).abs() < 1e-13);
        assert!((miss((f(-1.0), f(1.0) - 0.5)) - 0.5).abs() < 1e-13);
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
