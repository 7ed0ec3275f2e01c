//! Moves of a program that are one path.

use std::ops::Range;

use nalgebra::Vector3;

use crate::input::gcode::{GcodeMarker, GcodeMove, GcodeProgram, MarkerKind};

/// Consecutive moves of a program that the tool makes as one path, with the codes between them.
#[derive(Debug, Clone)]
pub(crate) struct Stretch<'p> {
    pub program: &'p GcodeProgram,
    /// Indices of its moves.
    pub range: Range<usize>,
    pub markers: Vec<GcodeMarker>,
}

impl<'p> Stretch<'p> {
    /// All moves from the first one that is not rapid on.
    pub fn whole(program: &'p GcodeProgram) -> Self {
        let range = program.first_working_move()..program.moves.len();
        Self { program, range, markers: program.markers.clone() }
    }

    pub fn moves(&self) -> &'p [GcodeMove] {
        &self.program.moves[self.range.clone()]
    }

    /// Positions of the rotary axes where it starts, rad.
    pub fn start_rotary(&self) -> Option<Vector3<f64>> {
        self.range.start.checked_sub(1).and_then(|before| self.program.moves[before].rotary)
    }

    /// Index of the last move before a code, among the moves of the stretch; `None` at its start.
    pub fn move_before(&self, marker: &GcodeMarker) -> Option<usize> {
        marker.after.checked_sub(self.range.start + 1)
    }

    /// The number of its moves before each dwell.
    pub fn dwells(&self) -> impl Iterator<Item = usize> + '_ {
        let rests = self.markers.iter().filter(|m| matches!(m.kind, MarkerKind::Dwell { .. }));
        rests.map(|m| m.after.saturating_sub(self.range.start))
    }
}
