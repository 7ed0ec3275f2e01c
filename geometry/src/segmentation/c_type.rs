//! Segmentation into C-type pieces: Liu et al. 2023, algorithm 1.

use super::cutter::Cutter;
use crate::bezier::Homogeneous;
use crate::error::GeometryError;

/// Splits every Bezier piece where its curvature vanishes, then halves until the extreme deviation is within the
/// tolerance.
pub(super) fn cut<const D: usize>(cutter: &mut Cutter<'_, D>) -> Result<(), GeometryError> {
    let mut roots = Vec::new();
    for index in 0..cutter.beziers.len() {
        let (m, n) = cutter.beziers[index].interval();
        inflections(cutter.beziers[index].homogeneous(), &mut roots);
        let mut start = m;
        for &t in &roots {
            let u = m + t * (n - m);
            if start < u && u < n {
                cutter.halve(index, start, u, false)?;
                start = u;
            }
        }
        cutter.halve(index, start, n, false)?;
    }
    Ok(())
}

/// Local parameters in (0, 1) where the curvature of a rational Bezier piece changes its sign, increasing.
///
/// With the homogeneous curve `H = (w x, w y, w)` the numerator of the curvature, `C' x C''` (Liu et al. 2023, eq. 10), is
/// `det(H, H', H'') / w^3`, and by de Casteljau's scheme this determinant is, up to a factor, `det(b0, b1, b2)` with
/// the three points of the last level but two: a polynomial of degree 3 (p - 2), whose roots are isolated in
/// Bernstein form.
///
/// In space the curvature of a twisted curve does not vanish; there the inflections of the curve's shadow along its
/// main binormal are taken. For a plane curve lying in space these are the same points.
fn inflections(h: &[Homogeneous], roots: &mut Vec<f64>) {
    roots.clear();
    let p = h.len() - 1;
    if p < 3 {
        return;
    }
    // Coordinates relative to the first point, in two axes of the plane in which the piece mainly bends.
    let o = crate::chord::cartesian(&h[0]);
    let rel: Vec<[f64; 4]> =
        h.iter().map(|h| [h[0] - h[3] * o[0], h[1] - h[3] * o[1], h[2] - h[3] * o[2], h[3]]).collect();
    let (e1, e2) = main_plane(&rel);
    let along = |e: &[f64; 3]| -> Vec<f64> { rel.iter().map(|h| h[0] * e[0] + h[1] * e[1] + h[2] * e[2]).collect() };
    let lanes = [along(&e1), along(&e2), rel.iter().map(|h| h[3]).collect::<Vec<f64>>()];
    let level = |lane: usize, j: usize| &lanes[lane][j..j + p - 1];
    let mut det = vec![0.0; 3 * (p - 2) + 1];
    let mut scale = 0.0f64;
    for (a, b, c, sign) in
        [(0, 1, 2, 1.0), (1, 2, 0, 1.0), (2, 0, 1, 1.0), (2, 1, 0, -1.0), (1, 0, 2, -1.0), (0, 2, 1, -1.0)]
    {
        let product = multiply(&multiply(level(a, 0), level(b, 1)), level(c, 2));
        for (d, x) in det.iter_mut().zip(&product) {
            *d += sign * x;
            scale = scale.max(x.abs());
        }
    }
    // Below this a coefficient is rounding: a straight piece has no inflections, not many.
    let noise = 16.0 * f64::EPSILON * scale;
    det.iter_mut().filter(|d| d.abs() <= noise).for_each(|d| *d = 0.0);
    bernstein_roots(&det, 0.0, 1.0, 0, roots);
}

