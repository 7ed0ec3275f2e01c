//! Sine, cosine, arc tangent and rounding that the compiler can inline and vectorise.
//!
//! Half of the time of a forward or inverse call would go into the C library's functions, which are calls per value and
//! spill every register. These agree with them to 2 units in the last place (tested), and are the same on all platforms.

// Coefficients are kept with the digits of their source.
#![allow(clippy::excessive_precision)]

#[cfg(not(feature = "std"))]
use num_traits::Float;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Angles up to here are reduced here, rad; for larger ones the library reduces.
const REDUCIBLE: f64 = 1e5;
/// pi/2 in three parts, the first two with enough zero bits that their multiples up to `REDUCIBLE` are exact
/// (Cody and Waite; parts as in fdlibm's `e_rem_pio2.c`).
const PIO2_1: f64 = 1.570_796_326_734_125_614_17;
const PIO2_2: f64 = 6.077_100_506_303_965_976_60e-11;
const PIO2_3: f64 = 2.022_266_248_795_950_631_54e-21;
/// Adding and subtracting this rounds to the nearest integer.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Sines and cosines of `N` angles (rad).
#[inline]
pub(crate) fn sin_cos<const N: usize>(angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    let mut sines = [0.0; N];
    let mut cosines = [0.0; N];
    let mut small = true;
    for i in 0..N {
        let x = angles[i];
        small &= x.abs() < REDUCIBLE;
        let shifted = x * FRAC_2_PI + ROUNDER;
        let quarters = shifted - ROUNDER;
        let quadrant = shifted.to_bits();
        let r = ((x - quarters * PIO2_1) - quarters * PIO2_2) - quarters * PIO2_3;
        let (sin, cos) = (sin_kernel(r).to_bits(), cos_kernel(r).to_bits());
        // Odd quadrants swap the two, the upper bit of the quadrant (plus one, for the cosine) is the sign.
        let swap = (quadrant & 1).wrapping_neg();
        let (s, c) = ((sin & !swap) | (cos & swap), (cos & !swap) | (sin & swap));
        sines[i] = f64::from_bits(s ^ ((quadrant & 2) << 62));
        cosines[i] = f64::from_bits(c ^ ((quadrant.wrapping_add(1) & 2) << 62));
    }
    if !small {
        for i in 0..N {
            (sines[i], cosines[i]) = angles[i].sin_cos();
        }
    }
    (sines, cosines)
}

/// Sine on [-pi/4, pi/4]: fdlibm `k_sin.c`.
#[inline]
fn sin_kernel(x: f64) -> f64 {
    let z = x * x;
    let r = 8.333_333_333_322_489_461_24e-3
        + z * (-1.984_126_982_985_794_931_34e-4
            + z * (2.755_731_370_707_006_767_89e-6
                + z * (-2.505_076_025_340_686_341_95e-8 + z * 1.589_690_995_211_550_102_21e-10)));
    x + z * x * (-1.666_666_666_666_663_243_48e-1 + z * r)
}

/// Cosine on [-pi/4, pi/4]: fdlibm `k_cos.c`.
#[inline]
fn cos_kernel(x: f64) -> f64 {
    let z = x * x;
    let r = z
        * (4.166_666_666_666_660_190_37e-2
            + z * (-1.388_888_888_887_410_957_49e-3
                + z * (2.480_158_728_947_672_941_78e-5
                    + z * (-2.755_731_435_139_066_330_35e-7
                        + z * (2.087_572_321_298_174_827_90e-9 - z * 1.135_964_755_778_819_482_65e-11)))));
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + ((1.0 - w) - half + z * r)
}

/// Angle of the direction (`x`, `y`), rad in [-pi, pi]. 0 for (0, 0); NaN if one is not finite.
#[inline]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let (high, low) = if ax >= ay { (ax, ay) } else { (ay, ax) };
    if high == 0.0 {
        return 0.0;
    }
    // Above tan(pi/8) or so, turned back by pi/4.
    let (numerator, denominator, start) =
        if low > 0.5 * high { (low - high, low + high, FRAC_PI_4) } else { (low, high, 0.0) };
    let acute = start + atan_kernel(numerator / denominator);
    let first = if ax >= ay { acute } else { FRAC_PI_2 - acute };
    let upper = if x < 0.0 { PI - first } else { first };
    upper.copysign(y)
}

