//! A program or a polyline as a path with blended corners and the feeds of its lines.

use std::path::Path;

use arcfeed_geometry::{
    ArcLengthCurve, Blending, GeometryError, JoinedPath, JoinedPathBuilder, Joint, JointOutcome, PathPiece, PieceKind,
};
use arcfeed_interp::{Extent, FeedSection};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::dense_lines::{self, CurveLine, MoveRange};
use super::error::Cr7Error;
use super::feed_notes::FeedNotes;
use super::outline::{CornerLine, LineEnd, MarkerLine, Outline, OutlinePiece, Smoothed, Stop};
use super::stretch::Stretch;
use crate::input::error::InputError;
use crate::input::gcode::{GcodeMove, GcodeProgram, MarkerKind, MoveKind, PathControl};
use crate::input::job::Job;
use crate::input::path_file::PathFile;
use crate::input::rapid_moves::RapidKind;
use crate::text::number;

/// Blends of a program that asks for them (G64) and states no tolerance, where the job does not either, m.
const UNSTATED_BLEND: f64 = 1e-4;
/// A joint with a smaller angle is no corner, rad.
const CORNER: f64 = 1e-6;
/// Ends of the lines of a polyline may be off by rounding, m.
const GAP: f64 = 1e-9;

/// One line of the file.
#[derive(Debug, Clone, Copy)]
struct Step {
    line: usize,
    /// The last line of a curve that takes the place of several.
    last: usize,
    number: Option<u32>,
    /// m/s, where the file states one.
    feed: Option<f64>,
    /// Tolerance of the joint at its end, m.
    tolerance: f64,
    /// The tool stops at its end, even where the path is smooth.
    stop: bool,
}

/// A code between moves.
struct Mark {
    /// Index of the step that it belongs to, and the line before it.
    place: Option<(usize, usize)>,
    line: u64,
    what: String,
}

/// A path from lines of a file, with blends in place of its corners.
pub(crate) struct Programmed {
    steps: Vec<Step>,
    pub path: JoinedPath,
    joints: Vec<(Joint, JointOutcome)>,
    /// Turns of the tool by rotary axes: at the start, then at the end of each line.
    pub turns: Option<Vec<UnitQuaternion<f64>>>,
    marks: Vec<Mark>,
    smoothed: Smoothed,
    /// Lines that curves stand for.
    inside: Vec<CurveLine>,
    pub notes: FeedNotes,
    pub warnings: Vec<String>,
}

impl Programmed {
    /// The working moves of a program as one path, rapid moves included.
    pub fn of_program(program: &GcodeProgram, job: &Job) -> Result<Self, Cr7Error> {
        let stretch = Stretch::whole(program);
        let mut programmed = Self::of_stretch(&stretch, job)?;
        let warnings = &mut programmed.warnings;
        let rests = stretch.dwells().count();
        if rests > 0 {
            warnings.push(format!("the tool stops at {rests} dwells (G4), but the motion does not wait there: the times are marks in the report"));
        }
        if job.rapid.kind == RapidKind::Joints && stretch.moves().iter().any(|step| step.kind == MoveKind::Rapid) {
            warnings
                .push("rapid moves are straight lines here: feed.rapid = \"joints\" counts in `cr7 plan`".to_owned());
        }
        warnings.extend(skipped_words(program));
        Ok(programmed)
    }

    /// Moves of a program: blends where it says G64, or where the job gives a tolerance and the program says nothing.
    pub fn of_stretch(stretch: &Stretch<'_>, job: &Job) -> Result<Self, Cr7Error> {
        let program = stretch.program;
        if !job.sections.is_empty() {
            let rule = "a program states its own feeds (F)";
            return Err(program.wrong(None, "[[sections]] of the job", "given", rule, "remove the sections").into());
        }
        let moves = stretch.moves();
        let (programmed, units) = dense_lines::joined(stretch, job)?;
        let (steps, notes) = steps(stretch, &units, &programmed, job);
        let marks = stretch.markers.iter().map(|m| Mark {
            place: stretch.move_before(m).map(|before| place_of(before, &units, moves)),
            line: m.line,
            what: words(&m.kind),
        });
        let marks = marks.collect();
        let warnings = standing_curves(&programmed).into_iter().collect();
        let blended = blend(&programmed, &steps).map_err(|source| curve_error(&program.file, source))?;
        Ok(Self {
            steps,
            path: blended.path,
            joints: blended.joints,
            turns: turns(stretch, &units),
            marks,
            smoothed: smoothed(&units),
            inside: dense_lines::curve_lines(&units, moves),
            notes,
            warnings,
        })
    }

