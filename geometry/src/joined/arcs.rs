//! Circular arcs and helices as spans.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use nalgebra::{Unit, Vector3};

use super::spans::{Spans, homogeneous, length};
use crate::error::GeometryError;

/// Most full turns of an arc or a helix.
const MOST_TURNS: u32 = 10_000;
/// Largest angle of a span of an arc: there the speed of its parameter is within 3 % of its mean.
const SPAN_OF_ARC: f64 = FRAC_PI_4;

/// Where an arc or a helix goes from the present end of a path.
///
/// It turns about the axis through `centre` along `normal`, counter-clockwise seen against the normal, by the first
/// angle above 0 that leads to `end`, and by `turns` full turns more. An end equal to the start means a full turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArcTo {
    /// A point on the axis.
    pub centre: Vector3<f64>,
    /// Direction of the axis.
    pub normal: Unit<Vector3<f64>>,
    /// Where the piece ends.
    pub end: Vector3<f64>,
    /// Full turns beyond the first angle.
    pub turns: u32,
}

impl ArcTo {
    /// An arc of less than a full turn, or a full turn where it ends in its start.
    pub fn new(centre: Vector3<f64>, normal: Unit<Vector3<f64>>, end: Vector3<f64>) -> Self {
        Self { centre, normal, end, turns: 0 }
    }
}

/// A helix, or a circle where it does not rise: `centre + radius cos(a) + across sin(a) + rise a / sweep`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turning {
    centre: Vector3<f64>,
    radius: Vector3<f64>,
    across: Vector3<f64>,
    rise: Vector3<f64>,
    sweep: f64,
    end: Vector3<f64>,
}

impl Turning {
    /// An arc from `start`. Its centre is moved so that both radii are equal, and its plane is tilted through the
    /// end.
    pub fn arc(start: &Vector3<f64>, to: &ArcTo, tolerance: f64, line: usize) -> Result<Self, GeometryError> {
        let chord = to.end - start;
        let rise = chord.dot(&to.normal);
        let size = rounding(&[start, &to.end, &to.centre]);
        let flat = chord - to.normal.as_ref() * rise;
        if rise.abs() <= size {
            return Self::about(start, &ArcTo { end: start + flat, ..*to }, tolerance, line).map(|arc| Self {
                end: to.end,
                rise: Vector3::zeros(),
                ..arc
            });
        }
        // The far side of the circle moves by more than the end.
        let diameter = 2.0 * (start - to.centre).cross(&to.normal).norm();
        let deviation = rise.abs() * (diameter / flat.norm()).max(1.0);
        if deviation.is_nan() || deviation > tolerance {
            return Err(GeometryError::ArcEnd { line, deviation, tolerance });
        }
        let along = chord / chord.norm();
        let normal = Unit::new_normalize(to.normal.as_ref() - along * to.normal.dot(&along));
        Self::about(start, &ArcTo { normal, ..*to }, tolerance, line).map(|arc| Self { rise: Vector3::zeros(), ..arc })
    }

    /// A helix from `start`. Its axis is moved so that both radii are equal.
    pub fn about(start: &Vector3<f64>, to: &ArcTo, tolerance: f64, line: usize) -> Result<Self, GeometryError> {
        if to.turns > MOST_TURNS {
            return Err(GeometryError::TooManyTurns { line, turns: to.turns, limit: MOST_TURNS });
        }
        let n = to.normal.as_ref();
        let size = rounding(&[start, &to.end, &to.centre]);
        let rise = n * (to.end - start).dot(n);
        let flat_end = to.end - rise;
        let programmed = to.centre + n * (start - to.centre).dot(n);
        let radius = (start - programmed).norm();
        if radius.is_nan() || radius <= size {
            return Err(GeometryError::ArcRadius { line, radius });
        }
        let chord = flat_end - start;
        let whole_turns = TAU * f64::from(to.turns);
        let at = |centre: Vector3<f64>, sweep: f64| {
            let radius = start - centre;
            Self { centre, radius, across: n.cross(&radius), rise, sweep: sweep + whole_turns, end: to.end }
        };
        if chord.norm() <= size {
            return Ok(at(programmed, TAU));
        }
        let along = chord / chord.norm();
        let shift = along * ((start + flat_end) * 0.5 - programmed).dot(&along);
        let centre = programmed + shift;
        let sweep_about = |c: Vector3<f64>| {
            let (u, v) = (start - c, flat_end - c);
            let angle = n.dot(&u.cross(&v)).atan2(u.dot(&v));
            if angle > 0.0 { angle } else { angle + TAU }
        };
        let sweep = sweep_about(centre);
        // A point of the arc goes from the one circle to the other by the part of the shift that turns with it.
        let turning = if to.turns > 0 { PI } else { sweep.min(PI) };
        let deviation = 2.0 * (0.5 * turning).sin() * shift.norm();
        let same_way = (sweep - sweep_about(programmed)).abs() < 1.0;
        if !(deviation <= tolerance && same_way && (start - centre).norm() > size) {
            let radii = ((flat_end - programmed).norm() - radius).abs();
            return Err(GeometryError::ArcEnd { line, deviation: deviation.max(radii), tolerance });
        }
        Ok(at(centre, sweep))
    }

