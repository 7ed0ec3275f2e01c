//! NURBS curves: what defines them, and their validation.

use nalgebra::SVector;

use crate::bezier::Homogeneous;
use crate::curve::{Curve, Jet};
use crate::error::GeometryError;
use crate::knots::{KnotVector, check_degree};
use crate::pieces::Pieces;

/// A non-uniform rational B-spline curve in the plane (`D = 2`) or in space (`D = 3`), of any degree.
///
/// `C(u) = sum w_i N_i(u) P_i / sum w_i N_i(u)` (Liu et al. 2023, eqs. 1-3). A value that exists is valid: finite points,
/// weights above 0, non-decreasing knots. Evaluation runs on power-basis pieces that are prepared once at construction;
/// it allocates nothing. At an end where the first or last knot stands degree + 1 times the point is the control point,
/// to the last bit.
///
/// ```
/// use arcfeed_geometry::{Curve, NurbsCurve, nalgebra::vector};
///
/// // A quarter of the unit circle, exactly.
/// let quarter = NurbsCurve::new(
///     2,
///     vec![vector![1.0, 0.0], vector![1.0, 1.0], vector![0.0, 1.0]],
///     vec![1.0, std::f64::consts::FRAC_1_SQRT_2, 1.0],
///     vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
/// )?;
/// let jet = quarter.jet(0.3);
/// assert!((jet.point.norm() - 1.0).abs() < 1e-15);
/// assert!((jet.curvature() - 1.0).abs() < 1e-14);
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Clone)]
pub struct NurbsCurve<const D: usize> {
    points: Vec<SVector<f64, D>>,
    weights: Vec<f64>,
    knots: KnotVector,
    homogeneous: Vec<Homogeneous>,
    pieces: Pieces,
    /// Points at both ends of the domain.
    ends: Box<[SVector<f64, D>; 2]>,
}

/// The definition of the curve, without the tables prepared for its evaluation.
impl<const D: usize> std::fmt::Debug for NurbsCurve<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NurbsCurve")
            .field("degree", &self.degree())
            .field("points", &self.points)
            .field("weights", &self.weights)
            .field("knots", &self.knots.as_slice())
            .finish_non_exhaustive()
    }
}

/// Two curves are equal when their degree, points, weights and knots are.
impl<const D: usize> PartialEq for NurbsCurve<D> {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points && self.weights == other.weights && self.knots == other.knots
    }
}

impl<const D: usize> NurbsCurve<D> {
    /// A curve from its degree, control points (not multiplied by their weights), weights and full knot vector.
    ///
    /// # Errors
    /// Fails when the counts do not match (`knots = points + degree + 1`, one weight per point), a number is not finite, a
    /// weight is not above 0, the knots decrease or stand too often, or the curve would jump.
    pub fn new(
        degree: usize,
        points: Vec<SVector<f64, D>>,
        weights: Vec<f64>,
        knots: Vec<f64>,
    ) -> Result<Self, GeometryError> {
        const { assert!(D == 2 || D == 3, "curves live in the plane or in space") };
        check_degree(degree)?;
        if points.len() < degree + 1 {
            return Err(GeometryError::TooFewPoints { points: points.len(), degree });
        }
        if weights.len() != points.len() {
            return Err(GeometryError::WeightCount { weights: weights.len(), points: points.len() });
        }
        if knots.len() != points.len() + degree + 1 {
            return Err(GeometryError::KnotCount { knots: knots.len(), points: points.len(), degree });
        }
        check_points("control point", &points)?;
        check_weights(&weights)?;
        let knots = KnotVector::new(degree, knots)?;

        let largest = weights.iter().fold(0.0f64, |m, &w| m.max(w));
        let homogeneous: Vec<Homogeneous> = points
            .iter()
            .zip(&weights)
            .map(|(p, &w)| {
                let w = w / largest;
                let mut h = [0.0, 0.0, 0.0, w];
                for i in 0..D {
                    h[i] = p[i] * w;
                }
                h
            })
            .collect();
        let rational = weights.iter().any(|&w| w != weights[0]);
        let pieces = Pieces::build(&knots, &homogeneous, rational);
        let ends = Box::new(pieces.ends(&knots, &points));
        let this = Self { points, weights, knots, homogeneous, pieces, ends };
        this.check_jumps()?;
        Ok(this)
    }

    /// A polynomial (not rational) curve: all weights 1.
    ///
    /// # Errors
    /// As [`NurbsCurve::new`].
    pub fn bspline(degree: usize, points: Vec<SVector<f64, D>>, knots: Vec<f64>) -> Result<Self, GeometryError> {
        let weights = vec![1.0; points.len()];
        Self::new(degree, points, weights, knots)
    }

