//! The picture of a run in space: the way of the tool over the floor, with its events.

use std::io;

use arcfeed_interp::HybridState;
use nalgebra::Vector3;
use plotters::prelude::RGBColor;

use super::canvas::{Anchor, Canvas, PALETTE, Pen, page};
use super::panel::{range, widened};
use super::run_states::{STATES, colour_of};
use super::view::{FAINT, PathGrid, View, grid, thin};
use super::{RIGHT, WIDTH};
use crate::output::run_report::RunReport;
use crate::run::play::{Cycle, Played};
use crate::run::stage::Stage;
use crate::text::number;

const SHADOW: RGBColor = RGBColor(185, 185, 190);

/// The way of the tool in space, coloured by state, over its shadow on the floor.
pub(super) fn space_picture(stage: &Stage<'_>, played: &Played, report: &RunReport) -> Result<String, io::Error> {
    let path = stage.live().path().pose_path();
    let tool = |c: &Cycle| c.setpoint.pose.translation.vector * 1e3;
    let way: Vec<Vector3<f64>> = played.cycles().iter().map(tool).collect();
    let whole: Vec<Vector3<f64>> =
        (0..=400).map(|i| path.curve().point(path.length() * f64::from(i) / 400.0) * 1e3).collect();
    let mut all: Vec<Vector3<f64>> = way.iter().chain(&whole).copied().collect();
    let sides = [0, 1, 2].map(|k| range(all.iter().map(|p| p[k])));
    let size = sides.iter().fold(1.0, |a: f64, s| a.max(s.1 - s.0));
    // A large motion stands over the base; a small one over a floor of its own, so that it fills the page.
    let large = !report.excursions.is_empty() || size > 400.0;
    let ground = PathGrid {
        height: if large { 0.0 } else { sides[2].0 - 0.25 * size },
        square: if size > 150.0 { 100.0 } else { 10.0 },
    };
    let floor = |p: &Vector3<f64>| Vector3::new(p.x, p.y, ground.height);
    let shadows: Vec<_> = all.iter().map(floor).collect();
    all.extend(shadows);
    if large {
        all.push(Vector3::zeros());
    }
    let view = View::best(&all);
    let (x, y) = view.ranges(&all);
    let (x, y) = (widened(x, 0.09), widened(y, 0.09));
    let (top, width) = (72.0, RIGHT - 24.0);
    let height = (width * (y.1 - y.0) / (x.1 - x.0)).clamp(320.0, 640.0);
    let scale = (width / (x.1 - x.0)).min(height / (y.1 - y.0));
    let middle = (0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1));
    let place = |p: &Vector3<f64>| {
        let (a, b) = view.flat(p);
        (24.0 + 0.5 * width + (a - middle.0) * scale, top + 0.5 * height - (b - middle.1) * scale)
    };
    let facts = space_facts(report, ground.square);
    page(WIDTH, (top + height + 24.0) as u32, |canvas| {
        let used: Vec<_> = STATES
            .iter()
            .filter(|(name, _)| report.states.iter().any(|s| s.state.starts_with(name)))
            .filter(|(name, _)| !matches!(*name, "waiting" | "holding" | "stepping back" | "done"))
            .map(|(name, colour)| (*name, Pen::solid(*colour, 2.4)))
            .collect();
        canvas.header(&format!("{}: way of the tool", report.path), &facts, &used)?;
        grid(canvas, &all, &ground, &place)?;
        let shadow: Vec<_> = thin(way.iter().map(|p| place(&floor(p))));
        canvas.line(&shadow, Pen::solid(SHADOW, 1.2))?;
        if large {
            triad(canvas, &place)?;
        }
        let planned: Vec<_> = thin(whole.iter().map(&place));
        canvas.line(&planned, Pen::solid(FAINT, 7.0))?;
        let mut from = 0;
        while from < way.len() {
            let state = played.cycles()[from].state;
            let same = |s: HybridState| std::mem::discriminant(&s) == std::mem::discriminant(&state);
            let to = (from..way.len()).find(|&i| !same(played.cycles()[i].state)).unwrap_or(way.len());
            let run = thin(way[from.saturating_sub(1)..to].iter().map(&place));
            // The way back lies on the way there where it goes through the same points: a thin line on a wide one.
            let returns = state == HybridState::Returning;
            if returns {
                canvas.line(&run, Pen::solid(RGBColor(255, 255, 255), 4.2))?;
            }
            let width = if returns { 2.0 } else { 7.0 };
            canvas.line(&run, Pen::solid(colour_of(state.name()), width))?;
            from = to;
        }
        let mut taken: Vec<[f64; 3]> = Vec::new();
        for (p, words, above) in marks(played, report, &way) {
            let at = place(&p);
            canvas.line(&[at, place(&floor(&p))], Pen { dashed: true, ..Pen::solid(SHADOW, 0.9) })?;
            dot(canvas, at)?;
            let [x, end, y] = free_place(&mut taken, at, words.chars().count(), above);
            let ground = [(x - 2.0, y - 8.0), (end, y - 8.0), (end, y + 8.0), (x - 2.0, y + 8.0)];
            canvas.fill(&ground, RGBColor(255, 255, 255), 0.8)?;
            canvas.text(&words, (x, y), Anchor::Left)?;
        }
        Ok(())
    })
}

