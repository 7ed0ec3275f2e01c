//! The elements of a fitted curve, and the curves that they make.

use nalgebra::SVector;

use super::fitted::{FittedStretch, StretchShape, joined};
use super::piece::Piece;
use super::primitive::{Shape, arc_curve};
use crate::error::GeometryError;

/// A part of a fitted curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<const D: usize> {
    pub shape: ElementShape<D>,
    /// Indices of the data points at or before its start and at or behind its end.
    pub indices: (usize, usize),
}

/// What a part of a fitted curve is.
#[derive(Debug, Clone, Copy)]
pub(super) enum ElementShape<const D: usize> {
    /// A cubic span, or a line.
    Cubic(Piece<D>),
    /// An arc over an interval of the length along the polyline.
    Arc { shape: Shape<D>, span: (f64, f64), deviation: f64 },
}

impl<const D: usize> Element<D> {
    fn is_arc(&self) -> bool {
        matches!(self.shape, ElementShape::Arc { .. })
    }

    /// Number of polynomial or rational pieces.
    pub fn pieces(&self) -> usize {
        match &self.shape {
            ElementShape::Cubic(_) => 1,
            ElementShape::Arc { shape, span, .. } => shape.spans(*span),
        }
    }
}

/// The curves of elements that continue each other: arcs, and B-splines of the cubics between them. `ends` are the points
/// and `indices` the data points at both ends, and `continues` tells whether the first curve continues another.
pub(super) fn curves<const D: usize>(
    elements: &[Element<D>],
    ends: (SVector<f64, D>, SVector<f64, D>),
    indices: (usize, usize),
    mut continues: bool,
    rounding: f64,
) -> Result<Vec<FittedStretch<D>>, GeometryError> {
    let mut out = Vec::new();
    let (mut from, mut first) = (ends.0, indices.0);
    let mut rest = elements;
    for group in elements.chunk_by(|a, b| !a.is_arc() && !b.is_arc()) {
        rest = &rest[group.len()..];
        let (to, last) = match (rest.first().map(|e| &e.shape), &group[0].shape) {
            (None, _) => (ends.1, indices.1),
            (_, ElementShape::Arc { shape, span, .. }) => (shape.point(span.1), group[0].indices.1),
            (Some(ElementShape::Arc { shape, span, .. }), _) => (shape.point(span.0), group[group.len() - 1].indices.1),
            // Groups of cubics do not follow each other.
            (Some(ElementShape::Cubic(piece)), _) => (piece.point(-1.0), group[group.len() - 1].indices.1),
        };
        let mut stretch = match &group[0].shape {
            ElementShape::Arc { shape, span, deviation } => {
                let curve = arc_curve(shape, *span, (from, to))?;
                FittedStretch::bent(StretchShape::Arc, curve, (first, last), *deviation)
            }
            ElementShape::Cubic(_) => {
                let cubic = |e: &Element<D>| match e.shape {
                    ElementShape::Cubic(piece) => Some(piece),
                    ElementShape::Arc { .. } => None,
                };
                let pieces: Vec<Piece<D>> = group.iter().filter_map(cubic).collect();
                let largest = pieces.iter().fold(0.0f64, |m, p| m.max(p.deviation));
                let curve = joined(&pieces, (from, to))?;
                let mut stretch = FittedStretch::bent(StretchShape::Curve, curve, (first, last), largest);
                let origin = pieces[0].start;
                let lines = pieces.iter().filter(|p| p.straight);
                stretch.lines = lines.map(|p| (p.start - origin, p.end - origin)).collect();
                stretch
            }
        };
        stretch.max_deviation += rounding;
        stretch.continues = continues;
        out.push(stretch);
        continues = true;
        from = to;
        first = rest.first().map_or(last, |next| next.indices.0);
    }
    Ok(out)
}
