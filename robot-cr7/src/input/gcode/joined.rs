//! A program as one path.

use std::f64::consts::TAU;

use arcfeed_geometry::{ArcTo, GeometryError, JoinedPath, JoinedPathBuilder};
use nalgebra::Vector3;

use super::program::{GcodeMove, GcodeProgram, MoveKind, MoveShape};
use crate::input::error::InputError;

/// By how much the ends of arcs and the starts of curves may be off, in metres: the rounding of coordinates.
const GAP: f64 = 1e-7;
/// A helix is kept within this, in metres.
const HELIX: f64 = 1e-8;
/// A curve is kept within this, in metres, where it stands still because control points coincide.
const STANDING: f64 = 1e-6;

impl GcodeProgram {
    /// The moves from the first one that is not rapid on: where the tool comes from is not part of the work. A program of rapid moves
    /// alone is kept.
    pub fn working_moves(&self) -> &[GcodeMove] {
        &self.moves[self.first_working_move()..]
    }

    /// Index of the first of the working moves.
    pub(crate) fn first_working_move(&self) -> usize {
        self.moves.iter().position(|step| step.kind != MoveKind::Rapid).unwrap_or(0)
    }

    /// Where the move of this index starts, in metres.
    pub(crate) fn start_of(&self, index: usize) -> Vector3<f64> {
        index.checked_sub(1).and_then(|before| self.moves.get(before)).map_or(self.start, GcodeMove::end)
    }

    /// The [working moves](Self::working_moves) as one path, in metres. The source of each piece is its line in the file.
    ///
    /// # Errors
    /// [`InputError::Value`] for a program without moves and for a move that only turns rotary axes, [`InputError::Curve`] for a shape that
    /// is no path.
    pub fn joined(&self) -> Result<JoinedPath, InputError> {
        let mut path = self.begin(self.first_working_move())?;
        for step in self.working_moves() {
            self.append(&mut path, step)?;
        }
        path.build().map_err(|source| self.curve_error(0, source))
    }

    /// A path that starts where the move of this index does.
    pub(crate) fn begin(&self, index: usize) -> Result<JoinedPathBuilder, InputError> {
        let Some(first) = self.moves.get(index) else {
            return Err(self.wrong(
                None,
                "the program",
                "without a move",
                "a path needs one",
                "write G1, G2, G3 or G5",
            ));
        };
        JoinedPathBuilder::new(self.start_of(index), GAP).map_err(|source| self.curve_error(first.line, source))
    }

    /// Appends one move to a path.
    pub(crate) fn append(&self, path: &mut JoinedPathBuilder, step: &GcodeMove) -> Result<(), InputError> {
        append(path, step).map_err(|source| match source {
            GeometryError::PieceTooShort { .. } if matches!(step.kind, MoveKind::RotaryFeed { .. }) => {
                let rule = "along a path the tool moves while it turns";
                let remedy = "turn the axes during a move of the tool";
                self.wrong(Some(step.line), "the move", "rotary axes alone", rule, remedy)
            }
            source => self.curve_error(step.line, source),
        })
    }

    /// The error of a shape in a line.
    pub(crate) fn curve_error(&self, line: u64, source: GeometryError) -> InputError {
        InputError::Curve { file: self.file.clone(), key: format!("line {line}"), source }
    }

    /// The error of a value in the program.
    pub(crate) fn wrong(
        &self,
        line: Option<u64>,
        key: &str,
        value: &str,
        rule: &'static str,
        remedy: &'static str,
    ) -> InputError {
        let line = line.and_then(|line| usize::try_from(line).ok());
        InputError::Value { file: self.file.clone(), line, key: key.to_owned(), value: value.to_owned(), rule, remedy }
    }
}

fn append(path: &mut JoinedPathBuilder, step: &GcodeMove) -> Result<(), GeometryError> {
    let source = usize::try_from(step.line).unwrap_or(usize::MAX);
    match &step.shape {
        MoveShape::Line { to } => path.line_to(*to, source)?,
        MoveShape::Arc { centre, normal, sweep, to, .. } => {
            // A sweep of full turns ends where it starts, to rounding.
            let turns = (sweep.abs() / TAU - 1e-9).ceil().max(1.0) as u32 - 1;
            let normal = if *sweep < 0.0 { -*normal } else { *normal };
            path.helix(&ArcTo { centre: *centre, normal, end: *to, turns }, HELIX, source)?
        }
        MoveShape::Curve(curve) => path.curve_within(curve, STANDING, source)?,
    };
    Ok(())
}
