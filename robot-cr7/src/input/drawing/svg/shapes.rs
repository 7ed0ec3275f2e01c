//! The basic shapes of SVG.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::length::{Element, plane};
use super::path::path;
use crate::input::drawing::conic::EllipseArc;
use crate::input::drawing::map::Map;
use crate::input::drawing::piece::Piece;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// The pieces of a shape, in metres. `None` where the element is no shape, and an empty list where the shape has no size, for then SVG does
/// not draw it.
pub(super) fn pieces_of(element: &Element, map: &Map, sink: &Sink) -> Result<Option<Vec<Piece>>, InputError> {
    let line = element.named.line;
    let pieces = match element.node.tag_name().name() {
        "path" => path(element, map, sink)?,
        "rect" => rectangle(element, map, sink)?,
        "circle" | "ellipse" => ellipse(element, map, sink)?,
        "line" => {
            let [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map(|name| element.length_or_zero(name, sink));
            vec![Piece::line(map.point(&plane(x1?, y1?)), map.point(&plane(x2?, y2?)), line)]
        }
        "polyline" => polyline(element, false, map, sink)?,
        "polygon" => polyline(element, true, map, sink)?,
        _ => return Ok(None),
    };
    Ok(Some(pieces))
}

fn polyline(element: &Element, closed: bool, map: &Map, sink: &Sink) -> Result<Vec<Piece>, InputError> {
    let numbers = element.numbers("points", sink)?;
    if numbers.len() % 2 != 0 {
        let why = ("points have two coordinates each", "correct them");
        return Err(element.wrong(sink, "points", &format!("{} numbers", numbers.len()), why));
    }
    let mut points: Vec<_> = numbers.chunks_exact(2).map(|p| map.point(&plane(p[0], p[1]))).collect();
    if closed && points.len() > 1 {
        points.push(points[0]);
    }
    Ok(points.windows(2).map(|pair| Piece::line(pair[0], pair[1], element.named.line)).collect())
}

/// A circle or an ellipse from its point at +x on, first towards +y of the drawing.
fn ellipse(element: &Element, map: &Map, sink: &Sink) -> Result<Vec<Piece>, InputError> {
    let radii = match element.node.tag_name().name() {
        "circle" => element.size("r", sink)?.map(|r| [r, r]),
        _ => match (element.size("rx", sink)?, element.size("ry", sink)?) {
            (None, None) => None,
            (x, y) => x.or(y).zip(y.or(x)).map(|(x, y)| [x, y]),
        },
    };
    let Some([rx, ry]) = radii.filter(|radii| radii.iter().all(|r| *r > 0.0)) else { return Ok(Vec::new()) };
    let [x, y] = ["cx", "cy"].map(|name| element.length_or_zero(name, sink));
    let arc = EllipseArc::whole(plane(x?, y?), [Vector3::x() * rx, Vector3::y() * ry]);
    Ok(vec![element.arc_piece(arc.mapped(map).piece(element.named.line), sink)?])
}

/// A rectangle, whose corners may be round (SVG 1.1, 9.2).
fn rectangle(element: &Element, map: &Map, sink: &Sink) -> Result<Vec<Piece>, InputError> {
    let [x, y] = ["x", "y"].map(|name| element.length_or_zero(name, sink));
    let (x, y) = (x?, y?);
    let [w, h] = ["width", "height"].map(|name| element.size(name, sink));
    let (w, h) = (w?.unwrap_or(0.0), h?.unwrap_or(0.0));
    if w <= 0.0 || h <= 0.0 {
        return Ok(Vec::new());
    }
    let [rx, ry] = ["rx", "ry"].map(|name| element.size(name, sink));
    let (rx, ry) = (rx?, ry?);
    let (rx, ry) = (rx.or(ry).unwrap_or(0.0).min(0.5 * w), ry.or(rx).unwrap_or(0.0).min(0.5 * h));
    let round = rx > 0.0 && ry > 0.0;
    let (rx, ry) = if round { (rx, ry) } else { (0.0, 0.0) };
    let line = element.named.line;
    let mut pieces: Vec<Piece> = Vec::new();
    let mut at = plane(x + rx, y);
    // Each side with the corner behind it: its end, and the centre and the first angle of the corner.
    let sides = [
        (plane(x + w - rx, y), plane(x + w - rx, y + ry), -FRAC_PI_2),
        (plane(x + w, y + h - ry), plane(x + w - rx, y + h - ry), 0.0),
        (plane(x + rx, y + h), plane(x + rx, y + h - ry), FRAC_PI_2),
        (plane(x, y + ry), plane(x + rx, y + ry), 2.0 * FRAC_PI_2),
    ];
    let next = [plane(x + w, y + ry), plane(x + w - rx, y + h), plane(x, y + h - ry), plane(x + rx, y)];
    for ((end, centre, from), next) in sides.into_iter().zip(next) {
        if (end - at).norm() > 1e-12 * (w + h) {
            pieces.push(Piece::line(map.point(&at), map.point(&end), line));
        }
        if round {
            let axes = [Vector3::x() * rx, Vector3::y() * ry];
            let arc = EllipseArc { centre, axes, from, sweep: FRAC_PI_2 }.mapped(map);
            let piece = element.arc_piece(arc.piece(line), sink)?;
            pieces.push(piece.ending_at([map.point(&end), map.point(&next)]));
        }
        at = next;
    }
    Ok(pieces)
}
