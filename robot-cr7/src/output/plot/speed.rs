//! The path of the tool, coloured by its speed.

use std::io;

use plotters::style::RGBColor;

use super::canvas::{Anchor, Pen, page};
use super::panel::{Panel, range, widened};
use super::{LEFT, RIGHT, WIDTH};
use crate::text::number;

/// Colours of the speed, from rest to the highest: dark blue, green, yellow. Their lightness grows, so that they can be told apart in grey.
const RAMP: [(u8, u8, u8); 6] =
    [(45, 20, 90), (40, 70, 140), (30, 120, 140), (40, 165, 110), (130, 200, 60), (240, 205, 30)];
/// Number of colours that are drawn.
const LEVELS: usize = 24;

/// The path seen along the z axis of the workpiece: `points` are x and y in m and the speed there in m/s.
///
/// # Errors
/// The error of the picture's memory, which does not happen.
pub fn speed_path_picture(name: &str, points: &[[f64; 3]]) -> Result<String, io::Error> {
    let finite: Vec<&[f64; 3]> = points.iter().filter(|p| p.iter().all(|v| v.is_finite())).collect();
    let x = widened(range(finite.iter().map(|p| p[0] * 1e3)), 0.04);
    let y = widened(range(finite.iter().map(|p| p[1] * 1e3)), 0.04);
    // Equal scale on both axes.
    let height = ((RIGHT - LEFT) * (y.1 - y.0) / (x.1 - x.0)).clamp(220.0, 640.0);
    let scale = ((RIGHT - LEFT) / (x.1 - x.0)).min(height / (y.1 - y.0));
    let grown = |(a, b): (f64, f64), pixels: f64| {
        let (middle, half) = (0.5 * (a + b), 0.5 * pixels / scale);
        (middle - half, middle + half)
    };
    let top = 82.0;
    let shape =
        Panel { left: LEFT, right: RIGHT, top, bottom: top + height, x: grown(x, RIGHT - LEFT), y: grown(y, height) };
    let highest = finite.iter().fold(0.0f64, |most, p| most.max(p[2]));
    let level = |speed: f64| level_of(speed, highest);
    page(WIDTH, (shape.bottom + 52.0) as u32, |canvas| {
        canvas.header(name, "the path of the tool, coloured by its speed", &[])?;
        shape.axes(canvas, Some("x [mm]"), "y [mm]")?;
        let mut from = 0;
        while from + 1 < finite.len() {
            let colour = level(finite[from][2]);
            let to = (from + 1..finite.len()).find(|&i| level(finite[i][2]) != colour).unwrap_or(finite.len() - 1);
            let run: Vec<_> = finite[from..=to].iter().map(|p| shape.place((p[0] * 1e3, p[1] * 1e3))).collect();
            canvas.line(&run, Pen::solid(colour_of(colour), 3.4))?;
            from = to;
        }
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
