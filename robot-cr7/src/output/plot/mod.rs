//! Pictures of paths, speeds and joint curves, as SVG.
//!
//! Every input is in SI; the pictures show millimetres and degrees. Long series are thinned so that each pixel column
//! keeps its least and largest value: no peak is lost. Values that are not finite leave a gap.

mod arm;
mod canvas;
mod compare;
mod decimate;
mod motion;
mod panel;
mod paper;
mod path;
#[cfg(feature = "png")]
mod png;
mod run;
mod run_space;
mod run_states;
mod schedule;
#[cfg(feature = "controller")]
mod sent;
mod view;

use std::io::{self, Write};
use std::path::Path;

use crate::input::error::InputError;
use crate::output::whole_file::{unwritten, write_whole};
use crate::run::limit_line::TOLERANCE;
use crate::text::{number, percent};
pub use arm::ArmAtEnds;
pub use motion::motion_picture;
pub use paper::paper_picture;
pub use path::{PathMotion, PathPlace, path_picture, speed_path_picture};
#[cfg(feature = "png")]
pub use png::{PngError, PngPainter};
pub use run::{Picture, run_pictures};
pub use schedule::{joint_panels_picture, shares_picture, speed_picture};
#[cfg(feature = "controller")]
pub use sent::sent_picture;

use canvas::{Anchor, Canvas, LIMIT, PALETTE, Pen, page};
use panel::{Panel, range, widened};

pub use compare::compare_picture;

const WIDTH: u32 = 1080;
const LEFT: f64 = 88.0;
const RIGHT: f64 = 1056.0;

/// The quantity on a picture's x axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// Arc length, given in m and shown in mm.
    Length,
    /// Time in s.
    Time,
}

impl Along {
    fn factor(self) -> f64 {
        match self {
            Self::Length => 1e3,
            Self::Time => 1.0,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Length => "path length s [mm]",
            Self::Time => "time t [s]",
        }
    }
}

/// Which derivative of the joint angles a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointQuantity {
    /// Angle, given in rad.
    Position,
    /// Velocity, given in rad/s.
    Velocity,
    /// Acceleration, given in rad/s^2.
    Acceleration,
    /// Jerk, given in rad/s^3.
    Jerk,
}

impl JointQuantity {
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Position => ("Joint position", "deg"),
            Self::Velocity => ("Joint velocity", "deg/s"),
            Self::Acceleration => ("Joint acceleration", "deg/s²"),
            Self::Jerk => ("Joint jerk", "deg/s³"),
        }
    }
}

/// The limit of one joint in [`joint_picture`], in the unit of the curve.
#[derive(Debug, Clone, Copy)]
pub enum Bound<'a> {
    /// The same all the time, for both signs.
    Constant(f64),
    /// From a lower to an upper end.
    Between(f64, f64),
    /// One value for each time of the picture, for both signs.
    OverTime(&'a [f64]),
}

impl Bound<'_> {
    /// Lower and upper end at sample `i`.
    fn at(&self, i: usize) -> (f64, f64) {
        match self {
            Self::Constant(limit) => (-limit, *limit),
            Self::Between(low, high) => (*low, *high),
            Self::OverTime(limits) => limits.get(i).map_or((0.0, 0.0), |&limit| (-limit, limit)),
        }
    }

    /// The part of it that `value` uses.
    fn used(&self, value: f64, i: usize) -> f64 {
        let (low, high) = self.at(i);
        (value - 0.5 * (low + high)).abs() / (0.5 * (high - low))
    }

    /// Widest lower and upper end.
    fn widest(&self) -> (f64, f64) {
        match self {
            Self::OverTime(limits) => {
                let most = limits.iter().fold(0.0, |a: f64, &v| a.max(v));
                (-most, most)
            }
            _ => self.at(0),
        }
    }
}

/// A named line of [`lines_picture`].
#[derive(Debug, Clone, Copy)]
pub struct Line<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Points in the units of the axis labels, x not decreasing.
    pub points: &'a [(f64, f64)],
}

/// Saves a picture, whole or not at all.
///
/// # Errors
/// Fails when the file cannot be written.
pub fn save_picture(file: &Path, svg: &str) -> Result<(), InputError> {
    write_whole(file, |mut part| part.write_all(svg.as_bytes()).map_err(unwritten(file)))
}

