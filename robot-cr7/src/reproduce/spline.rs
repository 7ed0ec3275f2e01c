//! Evaluation of NURBS curves by de Boor's algorithm: a second path beside the library's
//! power-basis pieces.

use arcfeed_geometry::NurbsCurve;
use nalgebra::{Vector3, Vector4};

/// A NURBS curve in homogeneous coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<Vector4<f64>>,
}

impl Spline {
    /// The same control points, weights and knots as `curve`.
    pub fn new(curve: &NurbsCurve<3>) -> Self {
        let lift = |(p, w): (&Vector3<f64>, &f64)| Vector4::new(p.x * w, p.y * w, p.z * w, *w);
        Self {
            degree: curve.degree(),
            knots: curve.knots().as_slice().to_vec(),
            points: curve.control_points().iter().zip(curve.weights()).map(lift).collect(),
        }
    }

    /// First and last parameter.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.knots.len() - 1 - self.degree])
    }

    /// Distinct knots of the domain.
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..self.knots.len() - self.degree].to_vec();
        breaks.dedup();
        breaks
    }

    fn span(&self, u: f64) -> usize {
        let last = self.points.len() - 1;
        (self.degree..last).find(|&i| u < self.knots[i + 1]).unwrap_or(last)
    }

    /// The polar form with one argument for each level of de Boor's scheme, in the span of
    /// `inside`.
    fn blossom(&self, inside: f64, arguments: &[f64]) -> Vec<Vector4<f64>> {
        let (k, span) = (self.degree, self.span(inside));
        let mut d: Vec<Vector4<f64>> = self.points[span - k..=span].to_vec();
        for (level, &u) in arguments.iter().enumerate() {
            for j in 0..k - level {
                let i = span - k + level + 1 + j;
                let (a, b) = (self.knots[i], self.knots[i + k - level]);
                let alpha = (u - a) / (b - a);
                d[j] = d[j] * (1.0 - alpha) + d[j + 1] * alpha;
            }
            d.truncate(k - level);
        }
        d
    }

    /// The point at `u`.
    pub fn point(&self, u: f64) -> Vector3<f64> {
        let d = self.blossom(u, &vec![u; self.degree])[0];
        d.xyz() / d.w
    }

    /// The derivative by `u`.
    pub fn derivative(&self, u: f64) -> Vector3<f64> {
        let (k, span) = (self.degree, self.span(u));
        let d = self.blossom(u, &vec![u; k - 1]);
        let (a, b) = (self.knots[span], self.knots[span + 1]);
        let slope = (d[1] - d[0]) * (k as f64 / (b - a));
        let alpha = (u - a) / (b - a);
        let value = d[0] * (1.0 - alpha) + d[1] * alpha;
        (slope.xyz() - value.xyz() * (slope.w / value.w)) / value.w
    }

    /// Control points of the Bezier piece over the span from `a` to `b`, from the polar form.
    pub fn bezier(&self, a: f64, b: f64) -> Vec<Vector4<f64>> {
        let inside = 0.5 * (a + b);
        let arguments = |ends: usize| (0..self.degree).map(|i| if i < ends { b } else { a }).collect::<Vec<_>>();
        (0..=self.degree).map(|ends| self.blossom(inside, &arguments(ends))[0]).collect()
    }

    /// Signed curvature in the plane of x and y, from differences of the derivative.
    pub fn curvature(&self, u: f64) -> f64 {
        let (lo, hi) = self.domain();
        let h = 1e-6 * (hi - lo);
        let (before, after) = ((u - h).max(lo), (u + h).min(hi));
        let first = self.derivative(u);
        let second = (self.derivative(after) - self.derivative(before)) / (after - before);
        (first.x * second.y - first.y * second.x) / first.norm().powi(3)
    }

    /// Arc length between two parameters by Simpson's rule, knot span by knot span.
    pub fn length(&self, from: f64, to: f64, intervals: u32) -> f64 {
        let mut inner = vec![from];
        inner.extend(self.breaks().into_iter().filter(|u| *u > from && *u < to));
        inner.push(to);
        inner.windows(2).map(|w| self.simpson(w[0], w[1], intervals)).sum()
    }

    fn simpson(&self, a: f64, b: f64, intervals: u32) -> f64 {
        let n = intervals + intervals % 2;
        let h = (b - a) / f64::from(n);
        // The ends belong to this span: a step inside keeps them there.
        let inside = |u: f64| u.max(a + 1e-12 * (b - a)).min(b - 1e-12 * (b - a));
        let weight = |i: u32| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
        (0..=n).map(|i| weight(i) * self.derivative(inside(a + h * f64::from(i))).norm()).sum::<f64>() * h / 3.0
    }

    /// Largest distance of the curve between `a` and `b` from the chord, over `samples` places.
    pub fn deviation(&self, a: f64, b: f64, samples: u32) -> f64 {
        let (p, q) = (self.point(a), self.point(b));
        let inner = (1..samples).map(|i| self.point(a + (b - a) * f64::from(i) / f64::from(samples)));
        inner.fold(0.0, |worst: f64, x| worst.max(off_segment(&x, &p, &q)))
    }

    /// Largest distance of the curve from the chords between `breaks`.
    pub fn largest_deviation(&self, breaks: &[f64], samples: u32) -> f64 {
        breaks.windows(2).fold(0.0, |worst, w| worst.max(self.deviation(w[0], w[1], samples)))
    }

    /// The parameter nearest to `point`, searched by Gauss-Newton steps from `near`.
    pub fn nearest(&self, point: &Vector3<f64>, near: f64) -> f64 {
        let (lo, hi) = self.domain();
        let mut u = near;
        for _ in 0..30 {
            let slope = self.derivative(u);
            let step = (point - self.point(u)).dot(&slope) / slope.norm_squared();
            u = (u + step).max(lo).min(hi);
            if step.abs() <= 1e-14 * (hi - lo) {
                break;
            }
        }
        u
    }

    /// `n + 1` points between two parameters, in mm in the plane of x and y.
    pub fn drawn(&self, a: f64, b: f64, n: u32) -> Vec<[f64; 2]> {
        let at = |i: u32| self.point(a + (b - a) * f64::from(i) / f64::from(n));
        (0..=n).map(at).map(|p| [p.x * 1e3, p.y * 1e3]).collect()
    }
}

/// Distance of `x` from the segment between `p` and `q`.
pub fn off_segment(x: &Vector3<f64>, p: &Vector3<f64>, q: &Vector3<f64>) -> f64 {
    let (chord, way) = (q - p, x - p);
    let length2 = chord.norm_squared();
    let f = if length2 > 0.0 { (way.dot(&chord) / length2).max(0.0).min(1.0) } else { 0.0 };
    (way - chord * f).norm()
}
