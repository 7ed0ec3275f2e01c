//! Arcs of circles and ellipses, exactly.

use std::f64::consts::{FRAC_PI_2, TAU};

use arcfeed_geometry::{GeometryError, NurbsCurve};
use nalgebra::{Unit, Vector2, Vector3};

use super::map::Map;
use super::piece::Piece;
use crate::input::gcode::MoveShape;

/// Axes that differ by this part, or are as far from square, are those of a circle.
const ROUND: f64 = 1e-12;
/// Below this sweep, in rad, an arc is given by its ends and its tangents: the centre is too far away to say where the arc is.
const FLAT: f64 = 0.02;

/// An arc of an ellipse: `centre + axes[0] cos t + axes[1] sin t` for `t` from `from` on over `sweep` (rad). The axes are any pair of
/// conjugate half diameters, in m.
#[derive(Debug, Clone, Copy)]
pub(super) struct EllipseArc {
    pub centre: Vector3<f64>,
    pub axes: [Vector3<f64>; 2],
    pub from: f64,
    pub sweep: f64,
}

impl EllipseArc {
    /// The place at the angle `t`, m.
    pub fn point(&self, t: f64) -> Vector3<f64> {
        self.centre + self.axes[0] * t.cos() + self.axes[1] * t.sin()
    }

    /// The whole ellipse, from its first axis on.
    pub fn whole(centre: Vector3<f64>, axes: [Vector3<f64>; 2]) -> Self {
        Self { centre, axes, from: 0.0, sweep: TAU }
    }

    /// The arc elsewhere.
    pub fn mapped(&self, map: &Map) -> Self {
        Self { centre: map.point(&self.centre), axes: self.axes.map(|axis| map.vector(&axis)), ..*self }
    }

    /// An arc of a circle where it is round, else a rational curve. `None` where the ellipse has no area.
    pub fn piece(&self, line: u64) -> Option<Result<Piece, GeometryError>> {
        let [a, b] = self.axes;
        let (across, size) = ((a / a.amax()).cross(&(b / b.amax())), a.norm() * b.norm());
        let normal = Unit::try_new(across, 1e-9)?;
        let round = (a.norm() - b.norm()).abs() <= ROUND * a.norm() && a.dot(&b).abs() <= ROUND * size;
        if !round {
            return Some(self.curve().and_then(|curve| Piece::curve(curve, line)));
        }
        let (normal, sweep) = if normal.z < 0.0 { (-normal, -self.sweep) } else { (normal, self.sweep) };
        let (start, to) = (self.point(self.from), self.end());
        let shape = MoveShape::Arc { centre: self.centre, normal, sweep, rise: 0.0, to };
        Some(Ok(Piece { start, end: to, shape, line }))
    }

    fn end(&self) -> Vector3<f64> {
        self.point(if self.sweep.abs() == TAU { self.from } else { self.from + self.sweep })
    }

    /// The arc as a rational curve of degree 2, which is exact: spans of 90 degrees at most, with the cosine of half their angle as weight
    /// (Piegl and Tiller, The NURBS Book, 7.5).
    pub fn curve(&self) -> Result<NurbsCurve<3>, GeometryError> {
        let spans = (self.sweep.abs() / FRAC_PI_2 - 1e-12).ceil().max(1.0);
        let half = 0.5 * self.sweep / spans;
        let weight = half.cos();
        let [a, b] = self.axes;
        let (mut points, mut weights, mut knots) = (vec![self.point(self.from)], vec![1.0], vec![0.0; 3]);
        for i in 0..spans as u32 {
            let middle = self.from + half * f64::from(2 * i + 1);
            points.push(self.centre + (a * middle.cos() + b * middle.sin()) / weight);
            points.push(self.point(middle + half));
            weights.extend([weight, 1.0]);
            knots.extend([f64::from(i + 1); 2]);
        }
        if let Some(last) = points.last_mut() {
            *last = self.end();
        }
        knots.push(spans);
        NurbsCurve::new(2, points, weights, knots)
    }
}

/// An arc of a circle in a plane between two points.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChordArc {
    pub start: Vector2<f64>,
    pub end: Vector2<f64>,
    /// Angle of the arc, rad, above 0 counter-clockwise; less than a full turn, and not 0.
    pub sweep: f64,
}

impl ChordArc {
    /// The arc of a polyline with this bulge: the tangent of a quarter of its angle.
    pub fn of_bulge(start: Vector2<f64>, end: Vector2<f64>, bulge: f64) -> Self {
        Self { start, end, sweep: 4.0 * bulge.atan() }
    }

    /// The arc at its place: `map` takes points of its plane at the height `z` to metres. `None` where it has no area there.
    pub fn piece(&self, z: f64, map: &Map, line: u64) -> Option<Result<Piece, GeometryError>> {
        let at = |p: Vector2<f64>| map.point(&Vector3::new(p.x, p.y, z));
        let chord = self.end - self.start;
        let left = Vector2::new(-chord.y, chord.x);
        let middle = self.start + 0.5 * chord;
        let ends = [self.start, self.end].map(at);
        let half = 0.5 * self.sweep;
        if self.sweep.abs() < FLAT {
            let tip = at(middle - left * (0.5 * half.tan()));
            let curve = NurbsCurve::new(
                2,
                vec![ends[0], tip, ends[1]],
                vec![1.0, half.cos(), 1.0],
                vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            );
            return Some(curve.and_then(|curve| Piece::curve(curve, line)));
        }
        let centre = middle + left * (0.5 / half.tan());
        let arm = self.start - centre;
        let lifted = |p: Vector2<f64>| Vector3::new(p.x, p.y, 0.0);
        let axes = [lifted(arm), lifted(Vector2::new(-arm.y, arm.x))];
        let arc = EllipseArc { centre: Vector3::new(centre.x, centre.y, z), axes, from: 0.0, sweep: self.sweep };
        let piece = arc.mapped(map).piece(line)?;
        Some(piece.map(|piece| piece.ending_at(ends)))
    }
}
