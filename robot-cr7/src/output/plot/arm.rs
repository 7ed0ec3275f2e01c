//! The arm in the picture of a path, at both ends of the motion.

use std::io;

use nalgebra::{Isometry3, Vector3};
use plotters::prelude::RGBColor;

use super::canvas::{Canvas, Pen};
use crate::output::arm_poses::Pose;

const BODY: RGBColor = RGBColor(212, 220, 228);
const EDGE: RGBColor = RGBColor(134, 150, 165);
/// Radius of a link over the length of all links, and of the tool and the base over that of a link.
const SLENDER: f64 = 0.025;
const TOOL: f64 = 0.4;
const BASE: f64 = 1.8;
/// Links that a picture shows, at the most and at the least, pixels.
const WIDEST: f64 = 90.0;
const THINNEST: f64 = 2.5;

/// The arm at both ends of a motion.
#[derive(Debug, Clone, Copy)]
pub struct ArmAtEnds<'a> {
    /// At the start.
    pub start: &'a Pose,
    /// At the end.
    pub end: &'a Pose,
    /// The frame of the workpiece in that of the base: places of a path are in the frame of the workpiece.
    pub workpiece: &'a Isometry3<f64>,
}

/// An arm at both ends of a motion in the frame of a picture: base, joints, flange and tip of the tool, mm.
#[derive(Debug, Clone)]
pub(super) struct ArmShape {
    start: Vec<Vector3<f64>>,
    end: Vec<Vector3<f64>>,
    /// Radius of the links, mm.
    radius: f64,
    /// The directions of x and y of the base.
    ground: [Vector3<f64>; 2],
}

impl ArmShape {
    /// The arm in the frame of the base; `None` where a number is not finite.
    pub fn of(arm: &ArmAtEnds<'_>) -> Option<Self> {
        let [start, end] = [arm.start, arm.end].map(|pose| pose.places().map(|p| p * 1e3).collect::<Vec<_>>());
        let length: f64 = start.windows(2).map(|link| (link[1] - link[0]).norm()).sum();
        let shape = Self { start, end, radius: SLENDER * length, ground: [Vector3::x(), Vector3::y()] };
        (shape.start.len() > 1 && shape.points().all(|p| p.iter().all(|v| v.is_finite() && v.abs() < 1e9)))
            .then_some(shape)
    }

    /// The arm in the frame that is `frame` in the present one (m).
    pub fn seen_from(&self, frame: &Isometry3<f64>) -> Self {
        let (back, origin) = (frame.rotation.inverse(), frame.translation.vector * 1e3);
        let seen = |points: &[Vector3<f64>]| points.iter().map(|p| back * (p - origin)).collect();
        let ground = self.ground.map(|axis| back * axis);
        Self { start: seen(&self.start), end: seen(&self.end), radius: self.radius, ground }
    }

    /// All of its points, with those around its joints and its base.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        let [x, y] = self.ground;
        let around = [x, -x, y, -y, x.cross(&y)].map(|way| way * self.radius);
        let joints = self.start.iter().flat_map(move |joint| around.map(|way| joint + way));
        joints.chain(self.end.iter().copied()).chain(self.foot())
    }

    /// The place of its base.
    pub fn base(&self) -> Vector3<f64> {
        self.start.first().copied().unwrap_or_default()
    }

    /// The longest side of the box around it.
    pub fn size(&self) -> f64 {
        let side = |k: usize| {
            let ends = |(low, high): (f64, f64), p: Vector3<f64>| (low.min(p[k]), high.max(p[k]));
            let (low, high) = self.points().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
            high - low
        };
        (0..3).map(side).fold(0.0, f64::max)
    }

    /// The rim of its foot on the ground.
    fn foot(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        let [x, y] = self.ground.map(|axis| axis * (BASE * self.radius));
        (0..32)
            .map(|i| std::f64::consts::TAU * f64::from(i) / 32.0)
            .map(move |a| self.base() + x * a.cos() + y * a.sin())
    }

    /// Draws it at true scale: `scale` pixels are 1 mm. The start is solid, the end a thin line.
    pub fn draw(
        &self,
        canvas: &Canvas<'_>,
        place: &impl Fn(&Vector3<f64>) -> (f64, f64),
        scale: f64,
    ) -> Result<(), io::Error> {
        let width = (2.0 * self.radius * scale).max(THINNEST).min(WIDEST);
        let foot: Vec<_> = self.foot().map(|p| place(&p)).collect();
        canvas.fill(&foot, EDGE, 1.0)?;
        let joints: Vec<_> = self.start.iter().map(place).collect();
        let links = joints.len().saturating_sub(2);
        // The rim of all links first, so that they become one body.
        for (colour, rim) in [(EDGE, 1.0), (BODY, 0.0)] {
            for (i, link) in joints.windows(2).enumerate() {
                let width = if i < links { width } else { (TOOL * width).max(THINNEST) } + 2.0 * rim;
                canvas.line(link, Pen::solid(colour, width))?;
                link.iter().try_for_each(|end| canvas.fill(&disc(*end, 0.5 * width), colour, 1.0))?;
            }
        }
        let end: Vec<_> = self.end.iter().map(place).collect();
        canvas.line(&end, Pen::solid(EDGE, 1.4))
    }
}

fn disc((x, y): (f64, f64), radius: f64) -> Vec<(f64, f64)> {
    let at = |i: u8| std::f64::consts::TAU * f64::from(i) / 24.0;
    (0..24).map(at).map(|a| (x + radius * a.cos(), y + radius * a.sin())).collect()
}
