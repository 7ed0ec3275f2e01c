//! Figures 1 to 4, 6, 10, 11 and 13 of Liu et al. 2023.

use arcfeed_feedrate::{AxisLimits, MotionLaw, SProfile, SpeedChange};

use super::bezier_table::BezierTable;
use super::competitors::{Compared, Table2Run};
use super::counts::{CountRun, type_c};
use super::curves::{chords, pieces, plane};
use super::motion::MotionRun;
use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure, PlaneCurve, PlanePlot};
use crate::reproduce::checker::SampledMotion;
use crate::reproduce::spline::Spline;

fn figure(number: &str, title: &str, facts: String, caption: &str, drawing: Drawing) -> PaperFigure {
    PaperFigure {
        file: format!("pn_figure_{number}.svg"),
        title: format!("Figure {}: {title}", number.trim_start_matches('0').split('_').next().unwrap_or_default()),
        facts,
        caption: caption.to_owned(),
        drawing,
    }
}

fn panel(across: &str, label: &str, lines: Vec<FigureLine>, limits: Vec<FigureLine>) -> PanelPlot {
    PanelPlot { across: across.to_owned(), label: label.to_owned(), lines, limits, marks: Vec::new() }
}

/// Figures 1 to 3: the six-point curve.
pub fn six_points(table: &BezierTable, curve: &Spline, count: &CountRun) -> Vec<PaperFigure> {
    let spans = curve.breaks();
    let split = type_c(curve);
    let second: Vec<f64> = split.iter().copied().filter(|u| (spans[1]..=spans[2]).contains(u)).collect();
    let inner = second.get(1).map_or(Vec::new(), |u| {
        let p = curve.point(*u);
        vec![([p.x * 1e3, p.y * 1e3], "zero curvature".to_owned())]
    });
    let n = count.breaks.len() - 1;
    vec![
        figure(
            "01a",
            "a NURBS curve",
            "six control points of Table 1".to_owned(),
            "The paper shows the curve with its control points. No difference.",
            Drawing::Plane(plane(pieces(curve, &[spans[0], spans[3]]), table.polygon())),
        ),
        figure(
            "01b",
            "three Bezier curves",
            "by knot insertion".to_owned(),
            "The paper shows three Bezier curves. No difference, except for the misprint in Table 1.",
            Drawing::Plane(plane(pieces(curve, &spans), table.ends())),
        ),
        figure(
            "02a",
            "Bezier 2 in two curves of type C",
            "split where the curvature vanishes".to_owned(),
            "The paper splits the S-shaped Bezier 2 where its curvature is zero. No difference.",
            Drawing::Plane(plane(pieces(curve, &second), inner)),
        ),
        figure(
            "02b",
            "the chord error",
            "Bezier 1 in the frame of its chord".to_owned(),
            "The paper takes the largest distance from the chord as the chord error. No difference.",
            Drawing::Plane(table.local_frame(0)),
        ),
        figure(
            "03a",
            "curves of type C",
            format!("{} pieces", split.len() - 1),
            "The paper shows the curve in pieces of type C. No difference.",
            Drawing::Plane(plane(pieces(curve, &split), Vec::new())),
        ),
        figure(
            "03b",
            "pieces at 0.001 mm",
            format!("{n} pieces; the paper has 143"),
            "The paper has 143 pieces. No reading of its method gives this count.",
            Drawing::Plane(plane(pieces(curve, &count.breaks), Vec::new())),
        ),
    ]
}

fn law_panels(laws: &[(&str, &dyn MotionLaw)], scale: f64, limits: [f64; 3]) -> Vec<PanelPlot> {
    let end = laws.iter().map(|l| l.1.duration()).fold(0.0, f64::max);
    let line = |of: fn(&arcfeed_feedrate::MotionState) -> f64| {
        laws.iter()
            .map(|(name, law)| {
                let at = |i: i32| law.duration() * f64::from(i) / 2000.0;
                FigureLine::new(*name, (0..=2000).map(|i| (at(i), of(&law.at(at(i))) * scale)).collect())
            })
            .collect::<Vec<_>>()
    };
    let both = |x: f64| vec![FigureLine::level((0.0, end), x), FigureLine::level((0.0, end), -x)];
    vec![
        panel("time t [s]", "v [mm/s]", line(|s| s.v), vec![FigureLine::level((0.0, end), limits[0])]),
        panel("time t [s]", "a [mm/s²]", line(|s| s.a), both(limits[1])),
        panel("time t [s]", "j [mm/s³]", line(|s| s.j), both(limits[2])),
    ]
}

