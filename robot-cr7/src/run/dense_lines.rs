//! Runs of short lines in a program, as smooth curves.

use arcfeed_geometry::{
    ArcLengthCurve, DenseFit, FittedStretch, GeometryError, JoinedPath, JoinedPathBuilder, StretchShape,
};
use nalgebra::{Isometry3, Vector3};

use super::error::Cr7Error;
use super::stretch::Stretch;
use crate::input::gcode::{GcodeMove, GcodeProgram, MoveKind, MoveShape, PathControl};
use crate::input::job::Job;
use crate::input::path_file::MOST_CONTROL_POINTS;

/// Fewer lines than these are no run: each is a line of its own.
const LEAST_LINES: usize = 12;

/// Steps towards the nearest place of a curve; the deviation is small against the radius of curvature, and three do.
const MOST_STEPS: usize = 12;
/// The nearest place is found to this, m.
const SAME_PLACE: f64 = 1e-12;

/// The number of moves from the first of `moves` on that are lines of one feed, to be passed within one tolerance (m), with that tolerance.
pub(crate) fn run(moves: &[GcodeMove], unstated: Option<f64>) -> Option<(usize, f64)> {
    let first = moves.first()?;
    let tolerance = tolerance_of(first, unstated)?;
    let same = |step: &&GcodeMove| step.kind == first.kind && tolerance_of(step, unstated) == Some(tolerance);
    let count = moves.iter().take_while(same).count();
    (count >= LEAST_LINES).then_some((count, tolerance))
}

/// The tolerance within which lines may be merged (Q of G64, or that of the job where the program says nothing).
fn tolerance_of(step: &GcodeMove, unstated: Option<f64>) -> Option<f64> {
    let naive = match step.control {
        None => unstated?,
        Some(PathControl::Blend { naive, .. }) => naive,
        Some(PathControl::ExactPath | PathControl::ExactStop) => return None,
    };
    let line = matches!((step.kind, &step.shape), (MoveKind::Feed { .. }, MoveShape::Line { .. }));
    (line && step.rotary.is_none() && naive > 0.0).then_some(naive)
}

/// A piece that takes the place of moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MoveRange {
    /// Its first move, by index.
    pub first: usize,
    /// Its last one.
    pub last: usize,
    /// Largest distance from the lines of these moves that is possible, m; 0 for a move of its own.
    pub deviation: f64,
}

/// The moves as one path, runs of short lines as smooth curves where the program permits. What each piece that was appended stands
/// for.
pub(crate) fn joined(stretch: &Stretch<'_>, job: &Job) -> Result<(JoinedPath, Vec<MoveRange>), Cr7Error> {
    let (program, moves) = (stretch.program, stretch.moves());
    let mut path = program.begin(stretch.range.start)?;
    let mut units = Vec::with_capacity(moves.len());
    let mut at = 0;
    // A curve does not go on through a dwell.
    let mut dwells = stretch.dwells().peekable();
    while at < moves.len() {
        few_enough(program, &moves[at], units.len())?;
        while dwells.next_if(|&after| after <= at).is_some() {}
        let ahead = &moves[at..dwells.peek().map_or(moves.len(), |&after| after.min(moves.len()))];
        if let Some((count, tolerance)) = run(ahead, job.smooth.or(job.blend)) {
            let curves = append_smooth(&mut path, &moves[at..at + count], tolerance);
            let curves = curves.map_err(|source| program.curve_error(moves[at].line, source))?;
            units.extend(curves.into_iter().map(|unit| MoveRange {
                first: at + unit.first,
                last: at + unit.last,
                ..unit
            }));
            at += count;
        } else {
            program.append(&mut path, &moves[at])?;
            units.push(MoveRange { first: at, last: at, deviation: 0.0 });
            at += 1;
        }
    }
    Ok((path.build().map_err(|source| program.curve_error(0, source))?, units))
}

/// Refuses a path with more pieces than it may have control points, before it is stored as a whole.
fn few_enough(program: &GcodeProgram, step: &GcodeMove, pieces: usize) -> Result<(), Cr7Error> {
    if pieces < MOST_CONTROL_POINTS {
        return Ok(());
    }
    let (value, rule) = (format!("longer than {pieces} pieces"), "a path has at most 25000 control points");
    let remedy = "state a tolerance for short lines (Q of G64, or path.smooth_mm of the job), or split the program";
    Err(program.wrong(Some(step.line), "the path up to here", &value, rule, remedy).into())
}

