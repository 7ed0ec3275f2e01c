//! Entities of one record: lines, arcs, ellipses and splines.

use std::f64::consts::TAU;

use arcfeed_geometry::NurbsCurve;

use super::ocs::{axes, object_map};
use super::polyline::light_polyline;
use super::record::Record;
use crate::input::drawing::conic::EllipseArc;
use crate::input::drawing::map::Map;
use crate::input::drawing::piece::Piece;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// Angles that differ by less are the same: the arc is a full turn. In rad.
const SAME_ANGLE: f64 = 1e-12;
/// The highest degree of a spline. CAD writes 11 or so at the most, and a path that is joined is a curve of the highest degree of its
/// pieces, lines included.
const HIGHEST_DEGREE: usize = 15;

/// The pieces of an entity, in metres; `None` for a kind that is no path.
pub(super) fn pieces_of(record: &Record, map: &Map, sink: &Sink) -> Result<Option<Vec<Piece>>, InputError> {
    let piece = match record.kind {
        "LINE" => {
            let [start, end] = [10, 11].map(|code| record.point(code, sink));
            Piece::line(map.point(&start?), map.point(&end?), record.line)
        }
        "CIRCLE" => placed(record, &round(record, None, sink)?, map, sink)?,
        "ARC" => {
            let [from, to] = [50, 51].map(|code| record.number(code, sink).map(f64::to_radians));
            placed(record, &round(record, Some([from?, to?]), sink)?, map, sink)?
        }
        "ELLIPSE" => placed(record, &ellipse(record, sink)?, map, sink)?,
        "SPLINE" => spline(record, map, sink)?,
        "LWPOLYLINE" => return light_polyline(record, map, sink).map(Some),
        _ => return Ok(None),
    };
    Ok(Some(vec![piece]))
}

/// A circle or an arc, whose angles (rad) run counter-clockwise about the extrusion direction.
fn round(record: &Record, angles: Option<[f64; 2]>, sink: &Sink) -> Result<EllipseArc, InputError> {
    let radius = record.number(40, sink)?;
    if radius <= 0.0 {
        let why = ("a radius has to be above 0", "correct the entity, or remove it");
        return Err(record.wrong(sink, "the radius (40)", &radius.to_string(), why));
    }
    let own = object_map(record, sink)?;
    let (x, y) = (own.linear.column(0) * radius, own.linear.column(1) * radius);
    let mut arc = EllipseArc::whole(own.point(&record.point(10, sink)?), [x, y]);
    if let Some([from, to]) = angles {
        (arc.from, arc.sweep) = (from, turn(from, to));
    }
    Ok(arc)
}

fn ellipse(record: &Record, sink: &Sink) -> Result<EllipseArc, InputError> {
    let (major, ratio) = (record.point(11, sink)?, record.number(40, sink)?);
    let normal = record.extrusion(sink)?;
    let Some(z) = axes(&normal).map(|axes| axes.column(2).into_owned()) else {
        let why = ("a direction needs a length", "draw the entity again");
        return Err(record.wrong(sink, "the extrusion direction (210, 220, 230)", "(0, 0, 0)", why));
    };
    if !(major.norm() > 0.0 && ratio.abs() > 0.0) {
        let value = format!("an axis of {} with a ratio of {ratio}", major.norm());
        let why = ("both axes of an ellipse need a length", "correct the entity, or remove it");
        return Err(record.wrong(sink, "the size (11, 40)", &value, why));
    }
    let (from, to) = (record.number_or(41, 0.0, sink)?, record.number_or(42, TAU, sink)?);
    let minor = z.cross(&major) * ratio;
    Ok(EllipseArc { centre: record.point(10, sink)?, axes: [major, minor], from, sweep: turn(from, to) })
}

/// The angle counter-clockwise from one direction to another, rad: above 0, and a full turn for the same one.
fn turn(from: f64, to: f64) -> f64 {
    let sweep = (to - from).rem_euclid(TAU);
    if sweep <= SAME_ANGLE || TAU - sweep <= SAME_ANGLE { TAU } else { sweep }
}

fn placed(record: &Record, arc: &EllipseArc, map: &Map, sink: &Sink) -> Result<Piece, InputError> {
    match arc.mapped(map).piece(record.line) {
        Some(piece) => piece.map_err(|source| record.curve_error(source, sink)),
        None => Err(record.flat(sink)),
    }
}

/// A NURBS curve.
fn spline(record: &Record, map: &Map, sink: &Sink) -> Result<Piece, InputError> {
    let points = record.points(10, sink)?;
    if points.is_empty() {
        let fit = record.groups.iter().filter(|group| group.code == 11).count();
        let value = format!("none, and {fit} fit points");
        let why = ("a spline needs control points", "turn it into control vertices or into a polyline in CAD");
        return Err(record.wrong(sink, "control points (10, 20)", &value, why));
    }
    let degree = record.flags(71, sink)?;
    let Some(degree) = usize::try_from(degree).ok().filter(|degree| (1..=HIGHEST_DEGREE).contains(degree)) else {
        let why = ("a degree is from 1 to 15", "rebuild the spline with a lower degree in CAD");
        return Err(record.wrong(sink, "the degree (71)", &degree.to_string(), why));
    };
    let numbers = |code: i32| -> Result<Vec<f64>, InputError> {
        let groups = record.groups.iter().filter(|group| group.code == code);
        groups.map(|group| record.number_of(group, sink)).collect()
    };
    let (knots, mut weights) = (numbers(40)?, numbers(41)?);
    if weights.is_empty() {
        weights = vec![1.0; points.len()];
    }
    let points = points.iter().map(|(_, point)| map.point(point)).collect();
    let curve = NurbsCurve::new(degree, points, weights, knots).and_then(|curve| Piece::curve(curve, record.line));
    curve.map_err(|source| record.curve_error(source, sink))
}
