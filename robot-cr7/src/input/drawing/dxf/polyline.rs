//! Polylines with straight segments and arcs.

use nalgebra::{Vector2, Vector3};

use super::ocs::object_map;
use super::record::Record;
use crate::input::drawing::conic::ChordArc;
use crate::input::drawing::map::Map;
use crate::input::drawing::piece::Piece;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// An arc that is as near to its chord as this is a line, m.
const STRAIGHT: f64 = 1e-10;

/// A vertex: its line, its place, and the bulge of the segment behind it.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    line: u64,
    place: Vector3<f64>,
    bulge: f64,
}

/// The segments of an LWPOLYLINE.
pub(super) fn light_polyline(record: &Record, map: &Map, sink: &Sink) -> Result<Vec<Piece>, InputError> {
    let height = record.number_or(38, 0.0, sink)?;
    let points = record.points(10, sink)?;
    let vertex = |&(line, p): &(u64, Vector3<f64>)| Vertex { line, place: Vector3::new(p.x, p.y, height), bulge: 0.0 };
    let mut vertices: Vec<Vertex> = points.iter().map(vertex).collect();
    let mut last = None;
    for group in &record.groups {
        match group.code {
            10 => last = Some(last.map_or(0, |i: usize| i + 1)),
            42 => {
                if let Some(vertex) = last.and_then(|i| vertices.get_mut(i)) {
                    vertex.bulge = record.number_of(group, sink)?;
                }
            }
            _ => {}
        }
    }
    let closed = record.flags(70, sink)? & 1 != 0;
    segments(record, &vertices, closed, &map.after(&object_map(record, sink)?), sink)
}

/// The segments of a POLYLINE with its VERTEX records; `None` for a mesh.
pub(super) fn old_polyline(
    record: &Record,
    vertices: &[Record],
    map: &Map,
    sink: &Sink,
) -> Result<Option<Vec<Piece>>, InputError> {
    let flags = record.flags(70, sink)?;
    if flags & (16 | 64) != 0 {
        return Ok(None);
    }
    let spatial = flags & 8 != 0;
    let height = record.number_or(30, 0.0, sink)?;
    let mut corners = Vec::with_capacity(vertices.len());
    for vertex in vertices {
        // Control points of a spline, which the vertices beside them replace.
        if vertex.flags(70, sink)? & 16 != 0 {
            continue;
        }
        let p = vertex.point(10, sink)?;
        let (place, bulge) = match spatial {
            true => (p, 0.0),
            false => (Vector3::new(p.x, p.y, height), vertex.number_or(42, 0.0, sink)?),
        };
        corners.push(Vertex { line: vertex.line, place, bulge });
    }
    let map = if spatial { *map } else { map.after(&object_map(record, sink)?) };
    segments(record, &corners, flags & 1 != 0, &map, sink).map(Some)
}

fn segments(
    record: &Record,
    vertices: &[Vertex],
    closed: bool,
    map: &Map,
    sink: &Sink,
) -> Result<Vec<Piece>, InputError> {
    if vertices.len() < 2 {
        let why = ("a polyline needs two vertices", "correct the entity, or remove it");
        return Err(record.wrong(sink, "vertices", &vertices.len().to_string(), why));
    }
    let ends = vertices[1..].iter().chain(closed.then_some(&vertices[0]));
    let segment = |(from, to): (&Vertex, &Vertex)| {
        let flat_place = |v: &Vertex| Vector2::new(v.place.x, v.place.y);
        let (a, b) = (map.point(&from.place), map.point(&to.place));
        // Also where the vertices are the same: no arc joins them.
        if from.bulge.abs() * (b - a).norm() <= 2.0 * STRAIGHT {
            return Ok(Piece::line(a, b, from.line));
        }
        let arc = ChordArc::of_bulge(flat_place(from), flat_place(to), from.bulge);
        match arc.piece(from.place.z, map, from.line) {
            Some(piece) => piece.map_err(|source| record.curve_error(source, sink)),
            None => Err(record.flat(sink)),
        }
    };
    vertices.iter().zip(ends).map(segment).collect()
}
