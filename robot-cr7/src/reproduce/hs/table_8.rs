//! Liu et al. 2024, section 5.3: the event in both spaces (Table 8, Figure 14).

use arcfeed_interp::HybridState;
use nalgebra::Vector3;

use super::conditions::played;
use super::projection::{ACCELERATION, VELOCITY};
use crate::input::scenario::Scenario;
use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure, PlaneCurve, PlanePlot};
use crate::reproduce::checker::{AxisBounds, SampledAxis, SampledMotion};
use crate::reproduce::spline::off_segment;
use crate::reproduce::{Reproduction, cr7_dh};
use crate::run::error::Cr7Error;

/// Table 8, rad, in the zero of the paper.
#[expect(clippy::approx_constant, reason = "digits as printed")]
const POINTS: [[f64; 6]; 4] = [
    [-2.4784, -1.6947, 2.0595, -1.9373, -1.5708, -0.9146],
    [-1.5427, -1.6954, 2.0565, -1.9319, -1.5708, 0.0281],
    [-0.4119, -1.0036, 0.8622, -1.8675, -1.5708, 0.0281],
    [0.0281, -1.1292, 0.8622, -2.6878, -1.5708, 0.0281],
];

/// Where the first scenario's path ends, 100 mm behind point 2 on the line from point 1, rad, in the zero of the paper. The paper lets
/// the task go on behind point 2 and does not say where it ends.
const BEHIND: [f64; 6] =
    [-1.288716540983, -1.53915982343, 1.908883478059, -1.940343105692, -1.570343399872, 0.284108430358];

/// Joint values in the zero of the maker.
fn in_maker_zero(q: &[f64; 6]) -> [f64; 6] {
    use std::f64::consts::FRAC_PI_2 as Q;
    let zero = [0.0, Q, 0.0, Q, 0.0, 0.0];
    std::array::from_fn(|k| q[k] + zero[k])
}

/// A point of Table 8 in the zero of the maker.
fn point(number: usize) -> [f64; 6] {
    in_maker_zero(&POINTS[number - 1])
}

/// One of the two events.
struct Event {
    scenario: &'static str,
    place: &'static str,
    /// Where the path ends, in the zero of the paper.
    end: [f64; 6],
    /// The arm stops at point 2 and passes point 3 within so much, rad; else it leaves before point 2 and stops at point 3.
    passes_within: Option<f64>,
}

/// The event of section 5.3, played by one scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct EventRun {
    /// Where in the paper.
    pub place: &'static str,
    /// How near the arm passes point 3 without a stop, rad; `None` where it stops there.
    pub passes_within: Option<f64>,
    /// The joints.
    pub joints: SampledMotion,
    /// Where the motion is in each sample, in words.
    pub states: Vec<&'static str>,
    /// Tool points by the Denavit-Hartenberg table, m.
    pub tool: Vec<[f64; 3]>,
    /// Largest distance of the simulated arm from its setpoints, rad.
    pub lag: f64,
}

/// The two events: at point 2 with braking, in the middle of the path at once.
const EVENTS: [Event; 2] = [
    Event {
        scenario: "event.toml",
        place: "Table 8, figure 14: event at point 2, brakes on the path first (limits of table 7)",
        end: BEHIND,
        passes_within: Some(10.0 * std::f64::consts::PI / 180.0),
    },
    Event {
        scenario: "event_middle.toml",
        place: "Table 8, section 5.3: event in the middle of the path, leaves at once at 100 mm/s",
        end: POINTS[1],
        passes_within: None,
    },
];

impl EventRun {
    /// Plays both events.
    ///
    /// # Errors
    /// [`Cr7Error`] when an embedded scenario cannot be played.
    pub fn measure() -> Result<Vec<Self>, Cr7Error> {
        EVENTS.iter().map(Self::play).collect()
    }