    /// Degree of the curve.
    pub fn degree(&self) -> usize {
        self.knots.degree()
    }

    /// Control points, not multiplied by their weights.
    pub fn control_points(&self) -> &[SVector<f64, D>] {
        &self.points
    }

    /// Weights, one per control point.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Knot vector.
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// True where the weights differ, so that the curve is not a polynomial spline.
    pub fn is_rational(&self) -> bool {
        self.pieces.rational
    }

    /// True where the curve ends in the point where it starts, to `tolerance` (a length).
    pub fn is_closed(&self, tolerance: f64) -> bool {
        let (a, b) = self.domain();
        (self.point(a) - self.point(b)).norm() <= tolerance
    }

    pub(crate) fn homogeneous(&self) -> &[Homogeneous] {
        &self.homogeneous
    }

    /// Point at the first or last parameter, where `at` is no further inside than `start` or `end`.
    #[inline(always)]
    pub(crate) fn end(&self, at: f64, (start, end): (f64, f64)) -> Option<&SVector<f64, D>> {
        if at <= start {
            Some(&self.ends[0])
        } else if at >= end {
            Some(&self.ends[1])
        } else {
            None
        }
    }

    /// Evaluation pieces, for whoever walks along the curve and knows in which piece it is.
    pub(crate) fn pieces(&self) -> &Pieces {
        &self.pieces
    }

    /// A curve jumps where an interior knot stands degree + 1 times, unless the two points there coincide.
    fn check_jumps(&self) -> Result<(), GeometryError> {
        let (a, b) = self.domain();
        for (_, value, multiplicity) in self.knots.runs() {
            if multiplicity == self.degree() + 1 && a < value && value < b {
                let gap = (self.jet(value).point - self.jet_left(value).point).norm();
                let size = self.points.iter().fold(0.0f64, |m, p| m.max(p.norm()));
                if gap > 1e-14 * size {
                    return Err(GeometryError::Jump { value, gap });
                }
            }
        }
        Ok(())
    }
}

impl NurbsCurve<2> {
    /// The same curve in space, in the plane z = 0.
    pub fn lifted(&self) -> NurbsCurve<3> {
        NurbsCurve {
            points: self.points.iter().map(|p| p.push(0.0)).collect(),
            weights: self.weights.clone(),
            knots: self.knots.clone(),
            homogeneous: self.homogeneous.clone(),
            pieces: self.pieces.clone(),
            ends: Box::new(self.ends.map(|p| p.push(0.0))),
        }
    }
}

pub(crate) fn check_points<const D: usize>(
    what: &'static str,
    points: &[SVector<f64, D>],
) -> Result<(), GeometryError> {
    for (index, p) in points.iter().enumerate() {
        for axis in 0..D {
            // Not `>`: NaN has to fail too. 1e100 keeps every product of the evaluation inside the range of f64.
            if p[axis].is_nan() || p[axis].abs() >= 1e100 {
                return Err(GeometryError::PointNotFinite { what, index, axis, value: p[axis] });
            }
        }
    }
    Ok(())
}

fn check_weights(weights: &[f64]) -> Result<(), GeometryError> {
    let (mut smallest, mut largest) = (f64::INFINITY, 0.0f64);
    for (index, &value) in weights.iter().enumerate() {
        if !(value.is_finite() && value > 0.0) {
            return Err(GeometryError::Weight { index, value });
        }
        smallest = smallest.min(value);
        largest = largest.max(value);
    }
    if smallest < largest * 1e-12 {
        return Err(GeometryError::WeightRange { smallest, largest });
    }
    Ok(())
}

impl<const D: usize> Curve<D> for NurbsCurve<D> {
    fn domain(&self) -> (f64, f64) {
        self.knots.domain()
    }

    #[inline]
    fn jet(&self, u: f64) -> Jet<D> {
        let p = &self.pieces;
        let i = p.find(u);
        let jet = p.jet(i, p.local(i, u));
        match self.end(u, p.domain) {
            Some(&point) => Jet { point, ..jet },
            None => jet,
        }
    }

    fn jet_left(&self, u: f64) -> Jet<D> {
        let p = &self.pieces;
        let mut i = p.find(u);
        if i > 0 && u <= p.frames[i].start {
            i -= 1;
        }
        let jet = p.jet(i, p.local(i, u));
        match self.end(u, p.domain) {
            Some(&point) => Jet { point, ..jet },
            None => jet,
        }
    }

    #[inline]
    fn point(&self, u: f64) -> SVector<f64, D> {
        let p = &self.pieces;
        if let Some(&end) = self.end(u, p.domain) {
            return end;
        }
        let i = p.find(u);
        p.point(i, p.local(i, u))
    }
}
