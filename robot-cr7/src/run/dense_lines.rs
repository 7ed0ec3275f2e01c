//! Runs of short lines in a program, as smooth curves.

use arcfeed_geometry::{DenseFit, FittedStretch, GeometryError, JoinedPathBuilder, StretchShape};
use nalgebra::Vector3;

use crate::input::gcode::{GcodeMove, MoveKind, MoveShape, PathControl};

/// Fewer lines than these are no run: each is a line of its own.
const LEAST_LINES: usize = 12;

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
