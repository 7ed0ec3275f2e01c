//! A page with a title, a legend and panels with axes, drawn through the plotters SVG backend.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::{
    DrawingArea, IntoDrawingArea, IntoFont, PathElement, Polygon, RGBColor, Rectangle, SVGBackend, ShapeStyle, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, TextStyle};

use crate::text::clip;

/// Drawing units a pixel: the backend draws at whole units only, and whole pixels make curves look jagged.
const UNITS: f64 = 10.0;
/// The backend measures no text; this many em a letter is a little more than a sans-serif needs on average.
const LETTER: f64 = 0.55;
/// The SVG backend divides font sizes by this.
const FONT_FACTOR: f64 = 1.24;

/// Okabe and Ito's palette, told apart with every common colour blindness, in an order of good contrast on white.
pub(crate) const PALETTE: [RGBColor; 6] =
    [hex(0x00_72B2), hex(0xE6_9F00), hex(0x00_9E73), hex(0xCC_79A7), hex(0x56_B4E9), hex(0x5A_5A5A)];
/// Limits and tolerances.
pub(crate) const LIMIT: RGBColor = RGBColor(200, 30, 30);
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
const SOFT_INK: RGBColor = RGBColor(95, 95, 95);
pub(super) const GRID: RGBColor = RGBColor(228, 228, 228);
pub(super) const FRAME: RGBColor = RGBColor(150, 150, 150);

/// The colour with this number, red in its highest byte.
const fn hex(color: u32) -> RGBColor {
    let [_, red, green, blue] = color.to_be_bytes();
    RGBColor(red, green, blue)
}

/// The style of a line.
#[derive(Clone, Copy)]
pub(crate) struct Pen {
    pub color: RGBColor,
    /// Width in pixels.
    pub width: f64,
    pub dashed: bool,
}

impl Pen {
    pub const fn solid(color: RGBColor, width: f64) -> Self {
        Self { color, width, dashed: false }
    }

    pub const fn dashed(color: RGBColor, width: f64) -> Self {
        Self { color, width, dashed: true }
    }
}

/// The place of a text relative to its point.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Left,
    Middle,
    Right,
}

/// An SVG page; coordinates in pixels from the top left corner.
pub(crate) struct Canvas<'a> {
    root: DrawingArea<SVGBackend<'a>, Shift>,
    width: f64,
}

/// Draws a page of `width` x `height` pixels and returns its SVG text.
pub(crate) fn page(
    width: u32,
    height: u32,
    draw: impl FnOnce(&Canvas<'_>) -> Result<(), io::Error>,
) -> Result<String, io::Error> {
    let mut svg = String::new();
    let units = (width * UNITS as u32, height * UNITS as u32);
    {
        let root = SVGBackend::with_string(&mut svg, units).into_drawing_area();
        root.fill(&RGBColor(255, 255, 255)).map_err(io::Error::other)?;
        let canvas = Canvas { root, width: f64::from(width) };
        draw(&canvas)?;
        canvas.root.present().map_err(io::Error::other)?;
    }
    // The page is shown at its size in pixels, whatever the units it was drawn in.
    let drawn = format!("width=\"{}\" height=\"{}\"", units.0, units.1);
    Ok(svg.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\""), 1))
}

fn unit(v: f64) -> i32 {
    (v * UNITS).round() as i32
}

