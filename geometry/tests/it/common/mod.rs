//! What several tests share: fixtures, and a measurement of deviations that knows nothing of the library's own.
#![allow(dead_code, clippy::unwrap_used)]

#[cfg(feature = "fit")]
pub mod dense;
pub mod mixed;
pub mod polylines;
pub mod random;

use arcfeed_geometry::{Curve, NurbsCurve, nalgebra::SVector};
use serde::Deserialize;
use serde::de::DeserializeOwned;

#[derive(Deserialize)]
pub struct CurveFile {
    pub curves: Vec<NamedCurve>,
}

#[derive(Deserialize)]
pub struct NamedCurve {
    pub name: String,
    #[serde(flatten)]
    pub data: CurveData,
}

#[derive(Deserialize)]
pub struct CurveData {
    pub degree: usize,
    pub control_points: Vec<Vec<f64>>,
    pub weights: Vec<f64>,
    pub knots: Vec<f64>,
}

impl CurveData {
    pub fn curve<const D: usize>(&self) -> NurbsCurve<D> {
        NurbsCurve::new(self.degree, points(&self.control_points), self.weights.clone(), self.knots.clone()).unwrap()
    }
}

/// A curve of `fixtures/nurbs.json` with what a test needs of its values, computed with 50 digits.
#[derive(Deserialize)]
pub struct OracleCurve<T> {
    pub id: usize,
    pub dim: usize,
    #[serde(flatten)]
    pub data: CurveData,
    #[serde(flatten)]
    pub values: T,
}

/// All thirty curves.
pub fn oracle<T: DeserializeOwned>() -> Vec<OracleCurve<T>> {
    #[derive(Deserialize)]
    struct File<T> {
        curves: Vec<OracleCurve<T>>,
    }
    let file: File<T> = serde_json::from_str(include_str!("../../fixtures/nurbs.json")).unwrap();
    assert_eq!(file.curves.len(), 30);
    file.curves
}

pub fn points<const D: usize>(rows: &[Vec<f64>]) -> Vec<SVector<f64, D>> {
    rows.iter().map(|r| SVector::from_column_slice(r)).collect()
}

/// A published plane curve of `fixtures/curves.json`, in mm.
pub fn published(name: &str) -> NurbsCurve<2> {
    let file: CurveFile = serde_json::from_str(include_str!("../../fixtures/curves.json")).unwrap();
    file.curves.into_iter().find(|c| c.name == name).unwrap().data.curve()
}

pub fn distance_from_segment<const D: usize>(p: &SVector<f64, D>, a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
    let ab = b - a;
    let l2 = ab.norm_squared();
    let s = if l2 > 0.0 { ((p - a).dot(&ab) / l2).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - ab * s).norm()
}

/// Largest distance of the curve from the chord between two parameters: `n` samples and the knots, then golden section
/// around every local maximum of them that is nearly the largest. Never above the true value (but for rounding).
pub fn dense_deviation<const D: usize>(curve: &NurbsCurve<D>, u0: f64, u1: f64, n: usize) -> f64 {
    let (a, b) = (curve.point(u0), curve.point(u1));
    let f = |u: f64| distance_from_segment(&curve.point(u), &a, &b);
    let mut at: Vec<f64> = (0..=n).map(|i| u0 + (u1 - u0) * i as f64 / n as f64).collect();
    at.extend(curve.knots().as_slice().iter().filter(|&&k| u0 < k && k < u1));
    at.sort_by(f64::total_cmp);
    let values: Vec<f64> = at.iter().map(|&u| f(u)).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let mut best = largest;
    let g = (5f64.sqrt() - 1.0) / 2.0;
    for i in 1..at.len() - 1 {
        if values[i] < 0.95 * largest || values[i] < values[i - 1] || values[i] < values[i + 1] {
            continue;
        }
        let (mut lo, mut hi) = (at[i - 1], at[i + 1]);
        for _ in 0..40 {
            let (x, y) = (hi - g * (hi - lo), lo + g * (hi - lo));
            if f(x) > f(y) { hi = y } else { lo = x }
        }
        best = best.max(f(0.5 * (lo + hi)));
    }
    best
}

/// Point of a curve by de Boor's algorithm on Euclidean points with running weights (Farin's form): slow, accurate, and
/// independent of how the library evaluates. Where two spans meet it takes the right one, or the left one if `left`.
pub fn de_boor<const D: usize>(curve: &NurbsCurve<D>, u: f64, left: bool) -> SVector<f64, D> {
    let (p, t) = (curve.degree(), curve.knots().as_slice());
    let (a, b) = curve.domain();
    let u = u.clamp(a, b);
    let inside =
        |k: usize| if (left && u > a) || u == b { t[k] < u && u <= t[k + 1] } else { t[k] <= u && u < t[k + 1] };
    let k = (p..curve.control_points().len()).find(|&k| inside(k)).unwrap();
    let mut points = curve.control_points()[k - p..=k].to_vec();
    let mut weights = curve.weights()[k - p..=k].to_vec();
    for r in 1..=p {
        for i in (r..=p).rev() {
            let alpha = (u - t[k - p + i]) / (t[k + 1 + i - r] - t[k - p + i]);
            let w = (1.0 - alpha) * weights[i - 1] + alpha * weights[i];
            let share = alpha * weights[i] / w;
            points[i] = points[i - 1] * (1.0 - share) + points[i] * share;
            weights[i] = w;
        }
    }
    points[p]
}