    /// The lines through `points`, each with its line in the file.
    pub fn of_polyline(file: &PathFile, points: &[Vector3<f64>], lines: &[u64], job: &Job) -> Result<Self, Cr7Error> {
        let error = |source| curve_error(&file.file, source);
        let (start, rest) = points.split_first().ok_or_else(|| error(GeometryError::EmptyPath))?;
        let mut path = JoinedPathBuilder::new(*start, GAP).map_err(error)?;
        let tolerance = job.blend.unwrap_or(0.0);
        let mut steps = Vec::with_capacity(rest.len());
        for (point, &line) in rest.iter().zip(lines.iter().skip(1)) {
            let line = usize::try_from(line).unwrap_or(usize::MAX);
            path.line_to(*point, line).map_err(error)?;
            steps.push(Step { line, last: line, number: None, feed: None, tolerance, stop: false });
        }
        let blended = blend(&path.build().map_err(error)?, &steps).map_err(error)?;
        let (path, joints) = (blended.path, blended.joints);
        let (marks, warnings, smoothed) = (Vec::new(), Vec::new(), Smoothed::default());
        let (notes, inside) = (FeedNotes::default(), Vec::new());
        Ok(Self { steps, path, joints, turns: None, marks, smoothed, inside, notes, warnings })
    }

    /// The feeds along the path: those of the program, else those of the job.
    pub fn sections(&self, job: &Job) -> Vec<FeedSection> {
        let mut sections: Vec<(f64, f64, f64)> = Vec::new();
        for piece in self.path.pieces() {
            let feeds = piece.sources.map(|line| self.step(line).and_then(|step| step.feed));
            let [Some(before), Some(after)] = feeds else { return job.sections.clone() };
            let feed = before.min(after);
            match sections.last_mut() {
                Some(last) if last.2 == feed => last.1 = piece.end,
                _ => sections.push((piece.start, piece.end, feed)),
            }
        }
        let section = |(from, to, feed)| FeedSection { extent: Extent::Parameter { from, to }, feed };
        sections.into_iter().map(section).collect()
    }

    /// Where the lines of the file lie on the path, by arc length. `workpiece` leads from the file to the path.
    pub fn outline(&self, curve: &ArcLengthCurve<3>, workpiece: &Isometry3<f64>) -> Outline {
        let piece = |piece: &PathPiece| {
            let (blend, [first, second]) = (piece.kind == PieceKind::Blend, piece.sources);
            let step = self.step(second);
            OutlinePiece {
                to: curve.arc_length_at(piece.end),
                lines: if blend { [first, second] } else { [first, step.map_or(first, |step| step.last)] },
                blend,
                feed: step.and_then(|step| step.feed),
            }
        };
        let pieces: Vec<OutlinePiece> = self.path.pieces().iter().map(piece).collect();
        let mut inside: Vec<LineEnd> = Vec::with_capacity(self.inside.len());
        for lines in self.inside.chunk_by(|a, b| a.curve == b.curve) {
            let ends = dense_lines::ends_along(lines, curve_range(&pieces, lines[0].curve), curve, workpiece);
            let feed = self.step(lines[0].curve).and_then(|step| step.feed);
            let ends = ends.into_iter().zip(lines);
            inside.extend(ends.map(|(s, line)| LineEnd { s, line: line.line, feed, deviation: line.deviation }));
        }
        let end_of = |(i, line): (usize, usize)| {
            let step = self.steps.get(i)?;
            let within = inside.binary_search_by_key(&line, |end| end.line).ok().filter(|_| line < step.last);
            Some(within.map_or_else(|| end_of_line(&pieces, step.line), |k| inside[k].s))
        };
        let markers = self.marks.iter().map(|mark| {
            let s_m = mark.place.and_then(end_of).unwrap_or(0.0);
            MarkerLine { line: mark.line, s_m, t_s: None, what: mark.what.clone() }
        });
        let markers = markers.collect();
        let corner = |(joint, outcome): &(Joint, JointOutcome)| {
            let ([first, second], angle) = (joint.sources, joint.angle);
            let before = self.step(first).filter(|_| first != second);
            let lines = [before.map_or(first, |step| step.last), second];
            let asked = before.is_some_and(|step| step.stop);
            match outcome {
                JointOutcome::Kept(_) if asked => Some(CornerLine { lines, angle, blend: Err(Stop::Asked) }),
                JointOutcome::Kept(_) if angle < CORNER => None,
                JointOutcome::Kept(why) => Some(CornerLine { lines, angle, blend: Err(Stop::Kept(*why)) }),
                JointOutcome::Blended { deviation, .. } => Some(CornerLine { lines, angle, blend: Ok(*deviation) }),
            }
        };
        let corners = self.joints.iter().filter_map(corner).collect();
        let of_steps = self.steps.iter().map(|step| (step.line, step.number));
        let of_curves = self.inside.iter().map(|line| (line.line, line.number));
        let mut numbers: Vec<(usize, u32)> =
            of_steps.chain(of_curves).filter_map(|(line, n)| Some((line, n?))).collect();
        numbers.sort_unstable();
        numbers.dedup();
        Outline { markers, pieces, corners, numbers, smoothed: self.smoothed, inside }
    }

