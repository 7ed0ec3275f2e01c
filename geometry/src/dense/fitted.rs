//! The fitted curves, and how they are put together from pieces.

use nalgebra::SVector;

use super::piece::{DEGREE, ORDER, Piece, polar};
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// What a fitted stretch is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StretchShape {
    /// A straight line between two corners.
    Line,
    /// A cubic B-spline with continuous curvature.
    Curve,
    /// A circular arc, exact, of degree 2.
    Arc,
    /// A straight line in a place where no smooth curve keeps the tolerance: the polyline itself, up to a start
    /// within the tolerance of it. Its ends are corners.
    Polyline,
}

/// A part of a polyline between two corners, as a curve.
///
/// The parameter of a curve is the length along the polyline from the start of the stretch; the polyline's point
/// at the same parameter is never farther away than [`FittedStretch::max_deviation`], except that an arc has another
/// parameter inside. The bound holds in both directions: every point of the curve is that near to the polyline, and
/// every point of the polyline that near to the curve.
#[derive(Debug, Clone)]
pub struct FittedStretch<const D: usize> {
    /// The curve.
    pub curve: NurbsCurve<D>,
    /// What it is.
    pub shape: StretchShape,
    /// Index of the data point in which the stretch starts; where it starts within a chord, of the start of the
    /// chord.
    pub first: usize,
    /// Index of the data point in which the stretch ends; where it ends within a chord, of the end of the chord.
    pub last: usize,
    /// An upper bound on the distance between curve and polyline, in the points' unit. Never above the tolerance.
    pub max_deviation: f64,
    /// Parameter intervals on which the curve is a straight line, in order.
    pub lines: Vec<(f64, f64)>,
    /// True where the stretch continues the one before with the same point, direction and curvature (next to an arc its
    /// parameter runs at another rate). A corner is there otherwise.
    pub continues: bool,
}

impl<const D: usize> FittedStretch<D> {
    /// Number of polynomial pieces of the curve.
    pub fn pieces(&self) -> usize {
        self.curve.knots().spans().count()
    }

    /// A stretch that is no line, and that continues none.
    pub(super) fn bent(
        shape: StretchShape,
        curve: NurbsCurve<D>,
        (first, last): (usize, usize),
        max_deviation: f64,
    ) -> Self {
        Self { curve, shape, first, last, max_deviation, lines: Vec::new(), continues: false }
    }

    /// A straight stretch.
    pub(super) fn straight(
        shape: StretchShape,
        curve: NurbsCurve<D>,
        (first, last): (usize, usize),
        max_deviation: f64,
    ) -> Self {
        let lines = vec![curve.domain()];
        Self { curve, shape, first, last, max_deviation, lines, continues: false }
    }
}

/// The line between two points, over a parameter interval of the given length.
pub(super) fn line<const D: usize>(
    (from, to): (SVector<f64, D>, SVector<f64, D>),
    length: f64,
) -> Result<NurbsCurve<D>, GeometryError> {
    NurbsCurve::bspline(1, vec![from, to], vec![0.0, 0.0, length, length])
}

/// Puts pieces together that meet with continuous curvature.
///
/// A control point is the polar form of any piece in its support; the piece about its knots is taken, which costs the
/// fewest digits.
pub(super) fn joined<const D: usize>(
    pieces: &[Piece<D>],
    (from, to): (SVector<f64, D>, SVector<f64, D>),
) -> Result<NurbsCurve<D>, GeometryError> {
    let origin = pieces[0].start;
    let mut knots = vec![0.0; DEGREE];
    knots.extend(pieces.iter().map(|p| p.start - origin));
    let end = pieces[pieces.len() - 1].end - origin;
    knots.extend([end; ORDER]);
    let count = pieces.len() + DEGREE;
    let mut control: Vec<SVector<f64, D>> = (0..count)
        .map(|j| {
            // The pieces of the support are those from j - DEGREE to j.
            let support = &pieces[j.saturating_sub(DEGREE)..(j + 1).min(pieces.len())];
            let local = |p: &Piece<D>| -> [f64; DEGREE] { std::array::from_fn(|r| p.local(knots[j + 1 + r] + origin)) };
            let reach = |p: &Piece<D>| local(p).iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let mut nearest = &support[0];
            for piece in support {
                if reach(piece) < reach(nearest) {
                    nearest = piece;
                }
            }
            polar(&nearest.coefficients, local(nearest))
        })
        .collect();
    (control[0], control[count - 1]) = (from, to);
    NurbsCurve::bspline(DEGREE, control, knots)
}
