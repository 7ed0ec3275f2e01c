//! Paths of many pieces: the pieces, their joints, and all of it as one curve.

use std::ops::Range;

use nalgebra::{SVector, Vector3};

use super::spans::{Place, SpanJet, Spans, elevate, jet, parameter};
use crate::bezier::{Homogeneous, project};
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// Least width of a span in the parameter of the path, as a part of its length: knots closer together are refused.
const NARROWEST: f64 = 2e-12;
/// A cut this near to a border between two spans of a piece is made there, as a part of the span.
const SNAP: f64 = 1e-4;
/// Places of a piece within this part of its length are the same: rounding.
pub(super) const SAME_PLACE: f64 = 1e-12;
/// Two tangents within this angle (rad) count as one: what rounding makes of a smooth joint.
pub(super) const SAME_DIRECTION: f64 = 1e-9;

/// What a piece of a path is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PieceKind {
    /// A straight line.
    Line,
    /// A circular arc.
    Arc,
    /// A helix.
    Helix,
    /// A NURBS curve, or a smooth part of one.
    Curve,
    /// A piece that replaces a joint; see [`JoinedPath::blended`].
    Blend,
}

/// A piece of a [`JoinedPath`].
#[derive(Debug, Clone, PartialEq)]
pub struct PathPiece {
    /// What it is.
    pub kind: PieceKind,
    /// The lines of the input it came from: for a blend those of both neighbours, otherwise the same one twice.
    pub sources: [usize; 2],
    /// First parameter of the piece on the path.
    pub start: f64,
    /// Last parameter of the piece on the path.
    pub end: f64,
    /// Length of the piece, in the unit of the path.
    pub length: f64,
    /// Upper bound on its distance, in the unit of the path: of a blend from the two pieces that it joins, of another
    /// piece from the curve it stands for. 0 where nothing was replaced.
    pub deviation: f64,
    pub(super) spans: Range<usize>,
    /// Arc length of the programmed path at the start, at the middle of a blend, and at the end.
    pub(super) programmed: [f64; 3],
}

/// The place where two pieces of a path meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Index of the piece before it; the one after it has the next index.
    pub piece: usize,
    /// Parameter of the place on the path.
    pub parameter: f64,
    /// Lines of the input of the pieces before and after it.
    pub sources: [usize; 2],
    /// Angle between the tangents before and after, rad: 0 where the direction does not jump, pi at a reversal.
    pub angle: f64,
    /// Curvature before and after, in 1 / unit of length.
    pub curvature: [f64; 2],
    /// Norm of the difference of the curvature vectors before and after.
    pub curvature_jump: f64,
}

/// One path of many pieces: lines, arcs, helices and NURBS curves, each with the line of the input it came from.
///
/// [`JoinedPathBuilder`](crate::JoinedPathBuilder) makes it, [`JoinedPath::blended`] rounds its corners, and
/// [`JoinedPath::to_curve`] makes one curve of it. The parameter of the path is that of this curve. It is close to
/// the arc length: exactly on lines, and otherwise as the length of each span, so that the speed `|C'|` is near 1.
#[derive(Debug, Clone, PartialEq)]
pub struct JoinedPath {
    pub(super) spans: Spans,
    pub(super) pieces: Vec<PathPiece>,
    /// Arc lengths of the programmed path between the calls of the builder.
    pub(super) calls: Vec<f64>,
    /// Parameters at the ends of the spans, with the first one.
    knots: Vec<f64>,
}

impl JoinedPath {
    /// `pieces` without parameters and lengths, which follow from the spans.
    pub(super) fn from_parts(spans: Spans, mut pieces: Vec<PathPiece>, calls: Vec<f64>) -> Self {
        let total: f64 = spans.lengths().iter().sum();
        let mut knots = Vec::with_capacity(spans.len() + 1);
        let mut at = 0.0;
        knots.push(at);
        for length in spans.lengths() {
            at += length.max(NARROWEST * total);
            knots.push(at);
        }
        for piece in &mut pieces {
            piece.start = knots[piece.spans.start];
            piece.end = knots[piece.spans.end];
            piece.length = spans.lengths()[piece.spans.clone()].iter().sum();
        }
        Self { spans, pieces, calls, knots }
    }

    /// The pieces, in order.
    pub fn pieces(&self) -> &[PathPiece] {
        &self.pieces
    }

    /// First and last parameter.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// Sum of the lengths of the pieces. Lines and arcs are exact, others good to about 1e-9 of their length.
    pub fn length(&self) -> f64 {
        self.pieces.iter().map(|p| p.length).sum()
    }

    /// First point.
    pub fn start(&self) -> Vector3<f64> {
        project(&self.spans.get(0)[0])
    }

    /// Last point.
    pub fn end(&self) -> Vector3<f64> {
        let last = self.spans.get(self.spans.len() - 1);
        project(&last[last.len() - 1])
    }

    /// The line of the input that the place at the parameter `u` came from; on a blend the first half belongs to
    /// the piece before it. Parameters outside the domain are taken to its nearest end.
    pub fn source_at(&self, u: f64) -> usize {
        let after = self.pieces.partition_point(|p| p.start <= u);
        let piece = &self.pieces[after.max(1) - 1];
        piece.sources[usize::from(u > 0.5 * (piece.start + piece.end))]
    }