/// A line that a curve stands for, one of several.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurveLine {
    /// The first line of the curve.
    pub curve: usize,
    pub line: usize,
    pub number: Option<u32>,
    /// Its end in the workpiece, m.
    pub end: Vector3<f64>,
    /// Largest distance of the curve from its lines that is possible, m.
    pub deviation: f64,
}

/// The lines of all curves in their order.
pub(crate) fn curve_lines(units: &[MoveRange], moves: &[GcodeMove]) -> Vec<CurveLine> {
    let line_of = |step: &GcodeMove| usize::try_from(step.line).unwrap_or(usize::MAX);
    let lines = units.iter().filter(|unit| unit.last > unit.first).flat_map(|unit| {
        let (curve, deviation) = (line_of(&moves[unit.first]), unit.deviation);
        let own = &moves[unit.first..=unit.last];
        own.iter().map(move |step| CurveLine {
            curve,
            line: line_of(step),
            number: step.number,
            end: step.end(),
            deviation,
        })
    });
    lines.collect()
}

/// Where the lines of one curve end, by arc length of `path` between `from` and `to`: at the place that is nearest to the end of the
/// line, and no earlier than the line before. The last one ends in `to`. `workpiece` leads from the lines to the path.
pub(crate) fn ends_along(
    lines: &[CurveLine],
    (from, to): (f64, f64),
    path: &ArcLengthCurve<3>,
    workpiece: &Isometry3<f64>,
) -> Vec<f64> {
    let mut ends = Vec::with_capacity(lines.len());
    let (mut at, mut before) = (from, path.point(from));
    for line in lines {
        let point = workpiece.transform_point(&line.end.into()).coords;
        let mut place = (at + (point - before).norm()).min(to);
        for _ in 0..MOST_STEPS {
            let jet = path.jet(place);
            let next = (place + (point - jet.point).dot(&jet.d1)).max(at).min(to);
            let step = (next - place).abs();
            place = next;
            if step <= SAME_PLACE {
                break;
            }
        }
        ends.push(place);
        (at, before) = (place, point);
    }
    if let Some(last) = ends.last_mut() {
        *last = to;
    }
    ends
}

/// Appends smooth curves along the lines of `moves` to `path`, within `tolerance` (m) of them.
pub(crate) fn append_smooth(
    path: &mut JoinedPathBuilder,
    moves: &[GcodeMove],
    tolerance: f64,
) -> Result<Vec<MoveRange>, GeometryError> {
    let mut fit = DenseFit::<3>::new(tolerance)?;
    let mut curves = Vec::new();
    let mut take = |fit: &mut DenseFit<3>, path: &mut JoinedPathBuilder| -> Result<(), GeometryError> {
        while let Some(stretch) = fit.next_stretch() {
            let (first, last) = (stretch.first, stretch.last.saturating_sub(1).max(stretch.first));
            curves.push(MoveRange { first, last, deviation: stretch.max_deviation });
            append_stretch(path, moves, &stretch)?;
        }
        Ok(())
    };
    fit.push(path.position())?;
    for step in moves {
        fit.push(step.end())?;
        take(&mut fit, path)?;
    }
    fit.finish()?;
    take(&mut fit, path)?;
    Ok(curves)
}

fn append_stretch(
    path: &mut JoinedPathBuilder,
    moves: &[GcodeMove],
    stretch: &FittedStretch<3>,
) -> Result<(), GeometryError> {
    let source = moves.get(stretch.first).map_or(usize::MAX, |step| usize::try_from(step.line).unwrap_or(usize::MAX));
    match stretch.shape {
        StretchShape::Curve | StretchShape::Arc => path.curve(&stretch.curve, source)?,
        StretchShape::Line | StretchShape::Polyline => path.line_to(end_of(stretch), source)?,
    };
    Ok(())
}

fn end_of(stretch: &FittedStretch<3>) -> Vector3<f64> {
    let points = stretch.curve.control_points();
    points[points.len() - 1]
}
