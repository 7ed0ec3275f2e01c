//! The path of the tool, coloured by what limits the motion there or by its speed.

use std::io;

use plotters::style::RGBColor;

use super::arm::{ArmAtEnds, ArmShape};
use super::canvas::{Anchor, Canvas, LIMIT, PALETTE, Pen, page};
use super::panel::Panel;
use super::view::{FAINT, PathPage, Sheet, thin};
use super::{LEFT, RIGHT, WIDTH};
use crate::output::binding_line::BindingLine;
use crate::text::number;

/// Segments of a path without a motion that are told apart by colours, at the most.
const FEW: usize = 60;
/// Limits that have a colour of their own, at the most; they bind on this part of the path at least.
const MOST_LIMITS: usize = 4;
const LEAST_SHARE: f64 = 0.002;
/// Where another limit binds, and where none does.
const OTHER: RGBColor = RGBColor(105, 105, 105);
const NONE: RGBColor = RGBColor(190, 190, 190);
/// Colours of the speed, from rest to the highest: dark blue, green, yellow. Their lightness grows, so that they can be told apart in grey.
const RAMP: [(u8, u8, u8); 6] =
    [(45, 20, 90), (40, 70, 140), (30, 120, 140), (40, 165, 110), (130, 200, 60), (240, 205, 30)];
/// Number of colours of the speed that are drawn.
const LEVELS: usize = 24;
/// Width of a path, pixels.
const THICK: f64 = 3.4;
/// Heights of the picture of a path, pixels, and the least one where the arm is drawn beside it.
const HEIGHTS: (f64, f64) = (220.0, 640.0);
const BESIDE_ARM: f64 = 320.0;
/// Width of the picture of the arm beside that of the path, and of the gap between both, pixels.
const ARM_WIDTH: f64 = 310.0;
const GAP: f64 = 24.0;
/// The arm stands in the picture of a path that has this part of its size at least; beside a smaller one it has a picture of its own.
const LARGE: f64 = 0.35;
/// The tolerance in a legend.
const TOLERANCE: (&str, Pen) = ("tolerance", Pen::dashed(LIMIT, 2.0));

/// A place that a motion passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPlace {
    /// x, y, z in the frame of the workpiece, m.
    pub at: [f64; 3],
    /// The way so far, m.
    pub s: f64,
    /// Speed of the tool, m/s.
    pub speed: f64,
}

/// A motion along a path: places in their order, and where each limit binds by the way.
#[derive(Debug, Clone, Copy)]
pub struct PathMotion<'a> {
    /// The places.
    pub places: &'a [PathPlace],
    /// The limits.
    pub binding: &'a [BindingLine],
    /// The arm at both ends.
    pub arm: Option<ArmAtEnds<'a>>,
}

/// The picture of a path, and that of arm and path where the path is small beside the arm.
struct Papers<'a> {
    path: PathPage,
    beside: Option<(PathPage, ArmAtEnds<'a>)>,
}

impl<'a> Papers<'a> {
    fn of<'p>(points: impl Iterator<Item = &'p [f64; 3]> + Clone, arm: Option<ArmAtEnds<'a>>, top: f64) -> Self {
        let points = points.copied();
        let sheet = Sheet { left: LEFT, right: RIGHT, top, heights: HEIGHTS };
        let Some((arm, shape)) = arm.and_then(|arm| Some((arm, ArmShape::of(&arm)?))) else {
            return Self { path: PathPage::of(points, sheet, None), beside: None };
        };
        let (size, is_flat) = PathPage::size_of(points.clone());
        let is_upright = (arm.workpiece.rotation * nalgebra::Vector3::z()).z > 1.0 - 1e-9;
        if !is_flat && is_upright && size * 1e3 >= LARGE * shape.size() {
            return Self { path: PathPage::of(points, sheet, Some(shape.seen_from(arm.workpiece))), beside: None };
        }
        let right = RIGHT - ARM_WIDTH - GAP;
        let path = PathPage::of(points.clone(), Sheet { right, heights: (BESIDE_ARM, HEIGHTS.1), ..sheet }, None);
        let height = path.shape.bottom - path.shape.top;
        let sheet = Sheet { left: RIGHT - ARM_WIDTH, heights: (height, height), ..sheet };
        let in_base = points.map(|p| arm.workpiece.transform_point(&p.into()).into());
        Self { path, beside: Some((PathPage::of(in_base, sheet, Some(shape)), arm)) }
    }

    /// Axes or floors, with the arm, and the path in the picture of the arm.
    fn ground<'p>(&self, canvas: &Canvas<'_>, points: impl Iterator<Item = &'p [f64; 3]>) -> Result<(), io::Error> {
        self.path.axes(canvas)?;
        self.path.arm(canvas)?;
        let Some((paper, arm)) = &self.beside else { return Ok(()) };
        paper.axes(canvas)?;
        paper.arm(canvas)?;
        let words = paper.words();
        let words = words.trim_start_matches("; ");
        canvas.text(words, (paper.shape.left + 10.0, paper.shape.top + 34.0), Anchor::Left)?;
        let finite = points.filter(|p| p.iter().all(|v| v.is_finite()));
        let in_base = finite.map(|p| arm.workpiece.transform_point(&(*p).into()).into());
        canvas.line(&thin(in_base.map(|p| paper.place(&p))), Pen::solid(PALETTE[0], 1.6))
    }
}

