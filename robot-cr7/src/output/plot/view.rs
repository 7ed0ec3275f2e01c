//! How places in space come onto a page.

use std::io;

use nalgebra::Vector3;
use plotters::prelude::RGBColor;

use super::canvas::{Anchor, Canvas, FRAME, PALETTE, Pen};
use super::panel::{Panel, range, widened};
use super::{LEFT, RIGHT};

pub(super) const FAINT: RGBColor = RGBColor(215, 215, 215);
/// A path whose height changes by more than this part of its width is seen from aside.
const FLAT: f64 = 1e-4;
/// Length of an arrow of the frame, pixels.
const ARROW: f64 = 34.0;
/// Squares of the floor along the longer side of a path, at the most.
const SQUARES: f64 = 12.0;

/// A view from a direction; straight lines stay straight and parallel.
pub(super) struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
}

impl View {
    const ELEVATION: f64 = 0.45;

    fn from(azimuth: f64) -> Self {
        let (sin, cos) = azimuth.sin_cos();
        let right = Vector3::new(-sin, cos, 0.0);
        let towards = Vector3::new(cos * Self::ELEVATION.cos(), sin * Self::ELEVATION.cos(), Self::ELEVATION.sin());
        Self { right, up: towards.cross(&right) }
    }

    /// Against the z axis.
    fn from_above() -> Self {
        Self { right: Vector3::x(), up: Vector3::y() }
    }

    /// The direction above the horizon from which the points cover most of a page.
    pub fn best(points: &[Vector3<f64>]) -> Self {
        let area = |view: &Self| {
            let (x, y) = view.ranges(points);
            (x.1 - x.0) * (y.1 - y.0)
        };
        let views = (0..36).map(|i| Self::from(std::f64::consts::TAU * f64::from(i) / 36.0));
        views.max_by(|a, b| area(a).total_cmp(&area(b))).unwrap_or_else(|| Self::from(0.6))
    }

    pub fn flat(&self, p: &Vector3<f64>) -> (f64, f64) {
        (p.dot(&self.right), p.dot(&self.up))
    }

    pub fn ranges(&self, points: &[Vector3<f64>]) -> ((f64, f64), (f64, f64)) {
        (range(points.iter().map(|p| self.flat(p).0)), range(points.iter().map(|p| self.flat(p).1)))
    }
}

/// The ground below a picture, mm.
pub(super) struct PathGrid {
    pub height: f64,
    pub square: f64,
}

/// The floor under the points, in squares.
pub(super) fn grid(
    canvas: &Canvas<'_>,
    points: &[Vector3<f64>],
    ground: &PathGrid,
    place: &impl Fn(&Vector3<f64>) -> (f64, f64),
) -> Result<(), io::Error> {
    // Whole squares stay whole, whatever the division rounds to.
    let steps = |(low, high): (f64, f64)| {
        ((low / ground.square + 1e-6).floor() as i32, (high / ground.square - 1e-6).ceil() as i32)
    };
    let (x0, x1) = steps(range(points.iter().map(|p| p.x)));
    let (y0, y1) = steps(range(points.iter().map(|p| p.y)));
    let at = |x: i32, y: i32| {
        place(&(Vector3::new(f64::from(x), f64::from(y), 0.0) * ground.square + Vector3::z() * ground.height))
    };
    for x in (x0..=x1).take(60) {
        canvas.line(&[at(x, y0), at(x, y1)], Pen::solid(FAINT, 0.7))?;
    }
    for y in (y0..=y1).take(60) {
        canvas.line(&[at(x0, y), at(x1, y)], Pen::solid(FAINT, 0.7))?;
    }
    Ok(())
}

/// The part of a page on which a path is drawn at equal scale of both axes: along z where it is flat, else from aside over a floor.
pub(super) struct PathPage {
    view: View,
    pub shape: Panel,
    /// The floor and all points over it (mm), where the path is seen from aside.
    floor: Option<(PathGrid, Vec<Vector3<f64>>)>,
}