    /// The joints between the pieces, in order, smooth ones too.
    ///
    /// ```
    /// use arcfeed_geometry::{JoinedPathBuilder, nalgebra::vector};
    ///
    /// let mut builder = JoinedPathBuilder::new(vector![0.0, 0.0, 0.0], 1e-6)?;
    /// builder.line_to(vector![1.0, 0.0, 0.0], 10)?.line_to(vector![1.0, 1.0, 0.0], 11)?;
    /// let joints = builder.build()?.joints();
    /// assert_eq!(joints.len(), 1);
    /// assert_eq!(joints[0].angle, std::f64::consts::FRAC_PI_2);
    /// assert_eq!((joints[0].parameter, joints[0].sources), (1.0, [10, 11]));
    /// # Ok::<(), arcfeed_geometry::GeometryError>(())
    /// ```
    pub fn joints(&self) -> Vec<Joint> {
        (1..self.pieces.len())
            .map(|after| {
                let (a, b) = (self.jet(self.last_place(after - 1)), self.jet(self.first_place(after)));
                let curvature = [a.curvature(), b.curvature()];
                Joint {
                    piece: after - 1,
                    parameter: self.pieces[after].start,
                    sources: [self.pieces[after - 1].sources[1], self.pieces[after].sources[0]],
                    angle: angle_between(&a.tangent(), &b.tangent()),
                    curvature: curvature.map(|k| k.norm()),
                    curvature_jump: (curvature[1] - curvature[0]).norm(),
                }
            })
            .collect()
    }

    /// The path as one curve through all pieces, over [`JoinedPath::domain`].
    ///
    /// Its degree is the highest of the pieces, to which all others are raised. Lines and arcs are exact, a helix
    /// keeps the tolerance it was built with. Every joint is a knot of full multiplicity, so that corners stay.
    ///
    /// ```
    /// use arcfeed_geometry::{ArcLengthCurve, JoinedPathBuilder, nalgebra::vector};
    ///
    /// let mut builder = JoinedPathBuilder::new(vector![0.0, 0.0, 0.0], 1e-6)?;
    /// builder.line_to(vector![1.0, 0.0, 0.0], 10)?.line_to(vector![1.0, 2.0, 0.0], 11)?;
    /// let path = builder.build()?;
    /// let curve = ArcLengthCurve::new(path.to_curve()?, 1e-12)?;
    /// assert_eq!(curve.corners(0.1).len(), 1);
    /// assert_eq!(path.source_at(curve.parameter(0.5)), 10);
    /// assert_eq!(path.source_at(curve.parameter(1.5)), 11);
    /// # Ok::<(), arcfeed_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// As [`NurbsCurve::new`]; a path from the builder meets its rules, unless rounding spoils it.
    pub fn to_curve(&self) -> Result<NurbsCurve<3>, GeometryError> {
        let count = self.spans.len();
        let degree = (0..count).map(|i| self.spans.get(i).len() - 1).max().unwrap_or(1);
        let mut points: Vec<SVector<f64, 3>> = Vec::with_capacity(count * degree + 1);
        let mut weights = Vec::with_capacity(count * degree + 1);
        let mut knots = Vec::with_capacity(count * degree + degree + 2);
        knots.push(self.knots[0]);
        knots.extend(std::iter::repeat_n(self.knots[0], degree));
        let (mut span, mut higher) = (Vec::new(), Vec::new());
        for i in 0..count {
            span.clear();
            span.extend_from_slice(self.spans.get(i));
            while span.len() <= degree {
                elevate(&span, &mut higher);
                std::mem::swap(&mut span, &mut higher);
            }
            let first = usize::from(i > 0);
            points.extend(span[first..].iter().map(project::<3>));
            weights.extend(span[first..].iter().map(|h: &Homogeneous| h[3]));
            knots.extend(std::iter::repeat_n(self.knots[i + 1], degree));
        }
        knots.push(self.knots[count]);
        NurbsCurve::new(degree, points, weights, knots)
    }

    pub(super) fn jet(&self, place: Place) -> SpanJet {
        jet(self.spans.get(place.span), place.t)
    }

    pub(super) fn first_place(&self, piece: usize) -> Place {
        Place { span: self.pieces[piece].spans.start, t: 0.0 }
    }

    pub(super) fn last_place(&self, piece: usize) -> Place {
        Place { span: self.pieces[piece].spans.end - 1, t: 1.0 }
    }

    /// The place at the arc length `x` from the start of a piece, moved to a border between two spans that is close.
    pub(super) fn place(&self, piece: usize, x: f64) -> Place {
        let Range { start, end } = self.pieces[piece].spans.clone();
        let lengths = self.spans.lengths();
        let whole = self.pieces[piece].length;
        if x <= SAME_PLACE * whole {
            return self.first_place(piece);
        } else if x >= whole - SAME_PLACE * whole {
            return self.last_place(piece);
        }
        let span;
        // Arc length from the start of the span, counted from the nearer end of the piece.
        let mut rest;
        if x <= 0.5 * whole {
            rest = x;
            let mut i = start;
            while i + 1 < end && rest > lengths[i] {
                rest -= lengths[i];
                i += 1;
            }
            span = i;
        } else {
            let mut back = whole - x;
            let mut i = end - 1;
            while i > start && back > lengths[i] {
                back -= lengths[i];
                i -= 1;
            }
            span = i;
            rest = lengths[i] - back;
        }
        rest = rest.max(0.0);
        let t = parameter(self.spans.get(span), lengths[span], rest);
        if t < SNAP && span > start {
            Place { span: span - 1, t: 1.0 }
        } else if t > 1.0 - SNAP && span + 1 < end {
            Place { span, t: 1.0 }
        } else {
            Place { span, t }
        }
    }
}

/// Angle between two unit vectors, accurate for small ones and near pi too.
pub(super) fn angle_between(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    2.0 * (a - b).norm().atan2((a + b).norm())
}
