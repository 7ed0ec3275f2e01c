//! From contours to a program.

use std::path::Path;

use nalgebra::Vector3;

use super::contour::{Contour, Contours};
use super::options::DrawingOptions;
use super::piece::Piece;
use crate::input::gcode::{GcodeMarker, GcodeMove, GcodeProgram, MarkerKind, MoveKind, MoveShape, PathControl};
use crate::text::clip;

/// Moves of a lift: up, across and down.
const LIFT: u64 = 3;
/// A move as short as this is left out, m.
const SHORT: f64 = 1e-9;

/// The program that follows the contours, with a lift of the tool before each but the first. `None` where there is no contour.
///
/// `lines` is the number of lines of the file.
pub(super) fn program_of(
    file: &Path,
    contours: Contours,
    options: &DrawingOptions,
    lines: u64,
    mut warnings: Vec<String>,
) -> Option<GcodeProgram> {
    let contours = contours.contours;
    let start = contours.first()?.pieces.first()?.start;
    let top = contours.iter().flat_map(|contour| &contour.pieces).map(Piece::top).fold(start.z, f64::max);
    let mut writer =
        Writer { options, height: top + options.lift, position: start, moves: Vec::new(), markers: Vec::new() };
    for (i, contour) in contours.into_iter().enumerate() {
        writer.contour(i, contour);
    }
    let Writer { mut moves, mut markers, .. } = writer;
    let rises = moves.windows(2).all(|pair| pair[0].line < pair[1].line);
    if !rises && moves.len() > 1 {
        warnings.push(
            "several moves share a line of the file: the lines in reports count the moves from 1, lifts included, and \
             markers name the element of each contour"
                .to_owned(),
        );
        (1..).zip(&mut moves).for_each(|(number, step)| step.line = number);
        markers.iter_mut().for_each(|mark| mark.line = mark.after as u64 + 1);
    }
    Some(GcodeProgram { file: file.to_owned(), start, moves, markers, warnings, lines })
}

struct Writer<'a> {
    options: &'a DrawingOptions,
    /// The height of the lifts, m: above all that is drawn, which the tool may pass over.
    height: f64,
    position: Vector3<f64>,
    moves: Vec<GcodeMove>,
    markers: Vec<GcodeMarker>,
}

impl Writer<'_> {
    fn contour(&mut self, index: usize, contour: Contour) {
        let Contour { name, layer, line, pieces } = contour;
        let Some(first) = pieces.first() else { return };
        if index > 0 {
            // Lines of the file before the entity that hold no piece: DXF has the coordinates of another there.
            self.lift(first.start, line.saturating_sub(LIFT));
        }
        let layer = layer.map(|layer| format!(", layer \"{}\"", clip(&layer, 60))).unwrap_or_default();
        let what = format!("contour {}: {} at line {line}{layer}", index + 1, clip(&name, 80));
        self.markers.push(GcodeMarker { line: first.line, after: self.moves.len(), kind: MarkerKind::Message(what) });
        for piece in pieces {
            self.position = piece.end;
            self.moves.push(GcodeMove {
                line: piece.line,
                number: None,
                kind: MoveKind::Feed { speed: self.options.feed },
                shape: piece.shape,
                control: None,
                rotary: None,
            });
        }
    }

    /// Up, across and down to `to`. The contours around are followed up to their ends.
    fn lift(&mut self, to: Vector3<f64>, line: u64) {
        if let Some(last) = self.moves.last_mut() {
            last.control = Some(PathControl::ExactPath);
        }
        let up = Vector3::new(self.position.x, self.position.y, self.height);
        let across = Vector3::new(to.x, to.y, self.height);
        for (i, (from, end)) in (0..).zip([(self.position, up), (up, across), (across, to)]) {
            // Two contours may lie above one another.
            if (end - from).norm() > SHORT {
                let control = (end == to).then_some(PathControl::ExactPath);
                let (number, rotary, shape) = (None, None, MoveShape::Line { to: end });
                let kind = MoveKind::Rapid;
                self.moves.push(GcodeMove { line: line + i, number, kind, shape, control, rotary });
            }
        }
        self.position = to;
    }
}
