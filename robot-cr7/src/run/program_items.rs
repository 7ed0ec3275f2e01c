//! A program in parts that meet at rest: paths, rapid moves of the joints, and dwells.

use crate::input::error::InputError;
use crate::input::gcode::{GcodeMarker, GcodeProgram, MarkerKind, MoveKind};
use crate::input::rapid_moves::RapidKind;
use crate::text::number;

use super::stretch::Stretch;

/// All dwells of a program together take no longer, s: every control period has a sample.
const LONGEST_WAIT: f64 = 3600.0;

/// A part of a program.
#[derive(Debug, Clone)]
pub(crate) enum ProgramItem<'p> {
    /// Moves that are one path of the tool.
    Path(Stretch<'p>),
    /// Rapid moves that are one motion of the joints.
    Rapids(Stretch<'p>),
    /// The tool waits.
    Dwell(Wait),
}

/// A dwell, with the codes that stand right before and behind it.
#[derive(Debug, Clone)]
pub(crate) struct Wait {
    pub line: u64,
    /// s.
    pub seconds: f64,
    pub before: Vec<GcodeMarker>,
    pub after: Vec<GcodeMarker>,
}

/// The parts of a program from its first working move on, rapid moves as `rapid` says. A program of rapid moves alone is a path.
pub(crate) fn items(program: &GcodeProgram, rapid: RapidKind) -> Vec<ProgramItem<'_>> {
    let first = program.first_working_move();
    let works = program.moves.get(first).is_some_and(|step| step.kind != MoveKind::Rapid);
    let joints = rapid == RapidKind::Joints && works;
    let mut parts = Parts { program, items: Vec::new(), open: None, early: Vec::new() };
    let mut markers = program.markers.iter().peekable();
    for index in first..=program.moves.len() {
        while let Some(marker) = markers.next_if(|marker| marker.after <= index) {
            parts.mark(marker, index);
        }
        if let Some(step) = program.moves.get(index) {
            parts.step(index, joints && step.kind == MoveKind::Rapid);
        }
    }
    parts.close(program.moves.len());
    parts.items
}

/// Refuses a program that waits for too long.
pub(crate) fn check_waits(program: &GcodeProgram) -> Result<(), InputError> {
    let mut waited = 0.0;
    for marker in &program.markers {
        let MarkerKind::Dwell { seconds } = marker.kind else { continue };
        waited += seconds;
        // Not `>`: a NaN has to show.
        let short = waited <= LONGEST_WAIT;
        if !short {
            let value = format!("{} s, which makes {} s in all", number(seconds), number(waited));
            let rule = "the tool waits 3600 s in all at most, because every control period has a sample";
            return Err(program.wrong(Some(marker.line), "G4", &value, rule, "wait less, or split the program"));
        }
    }
    Ok(())
}

/// The parts as they are found.
struct Parts<'p> {
    program: &'p GcodeProgram,
    items: Vec<ProgramItem<'p>>,
    /// The part that goes on: whether it is one of rapid moves, its first move, and its codes.
    open: Option<(bool, usize, Vec<GcodeMarker>)>,
    /// Codes before the first part.
    early: Vec<GcodeMarker>,
}

impl Parts<'_> {
    /// A code before the move `index`.
    fn mark(&mut self, marker: &GcodeMarker, index: usize) {
        if let MarkerKind::Dwell { seconds } = &marker.kind {
            self.close(index);
            let before = std::mem::take(&mut self.early);
            let wait = Wait { line: marker.line, seconds: *seconds, before, after: Vec::new() };
            self.items.push(ProgramItem::Dwell(wait));
            return;
        }
        let marker = marker.clone();
        match (&mut self.open, self.items.last_mut()) {
            (Some((.., markers)), _) => markers.push(marker),
            (None, Some(ProgramItem::Dwell(wait))) => wait.after.push(marker),
            _ => self.early.push(marker),
        }
    }

    /// The move `index`, which is one of the joints where `joints` says so.
    fn step(&mut self, index: usize, joints: bool) {
        if self.open.as_ref().is_some_and(|open| open.0 != joints) {
            self.close(index);
        }
        if self.open.is_none() {
            self.open = Some((joints, index, std::mem::take(&mut self.early)));
        }
    }

    /// Ends the part that goes on before the move `index`.
    fn close(&mut self, index: usize) {
        let Some((joints, first, markers)) = self.open.take() else { return };
        let stretch = Stretch { program: self.program, range: first..index, markers };
        self.items.push(if joints { ProgramItem::Rapids(stretch) } else { ProgramItem::Path(stretch) });
    }
}