/// The path at equal scale of both axes, and the deviation of every segment below. With a motion it is coloured by the limit that binds,
/// else few segments are coloured in turn. A path that is not flat is seen from aside, over a floor. The arm of a motion stands behind a path
/// in space that is as large as a third of it, else beside the path in a picture of its own, which has the path at the same scale.
///
/// `segments` are dense polylines (x, y, z in m), one a segment; `deviations` the largest deviation of each from its chord in m;
/// `tolerance` in m.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn path_picture(
    name: &str,
    segments: &[Vec<[f64; 3]>],
    deviations: &[f64],
    tolerance: f64,
    motion: Option<PathMotion<'_>>,
) -> Result<String, io::Error> {
    let points = || segments.iter().flatten();
    let top = if motion.is_some() { 92.0 } else { 66.0 };
    let on_way = motion.iter().flat_map(|m| m.places.iter().map(|place| &place.at));
    let papers = Papers::of(points().chain(on_way), motion.and_then(|m| m.arm), top);
    let paper = &papers.path;
    let worst = deviations.iter().fold(0.0, |a: f64, &d| a.max(d));
    let under = paper.shape.bottom + 62.0;
    let (x, y) = ((0.0, deviations.len().max(1) as f64), (0.0, 1.15e6 * worst.max(tolerance).max(1e-12)));
    let below = Panel { left: LEFT, right: RIGHT, top: under, bottom: under + 150.0, x, y };
    let distance = |w: &[[f64; 3]]| (0..3).map(|k| (w[1][k] - w[0][k]).powi(2)).sum::<f64>().sqrt();
    let length: f64 = segments.iter().flat_map(|s| s.windows(2)).map(distance).sum();
    let facts = format!(
        "{} segments over {} mm; largest deviation {} µm of {} µm allowed{}",
        segments.len(),
        number(length * 1e3),
        number(worst * 1e6),
        number(tolerance * 1e6),
        paper.words()
    );
    page(WIDTH, (below.bottom + 52.0) as u32, |canvas| {
        match motion.filter(|motion| motion.places.len() > 1) {
            Some(motion) => {
                let shares = Shares::of(&motion);
                canvas.tall_header(name, &facts, &shares.legend())?;
                papers.ground(canvas, motion.places.iter().map(|place| &place.at))?;
                shadow(canvas, paper, motion.places.iter().map(|place| &place.at))?;
                let colours = motion.places.iter().map(|place| shares.colour(place.s));
                coloured(canvas, paper, motion.places, &colours.collect::<Vec<_>>())?;
            }
            None => {
                canvas.header(name, &facts, &[TOLERANCE])?;
                papers.ground(canvas, points())?;
                shadow(canvas, paper, points())?;
                in_turn(canvas, paper, segments)?;
            }
        }
        if let Some(start) = points().next() {
            let (px, py) = paper.place(start);
            canvas.line(&[(px - 5.0, py), (px + 5.0, py)], Pen::solid(PALETTE[5], 1.6))?;
            canvas.line(&[(px, py - 5.0), (px, py + 5.0)], Pen::solid(PALETTE[5], 1.6))?;
            canvas.text("start", (px + 8.0, py - 10.0), Anchor::Left)?;
        }
        below.axes(canvas, Some("segment"), "deviation [µm]")?;
        bars(canvas, &below, deviations, motion.is_none() && segments.len() <= FEW)?;
        below.level(canvas, tolerance * 1e6)
    })
}

