//! Pictures of scheduled motions.

use std::io;

use super::canvas::{Anchor, LIMIT, PALETTE, Pen, page};
use super::panel::{Panel, range, widened};
use super::{LEFT, RIGHT, WIDTH};
use crate::output::schedule_figure::{JointFigure, ShareFigure, SpeedFigure};
use crate::text::{number, percent};

/// Height of one row of bars.
const ROW: f64 = 22.0;

/// Speed under its limit curves; what no acceleration could keep is tinted, and bars below tell which limit binds.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn speed_picture(figure: &SpeedFigure) -> Result<String, io::Error> {
    let lines = || figure.speeds.iter().flat_map(|(_, points)| points);
    let fastest = range(lines().map(|p| p.1)).1.max(0.0);
    let top = if fastest > 0.0 { 1.35 * fastest } else { 1.0 };
    let x = range(lines().map(|p| p.0));
    // Far above the picture, but near enough for the cut at its edge to be exact.
    let capped = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        points.iter().map(|p| (p.0, if p.1 < 1e3 * top { p.1 } else { 1e3 * top })).collect()
    };
    let (ceiling, initial) = (capped(&figure.ceiling), capped(&figure.initial));
    let (left, first) = (LEFT + 92.0, 404.0);
    let height = first + ROW * figure.bindings.len().max(1) as f64 + 58.0;
    page(WIDTH, height as u32, |canvas| {
        let colours = [PALETTE[0], PALETTE[2], PALETTE[3], PALETTE[4]];
        let (over, constant) = (Pen::solid(LIMIT, 1.2), Pen::solid(PALETTE[1], 1.4));
        let pen = |i: usize| Pen::solid(colours[i % 4], if i == 0 { 2.2 } else { 1.4 });
        let mut legend: Vec<(&str, Pen)> =
            figure.speeds.iter().enumerate().map(|(i, (name, _))| (name.as_str(), pen(i))).collect();
        legend.push(("limit at constant speed", constant));
        legend.push(("maximum velocity curve", over));
        canvas.tall_header(&figure.title, &figure.facts, &legend)?;
        let panel = Panel { left, right: RIGHT, top: 92.0, bottom: 374.0, x, y: (0.0, top) };
        panel.shade_above(canvas, &ceiling, LIMIT)?;
        panel.axes(canvas, None, &figure.y_label)?;
        panel.series(canvas, &ceiling, over)?;
        panel.series(canvas, &initial, constant)?;
        for (i, (_, points)) in figure.speeds.iter().enumerate().rev() {
            panel.series(canvas, points, pen(i))?;
        }
        canvas.text("binds", (left - 10.0, first - 12.0), Anchor::Right)?;
        let rows = figure.bindings.len().max(1) as f64;
        let strip = Panel { top: first, bottom: first + ROW * rows, y: (0.0, rows), ..panel };
        strip.bare_axes(canvas, &figure.x_label)?;
        for (row, bar) in figure.bindings.iter().enumerate() {
            let y = first + ROW * row as f64;
            canvas.text(&bar.name, (left - 10.0, y + 0.5 * ROW), Anchor::Right)?;
            for &(from, to) in &bar.intervals {
                let (a, b) = (strip.place((from, 0.0)).0, strip.place((to, 0.0)).0);
                // A place is wide enough to be seen.
                let b = b.max(a + 2.0);
                canvas.rectangle((a, y + 5.0), (b, y + ROW - 5.0), bar.joint.map_or(LIMIT, |j| PALETTE[j % 6]))?;
            }
        }
        Ok(())
    })
}