    fn play(event: &Event) -> Result<Self, Cr7Error> {
        let file = event.scenario;
        let text = Scenario::ALL.into_iter().find(|(name, _)| *name == file).map_or("", |(_, text)| text);
        played(text, file, |_, played| {
            let cycles = played.cycles();
            let points: Vec<_> = std::iter::once(played.start()).chain(cycles.iter().map(|c| &c.setpoint)).collect();
            let (first, last) = (point(1), in_maker_zero(&event.end));
            let axis = |k: usize| SampledAxis {
                name: format!("joint {}", k + 1),
                p: points.iter().map(|p| p.q[k]).collect(),
                v: points.iter().map(|p| p.qd[k]).collect(),
                a: points.iter().map(|p| p.qdd[k]).collect(),
                start: [first[k], 0.0, 0.0],
                end: [last[k], 0.0, 0.0],
                bounds: vec![(0.0, AxisBounds::symmetric(VELOCITY[k], ACCELERATION[k], 10.0 * ACCELERATION[k]))],
            };
            let done = cycles.last().is_some_and(|c| c.state == HybridState::Done);
            Self {
                place: event.place,
                passes_within: event.passes_within,
                joints: SampledMotion {
                    t: points.iter().map(|p| p.t).collect(),
                    axes: (0..6).map(axis).collect(),
                    arrived: Some(done),
                    tolerance: 1e-12,
                },
                states: std::iter::once("task path").chain(cycles.iter().map(|c| c.state.name())).collect(),
                tool: points.iter().map(|p| cr7_dh::position(&p.q.into()).into()).collect(),
                lag: cycles.iter().map(|c| c.following_error.amax()).fold(0.0, f64::max),
            }
        })
    }

    /// Least distance of the joints from a point of Table 8 on the way out, rad, and when.
    fn nearest(&self, number: usize) -> (f64, f64) {
        let out = self.states.iter().position(|&s| s == "returning").unwrap_or(self.states.len());
        let target = point(number);
        let off = |i: usize| (0..6).fold(0.0f64, |w, k| w.max((self.joints.axes[k].p[i] - target[k]).abs()));
        let least = |best: (f64, f64), i: usize| if off(i) < best.0 { (off(i), self.joints.t[i]) } else { best };
        (0..out).fold((f64::INFINITY, f64::NAN), least)
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        self.joints.judge(r, self.place, "joints");
        self.judge_points(r);
        let ends = [1, 2].map(|n| cr7_dh::position(&point(n)));
        let on_path = |i: &usize| self.states[*i] == "task path";
        let behind = ends[0] + (ends[1] - ends[0]) * 2.0;
        let off = |i: usize| off_segment(&Vector3::from(self.tool[i]), &ends[0], &behind);
        let worst = (0..self.tool.len()).filter(on_path).map(off).fold(0.0, f64::max);
        r.independent(
            self.place,
            "on the path: tool off the line through points 1 and 2, m",
            "",
            format!("{worst:.1e}"),
            worst < 1e-9,
        );
        let left = (1..self.states.len()).find(|&i| self.states[i] != "task path").unwrap_or(0);
        let back = (left..self.states.len()).find(|&i| left > 0 && self.states[i] == "task path");
        let order = back.is_some_and(|back| {
            let (_, three) = self.nearest(3);
            let (_, four) = self.nearest(4);
            self.joints.t[left] < three && three < four && four < self.joints.t[back]
        });
        r.independent(
            self.place,
            "point 3, then point 4, then the path again",
            "yes",
            if order { "yes" } else { "no" },
            order,
        );
        // The last sample on the way back stands where the path was left.
        let gap = back.map_or(f64::INFINITY, |back| {
            let return_point = Vector3::from(self.tool[back.saturating_sub(1)]);
            let left_at = (0..left + 200).take_while(|i| *i < self.tool.len() && self.states[*i] != "joint move");
            left_at.map(|i| (Vector3::from(self.tool[i]) - return_point).norm()).fold(f64::INFINITY, f64::min)
        });
        r.information(self.place, "resumes beside a sample of the way out, mm", "", format!("{:.1e}", gap * 1e3));
        r.information(self.place, "largest lag of the simulated arm, rad", "", format!("{:.1e}", self.lag))
            .note("drives with a lag of 8 ms");
        let duration = self.joints.t.last().copied().unwrap_or(f64::NAN);
        r.information(self.place, "duration, s", "none printed", format!("{duration:.3}"));
    }