fn space_facts(report: &RunReport, square: f64) -> String {
    let mut facts = format!("{} s", number(report.duration_s));
    for way in &report.excursions {
        facts += &format!("; {} s to leave", number(way.time_to_leave_s));
        if let Some(t) = way.time_to_goal_s {
            facts += &format!(", {} s to the goal", number(t));
        }
        if let Some(t) = way.time_to_return_s {
            facts += &format!(", {} s to return", number(t));
        }
    }
    facts + &format!("; one square of the floor is {square} mm")
}

fn dot(canvas: &Canvas<'_>, (x, y): (f64, f64)) -> Result<(), io::Error> {
    let ring = |r: f64| -> Vec<(f64, f64)> {
        (0..20)
            .map(|i| std::f64::consts::TAU * f64::from(i) / 20.0)
            .map(|a| (x + r * a.cos(), y + r * a.sin()))
            .collect()
    };
    canvas.fill(&ring(5.5), RGBColor(255, 255, 255), 1.0)?;
    canvas.fill(&ring(4.0), RGBColor(40, 40, 40), 1.0)
}

/// The base frame, 120 mm long.
fn triad(canvas: &Canvas<'_>, place: &impl Fn(&Vector3<f64>) -> (f64, f64)) -> Result<(), io::Error> {
    let origin = place(&Vector3::zeros());
    for (axis, name) in [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")] {
        canvas.line(&[origin, place(&(axis * 120.0))], Pen::solid(PALETTE[5], 1.8))?;
        canvas.text(name, place(&(axis * 140.0)), Anchor::Middle)?;
    }
    canvas.text("base", (origin.0 + 8.0, origin.1 + 12.0), Anchor::Left)
}

/// Start, end and height of a name of so many characters beside `at`: one that would cover another one moves away.
fn free_place(taken: &mut Vec<[f64; 3]>, at: (f64, f64), characters: usize, above: bool) -> [f64; 3] {
    let (x, mut y) = (at.0 + 9.0, at.1 + if above { -12.0 } else { 14.0 });
    let end = x + 6.6 * characters as f64;
    while taken.iter().any(|&[from, to, at]| x < to && end > from && (y - at).abs() < 16.0) {
        y += if above { -4.0 } else { 4.0 };
    }
    taken.push([x, end, y]);
    [x, end, y]
}

/// Places with a name: start, end, events, points reached in joint space; and whether the name stands above the place.
fn marks(played: &Played, report: &RunReport, way: &[Vector3<f64>]) -> Vec<(Vector3<f64>, String, bool)> {
    let cycles = played.cycles();
    let at = |t: f64| way[((t / report.period_s).round() as usize).clamp(1, way.len()) - 1];
    let mut marks = vec![(played.start().pose.translation.vector * 1e3, "start".to_owned(), true)];
    for (i, line) in report.excursions.iter().enumerate() {
        let which = if report.excursions.len() > 1 { format!(" {}", i + 1) } else { String::new() };
        let left = line.event_s + line.time_to_leave_s;
        if line.time_to_leave_s < 0.01 {
            marks.push((at(left), format!("event{which}: leaves at once"), false));
        } else {
            marks.push((at(line.event_s), format!("event{which}"), true));
            marks.push((at(left), format!("leaves and returns{which}"), false));
        }
    }
    let mut before: Option<HybridState> = None;
    for (p, c) in way.iter().zip(cycles) {
        if let (Some(HybridState::JointMove(point)), true) = (before, before != Some(c.state)) {
            let name = if c.state == HybridState::Waiting { "goal".to_owned() } else { format!("point {}", point + 1) };
            if matches!(c.state, HybridState::Waiting | HybridState::JointMove(_)) {
                marks.push((*p, name, true));
            }
        }
        if let (Some(HybridState::Leaving), HybridState::JointMove(point @ 1..), true) = (before, c.state, !c.on_path) {
            marks.push((*p, format!("point {point}"), true));
        }
        before = Some(c.state);
    }
    if let Some(end) = way.last() {
        marks.push((*end, if report.path_finished { "end" } else { "stopped" }.to_owned(), true));
    }
    // Names of the same place stand once, one after the other.
    let mut merged: Vec<(Vector3<f64>, String, bool)> = Vec::new();
    for (p, words, above) in marks {
        match merged.iter_mut().find(|m| (m.0 - p).norm() < 15.0) {
            Some(m) if !m.1.contains(&words) => m.1 += &format!(", {words}"),
            Some(_) => {}
            None => merged.push((p, words, above)),
        }
    }
    merged.truncate(24);
    merged
}