impl Canvas<'_> {
    /// A line through `points`; dashes only for lines of two points.
    pub fn line(&self, points: &[(f64, f64)], pen: Pen) -> Result<(), io::Error> {
        let style =
            ShapeStyle { color: pen.color.to_rgba(), filled: false, stroke_width: unit(pen.width).max(1) as u32 };
        let draw = |points: Vec<(i32, i32)>| self.root.draw(&PathElement::new(points, style)).map_err(io::Error::other);
        if let (true, [a, b]) = (pen.dashed, points) {
            let (dash, gap) = (9.0, 6.0);
            let length = (b.0 - a.0).hypot(b.1 - a.1);
            let at = |d: f64| {
                let f = (d / length).min(1.0);
                (unit(a.0 + (b.0 - a.0) * f), unit(a.1 + (b.1 - a.1) * f))
            };
            let count = if length > 0.0 { (length / (dash + gap)).ceil().min(1e4) as usize } else { 0 };
            for i in 0..count {
                let from = i as f64 * (dash + gap);
                draw(vec![at(from), at(from + dash)])?;
            }
            return Ok(());
        }
        let mut whole: Vec<_> = points.iter().map(|p| (unit(p.0), unit(p.1))).collect();
        whole.dedup();
        if whole.len() == 1 {
            // A single place still has to be seen.
            whole.push((whole[0].0 + 1, whole[0].1));
        }
        draw(whole)
    }

    pub fn fill(&self, points: &[(f64, f64)], color: RGBColor, opacity: f64) -> Result<(), io::Error> {
        let points: Vec<_> = points.iter().map(|p| (unit(p.0), unit(p.1))).collect();
        self.root.draw(&Polygon::new(points, color.mix(opacity).filled())).map_err(io::Error::other)
    }

    pub fn rectangle(&self, a: (f64, f64), b: (f64, f64), color: RGBColor) -> Result<(), io::Error> {
        let corners = [(unit(a.0), unit(a.1)), (unit(b.0), unit(b.1))];
        self.root.draw(&Rectangle::new(corners, color.filled())).map_err(io::Error::other)
    }

    pub(super) fn styled(
        &self,
        text: &str,
        at: (f64, f64),
        size: f64,
        color: RGBColor,
        anchor: Anchor,
        (bold, upwards): (bool, bool),
    ) -> Result<(), io::Error> {
        let mut font = ("sans-serif", size * UNITS * FONT_FACTOR).into_font();
        if bold {
            font = font.style(FontStyle::Bold);
        }
        if upwards {
            font = font.transform(FontTransform::Rotate270);
        }
        let h = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        let style = TextStyle::from(font).color(&color).pos(Pos::new(h, VPos::Center));
        self.root.draw(&Text::new(text, (unit(at.0), unit(at.1)), style)).map_err(io::Error::other)
    }

    /// A small text, centred vertically on its point.
    pub fn text(&self, text: &str, at: (f64, f64), anchor: Anchor) -> Result<(), io::Error> {
        self.styled(text, at, 12.0, SOFT_INK, anchor, (false, false))
    }

    /// Like [`Canvas::text`], in white, for a dark ground.
    pub fn white(&self, text: &str, at: (f64, f64), anchor: Anchor) -> Result<(), io::Error> {
        self.styled(text, at, 12.0, RGBColor(255, 255, 255), anchor, (true, false))
    }

    /// Like [`Canvas::text`], in the colour of limits, for what breaks one.
    pub fn alarm(&self, text: &str, at: (f64, f64), anchor: Anchor) -> Result<(), io::Error> {
        self.styled(text, at, 12.0, LIMIT, anchor, (true, false))
    }

    /// Title, a line of key numbers and a legend, at the top of the page, where they cover no data.
    pub fn header(&self, title: &str, facts: &str, legend: &[(&str, Pen)]) -> Result<(), io::Error> {
        let right = self.legend(legend, 24.0)?;
        self.title(title, facts, right)
    }

    /// Like [`Canvas::header`], with a legend too long for the line of the title on a line of its own.
    pub fn tall_header(&self, title: &str, facts: &str, legend: &[(&str, Pen)]) -> Result<(), io::Error> {
        self.legend(legend, 72.0)?;
        self.title(title, facts, self.width - 20.0)
    }

    /// Names beside strokes, up to the right edge; returns where they begin.
    fn legend(&self, legend: &[(&str, Pen)], y: f64) -> Result<f64, io::Error> {
        let mut right = self.width - 24.0;
        for (name, pen) in legend.iter().rev() {
            let left = right - LETTER * 12.0 * name.chars().count() as f64;
            self.styled(name, (left, y), 12.0, INK, Anchor::Left, (false, false))?;
            let swatch = [(left - 30.0, y), (left - 6.0, y)];
            self.line(&swatch, Pen { width: pen.width.max(2.0), ..*pen })?;
            right = left - 48.0;
        }
        Ok(right)
    }

    fn title(&self, title: &str, facts: &str, right: f64) -> Result<(), io::Error> {
        let title = clip(title, ((right - 20.0) / (1.15 * LETTER * 17.0)).max(10.0) as usize);
        self.styled(&title, (20.0, 24.0), 17.0, INK, Anchor::Left, (true, false))?;
        let facts = clip(facts, ((self.width - 40.0) / (LETTER * 12.5)) as usize);
        self.styled(&facts, (20.0, 47.0), 12.5, SOFT_INK, Anchor::Left, (false, false))
    }
}
