//! The pieces of a drawing: lines, arcs and curves in metres.

use std::f64::consts::TAU;
use std::rc::Rc;

use arcfeed_geometry::{GeometryError, NurbsCurve};
use nalgebra::Vector3;

use crate::input::gcode::MoveShape;

/// Ends that are as near as this touch, m.
pub(super) const TOUCH: f64 = 1e-6;

/// One line, arc or curve.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// m.
    pub start: Vector3<f64>,
    /// m.
    pub end: Vector3<f64>,
    pub shape: MoveShape,
    /// Line of the file.
    pub line: u64,
}

/// What one entity of a drawing gives.
#[derive(Debug, Clone)]
pub(super) struct Entity {
    /// What it is in words, such as `CIRCLE (handle 2F)`.
    pub name: String,
    pub layer: Option<Rc<str>>,
    /// Line of the file where it begins.
    pub line: u64,
    pub pieces: Vec<Piece>,
}

impl Piece {
    pub fn line(start: Vector3<f64>, end: Vector3<f64>, line: u64) -> Self {
        Self { start, end, shape: MoveShape::Line { to: end }, line }
    }

    /// A curve, clamped where it is not.
    pub fn curve(curve: NurbsCurve<3>, line: u64) -> Result<Self, GeometryError> {
        let curve = curve.clamped()?;
        let points = curve.control_points();
        let (start, end) = (points[0], points[points.len() - 1]);
        Ok(Self { start, end, shape: MoveShape::Curve(Box::new(curve)), line })
    }

    /// The piece with these ends in place of its own, which are the same to rounding.
    pub fn ending_at(mut self, [start, end]: [Vector3<f64>; 2]) -> Self {
        (self.start, self.end) = (start, end);
        if let MoveShape::Line { to } | MoveShape::Arc { to, .. } = &mut self.shape {
            *to = end;
        }
        self
    }

    /// A length that the piece has at most, and that is 0 only where it has none, m.
    pub fn size(&self) -> f64 {
        match &self.shape {
            MoveShape::Line { .. } => (self.end - self.start).norm(),
            MoveShape::Arc { centre, sweep, .. } => (self.start - centre).norm() * sweep.abs(),
            MoveShape::Curve(curve) => curve.control_points().windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum(),
        }
    }

    /// A height that no point of the piece is above, m. For lines and arcs it is that of their highest point.
    pub fn top(&self) -> f64 {
        let ends = self.start.z.max(self.end.z);
        match &self.shape {
            MoveShape::Line { .. } => ends,
            MoveShape::Arc { centre, normal, sweep, .. } => {
                let arm = self.start - centre;
                let (start, quarter) = (arm.z, normal.cross(&arm).z);
                // The angle from the start to the top of the circle, in the direction of the arc.
                let angle = (quarter.atan2(start) * sweep.signum()).rem_euclid(TAU);
                if angle <= sweep.abs() { ends.max(centre.z + start.hypot(quarter)) } else { ends }
            }
            MoveShape::Curve(curve) => curve.control_points().iter().map(|p| p.z).fold(ends, f64::max),
        }
    }

    /// The largest coordinate of its points, m; NaN where one of them is not a number.
    pub fn extent(&self) -> f64 {
        let largest =
            |p: &Vector3<f64>| p.iter().fold(0.0f64, |m, x| if x.is_nan() { f64::NAN } else { m.max(x.abs()) });
        let max = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
        let ends = max(largest(&self.start), largest(&self.end));
        match &self.shape {
            MoveShape::Line { .. } => ends,
            MoveShape::Arc { centre, .. } => max(ends, largest(centre)),
            MoveShape::Curve(curve) => curve.control_points().iter().map(largest).fold(ends, max),
        }
    }
}
