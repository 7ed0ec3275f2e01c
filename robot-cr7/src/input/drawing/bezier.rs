//! Bezier curves of drawings, whose handles may be retracted.
//!
//! A curve is exact, except near an end whose handle is retracted: the curve stands still there, and its curvature has no limit. With
//! `P1 = P0` it is `P0 + A t^2 + B t^3`. Its part up to `t1` becomes the parabola with the same ends and tangents,
//! `P0 + A t1^2 (2 s + s^2)/3 + B t1^3 s^2`. At the same distance along `A` the two are `B t1^3 |s^2 - ((2 s + s^2)/3)^1.5|` apart, which is
//! at most `0.0212 |B| t1^3`.
//!
//! A handle as short as 1e-7 m counts as retracted. To leave it out moves the curve by less than its length, which is taken off the
//! tolerance of the parabola: together the two are at most 1e-6 m.

use arcfeed_geometry::{GeometryError, NurbsCurve};
use nalgebra::Vector3;

use super::piece::Piece;

/// A handle as short as this is retracted, m.
const RETRACTED: f64 = 1e-7;
/// The pieces may be as far from the curve as this, m.
const TOLERANCE: f64 = 1e-6;
/// An upper bound of the largest value of `|s^2 - ((2 s + s^2)/3)^1.5|` for `s` from 0 to 1.
const PARABOLA: f64 = 0.0212;
/// The largest part of the curve that becomes a parabola.
const MOST: f64 = 0.5;

type Point = Vector3<f64>;

/// The pieces of a Bezier curve of degree 2.
pub(super) fn quadratic([a, b, c]: [Point; 3], line: u64) -> Result<Vec<Piece>, GeometryError> {
    if (b - a).norm() <= RETRACTED || (c - b).norm() <= RETRACTED {
        return Ok(vec![Piece::line(a, c, line)]);
    }
    Ok(vec![bezier(vec![a, b, c], line)?])
}

/// The pieces of a Bezier curve of degree 3.
pub(super) fn cubic([a, b, c, d]: [Point; 4], line: u64) -> Result<Vec<Piece>, GeometryError> {
    let short = |p: &Point, q: &Point| (q - p).norm() <= RETRACTED;
    match (short(&a, &b), short(&c, &d)) {
        // The curve stays on the line between its ends.
        (true, true) => Ok(vec![Piece::line(a, d, line)]),
        (true, false) if short(&a, &c) => Ok(vec![Piece::line(a, d, line)]),
        (false, true) if short(&b, &d) => Ok(vec![Piece::line(a, d, line)]),
        (true, false) => {
            let (parabola, rest) = retracted([a, c, d]);
            Ok(vec![bezier(parabola.to_vec(), line)?, bezier(rest.to_vec(), line)?])
        }
        (false, true) => {
            let (mut parabola, mut rest) = retracted([d, b, a]);
            parabola.reverse();
            rest.reverse();
            Ok(vec![bezier(rest.to_vec(), line)?, bezier(parabola.to_vec(), line)?])
        }
        (false, false) => Ok(vec![bezier(vec![a, b, c, d], line)?]),
    }
}

/// The parabola at the start of the curve with the control points `a, a, c, d`, and the rest of the curve.
fn retracted([a, c, d]: [Point; 3]) -> ([Point; 3], [Point; 4]) {
    let second = 3.0 * (c - a);
    let third = d - 3.0 * c + 2.0 * a;
    // A third derivative of 0 leaves a straight line.
    let t = ((TOLERANCE - RETRACTED) / (PARABOLA * third.norm())).cbrt().min(MOST);
    let (ab, bc, cd) = (a, a + (c - a) * t, c + (d - c) * t);
    let (abc, bcd) = (ab + (bc - ab) * t, bc + (cd - bc) * t);
    let middle = abc + (bcd - abc) * t;
    ([a, a + second * (t * t / 3.0), middle], [middle, bcd, cd, d])
}

fn bezier(points: Vec<Point>, line: u64) -> Result<Piece, GeometryError> {
    let degree = points.len() - 1;
    let knots = [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
    Piece::curve(NurbsCurve::bspline(degree, points, knots)?, line)
}