/// Joint curves in units of their limits, one panel a quantity.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn shares_picture(figure: &ShareFigure) -> Result<String, io::Error> {
    let (top, pitch, height) = (92.0, 204.0, 172.0);
    let x = range(figure.panels.iter().flat_map(|p| p.joints.iter().flatten()).map(|p| p.0));
    let joints = figure.panels.iter().map(|p| p.joints.len()).max().unwrap_or(0);
    page(WIDTH, (top + pitch * figure.panels.len() as f64 + 28.0) as u32, |canvas| {
        let names: Vec<String> = (1..=joints).map(|j| format!("J{j}")).collect();
        let pen = |j: usize| Pen::solid(PALETTE[j % 6], 1.5);
        let legend: Vec<_> = names.iter().enumerate().map(|(j, name)| (name.as_str(), pen(j))).collect();
        canvas.tall_header(&figure.title, &figure.facts, &legend)?;
        for (i, panel) in figure.panels.iter().enumerate() {
            let at = top + pitch * i as f64;
            let most = range(panel.joints.iter().flatten().map(|p| p.1.abs())).1.max(1.0);
            let (used, worst) = panel.joints.iter().enumerate().fold((0.0, 0), |best, (j, line)| {
                let peak = line.iter().fold(0.0, |a: f64, p| a.max(p.1.abs()));
                if peak > best.0 { (peak, j) } else { best }
            });
            let y = (-1.12 * most, 1.12 * most);
            let frame = Panel { left: LEFT, right: RIGHT - 118.0, top: at, bottom: at + height, x, y };
            let last = i + 1 == figure.panels.len();
            frame.axes(canvas, last.then_some("time t [s]"), &format!("{} / limit", panel.label))?;
            for (j, line) in panel.joints.iter().enumerate() {
                frame.series(canvas, line, pen(j))?;
            }
            frame.level(canvas, 1.0)?;
            frame.level(canvas, -1.0)?;
            let beside = |row: f64| (frame.right + 10.0, at + 18.0 + 20.0 * row);
            canvas.text("most used", beside(0.0), Anchor::Left)?;
            let text = format!("J{}: {}", worst + 1, percent(used));
            if used > 1.0 + 1e-3 {
                canvas.alarm(&text, beside(1.0), Anchor::Left)?;
            } else {
                canvas.text(&text, beside(1.0), Anchor::Left)?;
            }
        }
        Ok(())
    })
}

/// One quantity in six panels, two a row, limits in red.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn joint_panels_picture(figure: &JointFigure) -> Result<String, io::Error> {
    let (top, pitch, height) = (104.0, 182.0, 124.0);
    let x = range(figure.joints.iter().flat_map(|panel| panel.lines.iter().flatten()).map(|p| p.0));
    let rows = figure.joints.len().div_ceil(2);
    page(WIDTH, (top + pitch * rows as f64 + 18.0) as u32, |canvas| {
        let colours = [PALETTE[0], PALETTE[1], PALETTE[2]];
        let pen = |i: usize| Pen::solid(colours[i % 3], if i == 0 { 1.6 } else { 1.3 });
        let mut legend: Vec<_> = figure.names.iter().enumerate().map(|(i, n)| (n.as_str(), pen(i))).collect();
        legend.push(("limit", Pen::dashed(LIMIT, 1.4)));
        canvas.tall_header(&figure.title, &figure.facts, &legend)?;
        let half = 0.5 * (RIGHT - LEFT - 74.0);
        for (j, panel) in figure.joints.iter().enumerate() {
            let (limit, lines) = (panel.limit, &panel.lines);
            let at = top + pitch * (j / 2) as f64;
            let left = LEFT + (half + 74.0) * (j % 2) as f64;
            let peak = lines.iter().flatten().fold(0.0, |a: f64, p| a.max(p.1.abs()));
            let y = widened((-limit.max(peak), limit.max(peak)), 0.08);
            let frame = Panel { left, right: left + half, top: at, bottom: at + height, x, y };
            frame.axes(canvas, Some("time t [s]"), &format!("J{} [{}]", j + 1, figure.unit))?;
            for (i, line) in lines.iter().enumerate().rev() {
                frame.series(canvas, line, pen(i))?;
            }
            frame.level(canvas, limit)?;
            frame.level(canvas, -limit)?;
            let most = lines.first().map_or(0.0, |l| l.iter().fold(0.0, |a: f64, p| a.max(p.1.abs())));
            let text = format!("{} of {} {}", number(most), number(limit), figure.unit);
            canvas.text(&text, (frame.right, at - 9.0), Anchor::Right)?;
        }
        Ok(())
    })
}