/// Arc tangent on [-0.66, 0.66]: Cephes `atan.c`.
#[inline]
fn atan_kernel(x: f64) -> f64 {
    let z = x * x;
    let p = -6.485_021_904_942_025_371_773e1
        + z * (-1.228_866_684_490_136_173_410e2
            + z * (-7.500_855_792_314_704_667_340e1
                + z * (-1.615_753_718_733_365_076_637e1 - z * 8.750_608_600_031_904_122_785e-1)));
    let q = 1.945_506_571_482_613_964_425e2
        + z * (4.853_903_996_359_136_964_868e2
            + z * (4.328_810_604_912_902_668_951e2
                + z * (1.650_270_098_316_988_542_046e2 + z * (2.485_846_490_142_306_297_962e1 + z))));
    x + x * z * (p / q)
}

/// The nearest integer; of halves, the even one.
#[inline]
pub(crate) fn round(x: f64) -> f64 {
    if x.abs() < 2_251_799_813_685_248.0 { (x + ROUNDER) - ROUNDER } else { x }
}

/// The greatest integer not above `x`.
#[inline]
pub(crate) fn floor(x: f64) -> f64 {
    let nearest = round(x);
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// The same angle in (-pi, pi].
#[inline]
pub(crate) fn principal(angle: f64) -> f64 {
    let wrapped = angle - TAU * round(angle / TAU);
    // For large angles the product rounds, and the rest can be a little outside.
    if wrapped > PI {
        wrapped - TAU
    } else if wrapped <= -PI {
        wrapped + TAU
    } else {
        wrapped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Angles of every size and sign, with the multiples of pi/4 and their neighbours.
    fn angles() -> impl Iterator<Item = f64> {
        let steps = (-4000..4000).map(|i| f64::from(i) * 0.007_123);
        let eighths = (-200..200).flat_map(|i| {
            let x = f64::from(i) * FRAC_PI_4;
            [x, f64::from_bits(x.to_bits() ^ 1), x + 1e-9, x * 317.0]
        });
        steps.chain(eighths).chain([0.0, -0.0, 1e-300, 1e-17, 1e-9, 99_999.9, -1e5, 1e9, 1e22])
    }

    #[test]
    fn sines_and_cosines_are_the_librarys() {
        for x in angles() {
            let ([s], [c]) = sin_cos(&[x]);
            assert!((s - x.sin()).abs() <= 2.3e-16 && (c - x.cos()).abs() <= 2.3e-16, "{x}: {s} {c}");
            assert!((s - x.sin()).abs() <= 1e-15 * x.sin().abs() || x.sin().abs() < 1e-6, "{x}: {s} {}", x.sin());
        }
        let ([s], [c]) = sin_cos(&[f64::NAN]);
        assert!(s.is_nan() && c.is_nan());
    }

    #[test]
    fn arc_tangents_are_the_librarys() {
        for x in angles() {
            for radius in [1.0, 1e-200, 1e200] {
                let (s, c) = x.sin_cos();
                let (y, x) = (radius * s, radius * c);
                let expected = y.atan2(x);
                assert!((atan2(y, x) - expected).abs() <= 4.5e-16 * expected.abs(), "{y} {x}: {}", atan2(y, x));
            }
        }
        for (y, x) in [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (-1.0, -1.0), (-0.0, -1.0)] {
            assert_eq!(atan2(y, x), f64::atan2(y, x), "{y} {x}");
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }

    #[test]
    fn roundings_are_the_librarys() {
        for x in angles().chain([2.5, 3.5, -0.5, 1e15, 1e300]) {
            assert_eq!(round(x), x.round_ties_even(), "{x}");
            assert_eq!(floor(x), x.floor(), "{x}");
            let p = principal(x);
            assert!(-PI < p && p <= PI, "{x}: {p}");
        }
    }
}
