//! The methods of others that Liu et al. 2023 and 2024 compare with, as far as they cut the curve.
//! None looks at the chord error.
//!
//! The papers name the methods and do not print them. Each reading follows what the papers say and
//! what is generally known of the work they cite.

use crate::reproduce::spline::Spline;

/// Places of a scan for extremes.
const SCAN: u32 = 4000;
/// Halvings of one knot span by the rule for its length.
const DEEPEST: u32 = 20;

/// Parameters of a scan, and the size of the curvature at each.
fn scan(curve: &Spline) -> (Vec<f64>, Vec<f64>) {
    let (from, to) = curve.domain();
    let at: Vec<f64> = (0..SCAN).map(|i| from + (to - from) * (f64::from(i) + 0.5) / f64::from(SCAN)).collect();
    let bend = at.iter().map(|&u| curve.curvature(u).abs()).collect();
    (at, bend)
}

/// The ends of the curve, and between them the places of a scan that `take` picks by the curvature
/// before, at and behind it.
fn split(curve: &Spline, take: impl Fn(f64, f64, f64) -> bool) -> Vec<f64> {
    let (from, to) = curve.domain();
    let (at, bend) = scan(curve);
    let inner = (1..at.len() - 1).filter(|&i| take(bend[i - 1], bend[i], bend[i + 1]));
    std::iter::once(from).chain(inner.map(|i| at[i])).chain(std::iter::once(to)).collect()
}

fn is_maximum(before: f64, here: f64, behind: f64) -> bool {
    here > before && here >= behind
}

/// M.L. (2024, reference 16), curvature-adaptive interpolation: split at the critical points of
/// high curvature, its local maxima.
pub fn curvature_maxima(curve: &Spline) -> Vec<f64> {
    split(curve, is_maximum)
}

/// X.D. (2023, reference 14; 2024, reference 34), the complete S-shaped scheduling: split where the
/// radius of curvature is extremal, at its maxima as at its minima.
pub fn radius_extremes(curve: &Spline) -> Vec<f64> {
    split(curve, |before, here, behind| is_maximum(before, here, behind) || (here < before && here <= behind))
}

/// L.F. (2023, reference 32), the interpolator with S-shaped scheduling: split at the local maxima
/// of curvature that are sharper than `curvature` (1/m), where the feed has to be lowered.
pub fn feed_sensitive_maxima(curve: &Spline, curvature: f64) -> Vec<f64> {
    split(curve, |before, here, behind| here > curvature && is_maximum(before, here, behind))
}

/// W.L. (2024, reference 35), arc length by the composite rule of Simpson: each knot span is halved
/// until the rule over both halves gives its length within `tolerance` (m).
pub fn simpson_intervals(curve: &Spline, tolerance: f64) -> Vec<f64> {
    fn halve(curve: &Spline, (a, b): (f64, f64), tolerance: f64, depth: u32, breaks: &mut Vec<f64>) {
        let (whole, halves) = (curve.length(a, b, 2), curve.length(a, b, 4));
        // The error of the finer rule is a fifteenth of the difference.
        if depth == 0 || (halves - whole).abs() <= 15.0 * tolerance {
            breaks.push(b);
            return;
        }
        let middle = 0.5 * (a + b);
        halve(curve, (a, middle), 0.5 * tolerance, depth - 1, breaks);
        halve(curve, (middle, b), 0.5 * tolerance, depth - 1, breaks);
    }
    let mut breaks = vec![curve.domain().0];
    for span in curve.breaks().windows(2) {
        halve(curve, (span[0], span[1]), tolerance, DEEPEST, &mut breaks);
    }
    breaks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::sample_paths::SamplePath;
    use crate::reproduce::pn::curves::curve_of;

    #[test]
    fn each_method_cuts_where_it_says() {
        let curve = Spline::new(&curve_of(SamplePath::Butterfly).expect("an embedded curve"));
        let (all, both) = (curvature_maxima(&curve), radius_extremes(&curve));
        let sharp = feed_sensitive_maxima(&curve, 100.0);
        assert!(sharp.len() < all.len() && all.len() < both.len(), "{} {} {}", sharp.len(), all.len(), both.len());
        assert!(all.iter().all(|u| both.contains(u)) && sharp.iter().all(|u| all.contains(u)));
        assert!(sharp[1..sharp.len() - 1].iter().all(|&u| curve.curvature(u).abs() > 100.0));
        // Between two maxima there is a minimum.
        let inner = &both[1..both.len() - 1];
        assert!(inner.windows(2).all(|w| all.contains(&w[0]) != all.contains(&w[1])));
    }

    #[test]
    fn the_rule_of_simpson_holds_its_tolerance_on_every_span() {
        let curve = Spline::new(&curve_of(SamplePath::SevenPoint).expect("an embedded curve"));
        let exact = |a: f64, b: f64| curve.length(a, b, 2000);
        for tolerance in [1e-4, 1e-6] {
            let breaks = simpson_intervals(&curve, tolerance);
            for span in curve.breaks().windows(2) {
                let inside: Vec<f64> = breaks.iter().copied().filter(|u| (span[0]..=span[1]).contains(u)).collect();
                let sum: f64 = inside.windows(2).map(|w| curve.length(w[0], w[1], 4)).sum();
                assert!((sum - exact(span[0], span[1])).abs() < 2.0 * tolerance);
            }
        }
    }
}
