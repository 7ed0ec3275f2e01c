//! Liu et al. 2024, sections 5.1 and 5.3: the butterfly with feeds that change while it runs, and the event in both spaces.

use arcfeed_geometry::SegmentationMethod;
use arcfeed_interp::{HybridState, LivePath, Setpoint};

use super::{Figure, FigureLine, Reproduction, dense_deviation};
use crate::input::scenario::Scenario;
use crate::output::run_report::RunReport;
use crate::run::cr7::Cr7;
use crate::run::error::Cr7Error;
use crate::run::play::{Clock, Played};
use crate::run::stage::Stage;

/// Round-off allowed in what a guarantee says, relative.
const SLACK: f64 = 1e-6;
/// Segments that the paper counts.
const COUNT: usize = 193;
/// Chord error of section 5.1, m.
const CHORD: f64 = 5e-5;
/// Table 6: the feed outside of sections, and first and last segment of each section (from 1) with its feed, mm/s.
const FEED: f64 = 10.0;
const SECTIONS: [(usize, usize, f64); 5] =
    [(20, 45, 12.0), (50, 60, 8.0), (70, 85, 14.0), (95, 100, 11.0), (150, 180, 15.0)];

const TABLE_6: &str = "Table 6, figures 11 and 12: butterfly at 0.05 mm, feeds ordered while it runs (mm, s)";

