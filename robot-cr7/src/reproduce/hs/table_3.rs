//! Liu et al. 2024, Table 3 and Figure 5: the online feed rate with limits that change.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, FeedScheduler, FeedStatus};

use super::conditions::{CYCLES, END, PERIOD, START, TABLE_3, Window};
use super::printed_feed::{FeedOutcome, Scheme, run};
use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure};
use crate::reproduce::Reproduction;
use crate::reproduce::checker::{AxisBounds, SampledAxis, SampledMotion};

const PLACE: &str = "Table 3, figure 5: online feed rate, limits changed at 3 and 6 s (mm, s)";

/// The motion of Table 3, and what the printed equations make of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Table3Run {
    /// Our motion.
    pub motion: SampledMotion,
    /// Jerk of each of its cycles, for the figure.
    pub jerk: Vec<f64>,
    /// Section 3 as printed.
    pub printed: FeedOutcome,
    /// Section 3 as corrected.
    pub corrected: FeedOutcome,
    /// Largest error of position, velocity, acceleration at the end as corrected, over 41 ways from
    /// 190 to 210 mm.
    pub corrected_errors: [f64; 3],
}

impl Table3Run {
    /// Runs the feed rate, and the printed scheme.
    ///
    /// # Errors
    /// None with the numbers of the table.
    pub fn measure() -> Result<Self, FeedError> {
        let limits = TABLE_3.map(|w| AxisLimits::forward(w.v.1, w.a, w.j));
        let state = |x: [f64; 3]| AxisState::new(x[0], x[1], x[2]);
        let mut row = 0;
        let mut feed = FeedScheduler::new(&state(START), &state(END), &limits[0]?)?;
        let first = feed.state();
        let (mut t, mut p, mut v, mut a) = (vec![0.0], vec![first.p], vec![first.v], vec![first.a]);
        let mut jerk = vec![first.j];
        let mut arrived = false;
        for cycle in 0..CYCLES {
            let now = PERIOD * f64::from(cycle);
            if row + 1 < TABLE_3.len() && now >= TABLE_3[row + 1].from - 0.5 * PERIOD {
                row += 1;
                feed.set_limits(&limits[row]?)?;
            }
            let step = feed.step(PERIOD)?;
            arrived = matches!(step.status, FeedStatus::Reached { .. });
            let unused = if let FeedStatus::Reached { unused } = step.status { unused } else { 0.0 };
            t.push(now + PERIOD - unused);
            p.push(step.state.p);
            v.push(step.state.v);
            a.push(step.state.a);
            jerk.push(step.state.j);
            if arrived {
                break;
            }
        }
        let bounds = TABLE_3.iter().map(|w| (w.from, AxisBounds { v: w.v, a: w.a, j: w.j })).collect();
        let axis = SampledAxis { name: "feed".to_owned(), p, v, a, start: START, end: END, bounds };
        let mut corrected_errors = [0.0f64; 3];
        for i in 0..=40 {
            let length = 190.0 + 0.5 * f64::from(i);
            let (_, end) = run(Scheme::Corrected, length, 1e-3, 30.0).last();
            for (worst, (got, asked)) in corrected_errors.iter_mut().zip(end.iter().zip([length, END[1], END[2]])) {
                *worst = worst.max((got - asked).abs());
            }
        }
        Ok(Self {
            motion: SampledMotion { t, axes: vec![axis], arrived: Some(arrived), tolerance: 0.0 },
            jerk,
            printed: run(Scheme::Printed, END[0], 1e-3, 12.0),
            corrected: run(Scheme::Corrected, END[0], 1e-3, 30.0),
            corrected_errors,
        })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        self.motion.judge(r, PLACE, "feed");
        let (t, [s, v, _]) = self.printed.last();
        let arrived = if self.printed.arrived { "arrives" } else { "does not arrive" };
        r.information(PLACE, format!("eqs. 2 to 16 as printed, after {t:.0} s"), "arrives", arrived).note(format!(
            "s = {s:.1} mm, v = {v:.1} mm/s: eq. 3 compares with the least velocity and stays without jerk"
        ));
        let (t, _) = self.corrected.last();
        let [s, v, a] = self.corrected_errors;
        r.information(PLACE, "eqs. 2 to 16 as corrected, arrival, s", "", format!("{t:.4}")).note(format!(
            "over 41 ways from 190 to 210 mm it ends up to {s:.3} mm, {v:.3} mm/s, {a:.3} mm/s^2 beside the end state"
        ));
    }

