//! Codes between the parts of a program.

use super::outline::MarkerLine;
use super::program_items::Wait;
use super::programmed::words;
use super::stretch::Stretch;
use crate::input::gcode::{GcodeMarker, MarkerKind};

/// Codes of one part of a program that is no path.
#[derive(Debug, Clone, Default)]
pub(crate) struct Marks {
    /// Each with the number of moves of the part that are done before it.
    marks: Vec<(usize, MarkerLine)>,
}

impl Marks {
    /// Codes between rapid moves.
    pub fn of_run(stretch: &Stretch<'_>) -> Self {
        let done = |marker: &GcodeMarker| stretch.move_before(marker).map_or(0, |before| before + 1);
        Self { marks: stretch.markers.iter().map(|marker| (done(marker), line_of(marker))).collect() }
    }

    /// A dwell and the codes beside it: those behind it count as done after one move.
    pub fn of_wait(wait: &Wait) -> Self {
        let kind = MarkerKind::Dwell { seconds: wait.seconds };
        let own = MarkerLine { line: wait.line, s_m: 0.0, t_s: None, what: words(&kind) };
        let before = wait.before.iter().map(|marker| (0, line_of(marker)));
        let after = wait.after.iter().map(|marker| (1, line_of(marker)));
        Self { marks: before.chain([(0, own)]).chain(after).collect() }
    }

    /// The codes at their times (s) and places (m); `at` says when and where so many moves of the part are done.
    pub fn placed(&self, at: impl Fn(usize) -> (f64, f64)) -> Vec<MarkerLine> {
        let place = |(done, mark): &(usize, MarkerLine)| {
            let (t, s_m) = at(*done);
            MarkerLine { s_m, t_s: Some(t), ..mark.clone() }
        };
        self.marks.iter().map(place).collect()
    }
}

fn line_of(marker: &GcodeMarker) -> MarkerLine {
    MarkerLine { line: marker.line, s_m: 0.0, t_s: None, what: words(&marker.kind) }
}
