//! Decomposition of a NURBS curve into rational Bezier pieces.

use crate::bezier::{Homogeneous, RationalBezier};
use crate::nurbs::NurbsCurve;

impl<const D: usize> NurbsCurve<D> {
    /// The rational Bezier pieces of the curve, one per non-empty knot span, in order.
    ///
    /// Each piece knows its interval `[m, n]` of the curve's parameter. The control points come from the polar form
    /// (blossom) of the span, which equals inserting every knot to full multiplicity (Boehm; Liu et al. 2023,
    /// eqs. 4-7) and works for clamped and unclamped vectors alike. The curve does not move.
    pub fn decompose(&self) -> Vec<RationalBezier<D>> {
        self.knots()
            .spans()
            .map(|k| {
                let t = self.knots().as_slice();
                let interval = (t[k], t[k + 1]);
                RationalBezier::from_homogeneous(interval, span_control_points(t, self.homogeneous(), self.degree(), k))
            })
            .collect()
    }
}

/// Bezier control points of the span `[t[k], t[k + 1]]`: `b_j = f(a, ..., a, b, ..., b)` with `j` times `b`, each by de
/// Boor's algorithm with its own argument in every round.
pub(crate) fn span_control_points(t: &[f64], points: &[Homogeneous], p: usize, k: usize) -> Vec<Homogeneous> {
    let (a, b) = (t[k], t[k + 1]);
    let mut d = vec![[0.0; 4]; p + 1];
    (0..=p)
        .map(|j| {
            d.copy_from_slice(&points[k - p..=k]);
            for r in 1..=p {
                let u = if r <= j { b } else { a };
                for i in (r..=p).rev() {
                    let left = t[k - p + i];
                    let right = t[k + 1 + i - r];
                    let alpha = (u - left) / (right - left);
                    d[i] = crate::bezier::lerp(&d[i - 1], &d[i], alpha);
                }
            }
            d[p]
        })
        .collect()
}
