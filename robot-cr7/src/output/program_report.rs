//! The lines of a file along a motion: corners, marks, and the time of each line.

use arcfeed_geometry::KeptJoint;
use serde::Serialize;

use super::limit_table::line_words;
use crate::run::outline::{CornerLine, MarkerLine, Outline, OutlinePiece, Smoothed, Stop};
use crate::text::number;

/// What became of the corners of a program or a polyline, and where its codes stand in time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProgramReport {
    /// Runs of short lines that became smooth curves. A blend between two of them adds its own distance.
    pub smoothed: Smoothed,
    /// Corners and jumps of curvature that were blended.
    pub blended: usize,
    /// Largest distance of a blend from the programmed path that is possible, m.
    pub blend_deviation_m: f64,
    /// Corners in which the tool stops.
    pub stops: Vec<StopLine>,
    /// Codes that switch, wait or inform, with the time at which the tool is there.
    pub markers: Vec<MarkerLine>,
}

/// A corner in which the tool stops.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StopLine {
    /// The lines that meet there.
    pub lines: [usize; 2],
    /// The angle between them, rad.
    pub angle_rad: f64,
    /// Why it was not blended.
    pub why: &'static str,
}

/// One line of a file along a motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LineTime {
    /// The line of the file, or the two whose corner is blended. A line of a curve that stands for many ends at the place of the curve
    /// that is nearest to its end. A line that blends left nothing of has no length.
    pub line: String,
    /// The N word, where there is one.
    pub n: Option<u32>,
    /// Where it begins on the path, m.
    pub s_from_m: f64,
    /// Where it ends, m.
    pub s_to_m: f64,
    /// When it begins, s.
    pub t_from_s: f64,
    /// When it ends, s.
    pub t_to_s: f64,
    /// Programmed feed, m/s.
    pub feed_m_s: Option<f64>,
    /// How far a blend, or the curve that the line is a part of, can be from the programmed path, m; of a rapid move of the joints: the
    /// distance at which its end is passed.
    pub deviation_m: Option<f64>,
}

impl ProgramReport {
    /// The report of `outline` on a motion that is at the places `s` (m) at the times `t` (s).
    pub fn new(outline: &Outline, t: &[f64], s: &[f64]) -> Self {
        let markers = outline.markers.iter().cloned();
        let markers = markers.map(|m| MarkerLine { t_s: Some(time_at(t, s, m.s_m)), ..m });
        Self { markers: markers.collect(), ..Self::of_corners(outline) }
    }

    /// The report of several motions one after the other, with the codes between their lines.
    pub(crate) fn joined<'o>(outlines: impl Iterator<Item = &'o Outline>, markers: Vec<MarkerLine>) -> Self {
        let none = Self {
            smoothed: Smoothed::default(),
            blended: 0,
            blend_deviation_m: 0.0,
            stops: Vec::new(),
            markers: Vec::new(),
        };
        let mut whole = outlines.map(Self::of_corners).fold(none, |mut whole, one| {
            whole.smoothed.lines += one.smoothed.lines;
            whole.smoothed.curves += one.smoothed.curves;
            whole.smoothed.deviation_m = whole.smoothed.deviation_m.max(one.smoothed.deviation_m);
            whole.blended += one.blended;
            whole.blend_deviation_m = whole.blend_deviation_m.max(one.blend_deviation_m);
            whole.stops.extend(one.stops);
            whole
        });
        whole.markers = markers;
        whole
    }

    /// What became of the corners.
    fn of_corners(outline: &Outline) -> Self {
        let stop = |corner: &CornerLine| {
            let why = corner.blend.err()?;
            Some(StopLine { lines: corner.lines, angle_rad: corner.angle, why: reason(why) })
        };
        let deviations = || outline.corners.iter().filter_map(|corner| corner.blend.ok());
        Self {
            smoothed: outline.smoothed,
            blended: deviations().count(),
            blend_deviation_m: deviations().fold(0.0, f64::max),
            stops: outline.corners.iter().filter_map(stop).collect(),
            markers: Vec::new(),
        }
    }

    /// The report on one line.
    pub(crate) fn line(&self) -> String {
        let stops = match self.stops.as_slice() {
            [] => "no stop".to_owned(),
            [one] => format!("1 stop at line {}: {}", line_words(one.lines), one.why),
            [one, ..] => {
                format!("{} stops, the first at line {}: {}", self.stops.len(), line_words(one.lines), one.why)
            }
        };
        let Smoothed { lines, curves, deviation_m } = self.smoothed;
        let smooth = match lines {
            0 => String::new(),
            _ => format!("{lines} lines as {curves} curves within {} um; ", number(deviation_m * 1e6)),
        };
        match self.blended {
            0 => smooth + &stops,
            n => format!("{smooth}{n} blended within {} um; {stops}", number(self.blend_deviation_m * 1e6)),
        }
    }
}

