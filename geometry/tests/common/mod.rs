//! What several tests share: fixtures, and a measurement of deviations that knows nothing of the library's own.
#![allow(dead_code)]

pub mod random;

use arcfeed_geometry::{Curve, NurbsCurve, nalgebra::SVector};
use serde::Deserialize;

#[derive(Deserialize)]
pub struct CurveFile {
    pub curves: Vec<NamedCurve>,
}

#[derive(Deserialize)]
pub struct NamedCurve {
    pub name: String,
    pub degree: usize,
    pub control_points: Vec<Vec<f64>>,
    pub weights: Vec<f64>,
    pub knots: Vec<f64>,
}

pub fn points<const D: usize>(rows: &[Vec<f64>]) -> Vec<SVector<f64, D>> {
    rows.iter().map(|r| SVector::from_column_slice(r)).collect()
}

/// A published plane curve of `fixtures/curves.json`, in mm.
pub fn published(name: &str) -> NurbsCurve<2> {
    let file: CurveFile = serde_json::from_str(include_str!("../fixtures/curves.json")).unwrap();
    let c = file.curves.into_iter().find(|c| c.name == name).unwrap();
    NurbsCurve::new(c.degree, points(&c.control_points), c.weights, c.knots).unwrap()
}

pub fn distance_from_segment<const D: usize>(p: &SVector<f64, D>, a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
    let ab = b - a;
    let l2 = ab.norm_squared();
    let s = if l2 > 0.0 { ((p - a).dot(&ab) / l2).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - ab * s).norm()
}

/// Largest distance of the curve from the chord between two parameters: `n` samples, then golden section around the
/// largest. Never above the true value (but for rounding).
pub fn dense_deviation<const D: usize>(curve: &NurbsCurve<D>, u0: f64, u1: f64, n: usize) -> f64 {
    let (a, b) = (curve.point(u0), curve.point(u1));
    let f = |u: f64| distance_from_segment(&curve.point(u), &a, &b);
    let at = |i: usize| u0 + (u1 - u0) * i as f64 / n as f64;
    let best = (0..=n).max_by(|&i, &j| f(at(i)).total_cmp(&f(at(j)))).unwrap();
    let (mut lo, mut hi) = (at(best.saturating_sub(1)), at((best + 1).min(n)));
    let g = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..40 {
        let (x, y) = (hi - g * (hi - lo), lo + g * (hi - lo));
        if f(x) > f(y) { hi = y } else { lo = x }
    }
    f(at(best)).max(f(0.5 * (lo + hi)))
}