/// The feed under its limit curve; what lies above the limit is tinted.
///
/// `feed` and `limit` are (x, m/s), x in m or s as `along` says. A limit that is not finite is none: the curve runs out
/// at the top of the picture there.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn feed_picture(name: &str, along: Along, feed: &[(f64, f64)], limit: &[(f64, f64)]) -> Result<String, io::Error> {
    let shown = |p: &(f64, f64)| (p.0 * along.factor(), p.1 * 1e3);
    let feed: Vec<_> = feed.iter().map(shown).collect();
    let fastest = range(feed.iter().map(|p| p.1)).1.max(0.0);
    let top = if fastest > 0.0 { 1.3 * fastest } else { 1.0 };
    let mut limit: Vec<_> = limit.iter().map(shown).collect();
    for p in &mut limit {
        // Far above the picture but near enough for the cut at its edge to be exact.
        if p.1.is_nan() || p.1 > 1e3 * top {
            p.1 = 1e3 * top;
        }
    }
    let mean = mean_speed(&feed, along);
    let x = range(feed.iter().chain(&limit).map(|p| p.0));
    let facts = format!(
        "fastest {} mm/s{}",
        number(fastest),
        mean.map(|m| format!(", mean {} mm/s", number(m))).unwrap_or_default()
    );
    page(WIDTH, 430, |canvas| {
        let pens = [Pen::solid(PALETTE[0], 1.8), Pen::solid(LIMIT, 1.2)];
        let legend = [("feed", pens[0]), ("limit", pens[1])];
        canvas.header(name, &facts, if limit.is_empty() { &legend[..1] } else { &legend })?;
        let panel = Panel { left: LEFT, right: RIGHT, top: 66.0, bottom: 374.0, x, y: (0.0, top) };
        panel.shade_above(canvas, &limit, LIMIT)?;
        panel.axes(canvas, Some(along.label()), "feed [mm/s]")?;
        panel.series(canvas, &limit, pens[1])?;
        panel.series(canvas, &feed, pens[0])
    })
}

/// Mean of the feed over time, by the trapezoidal rule; over length only the time integral of 1/v would be honest, and
/// it is singular at rest, so there is none.
fn mean_speed(feed: &[(f64, f64)], along: Along) -> Option<f64> {
    let span = feed.last()?.0 - feed.first()?.0;
    let area: f64 = feed.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
    Some(area / span).filter(|m| along == Along::Time && m.is_finite())
}