/// Two orthonormal axes of the plane in which control points mainly bend: x and y for a curve in the plane.
fn main_plane(rel: &[Homogeneous]) -> ([f64; 3], [f64; 3]) {
    let cross = |a: &[f64; 3], b: &[f64; 3]| -> [f64; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let norm2 = |a: &[f64; 3]| a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    let points: Vec<[f64; 3]> = rel.iter().map(crate::chord::cartesian).collect();
    let edge = |i: usize| -> [f64; 3] { std::array::from_fn(|l| points[i + 1][l] - points[i][l]) };
    let mut normal = [0.0, 0.0, 0.0];
    for i in 0..points.len() - 2 {
        let n = cross(&edge(i), &edge(i + 1));
        if norm2(&n) > norm2(&normal) {
            normal = n;
        }
    }
    if rel.iter().all(|h| h[2] == 0.0) || norm2(&normal) == 0.0 {
        return ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    }
    let length = norm2(&normal).sqrt();
    let n = normal.map(|x| x / length);
    // Any axis normal to n: start from the coordinate axis that is least along it.
    let least = (0..3).fold(0, |m, l| if n[l].abs() < n[m].abs() { l } else { m });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let e1 = cross(&n, &axis);
    let length = norm2(&e1).sqrt();
    let e1 = e1.map(|x| x / length);
    (e1, cross(&n, &e1))
}

/// Product of two polynomials in Bernstein form.
fn multiply(f: &[f64], g: &[f64]) -> Vec<f64> {
    let (m, n) = (f.len() - 1, g.len() - 1);
    let (bm, bn, bmn) = (binomials(m), binomials(n), binomials(m + n));
    let mut out = vec![0.0; m + n + 1];
    for i in 0..=m {
        for j in 0..=n {
            out[i + j] += bm[i] * bn[j] / bmn[i + j] * f[i] * g[j];
        }
    }
    out
}

/// Binomial coefficients of order `n`.
fn binomials(n: usize) -> Vec<f64> {
    let mut row = vec![1.0; n + 1];
    for i in 1..=n {
        row[i] = row[i - 1] * (n + 1 - i) as f64 / i as f64;
    }
    row
}

/// Appends the roots in (0, 1) of a polynomial in Bernstein form, mapped to `[a, b]`, increasing.
///
/// By Descartes' rule coefficients without a change of sign have no root and those with one have exactly one; more are
/// split in the middle.
fn bernstein_roots(c: &[f64], a: f64, b: f64, depth: u32, roots: &mut Vec<f64>) {
    const DEEPEST: u32 = 40;
    let changes = sign_changes(c);
    if changes == 0 {
        return;
    }
    let middle = 0.5 * (a + b);
    if changes == 1 || depth == DEEPEST {
        let t = if depth == DEEPEST { middle } else { a + bisect(c) * (b - a) };
        roots.push(t);
        return;
    }
    let mut left = c.to_vec();
    let mut right = c.to_vec();
    let n = c.len();
    for r in 1..n {
        for i in (r..n).rev() {
            left[i] = 0.5 * (left[i - 1] + left[i]);
        }
        right[n - 1 - r] = left[n - 1];
    }
    bernstein_roots(&left, a, middle, depth + 1, roots);
    if right[0] == 0.0 {
        roots.push(middle);
    }
    bernstein_roots(&right, middle, b, depth + 1, roots);
}

fn sign_changes(c: &[f64]) -> usize {
    let mut last = 0.0f64;
    let mut changes = 0;
    for &x in c.iter().filter(|x| **x != 0.0) {
        if last * x.signum() < 0.0 {
            changes += 1;
        }
        last = x.signum();
    }
    changes
}

/// The one root in (0, 1) of a polynomial in Bernstein form with one change of sign.
fn bisect(c: &[f64]) -> f64 {
    let mut work = c.to_vec();
    let mut value = |t: f64| {
        work.copy_from_slice(c);
        for r in (1..work.len()).rev() {
            for i in 0..r {
                work[i] = (1.0 - t) * work[i] + t * work[i + 1];
            }
        }
        work[0]
    };
    let rising = c.iter().find(|x| **x != 0.0).is_some_and(|&x| x < 0.0);
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..54 {
        let t = 0.5 * (lo + hi);
        if (value(t) < 0.0) == rising { lo = t } else { hi = t }
    }
    0.5 * (lo + hi)
}
