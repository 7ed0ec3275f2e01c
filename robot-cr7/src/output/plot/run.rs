//! Pictures of a run in both spaces: the way of the tool in space, joints in units of their limits, states, feed.

use std::io;

use super::canvas::{Anchor, Canvas, LIMIT, PALETTE, Pen, page};
use super::panel::{Panel, range, widened};
use super::run_space::space_picture;
use super::run_states::{STATES, colour_of};
use super::{LEFT, RIGHT, WIDTH};
use crate::output::run_report::RunReport;
use crate::run::play::Played;
use crate::run::stage::Stage;
use crate::text::number;

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