/// One panel a joint with its own limit lines.
///
/// `t` in s; `values` in rad, rad/s, ... one slice a joint, as long as `t`; `limits` in the same unit, for +- both; a thin line
/// at each of `marks` (s). A limit far above the curve would flatten it: then the panel shows the curve, and the number tells how much is used.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn joint_picture(
    name: &str,
    quantity: JointQuantity,
    t: &[f64],
    values: &[&[f64]],
    limits: &[Bound<'_>],
    marks: &[f64],
) -> Result<String, io::Error> {
    let (words, unit) = quantity.words();
    let degrees = 180.0 / std::f64::consts::PI;
    let x = range(t.iter().copied());
    let joints = values.len().min(limits.len());
    let peaks: Vec<f64> = values.iter().map(|v| v.iter().fold(0.0, |a: f64, v| a.max(v.abs()))).collect();
    let used = |j: usize| values[j].iter().enumerate().fold(0.0, |a: f64, (i, &v)| a.max(limits[j].used(v, i)));
    let used: Vec<f64> = (0..joints).map(used).collect();
    let worst = (0..joints).fold(0, |a, j| if used[j] > used[a] { j } else { a });
    let facts = format!(
        "{words} over {} s; most of its limit: J{} with {}",
        number(x.1 - x.0),
        worst + 1,
        percent(used.get(worst).copied().unwrap_or(0.0))
    );
    let (top, pitch, height) = (70.0, 116.0, 96.0);
    page(WIDTH, (top + joints as f64 * pitch + 32.0) as u32, |canvas| {
        let line = Pen::solid(PALETTE[0], 1.4);
        canvas.header(
            &format!("{name}: {}", words.to_lowercase()),
            &facts,
            &[(words, line), ("limit", Pen::dashed(LIMIT, 1.6))],
        )?;
        for j in 0..joints {
            let (low, high) = limits[j].widest();
            let (low, high) = (low * degrees, high * degrees);
            let limit = high.max(-low);
            let peak = peaks[j] * degrees;
            let points: Vec<_> = t.iter().zip(values[j]).map(|(&t, &v)| (t, v * degrees)).collect();
            // A joint that rests shows rounding, which deserves no scale of its own.
            let y = if peak >= 0.2 * limit || peak <= 1e-6 * limit {
                widened(range([low.min(-peak), high.max(peak)]), 0.06)
            } else {
                widened(range(points.iter().map(|p| p.1)), 0.12)
            };
            let panel_top = top + j as f64 * pitch;
            let panel = Panel { left: LEFT, right: RIGHT - 128.0, top: panel_top, bottom: panel_top + height, x, y };
            panel.axes(canvas, (j + 1 == joints).then_some(Along::Time.label()), &format!("J{} [{unit}]", j + 1))?;
            for &mark in marks.iter().filter(|&&t| t >= x.0 && t <= x.1) {
                panel.series(canvas, &[(mark, y.0), (mark, y.1)], Pen::dashed(PALETTE[5], 0.9))?;
            }
            panel.series(canvas, &points, line)?;
            bound_lines(canvas, &panel, t, limits[j])?;
            let beside = |row: f64| (panel.right + 10.0, panel_top + 18.0 + 20.0 * row);
            canvas.text(&format!("peak {} {unit}", number(peak)), beside(0.0), Anchor::Left)?;
            let words = match limits[j] {
                Bound::Between(..) => format!("{} to {} {unit}", number(low), number(high)),
                _ => format!("limit {} {unit}", number(limit)),
            };
            canvas.text(&words, beside(1.0), Anchor::Left)?;
            let text = format!("used {}", percent(used[j]));
            if used[j] > 1.0 + TOLERANCE {
                canvas.alarm(&text, beside(2.0), Anchor::Left)?;
            } else {
                canvas.text(&text, beside(2.0), Anchor::Left)?;
            }
            if !(panel.y.0..=panel.y.1).contains(&limit) {
                canvas.text("limit is off this scale", beside(3.0), Anchor::Left)?;
            }
        }
        Ok(())
    })
}

/// The limits of a joint in its panel, in degrees.
fn bound_lines(canvas: &Canvas<'_>, panel: &Panel, t: &[f64], bound: Bound<'_>) -> Result<(), io::Error> {
    let degrees = 180.0 / std::f64::consts::PI;
    match bound {
        Bound::Constant(_) | Bound::Between(..) => {
            let (low, high) = bound.widest();
            panel.level(canvas, high * degrees)?;
            panel.level(canvas, low * degrees)
        }
        Bound::OverTime(limits) => [1.0, -1.0].into_iter().try_for_each(|sign| {
            let over: Vec<_> = t.iter().zip(limits).map(|(&t, &v)| (t, sign * v * degrees)).collect();
            panel.series(canvas, &over, Pen::dashed(LIMIT, 1.6))
        }),
    }
}

/// Several lines over one x axis; `levels` are drawn as dashed lines.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn lines_picture(
    title: &str,
    facts: &str,
    (x_label, y_label): (&str, &str),
    lines: &[Line<'_>],
    levels: &[f64],
) -> Result<String, io::Error> {
    let points = || lines.iter().flat_map(|l| l.points);
    let x = range(points().map(|p| p.0));
    let y = widened(range(points().map(|p| p.1).chain(levels.iter().copied())), 0.06);
    page(WIDTH, 430, |canvas| {
        let pen = |i: usize| Pen::solid(PALETTE[i % PALETTE.len()], 1.6);
        let legend: Vec<_> = lines.iter().enumerate().map(|(i, l)| (l.name, pen(i))).collect();
        canvas.header(title, facts, &legend)?;
        let panel = Panel { left: LEFT, right: RIGHT, top: 66.0, bottom: 374.0, x, y };
        panel.axes(canvas, Some(x_label), y_label)?;
        for (i, line) in lines.iter().enumerate() {
            panel.series(canvas, line.points, pen(i))?;
        }
        levels.iter().try_for_each(|&y| panel.level(canvas, y))
    })
}
