//! Linear programs in two variables, exactly: the least or greatest `x` for which some `u` keeps
//! all bands.
//!
//! A band `lo + p x <= u <= hi + p x` is a row divided by its factor of `u`. Over `x`, the least
//! upper bound `U(x)` on `u` is concave and the greatest lower bound `L(x)` convex, so `U - L` is
//! concave and piecewise linear, and Newton's method from outside reaches its root in finitely many
//! steps, in practice two to four of one pass over the bands each.

/// `lo + p x <= u <= hi + p x`; either bound may be infinite. `id` tells the caller which row it
/// is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    pub p: f64,
    pub lo: f64,
    pub hi: f64,
    pub id: usize,
}

/// The two bands that are tightest at one `x`, and the gap between them (negative: none).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gap {
    pub width: f64,
    /// Slope of the gap by `x`.
    pub slope: f64,
    /// The value at which the two bands meet: Newton's next iterate, without the cancellation of a
    /// difference.
    pub meet: f64,
    /// Magnitude of the terms of which the gap is the difference, for judging round-off.
    pub scale: f64,
    /// Band of the upper bound.
    pub upper: usize,
    /// Band of the lower bound.
    pub lower: usize,
}

pub(crate) fn gap(bands: &[Band], x: f64) -> Gap {
    let (mut hi, mut lo) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut upper, mut lower) = (0, 0);
    for (i, band) in bands.iter().enumerate() {
        let shift = band.p * x;
        if band.hi + shift < hi {
            hi = band.hi + shift;
            upper = i;
        }
        if band.lo + shift > lo {
            lo = band.lo + shift;
            lower = i;
        }
    }
    let slope = bands.get(upper).map_or(0.0, |b| b.p) - bands.get(lower).map_or(0.0, |b| b.p);
    let meet = match (bands.get(upper), bands.get(lower)) {
        (Some(u), Some(l)) => (u.hi - l.lo) / (l.p - u.p),
        _ => f64::NAN,
    };
    let of = |b: &Band, bound: f64| (b.p * x).abs().max(bound.abs());
    let scale = match (bands.get(upper), bands.get(lower)) {
        (Some(u), Some(l)) if hi.is_finite() && lo.is_finite() => of(u, u.hi).max(of(l, l.lo)),
        _ => 0.0,
    };
    Gap { width: hi - lo, slope, meet, scale, upper, lower }
}

/// Why there is no solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum NoOptimum {
    /// The bands at this `x` exclude each other, and there is no `x` at which they exclude each
    /// other less.
    Infeasible(f64),
    /// `x` has no bound in the direction asked for.
    Unbounded,
}

/// Gap that counts as none: differences of this size are round-off.
const TOLERANCE: f64 = 1e-13;

/// The point with the greatest `x`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Greatest {
    pub x: f64,
    /// The upper and the lower band that meet there; `None` where `most` was taken, or `least` by
    /// round-off.
    pub meeting: Option<[usize; 2]>,
}

/// The greatest `x` in `[least, most]` at which the bands leave some `u`; `most` may be infinite.
pub(crate) fn greatest_x(bands: &[Band], least: f64, most: f64) -> Result<Greatest, NoOptimum> {
    let mut x = if most < f64::INFINITY { most } else { outermost(bands)? };
    let mut meeting = None;
    if !(least <= x) {
        return Err(NoOptimum::Infeasible(least));
    }
    // Each step changes the active pair, so the bound is never met; it is there for round-off.
    for _ in 0..4 * bands.len() + 8 {
        let now = gap(bands, x);
        if now.width >= -TOLERANCE * now.scale {
            break;
        }
        let next = now.meet;
        if !(now.slope < 0.0) || !(next >= least) {
            // Left of here the gap only shrinks, or it opens too late.
            let worst = if now.slope < 0.0 { least } else { x };
            let last = gap(bands, worst);
            let opens = last.width >= -TOLERANCE * last.scale;
            return if opens { Ok(Greatest { x: worst, meeting: None }) } else { Err(NoOptimum::Infeasible(worst)) };
        }
        if next >= x {
            break;
        }
        (x, meeting) = (next, Some([now.upper, now.lower]));
    }
    Ok(Greatest { x, meeting })
}

