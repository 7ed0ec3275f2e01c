//! How places in space come onto a page.

use std::f64::consts::PI;
use std::io;

use nalgebra::Vector3;
use plotters::prelude::RGBColor;

use super::arm::ArmShape;
use super::canvas::{Anchor, Canvas, FRAME, PALETTE, Pen};
use super::panel::{Panel, range, widened};

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

/// The part of a page that is left for a picture in space, pixels.
#[derive(Clone, Copy)]
pub(super) struct Sheet {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    /// The least and the greatest height.
    pub heights: (f64, f64),
}

/// The part of a page on which a path is drawn at equal scale of both axes: along z where it is flat, else from aside over a floor.
pub(super) struct PathPage {
    view: View,
    pub shape: Panel,
    /// The floor and all points over it (mm), where the path is seen from aside.
    floor: Option<(PathGrid, Vec<Vector3<f64>>)>,
    /// The arm that stands on the floor.
    arm: Option<ArmShape>,
}

impl PathPage {
    /// For a path through `points` (x, y, z in m), with an arm beside it where there is one.
    pub fn of(points: impl Iterator<Item = [f64; 3]>, sheet: Sheet, arm: Option<ArmShape>) -> Self {
        let finite = points.filter(|p| p.iter().all(|v| v.is_finite()));
        let mut all: Vec<Vector3<f64>> = finite.map(|p| Vector3::from(p) * 1e3).collect();
        let lowest = ends(all.iter().map(|p| p.z))[0];
        all.extend(arm.iter().flat_map(ArmShape::points));
        let sides = [0, 1, 2].map(|k| ends(all.iter().map(|p| p[k])));
        let [wide, deep, high] = sides.map(|side| side[1] - side[0]);
        let size = wide.max(deep).max(high);
        let (view, floor) = if high > FLAT * wide.max(deep) {
            // An arm stands on the floor, unless the path is below it.
            let height = arm.as_ref().map_or(lowest - 0.15 * size, |arm| arm.base().z.min(lowest));
            let ground = PathGrid { height, square: round_length(size / SQUARES) };
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
        let Sheet { left, right, top, heights } = sheet;
        let height = ((right - left) * (y.1 - y.0) / (x.1 - x.0)).max(heights.0).min(heights.1);
        let scale = ((right - left) / (x.1 - x.0)).min(height / (y.1 - y.0));
        let grown = |(a, b): (f64, f64), pixels: f64| {
            let (middle, half) = (0.5 * (a + b), 0.5 * pixels / scale);
            (middle - half, middle + half)
        };
        let (x, y) = (grown(x, right - left), grown(y, height));
        let shape = Panel { left, right, top, bottom: top + height, x, y };
        Self { view, shape, floor: floor.map(|ground| (ground, all)), arm }
    }

    /// The longest side of the box around these points (m) and whether they lie in a plane of one height.
    pub fn size_of(points: impl Iterator<Item = [f64; 3]> + Clone) -> (f64, bool) {
        let side = |k: usize| ends(points.clone().map(|p| p[k]).filter(|v| v.is_finite()));
        let [wide, deep, high] = [0, 1, 2].map(side).map(|[low, high]| high - low);
        (wide.max(deep).max(high), high <= FLAT * wide.max(deep))
    }

    /// The arm, where there is one: what is drawn after it is on top.
    pub fn arm(&self, canvas: &Canvas<'_>) -> Result<(), io::Error> {
        let Some(arm) = &self.arm else { return Ok(()) };
        let Panel { left, right, top, x, .. } = self.shape;
        arm.draw(canvas, &|p| self.shape.place(self.view.flat(p)), (right - left) / (x.1 - x.0))?;
        canvas.text("the arm at the start; thin: at the end", (left + 10.0, top + 16.0), Anchor::Left)
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

/// What may be left out of a line, pixels.
const INVISIBLE: f64 = 0.15;

/// A line without the points that nobody sees: those that are left out lie within a part of a pixel of what remains. First and last stay.
pub(super) fn thin(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut points = points.filter(|p| p.0.is_finite() && p.1.is_finite());
    let first = points.next().unwrap_or_default();
    let (mut out, mut chord, mut before) = (vec![first], ChordFan::from(first), first);
    for p in points {
        if !chord.takes(p) {
            out.push(before);
            chord = ChordFan::from(before);
            chord.takes(p);
        }
        before = p;
    }
    if before != first || out.len() > 1 {
        out.push(before);
    }
    out
}

/// The chords from one point that pass by all points seen so far.
struct ChordFan {
    from: (f64, f64),
    /// Distance of the farthest point.
    far: f64,
    /// The direction of the first point that has one, and the least and the greatest angle from it, rad.
    axis: Option<(f64, f64)>,
    least: f64,
    greatest: f64,
}

impl ChordFan {
    fn from(from: (f64, f64)) -> Self {
        Self { from, far: 0.0, axis: None, least: -0.5 * PI, greatest: 0.5 * PI }
    }

    /// Takes one more point, or is false where the chord to it would miss another one, or would turn back.
    fn takes(&mut self, p: (f64, f64)) -> bool {
        let (x, y) = (p.0 - self.from.0, p.1 - self.from.1);
        let distance = x.hypot(y);
        if distance < self.far - INVISIBLE {
            return false;
        }
        if distance <= INVISIBLE {
            return true;
        }
        let axis = *self.axis.get_or_insert((x, y));
        let angle = (axis.0 * y - axis.1 * x).atan2(axis.0 * x + axis.1 * y);
        if !(self.least..=self.greatest).contains(&angle) {
            return false;
        }
        let half = (INVISIBLE / distance).asin();
        self.least = self.least.max(angle - half);
        self.greatest = self.greatest.min(angle + half);
        self.far = self.far.max(distance);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance of a point from a line of points.
    fn off(p: (f64, f64), line: &[(f64, f64)]) -> f64 {
        let one = |w: &[(f64, f64)]| {
            let (dx, dy) = (w[1].0 - w[0].0, w[1].1 - w[0].1);
            let along = ((p.0 - w[0].0) * dx + (p.1 - w[0].1) * dy) / (dx * dx + dy * dy).max(1e-300);
            let along = along.clamp(0.0, 1.0);
            (p.0 - w[0].0 - along * dx).hypot(p.1 - w[0].1 - along * dy)
        };
        line.windows(2).map(one).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn what_is_left_out_of_a_line_lies_on_it() {
        // 60 laps of a circle, and a line that turns back on itself.
        let circle = (0..=60_000).map(|i| f64::from(i) * 0.00628).map(|a| (300.0 + 200.0 * a.cos(), 200.0 * a.sin()));
        let circle: Vec<_> = circle.collect();
        let there: Vec<_> = (0..=1000).map(|i| (f64::from(i) * 0.1, 0.0)).collect();
        let back: Vec<_> = there.iter().chain(there[500..].iter().rev()).copied().collect();
        for line in [&circle, &back] {
            let thinned = thin(line.iter().copied());
            assert_eq!((thinned.first(), thinned.last()), (line.first(), line.last()));
            assert!(thinned.len() < line.len() / 2, "{} of {}", thinned.len(), line.len());
            // The first laps are enough.
            for p in line.iter().take(2000) {
                let away = off(*p, &thinned[..thinned.len().min(200)]);
                assert!(away < 1.5 * INVISIBLE, "{p:?}: {away}");
            }
        }
        assert_eq!(thin(std::iter::empty()), [(0.0, 0.0)]);
        assert_eq!(thin([(1.0, 2.0)].into_iter()), [(1.0, 2.0)]);
        assert_eq!(thin([(1.0, 2.0), (f64::NAN, 0.0), (1.1, 2.0)].into_iter()), [(1.0, 2.0), (1.1, 2.0)]);
    }
}
