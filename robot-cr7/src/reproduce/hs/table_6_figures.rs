//! Figures 11 and 12 of Liu et al. 2024.

use super::table_6::Table6Run;
use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure, PlaneCurve, PlanePlot};

const ALONG: &str = "path length s [mm]";
const TIME: &str = "time t [s]";
const COUNTS: &str = "The paper has 193 segments where its method, read in any way, gives other counts.";

fn panel(across: &str, label: &str, lines: Vec<FigureLine>, limits: Vec<FigureLine>) -> PanelPlot {
    PanelPlot { across: across.to_owned(), label: label.to_owned(), lines, limits, marks: Vec::new() }
}

impl Table6Run {
    /// Figures 11 and 12.
    pub fn figures(&self) -> Vec<PaperFigure> {
        let mut all = self.along_the_path();
        all.extend(self.over_time());
        all
    }

    fn figure(&self, file: &str, title: &str, caption: &str, drawing: Drawing) -> PaperFigure {
        PaperFigure {
            file: format!("hs_figure_{file}.svg"),
            title: title.to_owned(),
            facts: format!("butterfly, {} segments by halving at 0.05 mm", self.breaks.len() - 1),
            caption: caption.to_owned(),
            drawing,
        }
    }

    /// Figures 11a, 11b and 12a.
    fn along_the_path(&self) -> Vec<PaperFigure> {
        let mm = |s: f64| s * 1e3;
        let deviations: Vec<f64> = self.breaks.windows(2).map(|w| self.curve.deviation(w[0], w[1], 60) * 1e3).collect();
        let steps = self.lengths.windows(2).zip(&deviations);
        let error = steps.flat_map(|(b, d)| [(mm(b[0]), *d), (mm(b[1]), *d)]).collect();
        let (lo, hi) = self.curve.domain();
        let mut s = 0.0;
        let mut curvature = Vec::new();
        for i in 0..=6000 {
            let at = |i: i32| lo + (hi - lo) * (f64::from(i) / 6000.0).min(1.0 - 1e-12);
            if i > 0 {
                s += (self.curve.point(at(i)) - self.curve.point(at(i - 1))).norm();
            }
            curvature.push((mm(s), self.curve.curvature(at(i)).abs() * 1e-3));
        }
        let whole = (0.0, self.lengths.last().copied().unwrap_or(0.0) * 1e3);
        let pieces = self.breaks.windows(2).enumerate().map(|(i, w)| PlaneCurve {
            name: String::new(),
            colour: i % 4,
            thin: false,
            points: self.curve.drawn(w[0], w[1], 10),
        });
        let plane = PlanePlot {
            across: "x [mm]".to_owned(),
            label: "y [mm]".to_owned(),
            curves: pieces.collect(),
            points: Vec::new(),
        };
        vec![
            self.figure(
                "11a",
                "Figure 11a: chord error of each segment",
                &format!("The paper shows every chord error below 0.05 mm. {COUNTS}"),
                Drawing::Panels(vec![panel(
                    ALONG,
                    "chord error [mm]",
                    vec![FigureLine::new("ours", error)],
                    vec![FigureLine::level(whole, 0.05)],
                )]),
            ),
            self.figure(
                "11b",
                "Figure 11b: curvature",
                "The paper shows the curvature of the butterfly over its segments; here it is drawn over the \
                 path length.",
                Drawing::Panels(vec![panel(
                    ALONG,
                    "curvature [1/mm]",
                    vec![FigureLine::new("curvature", curvature)],
                    Vec::new(),
                )]),
            ),
            self.figure(
                "12a",
                "Figure 12a: the butterfly in its segments",
                &format!("The paper colours the segments. {COUNTS} The curve stands where the CR7 runs it."),
                Drawing::Plane(plane),
            ),
        ]
    }

    /// Figures 12b to 12d.
    fn over_time(&self) -> Vec<PaperFigure> {
        let t = &self.motion.t;
        let ends = (0.0, t.last().copied().unwrap_or(0.0));
        let over =
            |values: &[f64], factor: f64| t.iter().copied().zip(values.iter().map(|v| v * factor)).collect::<Vec<_>>();
        let axis = &self.motion.axes[0];
        let asked: Vec<f64> = self.cycles.iter().map(|c| c.asked).collect();
        let jerk =
            t.windows(2).zip(axis.a.windows(2)).map(|(t, a)| (t[1], (a[1] - a[0]) / (t[1] - t[0]) * 1e3)).collect();
        let both = |x: f64| vec![FigureLine::level(ends, x), FigureLine::level(ends, -x)];
        vec![
            self.figure(
                "12b",
                "Figure 12b: feed rate",
                "The paper shows the feed rate under the feeds of Table 6. The sections are the same shares of \
                 our segments.",
                Drawing::Panels(vec![panel(
                    TIME,
                    "feed [mm/s]",
                    vec![FigureLine::new("ours", over(&axis.v, 1e3)), FigureLine::new("ordered", over(&asked, 1e3))],
                    Vec::new(),
                )]),
            ),
            self.figure(
                "12c",
                "Figure 12c: tangential acceleration",
                "The paper shows the acceleration at its limits of 100 mm/s². A feed that may change at any \
                 time uses 70 % of them here.",
                Drawing::Panels(vec![panel(
                    TIME,
                    "acceleration [mm/s²]",
                    vec![FigureLine::new("ours", over(&axis.a, 1e3))],
                    both(100.0),
                )]),
            ),
            self.figure(
                "12d",
                "Figure 12d: tangential jerk",
                "The paper shows the jerk at its limits of 1000 mm/s³. A feed that may change at any time uses \
                 70 % of them here.",
                Drawing::Panels(vec![panel(TIME, "jerk [mm/s³]", vec![FigureLine::new("ours", jerk)], both(1000.0))]),
            ),
        ]
    }
}
