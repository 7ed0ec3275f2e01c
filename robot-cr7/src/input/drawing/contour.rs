//! Contours: pieces whose ends touch.

use std::rc::Rc;

use arcfeed_geometry::{GeometryError, NurbsCurve};
use nalgebra::Vector3;

use super::conic::EllipseArc;
use super::piece::{Entity, Piece, TOUCH};
use crate::input::gcode::MoveShape;

/// Ends that are as near as this are the same to rounding, and pieces as short as this are left out, m.
const ROUNDING: f64 = 1e-9;

/// Pieces, each of which starts where the one before it ends.
#[derive(Debug)]
pub(super) struct Contour {
    /// The entity that it begins with.
    pub name: String,
    pub layer: Option<Rc<str>>,
    /// Line of the file where that begins.
    pub line: u64,
    pub pieces: Vec<Piece>,
}

/// Contours in the order of the drawing.
#[derive(Debug, Default)]
pub(super) struct Contours {
    pub contours: Vec<Contour>,
    /// Lines of pieces that have no length: their number, and the first one.
    pub skipped: Option<(u64, u64)>,
}

impl Contours {
    /// Consecutive entities whose ends touch are one contour; a contour whose ends touch is closed.
    pub fn of(entities: Vec<Entity>) -> Result<Self, (u64, GeometryError)> {
        let mut all = Self::default();
        for entity in entities {
            let Entity { name, layer, line, pieces } = entity;
            for piece in pieces {
                let at = piece.line;
                if piece.size() <= ROUNDING {
                    all.skip(at);
                    continue;
                }
                let touches = all.end().is_some_and(|end| (piece.start - end).norm() <= TOUCH);
                if !touches {
                    all.close()?;
                    all.contours.push(Contour { name: name.clone(), layer: layer.clone(), line, pieces: Vec::new() });
                }
                all.append(piece).map_err(|e| (at, e))?;
            }
        }
        all.close()?;
        Ok(all)
    }

    fn end(&self) -> Option<Vector3<f64>> {
        Some(self.contours.last()?.pieces.last()?.end)
    }

    /// Adds a piece to the last contour, which it touches.
    fn append(&mut self, piece: Piece) -> Result<(), GeometryError> {
        let (end, start) = (piece.end, self.end().unwrap_or(piece.start));
        let piece = joined(piece, start, end)?;
        match self.contours.last_mut().filter(|_| piece.size() > ROUNDING) {
            Some(contour) => contour.pieces.push(piece),
            None => self.skip(piece.line),
        }
        Ok(())
    }

    /// Counts a piece without length.
    fn skip(&mut self, line: u64) {
        let (count, first) = self.skipped.unwrap_or((0, line));
        self.skipped = Some((count + 1, first));
    }

    /// Ends the last contour where it starts, where its ends touch. An error has the line of the piece that is moved.
    fn close(&mut self) -> Result<(), (u64, GeometryError)> {
        let Some(contour) = self.contours.last_mut() else { return Ok(()) };
        let Some(start) = contour.pieces.first().map(|first| first.start) else { return Ok(()) };
        if let Some(last) = contour.pieces.pop() {
            let closed = (last.end - start).norm() <= TOUCH && last.size() > 2.0 * TOUCH;
            let (from, to) = (last.start, if closed { start } else { last.end });
            let line = last.line;
            contour.pieces.push(joined(last, from, to).map_err(|e| (line, e))?);
        }
        Ok(())
    }
}

/// The piece with these ends, unless its own are the same to rounding: arcs stay arcs.
fn joined(piece: Piece, start: Vector3<f64>, end: Vector3<f64>) -> Result<Piece, GeometryError> {
    let off = (start - piece.start).norm().max((end - piece.end).norm());
    if off <= ROUNDING { Ok(piece.ending_at([start, end])) } else { moved(&piece, start, end) }
}

/// The piece with its ends moved there. The points between them move by a part of that: none moves farther than the ends.
fn moved(piece: &Piece, start: Vector3<f64>, end: Vector3<f64>) -> Result<Piece, GeometryError> {
    let shifts = [start - piece.start, end - piece.end];
    let curve = match &piece.shape {
        MoveShape::Line { .. } => return Ok(Piece::line(start, end, piece.line)),
        MoveShape::Arc { centre, normal, sweep, .. } => {
            let arm = piece.start - centre;
            EllipseArc { centre: *centre, axes: [arm, normal.cross(&arm)], from: 0.0, sweep: *sweep }.curve()?
        }
        MoveShape::Curve(curve) => curve.as_ref().clone(),
    };
    // The mean of the knots of a control point: points that coincide because of a full knot move alike.
    let knots = curve.knots().as_slice();
    let at = |i: usize| knots[i + 1..=i + curve.degree()].iter().sum::<f64>() / curve.degree() as f64;
    let ends = (at(0), at(curve.control_points().len() - 1));
    let share = |i: usize| ((at(i) - ends.0) / (ends.1 - ends.0)).clamp(0.0, 1.0);
    let moved = |(i, p): (usize, &Vector3<f64>)| p + shifts[0] * (1.0 - share(i)) + shifts[1] * share(i);
    let points = curve.control_points().iter().enumerate().map(moved).collect();
    let (weights, knots) = (curve.weights().to_vec(), curve.knots().as_slice().to_vec());
    Piece::curve(NurbsCurve::new(curve.degree(), points, weights, knots)?, piece.line)
}