/// Figures 4 and 6: the S-shaped profile, and changes of speed from any acceleration.
pub fn profiles() -> Vec<PaperFigure> {
    let mut out = Vec::new();
    let Ok(limits) = AxisLimits::symmetric(0.1, 1.0, 20.0) else { return out };
    let shown = [100.0, 1000.0, 20_000.0];
    if let Ok(profile) = SProfile::new(0.03, 0.01, 0.02, &limits) {
        let mut panels = law_panels(&[("ours", &profile)], 1e3, shown);
        let s = |i: i32| profile.duration() * f64::from(i) / 1000.0;
        let way = (0..=1000).map(|i| (s(i), profile.at(s(i)).p * 1e3)).collect();
        panels.insert(0, panel("time t [s]", "s [mm]", vec![FigureLine::new("ours", way)], Vec::new()));
        out.push(figure(
            "04",
            "the S-shaped profile with seven sections",
            "30 mm from 10 to 20 mm/s; limits 100 mm/s, 1000 mm/s², 20000 mm/s³".to_owned(),
            "The paper shows the seven sections without numbers. Numbers and limits here are examples.",
            Drawing::Panels(panels),
        ));
    }
    let cases = [
        ("06_acceleration", "(a to c) change to a higher speed", (0.02, 0.4, 0.09)),
        ("06_deceleration", "(d to f) change to a lower speed", (0.08, 0.4, 0.02)),
    ];
    for (number, title, (v, a, target)) in cases {
        let direct = SpeedChange::new(v, a, target, &limits);
        // The paper first brings the acceleration to zero (eqs. 14 and 15), then changes the speed
        // (eqs. 17 and 18).
        let free = v + a * a / (2.0 * 20.0);
        let after = SpeedChange::new(free, 0.0, target, &limits);
        let (Ok(direct), Ok(after)) = (direct, after) else { continue };
        let paper = InTwoSteps { v, a, jerk: 20.0, after };
        let panels = law_panels(&[("ours", &direct), ("the paper, in two steps", &paper)], 1e3, shown);
        out.push(figure(number, title, format!("from {} mm/s and {} mm/s² to {} mm/s: {:.4} s; in two steps {:.4} s",
                v * 1e3, a * 1e3, target * 1e3, direct.duration(), paper.duration()),
            "The paper shows feed rate, acceleration and jerk of a change in two steps: acceleration to zero, \
             then the change. \
             Ours goes straight to the peak acceleration and takes less time when the speed has to change in that direction.",
            Drawing::Panels(panels)));
    }
    out
}

/// Section 3.2: the acceleration is brought to zero, then the speed is changed.
struct InTwoSteps {
    v: f64,
    a: f64,
    jerk: f64,
    after: SpeedChange,
}

impl MotionLaw for InTwoSteps {
    fn duration(&self) -> f64 {
        self.a / self.jerk + self.after.duration()
    }

    fn at(&self, t: f64) -> arcfeed_feedrate::MotionState {
        let first = self.a / self.jerk;
        if t >= first {
            return self.after.at(t - first);
        }
        let v = self.v + self.a * t - 0.5 * self.jerk * t * t;
        arcfeed_feedrate::MotionState { p: 0.0, v, a: self.a - self.jerk * t, j: -self.jerk }
    }
}

/// Chord error of each segment as steps over the parameter, mm.
fn errors(curve: &Spline, breaks: &[f64]) -> Vec<(f64, f64)> {
    let of = |w: &[f64]| curve.deviation(w[0], w[1], 60) * 1e3;
    breaks.windows(2).flat_map(|w| [(w[0], of(w)), (w[1], of(w))]).collect()
}