/// The lines of a file with their times, in order.
pub fn line_times(outline: &Outline, t: &[f64], s: &[f64]) -> Vec<LineTime> {
    lines_from(outline, [0.0; 2], |place| time_at(t, s, place))
}

/// The same for a motion that begins at a place (m) and a time (s) of another one; `time` says when it is at a place of its own.
pub(crate) fn lines_from(outline: &Outline, from: [f64; 2], time: impl Fn(f64) -> f64) -> Vec<LineTime> {
    let lines = Vec::with_capacity(outline.pieces.len() + outline.inside.len());
    let mut rows = Rows { outline, from, at: from, time, lines };
    let mut corners = outline.corners.iter().filter_map(|corner| corner.blend.ok());
    let mut inside = outline.inside.iter().peekable();
    let mut before: Option<&OutlinePiece> = None;
    for piece in &outline.pieces {
        let swallowed = before.filter(|before| before.blend && piece.blend && before.lines[1] == piece.lines[0]);
        before = Some(piece);
        // Lines of a curve that blends left nothing of, or the line between two blends.
        let own = piece.lines[usize::from(piece.blend)];
        if let (Some(blend), false) = (swallowed, inside.peek().is_some_and(|end| end.line < own)) {
            rows.push([blend.lines[1]; 2], blend.to, blend.feed, None);
        }
        while let Some(end) = inside.next_if(|end| end.line < own) {
            rows.push([end.line; 2], end.s, end.feed, Some(end.deviation));
        }
        if piece.blend {
            rows.push(outline.ends_of(piece), piece.to, piece.feed, corners.next());
            continue;
        }
        if piece.lines[0] < piece.lines[1] {
            let mut last = None;
            while let Some(end) = inside.next_if(|end| end.line <= piece.lines[1] && end.s <= piece.to) {
                rows.push([end.line; 2], end.s, piece.feed, Some(end.deviation));
                last = Some(end.s);
            }
            let Some(rest) = inside.peek().filter(|end| end.line <= piece.lines[1] && last < Some(piece.to)) else {
                continue;
            };
            rows.push([rest.line; 2], piece.to, piece.feed, Some(rest.deviation));
            continue;
        }
        rows.push(piece.lines, piece.to, piece.feed, None);
    }
    rows.lines
}

/// Lines one after the other.
struct Rows<'o, T> {
    outline: &'o Outline,
    /// Place (m) and time (s) of the start.
    from: [f64; 2],
    /// Where the last line ends.
    at: [f64; 2],
    time: T,
    lines: Vec<LineTime>,
}

impl<T: Fn(f64) -> f64> Rows<'_, T> {
    /// Adds what ends at `to` (m) of the motion, to the row before where that is of the same lines.
    fn push(&mut self, lines: [usize; 2], to: f64, feed_m_s: Option<f64>, deviation_m: Option<f64>) {
        let line = line_words(lines);
        let [s_to_m, t_to_s] = [self.from[0] + to, self.from[1] + (self.time)(to)];
        match self.lines.last_mut().filter(|last| last.line == line) {
            Some(last) => (last.s_to_m, last.t_to_s) = (s_to_m, t_to_s),
            None => {
                let n = self.outline.number_of(lines[1]);
                let [s_from_m, t_from_s] = self.at;
                self.lines.push(LineTime { line, n, s_from_m, s_to_m, t_from_s, t_to_s, feed_m_s, deviation_m });
            }
        }
        self.at = [s_to_m, t_to_s];
    }
}

/// The time at which a motion is at `place` (m), between two samples as if its speed were constant there.
fn time_at(t: &[f64], s: &[f64], place: f64) -> f64 {
    let i = s.partition_point(|&at| at < place).clamp(1, s.len().saturating_sub(1).max(1));
    let (Some(&s0), Some(&s1), Some(&t0), Some(&t1)) = (s.get(i - 1), s.get(i), t.get(i - 1), t.get(i)) else {
        return 0.0;
    };
    if s1 > s0 { t0 + (t1 - t0) * ((place - s0) / (s1 - s0)).clamp(0.0, 1.0) } else { t1 }
}

fn reason(why: Stop) -> &'static str {
    match why {
        Stop::Asked => "the program says so (G61.1, G4)",
        Stop::Kept(KeptJoint::ExactStop) => "no tolerance to blend it within (G64 P, or path.blend_mm)",
        Stop::Kept(KeptJoint::Reversal) => "the path turns back",
        Stop::Kept(KeptJoint::NotCertified) => "no blend is certain to stay within the tolerance",
        Stop::Kept(KeptJoint::Smooth) => "smooth",
    }
}