/// The path coloured by the speed of the tool, seen as by [`path_picture`].
///
/// # Errors
/// The error of the picture's memory, which does not happen.
pub fn speed_path_picture(name: &str, motion: PathMotion<'_>) -> Result<String, io::Error> {
    let places = motion.places;
    let papers = Papers::of(places.iter().map(|place| &place.at), motion.arm, 82.0);
    let paper = &papers.path;
    let speeds = || places.iter().map(|place| place.speed).filter(|speed| speed.is_finite());
    let highest = speeds().fold(0.0f64, f64::max);
    page(WIDTH, (paper.shape.bottom + 52.0) as u32, |canvas| {
        let facts = format!("the path of the tool, coloured by its speed{}", paper.words());
        canvas.header(name, &facts, &[])?;
        papers.ground(canvas, places.iter().map(|place| &place.at))?;
        shadow(canvas, paper, places.iter().map(|place| &place.at))?;
        let colours = places.iter().map(|place| colour_of(level_of(place.speed, highest)));
        coloured(canvas, paper, places, &colours.collect::<Vec<_>>())?;
        // The scale of the colours.
        let (left, width) = (RIGHT - 330.0, 200.0 / LEVELS as f64);
        for k in 0..LEVELS {
            let from = left + k as f64 * width;
            canvas.rectangle((from, 40.0), (from + width + 1.0, 52.0), colour_of(k))?;
        }
        canvas.text("0", (left, 64.0), Anchor::Middle)?;
        canvas.text(&format!("{} mm/s", number(highest * 1e3)), (left + 200.0, 64.0), Anchor::Middle)
    })
}

/// The limits of a motion, those that bind longest first, with the part of the way on which each does.
struct Shares<'a> {
    lines: Vec<(f64, &'a BindingLine)>,
}

impl<'a> Shares<'a> {
    fn of(motion: &PathMotion<'a>) -> Self {
        let length = motion.places.last().map_or(0.0, |place| place.s);
        let mut lines: Vec<_> = motion.binding.iter().map(|line| (line.length() / length, line)).collect();
        lines.sort_by(|a, b| b.0.total_cmp(&a.0));
        Self { lines }
    }

    /// Those with a colour of their own.
    fn named(&self) -> &[(f64, &'a BindingLine)] {
        let count = self.lines.iter().take(MOST_LIMITS).take_while(|(share, _)| *share >= LEAST_SHARE).count();
        &self.lines[..count]
    }

    /// The colour at a place: of several limits the one that binds least elsewhere is shown.
    fn colour(&self, s: f64) -> RGBColor {
        let binds = |line: &BindingLine| {
            let i = line.intervals.partition_point(|[from, _]| *from <= s);
            i.checked_sub(1).is_some_and(|i| s <= line.intervals[i][1])
        };
        let named = self.named();
        let own = named.iter().rposition(|(_, line)| binds(line));
        let other = || self.lines[named.len()..].iter().any(|(_, line)| binds(line));
        own.map_or_else(|| if other() { OTHER } else { NONE }, |i| PALETTE[i])
    }

    fn legend(&self) -> Vec<(&'a str, Pen)> {
        let named = self.named().iter().enumerate();
        let mut legend: Vec<_> =
            named.map(|(i, (_, line))| (line.limit.as_str(), Pen::solid(PALETTE[i], THICK))).collect();
        if self.lines.len() > legend.len() {
            legend.push(("another limit", Pen::solid(OTHER, THICK)));
        }
        legend.push(("no limit at 99.9 %", Pen::solid(NONE, THICK)));
        legend.push(TOLERANCE);
        legend
    }
}

/// Places in their order, a line for each run of one colour.
fn coloured(
    canvas: &Canvas<'_>,
    paper: &PathPage,
    places: &[PathPlace],
    colours: &[RGBColor],
) -> Result<(), io::Error> {
    let finite = |i: &usize| places[*i].at.iter().all(|v| v.is_finite());
    let shown: Vec<usize> = (0..places.len()).filter(finite).collect();
    let mut from = 0;
    while from + 1 < shown.len() {
        let colour = colours[shown[from]];
        let to = (from + 1..shown.len()).find(|&i| colours[shown[i]] != colour).unwrap_or(shown.len() - 1);
        let run = thin(shown[from..=to].iter().map(|&i| paper.place(&places[i].at)));
        canvas.line(&run, Pen::solid(colour, THICK))?;
        from = to;
    }
    Ok(())
}

/// The shadow of a path on the floor, where it is seen from aside.
fn shadow<'p>(
    canvas: &Canvas<'_>,
    paper: &PathPage,
    points: impl Iterator<Item = &'p [f64; 3]>,
) -> Result<(), io::Error> {
    let finite = points.filter(|p| p.iter().all(|v| v.is_finite()));
    let mut shadow = finite.filter_map(|p| paper.shadow(p)).peekable();
    if shadow.peek().is_none() {
        return Ok(());
    }
    canvas.line(&thin(shadow), Pen::solid(FAINT, 1.6))
}