/// The value at which the flattest upper bound and the steepest lower bound meet: no feasible `x`
/// is beyond.
fn outermost(bands: &[Band]) -> Result<f64, NoOptimum> {
    let by_slope = |a: &&Band, b: &&Band| a.p.total_cmp(&b.p);
    let upper = bands.iter().filter(|b| b.hi < f64::INFINITY).min_by(by_slope).ok_or(NoOptimum::Unbounded)?;
    let lower = bands.iter().filter(|b| b.lo > f64::NEG_INFINITY).max_by(by_slope).ok_or(NoOptimum::Unbounded)?;
    if upper.p < lower.p { Ok((upper.hi - lower.lo) / (lower.p - upper.p)) } else { Err(NoOptimum::Unbounded) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertex enumeration: the optimum of a program lies where two bounds meet.
    fn brute(bands: &[Band], most: f64) -> Option<f64> {
        let lines: Vec<(f64, f64)> =
            bands.iter().flat_map(|b| [(b.p, b.lo), (b.p, b.hi)]).filter(|l| l.1.is_finite()).collect();
        let mut candidates = vec![0.0, most];
        for (i, a) in lines.iter().enumerate() {
            for b in &lines[..i] {
                candidates.push((b.1 - a.1) / (a.0 - b.0));
            }
        }
        let feasible = |x: f64| {
            let hi = bands.iter().map(|b| b.hi + b.p * x).fold(f64::INFINITY, f64::min);
            let lo = bands.iter().map(|b| b.lo + b.p * x).fold(f64::NEG_INFINITY, f64::max);
            (0.0..=most).contains(&x) && hi - lo >= -1e-9 * (1.0 + hi.abs() + lo.abs())
        };
        candidates.into_iter().filter(|x| feasible(*x)).max_by(f64::total_cmp)
    }

    #[test]
    fn agrees_with_vertex_enumeration() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
        };
        let mut infeasible = 0;
        for case in 0..20_000 {
            let bands: Vec<Band> = (0..2 + case % 9)
                .map(|id| {
                    let (p, middle, half) = (3.0 * random(), random(), 0.7 * random().abs());
                    Band { p, lo: middle - half, hi: middle + half, id }
                })
                .collect();
            match (greatest_x(&bands, 0.0, 2.0), brute(&bands, 2.0)) {
                (Ok(Greatest { x, .. }), Some(y)) => {
                    assert!((x - y).abs() < 1e-6, "case {case}: {x} instead of {y} for {bands:?}")
                }
                (Err(_), None) => infeasible += 1,
                // Decided by round-off only.
                (got, expected) => {
                    let best = (0..=4000).map(|i| gap(&bands, f64::from(i) / 2000.0).width).fold(f64::MIN, f64::max);
                    assert!(best.abs() < 1e-3, "case {case}: {got:?} instead of {expected:?} for {bands:?}");
                }
            }
        }
        assert!((1000..19_000).contains(&infeasible));
    }

    #[test]
    fn without_a_highest_value_the_flattest_and_the_steepest_band_bound_it() {
        let mut random = arcfeed_testing::Random::new(11);
        for case in 0..5000 {
            // Slopes that differ by less than 1 meet far away.
            let bands: Vec<Band> = (0..2 + case % 4)
                .map(|id| {
                    let (p, middle, half) = (0.3 * random.signed(), 0.2 * random.signed(), 0.5 + 0.2 * random.signed());
                    Band { p, lo: middle - half, hi: middle + half, id }
                })
                .collect();
            let expected = brute(&bands, 1e9).unwrap();
            let got = greatest_x(&bands, 0.0, f64::INFINITY).unwrap().x;
            assert!((got - expected).abs() < 1e-6 * (1.0 + expected), "{got} instead of {expected} for {bands:?}");
        }
    }
}
