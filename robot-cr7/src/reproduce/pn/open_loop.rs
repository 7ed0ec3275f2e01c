//! Open-loop segmentation: split at extremes of curvature, without a look at the chord error.

use crate::reproduce::spline::Spline;

/// Places of a scan for extremes.
const SCAN: u32 = 4000;

/// Ends of the curve and places where the curvature is a local maximum (the reading taken of X.D.
/// and L.F. in Liu et al. 2023, and of M.L., X.D. and W.L. in Liu et al. 2024: critical points by a
/// scan of the curvature).
pub fn curvature_split(curve: &Spline) -> Vec<f64> {
    let (from, to) = curve.domain();
    let at = |i: u32| from + (to - from) * (f64::from(i) + 0.5) / f64::from(SCAN);
    let bend: Vec<f64> = (0..SCAN).map(|i| curve.curvature(at(i)).abs()).collect();
    let mut breaks = vec![from];
    breaks.extend(
        (1..SCAN - 1)
            .filter(|&i| {
                let i = i as usize;
                bend[i] > bend[i - 1] && bend[i] >= bend[i + 1]
            })
            .map(at),
    );
    breaks.push(to);
    breaks
}