/// Plays a scenario on the CR7 and hands over all there is to know.
pub(super) fn played<T>(
    text: &str,
    name: &str,
    look: impl FnOnce(&Stage<'_>, &Played, &RunReport) -> T,
) -> Result<T, Cr7Error> {
    let scenario = Scenario::parse(text, name.as_ref())?;
    let cr7 = Cr7::of(scenario.job())?;
    let stage = scenario.stage(cr7.arm(), cr7.limits())?;
    let played = stage.play(Clock::Simulated)?;
    let report = RunReport::new(&stage, &played);
    Ok(look(&stage, &played, &report))
}

/// The scenario of table 6: sections from the segments of the halving that the paper uses. Also the breaks of these, m.
pub(super) fn table_6_scenario() -> Result<(String, Vec<f64>), Cr7Error> {
    let mut text =
        "[path]\nbuilt_in = \"butterfly\"\n[feed]\nfeed_mm_s = 15.0\ntangential_acceleration_mm_s2 = 100.0\n\
                    tangential_jerk_mm_s3 = 1000.0\nnormal_acceleration_mm_s2 = 120.0\n[tolerance]\nchord_mm = 0.05\n\
                    [sampling]\nperiod_ms = 1.0\n"
            .to_owned();
    text += &format!("[run]\nfeed_mm_s = {FEED:.1}\n");
    let scenario = Scenario::parse(&text, "table 6".as_ref())?;
    let cr7 = Cr7::of(scenario.job())?;
    let breaks = breaks_of(scenario.stage(cr7.arm(), cr7.limits())?.live())?;
    for (first, last, feed) in SECTIONS {
        let (from, to) = section(&breaks, first, last);
        let (from, to) = (from * 1e3, to * 1e3);
        text += &format!(
            "[[event]]\nat_cycle = 0\ndo = \"section\"\nfrom_mm = {from}\nto_mm = {to}\nfeed_mm_s = {feed:.1}\n"
        );
    }
    Ok((text, breaks))
}

/// Where a section of table 6 begins and ends, m: segments `first` to `last` of the paper's 193 are the same share of ours.
fn section(breaks: &[f64], first: usize, last: usize) -> (f64, f64) {
    let ours = breaks.len() - 1;
    let place = |n: usize| breaks[((n * ours + COUNT / 2) / COUNT).min(ours)];
    (place(first - 1), place(last))
}

/// Arc lengths at the ends of the segments by halving.
fn breaks_of(live: &LivePath) -> Result<Vec<f64>, Cr7Error> {
    let curve = live.path().pose_path().curve();
    let segments = curve
        .curve()
        .segment(SegmentationMethod::CType, CHORD)
        .map_err(|source| Cr7Error::Curve { file: "butterfly".to_owned(), source })?;
    Ok(segments.breaks().iter().map(|&u| curve.arc_length_at(u)).collect())
}

pub(super) fn table_6(r: &mut Reproduction, figures: &mut Vec<Figure>) -> Result<(), Cr7Error> {
    let (text, breaks) = table_6_scenario()?;
    played(&text, "table 6", |stage, played, report| {
        claims_6(r, stage, played, report, &breaks)?;
        figures_6(figures, stage, played, &breaks);
        Ok(())
    })?
}

fn claims_6(
    r: &mut Reproduction,
    stage: &Stage<'_>,
    played: &Played,
    report: &RunReport,
    breaks: &[f64],
) -> Result<(), Cr7Error> {
    let curve = stage.live().path().pose_path().curve();
    let segments = curve
        .curve()
        .segment(SegmentationMethod::CType, CHORD)
        .map_err(|source| Cr7Error::Curve { file: "butterfly".to_owned(), source })?;
    let deviation = dense_deviation(curve.curve(), segments.breaks());
    r.add(TABLE_6, "segments by halving", "193", segments.len().to_string())
        .note("no reading of the paper gives its count; a section is the same share of ours");
    r.add(TABLE_6, "largest chord error of a segment", "0.05", format!("{:.6}", deviation * 1e3))
        .guaranteed(deviation <= CHORD);
    let fastest = |from: f64, to: f64| {
        let inside = played.cycles().iter().map(|c| &c.setpoint).filter(|p| (from..to).contains(&p.s));
        inside.fold(0.0f64, |a, p| a.max(p.feed)) * 1e3
    };
    for (first, last, feed) in SECTIONS {
        let (from, to) = section(breaks, first, last);
        let ours = fastest(from, to);
        let what = format!("highest feed, segments {first}-{last} ({:.1}-{:.1} mm)", from * 1e3, to * 1e3);
        r.add(TABLE_6, what, feed.to_string(), format!("{ours:.6}"))
            .guaranteed(ours <= feed * (1.0 + SLACK) && ours > 0.99 * feed);
    }
    let inside = |s: f64| {
        SECTIONS.iter().any(|&(first, last, _)| {
            let (from, to) = section(breaks, first, last);
            (from..to).contains(&s)
        })
    };
    let outside = played.cycles().iter().map(|c| &c.setpoint).filter(|p| !inside(p.s));
    let ours = outside.fold(0.0f64, |a, p| a.max(p.feed)) * 1e3;
    r.add(TABLE_6, "highest feed elsewhere", FEED.to_string(), format!("{ours:.6}"))
        .note("a lower feed is met before its stretch begins")
        .guaranteed(ours <= FEED * (1.0 + SLACK));
    for (name, paper) in [
        ("tangential acceleration", "100"),
        ("tangential jerk", "1000"),
        ("normal acceleration", "120"),
        ("chord error", "0.05"),
    ] {
        if let Some(line) = report.limits.iter().find(|l| l.name == name) {
            let what = format!("largest {name}, by forward kinematics");
            r.add(TABLE_6, what, paper, format!("{:.6}", line.value.abs() * 1e3)).guaranteed(line.ratio <= 1.0 + SLACK);
        }
    }
    r.add(TABLE_6, "duration, s", "", format!("{:.3}", report.duration_s));
    held(r, TABLE_6, report);
    Ok(())
}

/// What holds of every run.
fn held(r: &mut Reproduction, place: &str, report: &RunReport) {
    r.add(place, "worst use of any limit, %", "", format!("{:.4}", 100.0 * report.worst_ratio()))
        .guaranteed(report.worst_ratio() <= 1.0 + SLACK);
    let times = &report.step_times;
    r.add(place, "one step, us: median, 99 %", "", format!("{:.2}, {:.2}", times.median_s * 1e6, times.p99_s * 1e6));
}

fn figures_6(figures: &mut Vec<Figure>, stage: &Stage<'_>, played: &Played, breaks: &[f64]) {
    const S: &str = "path length s [mm]";
    let curve = stage.live().path().pose_path().curve();
    let facts = format!("butterfly, {} segments by halving at 0.05 mm", breaks.len() - 1);
    let deviations: Vec<f64> =
        curve.curve().segment(SegmentationMethod::CType, CHORD).map(|s| s.deviations().to_vec()).unwrap_or_default();
    let steps = breaks.windows(2).zip(&deviations);
    let error = steps.flat_map(|(b, d)| [(b[0] * 1e3, d * 1e3), (b[1] * 1e3, d * 1e3)]).collect();
    let line = |name: &str, points: Vec<(f64, f64)>| FigureLine { name: name.to_owned(), points };
    figures.push(Figure {
        file: "figure_11a_chord_error.svg",
        title: "Figure 11a: chord error of each segment",
        facts: facts.clone(),
        across: S,
        label: "chord error [mm]",
        lines: vec![line("ours", error)],
    });
    let curvature = (0..=4000)
        .map(|i| curve.length() * f64::from(i) / 4000.0)
        .map(|s| (s * 1e3, curve.jet(s).d2.norm() * 1e-3))
        .collect();
    figures.push(Figure {
        file: "figure_11b_curvature.svg",
        title: "Figure 11b: curvature",
        facts,
        across: S,
        label: "curvature [1/mm]",
        lines: vec![line("curvature", curvature)],
    });
    let over_time = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        played.cycles().iter().enumerate().map(|(i, c)| (c.setpoint.t, value(i))).collect()
    };
    let cycles = played.cycles();
    let period = stage.live().period();
    let change = |i: usize| match i {
        0 => cycles[0].setpoint.acceleration / period,
        _ => (cycles[i].setpoint.acceleration - cycles[i - 1].setpoint.acceleration) / period,
    };
    let facts = format!("table 6; {:.3} s", cycles[cycles.len() - 1].setpoint.t);
    figures.push(Figure {
        file: "figure_12b_feed.svg",
        title: "Figure 12b: feed rate",
        facts: facts.clone(),
        across: "time t [s]",
        label: "feed [mm/s]",
        lines: vec![
            line("ordered", over_time(&|i| cycles[i].asked * 1e3)),
            line("ours", over_time(&|i| cycles[i].setpoint.feed * 1e3)),
        ],
    });
    figures.push(Figure {
        file: "figure_12c_acceleration.svg",
        title: "Figure 12c: tangential acceleration",
        facts: format!("{facts}; limit 100 mm/s²"),
        across: "time t [s]",
        label: "acceleration [mm/s²]",
        lines: vec![line("ours", over_time(&|i| cycles[i].setpoint.acceleration * 1e3))],
    });
    figures.push(Figure {
        file: "figure_12d_jerk.svg",
        title: "Figure 12d: tangential jerk",
        facts: format!("{facts}; limit 1000 mm/s³"),
        across: "time t [s]",
        label: "jerk [mm/s³]",
        lines: vec![line("ours", over_time(&|i| change(i) * 1e3))],
    });
}