impl PathPage {
    /// For a path through `points` (x, y, z in m), from `top` (pixels) downwards.
    pub fn of<'p>(points: impl Iterator<Item = &'p [f64; 3]>, top: f64) -> Self {
        let finite = points.filter(|p| p.iter().all(|v| v.is_finite()));
        let mut all: Vec<Vector3<f64>> = finite.map(|p| Vector3::from(*p) * 1e3).collect();
        let sides = [0, 1, 2].map(|k| ends(all.iter().map(|p| p[k])));
        let [wide, deep, high] = sides.map(|side| side[1] - side[0]);
        let size = wide.max(deep).max(high);
        let (view, floor) = if high > FLAT * wide.max(deep) {
            let ground = PathGrid { height: sides[2][0] - 0.15 * size, square: round_length(size / SQUARES) };
            // The whole of its squares.
            let whole = |[low, high]: [f64; 2]| {
                [(low / ground.square).floor() * ground.square, (high / ground.square).ceil() * ground.square]
            };
            let [across, along] = [whole(sides[0]), whole(sides[1])];
            all.extend(across.iter().flat_map(|x| along.map(|y| Vector3::new(*x, y, ground.height))));
            (View::best(&all), Some(ground))
        } else {
            (View::from_above(), None)
        };
        let (x, y) = view.ranges(&all);
        let (x, y) = (widened(x, 0.04), widened(y, 0.04));
        // Equal scale: the height of the panel follows the path, within what fits a screen; then the width gives way.
        let height = ((RIGHT - LEFT) * (y.1 - y.0) / (x.1 - x.0)).clamp(220.0, 640.0);
        let scale = ((RIGHT - LEFT) / (x.1 - x.0)).min(height / (y.1 - y.0));
        let grown = |(a, b): (f64, f64), pixels: f64| {
            let (middle, half) = (0.5 * (a + b), 0.5 * pixels / scale);
            (middle - half, middle + half)
        };
        let (x, y) = (grown(x, RIGHT - LEFT), grown(y, height));
        let shape = Panel { left: LEFT, right: RIGHT, top, bottom: top + height, x, y };
        Self { view, shape, floor: floor.map(|ground| (ground, all)) }
    }

    /// Pixel of a place in m.
    pub fn place(&self, p: &[f64; 3]) -> (f64, f64) {
        self.shape.place(self.view.flat(&(Vector3::from(*p) * 1e3)))
    }

    /// What a square of the floor is, in words, where there is one.
    pub fn words(&self) -> String {
        self.floor.as_ref().map_or_else(String::new, |(ground, _)| {
            format!("; one square of the floor is {} mm", crate::text::number(ground.square))
        })
    }

    /// Axes, or the floor with the directions of the frame.
    pub fn axes(&self, canvas: &Canvas<'_>) -> Result<(), io::Error> {
        let Some((ground, points)) = &self.floor else {
            return self.shape.axes(canvas, Some("x [mm]"), "y [mm]");
        };
        let place = |p: &Vector3<f64>| self.shape.place(self.view.flat(p));
        grid(canvas, points, ground, &place)?;
        let Panel { left: l, right: r, top: t, bottom: b, .. } = self.shape;
        canvas.line(&[(l, t), (r, t), (r, b), (l, b), (l, t)], Pen::solid(FRAME, 1.0))?;
        let origin = (l + 1.6 * ARROW, b - 1.2 * ARROW);
        for (axis, name) in [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")] {
            let (right, up) = self.view.flat(&axis);
            let at = |length: f64| (origin.0 + length * right, origin.1 - length * up);
            canvas.line(&[origin, at(ARROW)], Pen::solid(PALETTE[5], 1.6))?;
            canvas.text(name, at(ARROW + 9.0), Anchor::Middle)?;
        }
        Ok(())
    }

    /// The shadow of a place in m on the floor, where there is one.
    pub fn shadow(&self, p: &[f64; 3]) -> Option<(f64, f64)> {
        let (ground, _) = self.floor.as_ref()?;
        Some(self.shape.place(self.view.flat(&Vector3::new(p[0] * 1e3, p[1] * 1e3, ground.height))))
    }
}

/// The least and the greatest; 0 for nothing.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let wide = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
    Some(values.fold([f64::INFINITY, f64::NEG_INFINITY], wide)).filter(|ends| ends[0] <= ends[1]).unwrap_or_default()
}

/// The next of 1, 2, 5, 10, 20 .. that is no less; 10 for nothing.
fn round_length(length: f64) -> f64 {
    let finest = 10f64.powf(length.log10().floor());
    let rounded = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * finest).into_iter().find(|step| *step >= length);
    rounded.filter(|step| step.is_normal()).unwrap_or(10.0)
}

/// Points at least a third of a pixel apart.
pub(super) fn thin(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    for p in points.filter(|p| p.0.is_finite() && p.1.is_finite()) {
        if out.last().is_none_or(|l| (l.0 - p.0).hypot(l.1 - p.1) > 0.33) {
            out.push(p);
        }
    }
    if out.is_empty() {
        out.push((0.0, 0.0));
    }
    out
}
