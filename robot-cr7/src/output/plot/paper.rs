//! Pictures of the figures of papers.

use std::io;

use super::canvas::{Anchor, LIMIT, PALETTE, Pen, page};
use super::panel::{Panel, range, widened};
use super::schedule::{joint_panels_picture, speed_picture};
use super::{LEFT, RIGHT, WIDTH};
use crate::output::paper_figure::{Drawing, PanelPlot, PaperFigure, PlanePlot};

/// Height of one panel and distance to the next, pixels.
const HEIGHT: f64 = 190.0;
const PITCH: f64 = 252.0;

/// The figure as an SVG.
///
/// # Errors
/// When the drawing library fails.
pub fn paper_picture(figure: &PaperFigure) -> Result<String, io::Error> {
    match &figure.drawing {
        Drawing::Panels(panels) => panels_picture(figure, panels),
        Drawing::Plane(plane) => plane_picture(figure, plane),
        Drawing::Speed(speed) => speed_picture(speed),
        Drawing::Joints(joints) => joint_panels_picture(joints),
    }
}

fn panels_picture(figure: &PaperFigure, panels: &[PanelPlot]) -> Result<String, io::Error> {
    let top = 112.0;
    let height = top + PITCH * panels.len() as f64 - (PITCH - HEIGHT) + 58.0;
    page(WIDTH, height as u32, |canvas| {
        let mut legend: Vec<(&str, Pen)> = Vec::new();
        for panel in panels {
            for (i, line) in panel.lines.iter().enumerate() {
                if !line.name.is_empty() && legend.iter().all(|(name, _)| *name != line.name) {
                    legend.push((&line.name, pen(i)));
                }
            }
        }
        if panels.iter().any(|panel| !panel.limits.is_empty()) {
            legend.push(("limit", Pen::solid(LIMIT, 1.4)));
        }
        canvas.tall_header(&figure.title, &figure.facts, &legend)?;
        for (i, plot) in panels.iter().enumerate() {
            let at = top + PITCH * i as f64;
            let points = || plot.lines.iter().chain(&plot.limits).flat_map(|l| &l.points);
            let x = range(points().map(|p| p.0));
            let y = widened(range(points().map(|p| p.1)), 0.08);
            let panel = Panel { left: LEFT, right: RIGHT, top: at, bottom: at + HEIGHT, x, y };
            panel.axes(canvas, Some(&plot.across), &plot.label)?;
            let mut last = f64::NEG_INFINITY;
            for (place, name) in plot.marks.iter().filter(|m| (x.0..=x.1).contains(&m.0)) {
                panel.series(canvas, &[(*place, y.0), (*place, y.1)], Pen::dashed(PALETTE[5], 0.9))?;
                let px = panel.place((*place, 0.0)).0;
                // Names keep clear of each other and of the edge.
                let width = 6.0 * name.chars().count() as f64;
                let middle = px.min(RIGHT - 0.5 * width);
                if middle - last > width + 12.0 {
                    canvas.text(name, (middle, at - 9.0), Anchor::Middle)?;
                    last = middle;
                }
            }
            for limit in &plot.limits {
                panel.series(canvas, &limit.points, Pen::solid(LIMIT, 1.2))?;
            }
            for (i, line) in plot.lines.iter().enumerate() {
                panel.series(canvas, &line.points, pen(i))?;
            }
        }
        Ok(())
    })
}

fn pen(i: usize) -> Pen {
    Pen::solid(PALETTE[i % PALETTE.len()], 1.6)
}

fn plane_picture(figure: &PaperFigure, plane: &PlanePlot) -> Result<String, io::Error> {
    let points = || plane.curves.iter().flat_map(|c| &c.points).chain(plane.points.iter().map(|p| &p.0));
    let x = widened(range(points().map(|p| p[0])), 0.05);
    let y = widened(range(points().map(|p| p[1])), 0.05);
    let height = ((RIGHT - LEFT) * (y.1 - y.0) / (x.1 - x.0)).clamp(240.0, 620.0);
    let scale = ((RIGHT - LEFT) / (x.1 - x.0)).min(height / (y.1 - y.0));
    let grown = |(a, b): (f64, f64), pixels: f64| {
        let (middle, half) = (0.5 * (a + b), 0.5 * pixels / scale);
        (middle - half, middle + half)
    };
    let top = 96.0;
    let (x, y) = (grown(x, RIGHT - LEFT), grown(y, height));
    let panel = Panel { left: LEFT, right: RIGHT, top, bottom: top + height, x, y };
    page(WIDTH, (panel.bottom + 56.0) as u32, |canvas| {
        let mut legend: Vec<(&str, Pen)> = Vec::new();
        for curve in plane.curves.iter().filter(|c| !c.name.is_empty()) {
            if legend.iter().all(|(name, _)| *name != curve.name) {
                legend.push((&curve.name, pen(curve.colour)));
            }
        }
        canvas.tall_header(&figure.title, &figure.facts, &legend)?;
        panel.axes(canvas, Some(&plane.across), &plane.label)?;
        for curve in &plane.curves {
            let width = if curve.thin { 1.0 } else { 2.2 };
            let placed: Vec<_> = curve.points.iter().map(|p| panel.place((p[0], p[1]))).collect();
            canvas.line(&placed, Pen { width, ..pen(curve.colour) })?;
        }
        for (point, name) in &plane.points {
            let (px, py) = panel.place((point[0], point[1]));
            canvas.rectangle((px - 3.0, py - 3.0), (px + 3.0, py + 3.0), PALETTE[5])?;
            if !name.is_empty() {
                let (anchor, beside) = if px > RIGHT - 90.0 { (Anchor::Right, -8.0) } else { (Anchor::Left, 8.0) };
                canvas.text(name, (px + beside, py - 9.0), anchor)?;
            }
        }
        Ok(())
    })
}