/// Figure 10: the butterfly.
pub fn butterfly(count: &CountRun, motion: &MotionRun) -> Vec<PaperFigure> {
    let curve = &count.curve;
    let (a, b) = curve.domain();
    let split = type_c(curve);
    let n = count.breaks.len() - 1;
    let with = errors(curve, &count.breaks);
    let without = errors(curve, &split);
    let most = |line: &[(f64, f64)]| line.iter().map(|p| p.1).fold(0.0, f64::max);
    let log = |line: &[(f64, f64)]| line.iter().map(|p| (p.0, p.1.max(1e-7).log10())).collect::<Vec<_>>();
    let facts = format!("largest {:.6} mm with the constraint, {:.3} mm without", most(&with), most(&without));
    let over = |m: &SampledMotion, of: fn(&crate::reproduce::checker::SampledAxis) -> &Vec<f64>| {
        m.t.iter().copied().zip(of(&m.axes[0]).iter().map(|x| x * 1e3)).collect::<Vec<_>>()
    };
    let duration = format!("{:.3} s; feed 100 mm/s, 1000 mm/s², 20000 mm/s³, normal 1000 mm/s²", motion.durations[1]);
    vec![
        figure(
            "10a",
            "the butterfly",
            "51 control points".to_owned(),
            "The paper shows the curve. No difference.",
            Drawing::Plane(plane(pieces(curve, &[a, b]), Vec::new())),
        ),
        figure(
            "10b",
            "pieces of type C",
            format!("{} pieces", split.len() - 1),
            "The paper splits the curve where its curvature is zero. No difference.",
            Drawing::Plane(plane(pieces(curve, &split), Vec::new())),
        ),
        figure(
            "10c",
            "pieces at 0.001 mm",
            format!("{n} pieces; the paper has 1579"),
            "The paper has 1579 pieces. No reading of its method gives this count.",
            Drawing::Plane(plane(pieces(curve, &count.breaks), Vec::new())),
        ),
        figure(
            "10d",
            "chord error with and without the constraint",
            facts,
            "The paper says that the chord error is a hundred times larger without the constraint. Without it, \
             only the pieces of type C are used here.",
            Drawing::Panels(vec![panel(
                "parameter u",
                "log10 of the chord error [mm]",
                vec![FigureLine::new("with", log(&with)), FigureLine::new("without", log(&without))],
                vec![FigureLine::level((a, b), -3.0)],
            )]),
        ),
        figure(
            "10e",
            "displacement",
            duration.clone(),
            "The paper shows the displacement. It prints neither feed nor limits, so the duration differs.",
            Drawing::Panels(vec![panel(
                "time t [s]",
                "s [mm]",
                vec![FigureLine::new("ours", over(&motion.path, |a| &a.p))],
                Vec::new(),
            )]),
        ),
        figure(
            "10f",
            "feed rate",
            duration,
            "The paper shows the feed rate of the bidirectional scan. It prints neither feed nor limits, so the \
             duration differs.",
            Drawing::Panels(vec![panel(
                "time t [s]",
                "v [mm/s]",
                vec![FigureLine::new("ours", over(&motion.path, |a| &a.v))],
                vec![FigureLine::level((0.0, motion.durations[1]), 100.0)],
            )]),
        ),
    ]
}

