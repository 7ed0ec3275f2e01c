//! Contours: pieces whose ends touch.

use std::rc::Rc;

use arcfeed_geometry::GeometryError;
use nalgebra::Vector3;

use super::piece::{Entity, Piece, TOUCH};

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
                    all.close().map_err(|e| (at, e))?;
                    all.contours.push(Contour { name: name.clone(), layer: layer.clone(), line, pieces: Vec::new() });
                }
                all.append(piece).map_err(|e| (at, e))?;
            }
        }
        all.close().map_err(|e| (0, e))?;
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

    /// Ends the last contour where it starts, where its ends touch.
    fn close(&mut self) -> Result<(), GeometryError> {
        let Some(contour) = self.contours.last_mut() else { return Ok(()) };
        let Some(start) = contour.pieces.first().map(|first| first.start) else { return Ok(()) };
        if let Some(last) = contour.pieces.pop() {
            let closed = (last.end - start).norm() <= TOUCH && last.size() > 2.0 * TOUCH;
            let (from, to) = (last.start, if closed { start } else { last.end });
            contour.pieces.push(joined(last, from, to)?);
        }
        Ok(())
    }
}

/// The piece with these ends, unless its own are the same to rounding: arcs stay arcs.
fn joined(piece: Piece, start: Vector3<f64>, end: Vector3<f64>) -> Result<Piece, GeometryError> {
    let off = (start - piece.start).norm().max((end - piece.end).norm());
    if off <= ROUNDING { Ok(piece.ending_at([start, end])) } else { piece.with_ends(start, end) }
}
