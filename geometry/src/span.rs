//! One knot span as a polynomial: its Bezier points, and its powers about a middle.

use crate::bezier::{Homogeneous, lerp, restrict, to_centred_powers};

/// Bezier control points of the span `[t[k], t[k + 1]]`: `b_j = f(a, ..., a, b, ..., b)` with `j` times `b`, each by de
/// Boor's algorithm with its own argument in every round.
pub(crate) fn bezier_points(t: &[f64], points: &[Homogeneous], p: usize, k: usize) -> Vec<Homogeneous> {
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
                    d[i] = lerp(&d[i - 1], &d[i], alpha);
                }
            }
            d[p]
        })
        .collect()
}

/// Spans narrower than this part of the knots that act on them lose too many digits by way of their Bezier points.
const NARROW: f64 = 0.02;

/// Coefficients, constant term first, of the part of the span `[t[k], t[k + 1]]` between its local parameters `from` and
/// `to` (0 to 1), in powers of the local parameter of the part (-1 to 1); appended to `out`.
///
/// A span about as wide as its neighbours goes by way of its Bezier points, which lie near the curve, so that rounding
/// them moves the curve by as little. In a narrow one the differences of these points are lost in their rounding, and the
/// coefficients come from the derivatives.
pub(crate) fn part_powers(
    t: &[f64],
    points: &[Homogeneous],
    (p, k): (usize, usize),
    (from, to): (f64, f64),
    out: &mut Vec<Homogeneous>,
) {
    let width = t[k + 1] - t[k];
    if width < NARROW * (t[k + p] - t[k + 1 - p]) {
        let middle = 0.5 * (from + to);
        return derivative_powers(t, points, (p, k), (middle * width, 0.5 * (to - from) * width), out);
    }
    let mut part = bezier_points(t, points, p, k);
    restrict(&mut part, from, to);
    to_centred_powers(&part, out);
}

/// Coefficients of the span `[t[k], t[k + 1]]` in powers of `(u - t[k] - middle) / half`.
///
/// The coefficient of order `r` is `half^r / r!` times the derivative of that order: that of the spline on the
/// differences of the control points ("The NURBS Book", eq. 3.8), by de Boor's algorithm. Each difference is divided by
/// the width of as many knots as its order leaves, so that a span far narrower than its neighbours costs no digits.
fn derivative_powers(
    t: &[f64],
    points: &[Homogeneous],
    (p, k): (usize, usize),
    (middle, half): (f64, f64),
    out: &mut Vec<Homogeneous>,
) {
    let mut difference = points[k - p..=k].to_vec();
    let mut d = difference.clone();
    for order in 0..=p {
        let q = p - order;
        if order > 0 {
            for i in 0..=q {
                let width = t[k + 1 + i] - t[k - q + i];
                let factor = (q + 1) as f64 / order as f64 * (half / width);
                let (a, b) = (difference[i], difference[i + 1]);
                difference[i] = std::array::from_fn(|l| factor * (b[l] - a[l]));
            }
        }
        d[..=q].copy_from_slice(&difference[..=q]);
        for r in 1..=q {
            for i in (r..=q).rev() {
                let left = t[k - q + i];
                let alpha = ((t[k] - left) + middle) / (t[k + 1 + i - r] - left);
                d[i] = lerp(&d[i - 1], &d[i], alpha);
            }
        }
        out.push(d[q]);
    }
}