/// Segments in turn of four colours where they are few, else in one.
fn in_turn(canvas: &Canvas<'_>, paper: &PathPage, segments: &[Vec<[f64; 3]>]) -> Result<(), io::Error> {
    let pen = |i: usize| Pen::solid(PALETTE[if segments.len() <= FEW { i % 4 } else { 0 }], 2.2);
    let finite = |p: &&[f64; 3]| p.iter().all(|v| v.is_finite());
    if segments.len() > FEW {
        // Jumps between segments that do not join are not drawn.
        let mut run: Vec<[f64; 3]> = Vec::new();
        for segment in segments {
            if run.last().is_some_and(|last| segment.first() != Some(last)) {
                canvas.line(&thin(run.drain(..).map(|p| paper.place(&p))), pen(0))?;
            }
            run.extend(segment.iter().filter(finite));
        }
        return canvas.line(&thin(run.iter().map(|p| paper.place(p))), pen(0));
    }
    for (i, segment) in segments.iter().enumerate() {
        let mut shown = segment.iter().filter(finite).peekable();
        if shown.peek().is_some() {
            canvas.line(&thin(shown.map(|p| paper.place(p))), pen(i))?;
        }
    }
    Ok(())
}

/// A bar a segment, `in_turn` of the colours of the segments; more bars than pixels become one outline of the largest a pixel.
fn bars(canvas: &Canvas<'_>, panel: &Panel, deviations: &[f64], in_turn: bool) -> Result<(), io::Error> {
    let columns = (panel.right - panel.left) as usize;
    if deviations.len() * 3 <= columns {
        for (i, &d) in deviations.iter().enumerate() {
            let a = panel.place((i as f64 + 0.1, 0.0));
            let b = panel.place((i as f64 + 0.9, d * 1e6));
            canvas.rectangle((a.0, b.1), (b.0, a.1), PALETTE[if in_turn { i % 4 } else { 0 }])?;
        }
        return Ok(());
    }
    let mut outline = vec![panel.place((0.0, 0.0))];
    let mut i = 0;
    for column in 0..columns {
        let end = ((column + 1) * deviations.len() / columns).max(i + 1).min(deviations.len());
        if i >= end {
            break;
        }
        let largest = deviations[i..end].iter().fold(0.0, |a: f64, &d| a.max(d)) * 1e6;
        outline.extend([panel.place((i as f64, largest)), panel.place((end as f64, largest))]);
        i = end;
    }
    outline.push(panel.place((deviations.len() as f64, 0.0)));
    canvas.fill(&outline, PALETTE[0], 0.75)
}

/// The colour of a speed on the way to the highest one.
pub(super) fn level_of(speed: f64, highest: f64) -> usize {
    ((speed / highest.max(f64::MIN_POSITIVE) * LEVELS as f64) as usize).min(LEVELS - 1)
}

pub(super) fn colour_of(level: usize) -> RGBColor {
    let place = level as f64 / (LEVELS - 1) as f64 * (RAMP.len() - 1) as f64;
    let i = (place as usize).min(RAMP.len() - 2);
    let ((r0, g0, b0), (r1, g1, b1)) = (RAMP[i], RAMP[i + 1]);
    let between = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * (place - i as f64)).round() as u8;
    RGBColor(between(r0, r1), between(g0, g1), between(b0, b1))
}
