//! Paths of SVG.

use std::f64::consts::{PI, TAU};

use nalgebra::{Vector2, Vector3};
use svgtypes::{PathParser, PathSegment};

use super::length::{Element, plane};
use crate::input::drawing::bezier::{cubic, quadratic};
use crate::input::drawing::conic::ChordArc;
use crate::input::drawing::map::Map;
use crate::input::drawing::piece::{Piece, TOUCH};
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// Most commands of a path.
const MOST_COMMANDS: usize = 1_000_000;

/// The pieces of a path, in metres.
pub(super) fn path(element: &Element, map: &Map, sink: &Sink) -> Result<Vec<Piece>, InputError> {
    let text = element.node.attribute("d").unwrap_or("");
    if text.trim() == "none" {
        return Ok(Vec::new());
    }
    let origin = Vector2::zeros();
    let mut pen = Pen { element, map, sink, at: origin, start: origin, handle: Handle::None, pieces: Vec::new() };
    for (i, segment) in PathParser::from(text).enumerate() {
        let segment = segment.map_err(|e| {
            let why = ("path data has to follow the grammar of SVG", "correct it at this place");
            sink.wrong(element.named, "d", &e.to_string(), why)
        })?;
        if i == MOST_COMMANDS {
            let why = ("a path has 1000000 commands at the most", "divide the path");
            return Err(sink.wrong(element.named, "d", "longer", why));
        }
        pen.segment(&segment)?;
    }
    Ok(pen.pieces)
}

/// The control point that S and T mirror.
#[derive(Debug, Clone, Copy)]
enum Handle {
    None,
    Cubic(Vector2<f64>),
    Quadratic(Vector2<f64>),
}

type Point = Vector2<f64>;

struct Pen<'a> {
    element: &'a Element<'a, 'a>,
    map: &'a Map,
    sink: &'a Sink<'a>,
    at: Point,
    /// Where the present contour began.
    start: Point,
    handle: Handle,
    pieces: Vec<Piece>,
}

impl Pen<'_> {
    fn place(&self, p: Point) -> Vector3<f64> {
        self.map.point(&plane(p.x, p.y))
    }

    fn line_to(&mut self, to: Point) {
        self.pieces.push(Piece::line(self.place(self.at), self.place(to), self.element.named.line));
        (self.at, self.handle) = (to, Handle::None);
    }

    fn segment(&mut self, segment: &PathSegment) -> Result<(), InputError> {
        let base = if segment.is_abs() { Point::zeros() } else { self.at };
        let point = |x: f64, y: f64| base + Point::new(x, y);
        match *segment {
            PathSegment::MoveTo { x, y, .. } => {
                self.at = point(x, y);
                (self.start, self.handle) = (self.at, Handle::None);
            }
            PathSegment::LineTo { x, y, .. } => self.line_to(point(x, y)),
            PathSegment::HorizontalLineTo { x, .. } => self.line_to(Point::new(base.x + x, self.at.y)),
            PathSegment::VerticalLineTo { y, .. } => self.line_to(Point::new(self.at.x, base.y + y)),
            PathSegment::CurveTo { x1, y1, x2, y2, x, y, .. } => {
                self.cubic_to(point(x1, y1), point(x2, y2), point(x, y))?;
            }
            PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => {
                let first = if let Handle::Cubic(handle) = self.handle { 2.0 * self.at - handle } else { self.at };
                self.cubic_to(first, point(x2, y2), point(x, y))?;
            }
            PathSegment::Quadratic { x1, y1, x, y, .. } => self.quadratic_to(point(x1, y1), point(x, y))?,
            PathSegment::SmoothQuadratic { x, y, .. } => {
                let handle = if let Handle::Quadratic(handle) = self.handle { 2.0 * self.at - handle } else { self.at };
                self.quadratic_to(handle, point(x, y))?;
            }
            PathSegment::EllipticalArc { rx, ry, x_axis_rotation, large_arc, sweep, x, y, .. } => {
                let arc = EndpointArc { radii: [rx, ry], rotation: x_axis_rotation, large: large_arc, sweep };
                self.arc_to(&arc, point(x, y))?;
            }
            PathSegment::ClosePath { .. } => {
                // Ends that touch are closed anyway.
                if (self.place(self.at) - self.place(self.start)).norm() > TOUCH {
                    self.line_to(self.start);
                }
                (self.at, self.handle) = (self.start, Handle::None);
            }
        }
        Ok(())
    }

    fn cubic_to(&mut self, b: Point, c: Point, d: Point) -> Result<(), InputError> {
        let points = [self.at, b, c, d].map(|p| self.place(p));
        let pieces = cubic(points, self.element.named.line);
        self.pieces.extend(pieces.map_err(|source| self.sink.curve_error(self.element.named, source))?);
        (self.at, self.handle) = (d, Handle::Cubic(c));
        Ok(())
    }

    fn quadratic_to(&mut self, b: Point, c: Point) -> Result<(), InputError> {
        let points = [self.at, b, c].map(|p| self.place(p));
        let pieces = quadratic(points, self.element.named.line);
        self.pieces.extend(pieces.map_err(|source| self.sink.curve_error(self.element.named, source))?);
        (self.at, self.handle) = (c, Handle::Quadratic(b));
        Ok(())
    }

    fn arc_to(&mut self, arc: &EndpointArc, to: Point) -> Result<(), InputError> {
        let from = self.at;
        if from == to {
            // SVG 1.1, F.6.2: the arc is left out.
            self.handle = Handle::None;
            return Ok(());
        }
        let Some((ellipse, chord)) = arc.on_circle(from, to) else {
            self.line_to(to);
            return Ok(());
        };
        let piece = chord.piece(0.0, &self.map.after(&ellipse), self.element.named.line);
        let ends = [self.place(from), self.place(to)];
        let piece = self.element.arc_piece(piece, self.sink)?.ending_at(ends);
        self.pieces.push(piece);
        (self.at, self.handle) = (to, Handle::None);
        Ok(())
    }
}

/// An arc of an ellipse as the command A states it.
struct EndpointArc {
    radii: [f64; 2],
    /// Degrees.
    rotation: f64,
    large: bool,
    sweep: bool,
}

impl EndpointArc {
    /// The arc on a circle of radius 1, and the map from there. `None` for a radius of 0, which makes a line. Radii that are too small for
    /// the ends grow (SVG 1.1, F.6.6).
    fn on_circle(&self, from: Point, to: Point) -> Option<(Map, ChordArc)> {
        let [rx, ry] = self.radii.map(f64::abs);
        if !(rx > 0.0 && ry > 0.0) {
            return None;
        }
        let (sin, cos) = self.rotation.to_radians().sin_cos();
        let unit = |p: Point| Point::new((p.x * cos + p.y * sin) / rx, (p.y * cos - p.x * sin) / ry);
        let chord = unit(to - from);
        // Half of the chord is the sine of half of the angle.
        let half = 0.5 * chord.norm();
        let small = 2.0 * half.min(1.0).asin();
        let size = if self.large { TAU - small } else { small };
        // Radii that only just reach, or that grew, make half a turn.
        let size = if half >= 1.0 { PI } else { size };
        let angle = if self.sweep { size } else { -size };
        let [a, b] = [rx, ry];
        let ellipse = Map::plane([a * cos, a * sin, -b * sin, b * cos, from.x, from.y]);
        Some((ellipse, ChordArc { start: Point::zeros(), end: chord, sweep: angle }))
    }
}