    /// Rows of points 2 to 4: where the arm stands still, and where it passes.
    fn judge_points(&self, r: &mut Reproduction) {
        let speed = |i: usize| self.joints.axes.iter().fold(0.0f64, |w, axis| w.max(axis.v[i].abs()));
        let mut stands_at = |number: usize| {
            let (off, t) = self.nearest(number);
            let what = format!("reaches point {number} of Table 8, least distance, rad");
            r.independent(self.place, what, "0", format!("{off:.1e}"), off < 1e-9).note(format!("after {t:.3} s"));
        };
        stands_at(4);
        let Some(within) = self.passes_within else { return stands_at(3) };
        let (off, t) = self.nearest(3);
        let slowest = (0..self.joints.t.len()).filter(|&i| (self.joints.t[i] - t).abs() < 0.1).map(speed);
        let slowest = slowest.fold(f64::INFINITY, f64::min);
        let what = "passes point 3 of Table 8 without a stop, least distance, rad";
        r.independent(self.place, what, "near 0", format!("{off:.3}"), off < within && slowest > 0.1)
            .note(format!("asked for {within:.3}; no slower than {slowest:.2} rad/s there, after {t:.3} s"));
        // The tool stops where a cycle ends, within the way of one; the joints then have the speed of a part of a cycle at most.
        let two = cr7_dh::position(&point(2));
        let stands = (1..self.states.len()).find(|&i| self.states[i] == "joint move").map_or(0, |i| i - 1);
        let off = (Vector3::from(self.tool[stands]) - two).norm();
        let what = "stops at point 2 of Table 8, tool off it, mm";
        r.independent(self.place, what, "0", format!("{:.3}", off * 1e3), off < 2e-4 && speed(stands) < 1e-3)
            .note("the way of one cycle at 100 mm/s is 0.2 mm");
        let end = self.tool.last().map_or(f64::NAN, |p| (Vector3::from(*p) - two).norm());
        r.information(self.place, "goes on along the path behind point 2, mm", "", format!("{:.3}", end * 1e3));
    }

    /// Figure 14: the way of the tool from above and from the side, and the joints.
    pub fn figures(&self, file: &str, title: &str) -> Vec<PaperFigure> {
        let view = |name: &str, (i, j): (usize, usize), labels: (&str, &str)| {
            let at = |p: &[f64; 3]| [p[i] * 1e3, p[j] * 1e3];
            let mut curves: Vec<PlaneCurve> = Vec::new();
            for (k, p) in self.tool.iter().enumerate() {
                let words = self.states[k];
                let colour =
                    ["task path", "leaving", "joint move", "returning"].iter().position(|s| *s == words).unwrap_or(4);
                let same = curves.last().is_some_and(|c| c.name == words);
                if !same {
                    let joined = curves.last().and_then(|c| c.points.last().copied());
                    curves.push(PlaneCurve {
                        name: words.to_owned(),
                        colour,
                        thin: false,
                        points: joined.into_iter().collect(),
                    });
                }
                if let Some(curve) = curves.last_mut() {
                    curve.points.push(at(p));
                }
            }
            let named = (1..=4).map(|n| {
                let p: [f64; 3] = cr7_dh::position(&point(n)).into();
                (at(&p), format!("point {n}"))
            });
            PaperFigure {
                file: format!("hs_figure_{file}_{name}.svg"),
                title: format!("{title}: the tool, {}", if j == 1 { "from above" } else { "from the side" }),
                facts: "points 1 to 4 of Table 8".to_owned(),
                caption:
                    "The paper shows the arm and its path in a simulation and in a photograph. Here the way of the \
                          tool is drawn, with the points of Table 8; no arm was moved."
                        .to_owned(),
                drawing: Drawing::Plane(PlanePlot {
                    across: labels.0.to_owned(),
                    label: labels.1.to_owned(),
                    curves,
                    points: named.collect(),
                }),
            }
        };
        let t = &self.joints.t;
        let end = t.last().copied().unwrap_or(0.0);
        let changes = (1..self.states.len()).filter(|&i| self.states[i] != self.states[i - 1]);
        let marks: Vec<(f64, String)> = changes.map(|i| (t[i], self.states[i].to_owned())).collect();
        let panel = |label: &str, of: fn(&SampledAxis) -> &Vec<f64>, limit: Option<f64>| PanelPlot {
            across: "time t [s]".to_owned(),
            label: label.to_owned(),
            lines: self
                .joints
                .axes
                .iter()
                .map(|axis| FigureLine::new(&*axis.name, t.iter().copied().zip(of(axis).iter().copied()).collect()))
                .collect(),
            limits: limit.iter().flat_map(|&x| [x, -x]).map(|x| FigureLine::level((0.0, end), x)).collect(),
            marks: marks.clone(),
        };
        vec![
            view("above", (0, 1), ("x [mm]", "y [mm]")),
            view("side", (0, 2), ("x [mm]", "z [mm]")),
            PaperFigure {
                file: format!("hs_figure_{file}_joints.svg"),
                title: format!("{title}: the joints"),
                facts: format!("{end:.3} s; marks tell where the motion changes"),
                caption: "The paper shows no joint curves of this experiment. The limits are those of Table 7."
                    .to_owned(),
                drawing: Drawing::Panels(vec![
                    panel("position [rad]", |a| &a.p, None),
                    panel("velocity [rad/s]", |a| &a.v, None),
                    panel("acceleration [rad/s²]", |a| &a.a, None),
                ]),
            },
        ]
    }
}
