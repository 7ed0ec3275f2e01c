//! B-spline basis functions by the Cox-de Boor recursion.

use crate::knots::KnotVector;

/// The degree + 1 basis functions that do not vanish at `u`, and the index of the first of them.
///
/// Cox-de Boor recursion (Liu et al. 2023, eq. 2, with half-open spans), in the stable triangular form of Piegl and
/// Tiller, "The NURBS Book", algorithm A2.2. `out` is resized to degree + 1; its entries are non-negative and sum to 1.
pub fn basis_functions(knots: &KnotVector, u: f64, out: &mut Vec<f64>) -> usize {
    let p = knots.degree();
    let k = knots.span(u);
    let t = knots.as_slice();
    let (start, end) = knots.domain();
    let u = u.max(start).min(end);
    out.clear();
    out.resize(p + 1, 0.0);
    out[0] = 1.0;
    for j in 1..=p {
        let mut saved = 0.0;
        for r in 0..j {
            let right = t[k + r + 1] - u;
            let left = u - t[k + 1 + r - j];
            let share = out[r] / (right + left);
            out[r] = saved + right * share;
            saved = left * share;
        }
        out[j] = saved;
    }
    k - p
}