    /// Where the tool stops because the file says so, by arc length.
    pub fn stops(&self, curve: &ArcLengthCurve<3>) -> Vec<f64> {
        let asked = |piece: &PathPiece, next: Option<&PathPiece>| {
            let line = piece.sources[1];
            self.step(line).is_some_and(|step| step.stop) && next.is_some_and(|next| next.sources[0] != line)
        };
        let pieces = self.path.pieces();
        let ends = pieces.iter().enumerate().filter(|(i, piece)| asked(piece, pieces.get(i + 1)));
        ends.map(|(_, piece)| curve.arc_length_at(piece.end)).collect()
    }

    /// That both the job and the file turn the tool.
    pub fn turns_twice(file: &Path) -> InputError {
        InputError::Value {
            file: file.to_owned(),
            line: None,
            key: "the orientation of the job".to_owned(),
            value: "one that changes along the path".to_owned(),
            rule: "a file with rotary axes (A, B, C) or with columns of the tool turns the tool itself",
            remedy: "set orientation.mode = \"constant\"",
        }
    }

    /// The highest feed of a line, m/s, where the file states some.
    pub fn highest_feed(&self) -> Option<f64> {
        self.steps.iter().filter_map(|step| step.feed).reduce(f64::max)
    }

    fn step(&self, line: usize) -> Option<&Step> {
        step_of(&self.steps, line)
    }
}

/// Lines of a file only go up.
fn step_of(steps: &[Step], line: usize) -> Option<&Step> {
    steps.binary_search_by_key(&line, |step| step.line).ok().map(|i| &steps[i])
}

fn blend(path: &JoinedPath, steps: &[Step]) -> Result<arcfeed_geometry::BlendedPath, GeometryError> {
    path.blended_by(|joint| Blending::within(step_of(steps, joint.sources[0]).map_or(0.0, |step| step.tolerance)))
}

fn curve_error(file: &Path, source: GeometryError) -> Cr7Error {
    Cr7Error::Curve { file: file.display().to_string(), source }
}

/// What is said of the rapid moves before the first working move.
pub(crate) fn skipped_words(program: &GcodeProgram) -> Option<String> {
    let skipped = program.first_working_move();
    let first = program.moves.get(skipped).filter(|_| skipped > 0)?;
    Some(format!("the motion begins at line {}: the {skipped} rapid moves before it lead to its start", first.line))
}

/// The piece that stands for the move `before`, by index, and the line of that move.
fn place_of(before: usize, units: &[MoveRange], moves: &[GcodeMove]) -> (usize, usize) {
    let i = units.partition_point(|unit| unit.last < before).min(units.len().saturating_sub(1));
    (i, moves.get(before).map_or(usize::MAX, |step| usize::try_from(step.line).unwrap_or(usize::MAX)))
}

/// End of a line on the path, m, with the blend behind it. Lines only go up along the path.
fn end_of_line(pieces: &[OutlinePiece], line: usize) -> f64 {
    end_before(pieces, pieces.partition_point(|piece| piece.lines[0] <= line))
}

/// Start and end on the path of the curve that begins with a line, m, without the blends at its ends; the same where blends left none
/// of it.
fn curve_range(pieces: &[OutlinePiece], line: usize) -> (f64, f64) {
    let begin = pieces.partition_point(|piece| piece.lines[0] < line);
    let own = pieces[begin..].iter().take_while(|piece| piece.lines[0] == line).count();
    let last = pieces[begin..begin + own].iter().rposition(|piece| !piece.blend).map_or(begin, |i| begin + i + 1);
    (end_before(pieces, begin), end_before(pieces, last))
}

/// Where the piece before another one ends, m.
fn end_before(pieces: &[OutlinePiece], i: usize) -> f64 {
    i.checked_sub(1).and_then(|i| pieces.get(i)).map_or(0.0, |piece| piece.to)
}