/// The two events of section 5.3: at the end of the path with braking, in its middle at once.
pub(super) const EVENTS: [(&str, &str); 2] = [
    ("event.toml", "Table 8, figure 14: event at point 2, brakes on the path first (limits of table 7)"),
    ("event_middle.toml", "Table 8, section 5.3: event in the middle of the path, leaves at once at 100 mm/s"),
];

pub(super) fn embedded(file: &str) -> &'static str {
    Scenario::ALL.into_iter().find(|(name, _)| *name == file).map_or("", |(_, text)| text)
}

pub(super) fn table_8(r: &mut Reproduction, figures: &mut Vec<Figure>) -> Result<(), Cr7Error> {
    for (file, place) in EVENTS {
        played(embedded(file), file, |_, played, report| {
            claims_8(r, place, played, report);
            if file == EVENTS[0].0 {
                figures_14(figures, played, report);
            }
        })?;
    }
    Ok(())
}

/// The paper shows section 5.3 in pictures alone.
const NONE: &str = "none printed";

fn claims_8(r: &mut Reproduction, place: &str, played: &Played, report: &RunReport) {
    let Some(way) = report.excursions.first() else {
        r.add(place, "the path was never left", "", "").guaranteed(false);
        return;
    };
    let seconds = |t: Option<f64>| t.map_or("never".to_owned(), |t| format!("{t:.3}"));
    r.add(place, "from the event to joint space, s", NONE, format!("{:.3}", way.time_to_leave_s));
    r.add(place, "from the event over point 3 to point 4, s", NONE, seconds(way.time_to_goal_s))
        .guaranteed(way.time_to_goal_s.is_some());
    r.add(place, "from point 4 back to the path, s", NONE, seconds(way.time_to_return_s))
        .guaranteed(way.time_to_return_s.is_some());
    r.add(place, "left and resumed at, mm", NONE, {
        let resumed = way.resumed_at_m.map_or("never".to_owned(), |s| format!("{:.6}", s * 1e3));
        format!("{:.6}, {resumed}", way.left_at_m * 1e3)
    })
    .guaranteed(way.resumed_at_m == Some(way.left_at_m));
    for (name, accuracy) in [("before the event", report.accuracy_before), ("after the return", report.accuracy_after)]
    {
        let Some(a) = accuracy else { continue };
        r.add(place, format!("off the path {name}, setpoints, mm"), NONE, format!("{:.1e}", a.setpoints_m * 1e3))
            .guaranteed(a.setpoints_m < 1e-9);
        r.add(place, format!("off the path {name}, arm with lag, mm"), NONE, format!("{:.5}", a.simulated_arm_m * 1e3))
            .note("drives with a lag of 8 ms; the largest value is where the lag of the joint move settles");
    }
    let off = played.cycles().iter().any(|c| c.state == HybridState::TaskPath && !c.on_path);
    r.add(place, "cycles off the path in the state \"task path\"", "", if off { "some" } else { "none" })
        .guaranteed(!off);
    r.add(place, "end of the path reached", "", if report.path_finished { "yes" } else { "no" })
        .guaranteed(report.path_finished);
    held(r, place, report);
}

fn figures_14(figures: &mut Vec<Figure>, played: &Played, report: &RunReport) {
    type Of = fn(&Setpoint, usize) -> f64;
    let quantities: [(&'static str, &'static str, &'static str, Of); 3] = [
        ("figure_14_position.svg", "Figure 14: joint positions", "position [rad]", |p, k| p.q[k]),
        ("figure_14_velocity.svg", "Figure 14: joint velocities", "velocity [rad/s]", |p, k| p.qd[k]),
        ("figure_14_acceleration.svg", "Figure 14: joint accelerations", "acceleration [rad/s²]", |p, k| p.qdd[k]),
    ];
    for (file, title, label, of) in quantities {
        let joint = |k: usize| FigureLine {
            name: format!("joint {}", k + 1),
            points: played.cycles().iter().map(|c| (c.setpoint.t, of(&c.setpoint, k))).collect(),
        };
        figures.push(Figure {
            file,
            title,
            facts: format!("points 1, 2, event, 3, 4, wait, back; {:.3} s", report.duration_s),
            across: "time t [s]",
            label,
            lines: (0..6).map(joint).collect(),
        });
    }
}
