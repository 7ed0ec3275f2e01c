//! Speed profiles of several planners under one limit curve.

use std::io;

use super::canvas::{LIMIT, PALETTE, Pen, page};
use super::panel::{Panel, range};
use super::{LEFT, RIGHT, WIDTH};
use crate::run::compare::{Comparison, Entry};
use crate::text::number;

/// Planners that are drawn, where they found a motion: some of the others would only cover them.
const DRAWN: [&str; 5] =
    ["per-segment", "continuous-acceleration", "published", "interpolated-reachability", "jerk-limited"];
/// Part of the path that the lower panel shows.
const ZOOM: f64 = 0.06;

/// The profiles over the whole path, and closer around the place where the published scan breaks its limits most.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn compare_picture(comparison: &Comparison) -> Result<String, io::Error> {
    let shown = |points: &[(f64, f64)]| points.iter().map(|p| (p.0 * 1e3, p.1 * 1e3)).collect::<Vec<_>>();
    let drawn: Vec<(&Entry, Pen)> = DRAWN
        .iter()
        .enumerate()
        .filter_map(|(i, name)| {
            let colour = [PALETTE[5], PALETTE[4], PALETTE[1], PALETTE[2], PALETTE[0]][i];
            let entry = comparison.entries.iter().find(|e| e.planner == *name && !e.profile.is_empty())?;
            Some((entry, Pen::solid(colour, if i + 1 == DRAWN.len() { 1.9 } else { 1.3 })))
        })
        .collect();
    let limit = shown(&comparison.limit_curve);
    let length = comparison.length_m * 1e3;
    let fastest = |from: f64, to: f64| {
        let inside = |p: &&(f64, f64)| p.0 * 1e3 >= from && p.0 * 1e3 <= to;
        let speeds = drawn.iter().flat_map(|(e, _)| e.profile.iter().filter(inside).map(|p| p.1 * 1e3));
        1.15 * range(speeds).1.max(1e-9)
    };
    let middle = comparison
        .entries
        .iter()
        .find(|e| e.planner == "published")
        .and_then(|e| e.worst.first()?.at_s_m)
        .map_or(0.5 * length, |s| s * 1e3);
    let half = 0.5 * ZOOM * length;
    let middle = middle.clamp(half, length - half);
    let zoom = (middle - half, middle + half);
    let facts = drawn
        .iter()
        .filter_map(|(e, _)| Some(format!("{} {} s", e.planner, number(e.duration_s?))))
        .collect::<Vec<_>>()
        .join(", ");
    let above =
        Panel { left: LEFT, right: RIGHT, top: 66.0, bottom: 336.0, x: (0.0, length), y: (0.0, fastest(0.0, length)) };
    let below = Panel { top: 404.0, bottom: 674.0, x: zoom, y: (0.0, fastest(zoom.0, zoom.1)), ..above };
    page(WIDTH, 730, |canvas| {
        let pen = Pen::solid(LIMIT, 1.1);
        let mut legend: Vec<(&str, Pen)> = drawn.iter().map(|(e, pen)| (e.planner, *pen)).collect();
        legend.push(("limit at constant speed", pen));
        canvas.header(&comparison.name, &facts, &legend)?;
        for (panel, label) in [(&above, "speed [mm/s]"), (&below, "speed [mm/s], closer")] {
            let cut: Vec<_> = limit
                .windows(2)
                .filter(|w| w[1].0 >= panel.x.0 && w[0].0 <= panel.x.1)
                .map(|w| w[0])
                .map(|(s, v)| (s, v.min(1e3 * panel.y.1)))
                .collect();
            panel.shade_above(canvas, &cut, LIMIT)?;
            panel.axes(canvas, Some("path length s [mm]"), label)?;
            panel.series(canvas, &cut, pen)?;
            for (entry, pen) in &drawn {
                let points: Vec<_> =
                    shown(&entry.profile).into_iter().filter(|p| p.0 >= panel.x.0 && p.0 <= panel.x.1).collect();
                panel.series(canvas, &points, *pen)?;
            }
        }
        Ok(())
    })
}
