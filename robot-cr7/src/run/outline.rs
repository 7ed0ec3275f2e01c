//! Where the lines of a file lie on a path, and what became of its corners.

use arcfeed_geometry::KeptJoint;
use serde::Serialize;

/// The lines of a file along a path, by arc length in m.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub(crate) pieces: Vec<OutlinePiece>,
    pub(crate) corners: Vec<CornerLine>,
    pub(crate) markers: Vec<MarkerLine>,
    /// N words by line.
    pub(crate) numbers: Vec<(usize, u32)>,
    pub(crate) smoothed: Smoothed,
    /// Ends of the lines that curves stand for.
    pub(crate) inside: Vec<LineEnd>,
}

/// The end of a line that a curve stands for, one of several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineEnd {
    /// The place of the curve that is nearest to it, m.
    pub s: f64,
    pub line: usize,
    /// Programmed feed, m/s.
    pub feed: Option<f64>,
    /// Largest distance of the curve from its lines that is possible, m.
    pub deviation: f64,
}

/// Runs of short lines that became smooth curves.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Smoothed {
    /// Number of lines.
    pub lines: usize,
    /// Number of curves that stand for them.
    pub curves: usize,
    /// Largest distance of a curve from its lines that is possible, m.
    pub deviation_m: f64,
}

/// A piece of the path, which begins where the one before it ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OutlinePiece {
    /// Its end, m.
    pub to: f64,
    /// The first and last line that it stands for, or the lines that a blend joins.
    pub lines: [usize; 2],
    pub blend: bool,
    /// Programmed feed, m/s.
    pub feed: Option<f64>,
}

/// A corner of the programmed path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CornerLine {
    /// The lines that meet there: of a curve that stands for many, the last or the first.
    pub lines: [usize; 2],
    /// rad.
    pub angle: f64,
    /// By how much its blend deviates at most, m, or why the tool stops there.
    pub blend: Result<f64, Stop>,
}

/// Why the tool stops in a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stop {
    /// The file says so.
    Asked,
    /// It could not be blended.
    Kept(KeptJoint),
}

/// A code between moves that switches, waits or informs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MarkerLine {
    /// The line of the file.
    pub line: u64,
    /// The place on the path, m.
    pub s_m: f64,
    /// The time at which the tool is there, s.
    pub t_s: Option<f64>,
    /// The code.
    pub what: String,
}

impl Outline {
    /// The first and last line of the file that belong to the arc length `s` (m): mostly the same one; on a blend the lines that it joins.
    /// In a curve that stands for many lines it is the one whose end is the next one.
    pub fn lines_at(&self, s: f64) -> [usize; 2] {
        let Some(piece) = self.piece_at(s) else { return [0; 2] };
        if let Some(line) = self.line_inside(piece, s) {
            return [line; 2];
        }
        self.ends_of(piece)
    }

    /// The first and the last line of a piece; of a blend behind a curve the last line of that.
    pub(crate) fn ends_of(&self, piece: &OutlinePiece) -> [usize; 2] {
        let [from, to] = piece.lines;
        let before = self.inside.partition_point(|end| end.line < to).checked_sub(1).map(|i| self.inside[i].line);
        [before.filter(|&line| piece.blend && line > from).unwrap_or(from), to]
    }

    /// The line at a place of a curve that stands for several.
    fn line_inside(&self, piece: &OutlinePiece, s: f64) -> Option<usize> {
        let [from, to] = piece.lines;
        if piece.blend || from == to {
            return None;
        }
        let i = self.inside.partition_point(|end| end.s < s);
        self.inside.get(i).or(self.inside.last()).map(|end| end.line.clamp(from, to))
    }

    /// The first and the last line.
    pub(crate) fn ends(&self) -> [usize; 2] {
        let first = self.pieces.first().map_or(0, |piece| piece.lines[0]);
        [first, self.pieces.last().map_or(first, |piece| piece.lines[1])]
    }

    fn piece_at(&self, s: f64) -> Option<&OutlinePiece> {
        let i = self.pieces.partition_point(|piece| piece.to < s);
        self.pieces.get(i).or(self.pieces.last())
    }

    /// The N word of a line.
    pub(crate) fn number_of(&self, line: usize) -> Option<u32> {
        self.numbers.binary_search_by_key(&line, |n| n.0).ok().map(|i| self.numbers[i].1)
    }

    /// The same in words, to follow a message: with the N word where there is one.
    pub(crate) fn words_at(&self, s: f64) -> String {
        let Some(piece) = self.piece_at(s) else {
            return String::new();
        };
        let (OutlinePiece { lines: [from, to], blend, .. }, inside) = (*piece, self.line_inside(piece, s));
        let number = self.number_of(to).map(|n| format!(" (N{n})")).unwrap_or_default();
        match (from == to, blend) {
            (true, _) => format!("; that is at line {to}{number}"),
            (false, true) => format!("; that is in the blend between lines {from} and {to}{number}"),
            (false, false) => {
                let line = inside.map_or(String::new(), |line| format!("near line {line}, "));
                format!("; that is {line}in the curve through lines {from} to {to}{number}")
            }
        }
    }
}
