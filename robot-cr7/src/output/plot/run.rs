//! Pictures of a run in both spaces: the way of the tool in space, joints in units of their limits, states, feed.

use std::io;

use arcfeed_interp::HybridState;
use nalgebra::Vector3;
use plotters::prelude::RGBColor;

use super::canvas::{Anchor, Canvas, LIMIT, PALETTE, Panel, Pen, page, range, widened};
use super::{LEFT, RIGHT, WIDTH};
use crate::output::run_report::RunReport;
use crate::run::play::{Cycle, Played};
use crate::run::stage::Stage;
use crate::text::number;

const FAINT: RGBColor = RGBColor(215, 215, 215);
const SHADOW: RGBColor = RGBColor(185, 185, 190);

/// Names of the states with their colours.
const STATES: [(&str, RGBColor); 9] = [
    ("task path", PALETTE[0]),
    ("leaving", PALETTE[1]),
    ("joint move", PALETTE[2]),
    ("waiting", PALETTE[5]),
    ("returning", PALETTE[3]),
    ("holding", RGBColor(150, 150, 150)),
    ("stepping back", RGBColor(213, 94, 0)),
    ("stopping", LIMIT),
    ("done", PALETTE[4]),
];

fn colour_of(state: &str) -> RGBColor {
    STATES.iter().find(|(name, _)| state.starts_with(name)).map_or(PALETTE[5], |s| s.1)
}