/// Feed and tolerance of each piece. The feed of a working move is at most that of the job.
fn steps(stretch: &Stretch<'_>, units: &[MoveRange], path: &JoinedPath, job: &Job) -> (Vec<Step>, FeedNotes) {
    let moves = stretch.moves();
    let mut dwells = stretch.dwells().peekable();
    let mut notes = FeedNotes::default();
    let mut pieces = path.pieces().iter().peekable();
    let mut steps = Vec::with_capacity(units.len());
    let line_of = |i: usize| usize::try_from(moves[i].line).unwrap_or(usize::MAX);
    for &MoveRange { first, last, .. } in units {
        let (step, line) = (&moves[first], line_of(first));
        let mut length = 0.0;
        while let Some(piece) = pieces.next_if(|piece| piece.sources[0] == line) {
            length += piece.length;
        }
        let speed = match step.kind {
            MoveKind::Rapid => job.rapid.speed.unwrap_or(job.feed.feed),
            MoveKind::Feed { speed } => speed,
            MoveKind::InverseTime { seconds } => length / seconds,
            // Refused before: the tool rests.
            MoveKind::RotaryFeed { .. } => job.feed.feed,
        };
        let most = if step.kind == MoveKind::Rapid { speed } else { job.feed.feed };
        if speed > most * (1.0 + 1e-12) {
            notes.held_to_feed(line, speed);
        }
        let tolerance = match step.control {
            None => job.blend.unwrap_or(0.0),
            Some(PathControl::ExactPath | PathControl::ExactStop) => 0.0,
            Some(PathControl::Blend { tolerance: Some(tolerance), .. }) => tolerance,
            Some(PathControl::Blend { tolerance: None, .. }) => {
                if job.blend.is_none() {
                    notes.unstated_tolerance(line);
                }
                job.blend.unwrap_or(UNSTATED_BLEND)
            }
        };
        let feed = Some(speed.min(most));
        while dwells.next_if(|&after| after <= last).is_some() {}
        let stop = step.control == Some(PathControl::ExactStop) || dwells.peek() == Some(&(last + 1));
        let tolerance = if stop { 0.0 } else { tolerance };
        steps.push(Step { line, last: line_of(last), number: step.number, feed, tolerance, stop });
    }
    (steps, notes)
}

/// That curves are replaced where they stand still.
fn standing_curves(path: &JoinedPath) -> Option<String> {
    let replaced = || path.pieces().iter().filter(|piece| piece.kind == PieceKind::Curve && piece.deviation > 0.0);
    let line = replaced().next()?.sources[0];
    let most = replaced().map(|piece| piece.deviation).fold(0.0, f64::max);
    let most = number(most * 1e6);
    Some(format!(
        "control points of curves coincide, first at line {line}, where the curvature has no bound: short stretches there are replaced within {most} um"
    ))
}

/// What became of runs of short lines.
fn smoothed(units: &[MoveRange]) -> Smoothed {
    let curves = || units.iter().filter(|unit| unit.last > unit.first);
    Smoothed {
        lines: curves().map(|unit| unit.last - unit.first + 1).sum(),
        curves: curves().count(),
        deviation_m: curves().map(|unit| unit.deviation).fold(0.0, f64::max),
    }
}

/// What the rotary axes make of the tool: a turn by A about x, then by B about y, then by C about z.
fn turns(stretch: &Stretch<'_>, units: &[MoveRange]) -> Option<Vec<UnitQuaternion<f64>>> {
    let moves = stretch.moves();
    moves.iter().any(|step| step.rotary.is_some()).then(|| {
        let ends = units.iter().map(|unit| moves[unit.last].rotary);
        std::iter::once(stretch.start_rotary()).chain(ends).map(turn_of).collect()
    })
}

/// The turn of the tool by rotary axes, in the workpiece frame.
pub(crate) fn turn_of(rotary: Option<Vector3<f64>>) -> UnitQuaternion<f64> {
    let a = rotary.unwrap_or_default();
    UnitQuaternion::from_euler_angles(a.x, a.y, a.z)
}

/// A code in words.
pub(crate) fn words(kind: &MarkerKind) -> String {
    match kind {
        MarkerKind::Code(code) => code.clone(),
        MarkerKind::SpindleSpeed(speed) => format!("S{}", number(*speed)),
        MarkerKind::Tool(tool) => format!("T{tool}"),
        MarkerKind::Message(text) => text.clone(),
        MarkerKind::Dwell { seconds } => format!("dwell of {} s", number(*seconds)),
    }
}