/// Figure 11: the methods of Table 2.
pub fn compared(run: &Table2Run) -> Vec<PaperFigure> {
    let curve = &run.curve;
    let ours = run.methods.last();
    let step = |name: &str, colour: usize, method: Compared, over: &Spline| {
        let parameters = run.methods.iter().find(|m| m.method == method).map_or(&[][..], |m| &m.parameters);
        let points = parameters.iter().step_by(4).map(|u| over.point(*u)).map(|p| [p.x * 1e3, p.y * 1e3]).collect();
        PlaneCurve { name: name.to_owned(), colour, thin: true, points }
    };
    let mut all = chords(curve, &[("X.D.: chords", &run.open_loop[0]), ("L.F.: chords", &run.open_loop[1])]);
    all.curves.push(step("L.H.", 2, Compared::Lh, &run.refitted));
    all.curves.push(step("ours", 3, Compared::Ours, curve));
    let window = |x: (f64, f64), y: (f64, f64)| {
        let cut = |c: &PlaneCurve| {
            let inside = |p: &&[f64; 2]| (x.0..=x.1).contains(&p[0]) && (y.0..=y.1).contains(&p[1]);
            let first = c.points.iter().position(|p| inside(&p));
            let last = c.points.iter().rposition(|p| inside(&p));
            let points =
                first.zip(last).map_or(Vec::new(), |(a, b)| c.points[a..=b].iter().filter(inside).copied().collect());
            PlaneCurve { points, ..c.clone() }
        };
        PlanePlot { curves: all.curves.iter().map(cut).collect(), ..all.clone() }
    };
    let shape = curve.drawn(curve.domain().0, curve.domain().1, 2000);
    let end = shape[0];
    // Area A: where a chord of the open loop lies farthest from the curve. Area B: the sharpest
    // bend.
    let farthest = run.open_loop[0]
        .windows(2)
        .max_by(|a, b| curve.deviation(a[0], a[1], 60).total_cmp(&curve.deviation(b[0], b[1], 60)));
    let place = |u: f64| {
        let p = curve.point(u);
        [p.x * 1e3, p.y * 1e3]
    };
    let left = farthest.map_or(end, |w| place(0.5 * (w[0] + w[1])));
    let bend = run.open_loop[1][1..run.open_loop[1].len() - 1].iter().copied();
    let top = bend.max_by(|a, b| curve.curvature(*a).abs().total_cmp(&curve.curvature(*b).abs())).map_or(end, place);
    let near = |p: [f64; 2], half: f64| window((p[0] - half, p[0] + half), (p[1] - half, p[1] + half));
    let drift = run.methods.iter().map(|m| {
        let log = |(i, d): (usize, f64)| (i as f64 * 1e-3, (d.abs() * 1e3).max(1e-13).log10());
        FigureLine::new(m.method.name(), m.drifts().into_iter().enumerate().map(log).collect())
    });
    let drift: Vec<FigureLine> = drift.collect();
    let facts = ours.map_or(String::new(), |m| {
        let q = m.quality();
        format!("ours: chord error {:.6} mm, end of u {}", q.chord * 1e3, q.end)
    });
    const READING: &str = "The methods are read as the table of methods says; the paper does not print them.";
    vec![
        figure(
            "11a",
            "methods compared",
            facts,
            &format!("The paper shows large deviations of the open-loop chords. {READING}"),
            Drawing::Plane(all.clone()),
        ),
        figure(
            "11b",
            "methods compared, area A",
            "enlarged".to_owned(),
            &format!("The paper enlarges a bend. {READING}"),
            Drawing::Plane(near(left, 5.0)),
        ),
        figure(
            "11c",
            "methods compared, area B",
            "enlarged".to_owned(),
            &format!("The paper enlarges another bend. {READING}"),
            Drawing::Plane(near(top, 0.4)),
        ),
        figure(
            "11d",
            "methods compared, area C: accumulated error",
            "arc length reached less arc length asked for".to_owned(),
            "The paper shows that open-loop Taylor steps do not close the curve. Here the accumulated error of \
             the arc length is drawn over the whole motion.",
            Drawing::Panels(vec![panel("time t [s]", "log10 of the error [mm]", drift, Vec::new())]),
        ),
    ]
}

/// Figure 13: the fan.
pub fn fan(count: &CountRun, feed: &[(f64, f64)]) -> Vec<PaperFigure> {
    let n = count.breaks.len() - 1;
    vec![
        figure(
            "13a",
            "the fan at 0.001 mm",
            format!("{n} pieces; the paper has 1454"),
            "The paper has 1454 pieces. It does not print its fan; a public one of the same kind stands for it \
             and may be another curve.",
            Drawing::Plane(plane(pieces(&count.curve, &count.breaks), Vec::new())),
        ),
        figure(
            "13b",
            "feed rate on the fan",
            "defaults of `cr7 plan`, scanned".to_owned(),
            "The paper shows the feed rate of the scan without its limits. Figures 13c and 13d are photographs \
             of the part and have no counterpart.",
            Drawing::Panels(vec![panel(
                "path length s [mm]",
                "v [mm/s]",
                vec![FigureLine::new("ours", feed.to_vec())],
                Vec::new(),
            )]),
        ),
    ]
}