    /// Figure 5, and Figure 5 by the printed equations.
    pub fn figures(&self) -> Vec<PaperFigure> {
        let motion = &self.motion;
        let axis = &motion.axes[0];
        let line = |values: &[f64]| motion.t.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>();
        let end = motion.t.last().copied().unwrap_or(0.0);
        let steps = |of: fn(&Window) -> f64| {
            let until = |i: usize| TABLE_3.get(i + 1).map_or(end, |w| w.from);
            let both = TABLE_3.iter().enumerate().flat_map(|(i, w)| [(w.from, of(w)), (until(i), of(w))]);
            FigureLine::new("", both.collect())
        };
        let marks = vec![(3.0, "limits change".to_owned()), (6.0, "limits change".to_owned())];
        let other = |k: usize| self.corrected.samples.iter().map(|(t, x)| (*t, x[k])).collect::<Vec<_>>();
        let panel = |label: &str, lines: Vec<FigureLine>, limits: Vec<FigureLine>| PanelPlot {
            across: "time t [s]".to_owned(),
            label: label.to_owned(),
            lines,
            limits,
            marks: marks.clone(),
        };
        let pair = |values: &[f64], k: usize| {
            vec![FigureLine::new("ours", line(values)), FigureLine::new("section 3, corrected", other(k))]
        };
        let panels = vec![
            panel("s [mm]", pair(&axis.p, 0), Vec::new()),
            panel("v [mm/s]", pair(&axis.v, 1), vec![steps(|w| w.v.1), steps(|w| w.v.0)]),
            panel("a [mm/s²]", pair(&axis.a, 2), vec![steps(|w| w.a.1), steps(|w| w.a.0)]),
            panel(
                "j [mm/s³]",
                vec![FigureLine::new("ours", line(&self.jerk))],
                vec![steps(|w| w.j.1), steps(|w| w.j.0)],
            ),
        ];
        let printed = |k: usize| self.printed.samples.iter().map(|(t, x)| (*t, x[k])).collect::<Vec<_>>();
        let printed = ["s [mm]", "v [mm/s]", "a [mm/s²]"].into_iter().enumerate().map(|(k, label)| PanelPlot {
            across: "time t [s]".to_owned(),
            label: label.to_owned(),
            lines: vec![FigureLine::new("as printed", printed(k))],
            ..PanelPlot::default()
        });
        vec![
            PaperFigure {
                file: "hs_figure_05.svg".to_owned(),
                title: "Figure 5: online feed rate".to_owned(),
                facts: format!("limits change at 3 and 6 s; arrives after {end:.4} s at s = 200, v = 5, a = 6"),
                caption:
                    "The paper shows position, feed rate, acceleration and jerk for Table 3. Ours ends in the state \
                          that was asked for; the corrected scheme of the paper ends beside it."
                        .to_owned(),
                drawing: Drawing::Panels(panels),
            },
            PaperFigure {
                file: "hs_figure_05_as_printed.svg".to_owned(),
                title: "Figure 5 by the equations as printed".to_owned(),
                facts: "eqs. 2 to 5 to the letter".to_owned(),
                caption: "The paper does not show this: with eq. 3 as printed the motion runs backwards without end."
                    .to_owned(),
                drawing: Drawing::Panels(printed.collect()),
            },
        ]
    }
}