    /// Exact length.
    pub fn length(&self) -> f64 {
        (self.radius.norm() * self.sweep).hypot(self.rise.norm())
    }

    fn point(&self, angle: f64) -> Vector3<f64> {
        self.centre + self.out(angle) + self.rise * (angle / self.sweep)
    }

    fn out(&self, angle: f64) -> Vector3<f64> {
        self.radius * angle.cos() + self.across * angle.sin()
    }

    /// Ends of `count` equal parts: the angles, and the first and the last point exact.
    fn parts(&self, count: usize, start: &Vector3<f64>) -> impl Iterator<Item = (f64, f64, [Vector3<f64>; 2])> {
        let (this, start) = (*self, *start);
        let at = move |i: usize| {
            let angle = this.sweep * (i as f64 / count as f64);
            match i {
                0 => (angle, start),
                i if i == count => (angle, this.end),
                _ => (angle, this.point(angle)),
            }
        };
        (0..count).map(move |i| {
            let ((a, p), (b, q)) = (at(i), at(i + 1));
            (a, b, [p, q])
        })
    }

    /// The arc as exact rational spans of degree 2 (Piegl and Tiller, "The NURBS Book", section 7.5).
    pub fn arc_spans(&self, start: &Vector3<f64>) -> Spans {
        let count = (self.sweep / SPAN_OF_ARC - 1e-9).ceil().max(1.0) as usize;
        let mut spans = Spans::default();
        let half = 0.5 * self.sweep / count as f64;
        for (a, b, [p, q]) in self.parts(count, start) {
            let middle = self.centre + self.out(0.5 * (a + b)) / half.cos();
            let w = half.cos();
            let points = [homogeneous(&p), homogeneous(&middle).map(|x| x * w), homogeneous(&q)];
            spans.push(&points, self.length() / count as f64);
        }
        spans
    }

    /// The helix as polynomial spans of degree 5 that have its point, tangent and curvature at both ends.
    ///
    /// A Hermite interpolant of degree 5 over the angle `h` differs from a function `f` by at most `max |f^(6)| h^6
    /// / (6! 2^6)` (the error term of Hermite interpolation), and every sixth derivative of the helix by the angle
    /// is as long as its radius.
    pub fn helix_spans(&self, start: &Vector3<f64>, tolerance: f64) -> Result<Spans, GeometryError> {
        let radius = self.radius.norm();
        let smallest = 8.0 * f64::EPSILON * (radius + start.amax().max(self.end.amax()));
        if tolerance < smallest {
            return Err(GeometryError::ToleranceTooSmall { tolerance, smallest });
        }
        let widest = (46_080.0 * (tolerance / radius)).powf(1.0 / 6.0).min(1.0);
        let count = (self.sweep / widest).ceil().max(1.0) as usize;
        let mut spans = Spans::default();
        for (a, b, [p, q]) in self.parts(count, start) {
            let h = b - a;
            let first = |angle: f64| {
                (self.across * angle.cos() - self.radius * angle.sin() + self.rise / self.sweep) * (h / 5.0)
            };
            let second = |angle: f64| self.out(angle) * (-h * h / 20.0);
            let (d0, d1) = (first(a), first(b));
            let points = [p, p + d0, p + d0 * 2.0 + second(a), q - d1 * 2.0 + second(b), q - d1, q];
            let points = points.map(|p| homogeneous(&p));
            spans.push(&points, length(&points, 0.0, 1.0));
        }
        Ok(spans)
    }
}

/// What rounding makes of the coordinates of some points.
pub(super) fn rounding(points: &[&Vector3<f64>]) -> f64 {
    16.0 * f64::EPSILON * points.iter().fold(0.0f64, |m, p| m.max(p.amax()))
}