/// A picture and the name of its file.
pub type Picture = (&'static str, Result<String, io::Error>);

/// All pictures of a run.
pub fn run_pictures(stage: &Stage<'_>, played: &Played, report: &RunReport) -> Vec<Picture> {
    vec![
        ("tool_path.svg", space_picture(stage, played, report)),
        ("joints.svg", joints_picture(stage, played, report)),
        ("timeline.svg", timeline_picture(report)),
        ("feed.svg", feed_picture(stage, played, report)),
    ]
}

/// A view from a direction above the horizon; straight lines stay straight and parallel.
struct View {
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

    /// The direction from which the points cover most of a page.
    fn best(points: &[Vector3<f64>]) -> Self {
        let area = |view: &Self| {
            let (x, y) = view.ranges(points);
            (x.1 - x.0) * (y.1 - y.0)
        };
        let views = (0..36).map(|i| Self::from(std::f64::consts::TAU * f64::from(i) / 36.0));
        views.max_by(|a, b| area(a).total_cmp(&area(b))).unwrap_or_else(|| Self::from(0.6))
    }

    fn flat(&self, p: &Vector3<f64>) -> (f64, f64) {
        (p.dot(&self.right), p.dot(&self.up))
    }

    fn ranges(&self, points: &[Vector3<f64>]) -> ((f64, f64), (f64, f64)) {
        (range(points.iter().map(|p| self.flat(p).0)), range(points.iter().map(|p| self.flat(p).1)))
    }
}

/// The way of the tool in space, coloured by state, over its shadow on the floor.
fn space_picture(stage: &Stage<'_>, played: &Played, report: &RunReport) -> Result<String, io::Error> {
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

/// The ground of the picture, mm.
struct PathGrid {
    height: f64,
    square: f64,
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

/// Points at least a third of a pixel apart.
fn thin(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
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

/// The floor under the points, in squares.
fn grid(
    canvas: &Canvas<'_>,
    points: &[Vector3<f64>],
    ground: &PathGrid,
    place: &impl Fn(&Vector3<f64>) -> (f64, f64),
) -> Result<(), io::Error> {
    let steps = |(low, high): (f64, f64)| ((low / ground.square).floor() as i32, (high / ground.square).ceil() as i32);
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

/// A band of the states along the top of a panel.
fn band(canvas: &Canvas<'_>, panel: &Panel, report: &RunReport) -> Result<(), io::Error> {
    for span in &report.states {
        let (a, b) = (panel.place((span.from_s, panel.y.1)), panel.place((span.to_s, panel.y.1)));
        canvas.rectangle((a.0, panel.top - 9.0), (b.0.max(a.0 + 1.0), panel.top - 3.0), colour_of(&span.state))?;
    }
    Ok(())
}

fn legend(report: &RunReport) -> Vec<(&'static str, Pen)> {
    let used = STATES.iter().filter(|(name, _)| report.states.iter().any(|s| s.state.starts_with(name)));
    used.filter(|(name, _)| *name != "done").map(|(name, colour)| (*name, Pen::solid(*colour, 5.0))).collect()
}

/// Position, velocity, acceleration and jerk of all joints, each in units of its limit.
fn joints_picture(stage: &Stage<'_>, played: &Played, report: &RunReport) -> Result<String, io::Error> {
    let limits = stage.live().joints();
    let (lower, upper) = (limits.lower(), limits.upper());
    let t = (0.0, report.duration_s.max(1e-6));
    let cycles = played.cycles();
    let relative = |kind: usize, k: usize| -> Vec<(f64, f64)> {
        let value = |p: &arcfeed_interp::Setpoint| match kind {
            0 => (p.q[k] - 0.5 * (lower[k] + upper[k])) / (0.5 * (upper[k] - lower[k])),
            1 => p.qd[k] / limits.velocity()[k],
            2 => p.qdd[k] / limits.acceleration()[k],
            _ => p.jerk[k] / limits.jerk()[k],
        };
        cycles.iter().map(|c| (c.setpoint.t, value(&c.setpoint))).collect()
    };
    let names = ["position", "velocity", "acceleration", "jerk"];
    let facts = format!(
        "1 is the limit of the joint; for positions -1 and 1 are the ends of its range; most used: {:.2} %",
        100.0 * report.worst_ratio()
    );
    let joints = ["J1", "J2", "J3", "J4", "J5", "J6"];
    let (top, height, gap) = (84.0, 150.0, 36.0);
    page(WIDTH, (top + 4.0 * (height + gap) + 24.0) as u32, |canvas| {
        let legend: Vec<_> = joints.iter().enumerate().map(|(k, name)| (*name, Pen::solid(PALETTE[k], 1.6))).collect();
        canvas.header(&format!("{}: joints in units of their limits", report.path), &facts, &legend)?;
        for (kind, name) in names.into_iter().enumerate() {
            let panel_top = top + kind as f64 * (height + gap);
            let panel =
                Panel { left: LEFT, right: RIGHT, top: panel_top, bottom: panel_top + height, x: t, y: (-1.12, 1.12) };
            panel.axes(canvas, (kind == 3).then_some("time t [s]"), name)?;
            band(canvas, &panel, report)?;
            for (k, &colour) in PALETTE.iter().enumerate().take(6) {
                panel.series(canvas, &relative(kind, k), Pen::solid(colour, 1.4))?;
            }
            panel.level(canvas, 1.0)?;
            panel.level(canvas, -1.0)?;
        }
        Ok(())
    })
}

/// The states over time, one row each, with the events.
fn timeline_picture(report: &RunReport) -> Result<String, io::Error> {
    let names: Vec<&str> = {
        let mut names: Vec<&str> = Vec::new();
        for span in &report.states {
            if !names.contains(&span.state.as_str()) {
                names.push(&span.state);
            }
        }
        names
    };
    let events: Vec<_> = report.events.iter().take(24).collect();
    let (top, row, line) = (78.0, 30.0, 19.0);
    let bottom = top + row * names.len() as f64;
    let left = 150.0;
    let panel =
        Panel { left, right: RIGHT, top, bottom, x: (0.0, report.duration_s.max(1e-6)), y: (0.0, names.len() as f64) };
    let below = bottom + 62.0;
    page(WIDTH, (below + line * events.len() as f64 + 18.0) as u32, |canvas| {
        let facts = format!("{} s, {} events", number(report.duration_s), report.events.len());
        canvas.header(&format!("{}: states", report.path), &facts, &[])?;
        panel.bare_axes(canvas, "time t [s]")?;
        for (i, name) in names.iter().enumerate() {
            let y = top + row * (i as f64 + 0.5);
            canvas.text(name, (left - 12.0, y), Anchor::Right)?;
            for span in report.states.iter().filter(|s| s.state == *name) {
                let (a, b) = (panel.place((span.from_s, 0.0)).0, panel.place((span.to_s, 0.0)).0);
                canvas.rectangle((a, y - 9.0), (b.max(a + 2.0), y + 9.0), colour_of(name))?;
                let words = format!("{} s", number(span.to_s - span.from_s));
                if b - a > 70.0 {
                    canvas.white(&words, (0.5 * (a + b), y), Anchor::Middle)?;
                } else if span.to_s > span.from_s && report.states.len() < 14 {
                    let (at, anchor) =
                        if b < RIGHT - 80.0 { (b + 6.0, Anchor::Left) } else { (a - 6.0, Anchor::Right) };
                    canvas.text(&words, (at, y), anchor)?;
                }
            }
        }
        for (i, event) in events.iter().enumerate() {
            let x = panel.place((event.t_s, 0.0)).0;
            canvas.line(&[(x, top), (x, bottom)], Pen::dashed(PALETTE[5], 0.9))?;
            let refused = if event.refused.is_some() { " (refused)" } else { "" };
            canvas.text(&format!("{}", i + 1), (x, top - 9.0), Anchor::Middle)?;
            let words =
                format!("{}: {:.3} s, {} mm: {}{refused}", i + 1, event.t_s, number(event.s_m * 1e3), event.what);
            canvas.text(&words, (left, below + line * i as f64), Anchor::Left)?;
        }
        Ok(())
    })
}

/// The feed of the tool, what was asked for, and the limit curve where the tool is.
fn feed_picture(stage: &Stage<'_>, played: &Played, report: &RunReport) -> Result<String, io::Error> {
    let cycles = played.cycles();
    let t = (0.0, report.duration_s.max(1e-6));
    let gap = f64::NAN;
    let feed: Vec<_> =
        cycles.iter().map(|c| (c.setpoint.t, if c.on_path { c.setpoint.feed * 1e3 } else { gap })).collect();
    let off: Vec<_> =
        cycles.iter().map(|c| (c.setpoint.t, if c.on_path { gap } else { c.setpoint.feed * 1e3 })).collect();
    let programmed: Vec<_> = cycles.iter().map(|c| (c.setpoint.t, c.programmed * 1e3)).collect();
    let asked: Vec<_> = cycles.iter().map(|c| (c.setpoint.t, c.asked * 1e3)).collect();
    let allowed: Vec<_> = cycles
        .iter()
        .map(|c| {
            (
                c.setpoint.t,
                if c.on_path { stage.route().part_at(c.setpoint.s).curve().fastest(c.setpoint.s).v * 1e3 } else { gap },
            )
        })
        .collect();
    let highest = range(programmed.iter().chain(&asked).chain(&feed).map(|p| p.1)).1;
    let any_off = off.iter().any(|p| p.1.is_finite());
    let facts = format!(
        "programmed {} mm/s at the start; highest {} mm/s; the limit curve is what the rest of the path allows",
        number(programmed.first().map_or(0.0, |p| p.1)),
        number(stage.live().tool().feed().unwrap_or(f64::INFINITY) * 1e3)
    );
    let lines = [
        ("limit curve", allowed, Pen::solid(LIMIT, 1.0)),
        ("programmed", programmed, Pen::solid(PALETTE[4], 1.4)),
        ("with override", asked, Pen::solid(PALETTE[1], 1.6)),
        ("feed", feed, Pen::solid(PALETTE[0], 1.9)),
    ];
    page(WIDTH, if any_off { 660 } else { 480 }, |canvas| {
        let pens: Vec<_> = lines.iter().map(|(name, _, pen)| (*name, *pen)).collect();
        canvas.header(&format!("{}: feed", report.path), &facts, &pens)?;
        let y = (1.15 * range(lines[3].1.iter().map(|p| p.1)).0.min(0.0), 1.15 * highest.max(1e-6));
        let panel = Panel { left: LEFT, right: RIGHT, top: 84.0, bottom: 400.0, x: t, y };
        panel.axes(canvas, (!any_off).then_some("time t [s]"), "feed on the path [mm/s]")?;
        band(canvas, &panel, report)?;
        for (_, points, pen) in &lines {
            panel.series(canvas, points, *pen)?;
        }
        let mut below = 460.0;
        if any_off {
            let y = widened((0.0, range(off.iter().map(|p| p.1)).1), 0.06);
            let panel = Panel { top: 436.0, bottom: 560.0, y: (0.0, y.1), ..panel };
            panel.axes(canvas, Some("time t [s]"), "tool off it [mm/s]")?;
            panel.series(canvas, &off, Pen::solid(PALETTE[2], 1.6))?;
            below = 630.0;
        }
        states_key(canvas, report, below)
    })
}

/// The colours of the states, in a line.
fn states_key(canvas: &Canvas<'_>, report: &RunReport, y: f64) -> Result<(), io::Error> {
    let mut x = LEFT;
    for (name, pen) in legend(report) {
        canvas.rectangle((x, y - 4.0), (x + 22.0, y + 4.0), pen.color)?;
        canvas.text(name, (x + 30.0, y), Anchor::Left)?;
        x += 50.0 + 7.5 * name.len() as f64;
    }
    Ok(())
}
