//! One polynomial piece of a fitted curve, and the bound of its distance from the polyline.

use nalgebra::SVector;

use super::polyline::Part;

/// Degree of the fitted curves: the lowest with a continuous curvature.
pub(super) const DEGREE: usize = 3;

/// Number of coefficients of a piece.
pub(super) const ORDER: usize = DEGREE + 1;

/// A cubic polynomial over `[start, end]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece<const D: usize> {
    pub start: f64,
    pub end: f64,
    /// In powers of the local parameter, which runs from -1 to 1.
    pub coefficients: [SVector<f64, D>; ORDER],
    /// No point of the piece is farther than this from the point of the polyline with the same parameter.
    pub deviation: f64,
    /// True where the piece is a part of a chord.
    pub straight: bool,
}

impl<const D: usize> Piece<D> {
    /// The part of a line over an interval: its point and derivative at the start.
    pub fn line(
        (start, end): (f64, f64),
        point: &SVector<f64, D>,
        direction: &SVector<f64, D>,
        deviation: f64,
    ) -> Self {
        let half = 0.5 * (end - start);
        let zero = SVector::zeros();
        let coefficients = [point + direction * half, direction * half, zero, zero];
        Self { start, end, coefficients, deviation, straight: true }
    }

    pub fn width(&self) -> f64 {
        self.end - self.start
    }

    fn half(&self) -> f64 {
        0.5 * (self.end - self.start)
    }

    /// Local parameter of `t`.
    pub fn local(&self, t: f64) -> f64 {
        (t - 0.5 * (self.start + self.end)) / self.half()
    }

    /// Point at the local parameter `x`.
    #[inline]
    pub fn point(&self, x: f64) -> SVector<f64, D> {
        let [c0, c1, c2, c3] = &self.coefficients;
        ((c3 * x + c2) * x + c1) * x + c0
    }

    /// Value, first and second derivative at the end as Taylor coefficients; the third is left out.
    pub fn taylor_at_end(&self) -> [SVector<f64, D>; ORDER] {
        let [_, c1, c2, c3] = &self.coefficients;
        let scale = 1.0 / self.half();
        [self.point(1.0), (c1 + c2 * 2.0 + c3 * 3.0) * scale, (c2 + c3 * 3.0) * (scale * scale), SVector::zeros()]
    }

    /// Measures the piece against the `parts` of the polyline over its interval and sets the bound of its deviation.
    ///
    /// The difference to a part is a cubic. The parabola through its values at both ends and in the middle lies
    /// in the hull of the Bernstein coefficients of its two halves, and the cubic differs from it by at most
    /// `w^3 |c3| sqrt(3) / 36`, with the width `w` of the part by the local parameter.
    pub fn measure(&mut self, parts: impl Iterator<Item = Part<D>>) {
        let [_, _, c2, c3] = &self.coefficients;
        let (c2, c3) = (*c2, *c3);
        let cubic = c3.norm();
        // Half of the largest second derivative: at an end, because it is linear.
        let bend = (c2 + c3 * 3.0).norm().max((c2 - c3 * 3.0).norm());
        let mut largest = 0.0f64;
        let mut known: Option<SVector<f64, D>> = None;
        for part in parts {
            let (a, b) = (self.local(part.start), self.local(part.end));
            let before = known.unwrap_or_else(|| self.point(a) - part.from);
            let after = self.point(b) - part.to;
            known = Some(after);
            let width = b - a;
            let ends = before.norm_squared().max(after.norm_squared()).sqrt();
            // Between its ends a curve leaves its chord by no more than an eighth of width^2 times the second
            // derivative.
            if ends + 0.25 * width * width * bend <= largest {
                continue;
            }
            let middle = self.point(0.5 * (a + b)) - (part.from + part.to) * 0.5;
            let top = middle * 2.0 - (before + after) * 0.5;
            let inner = (before + top).norm().max((after + top).norm()) * 0.5;
            let rest = 3f64.sqrt() / 36.0 * width * width * width * cubic;
            let bound = ends.max(inner).max(middle.norm()) + rest;
            largest = largest.max(bound.min(ends + 0.25 * width * width * bend));
        }
        self.deviation = largest;
    }
}

/// Polar form of a cubic, given by its coefficients in powers: the control point of a spline that has
/// `arguments` as the knots that belong to the control point.
pub(super) fn polar<const D: usize>(
    coefficients: &[SVector<f64, D>; ORDER],
    arguments: [f64; DEGREE],
) -> SVector<f64, D> {
    let [x, y, z] = arguments;
    let [c0, c1, c2, c3] = coefficients;
    c0 + c1 * ((x + y + z) / 3.0) + c2 * ((x * y + x * z + y * z) / 3.0) + c3 * (x * y * z)
}
