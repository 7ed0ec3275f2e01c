//! Liu et al. 2024, Tables 5 and 7, Figures 9 and 13: projection on the error.

use std::time::Instant;

use arcfeed_sync::nalgebra::{SVector, Vector3};
use arcfeed_sync::{JointState, ProjectionStatus, ProjectionSync, SyncError, symmetric_limits};

use super::conditions::{CYCLES, PERIOD, V6};
use super::printed_projection::{Limits6, ProjectionOutcome, corrected, frame, printed_bounds};
use super::tool::{FROM_POINT, FROM_QUATERNION, TO_POINT, TO_QUATERNION, tool_run};
use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure};
use crate::reproduce::checker::{AxisBounds, SampledAxis, SampledMotion};
use crate::reproduce::{Random, Reproduction};

const PLACE_5: &str = "Table 5, figure 9: projection on the error, from rest, joints and tool";
const PLACE_7: &str = "Table 7, figure 13: targets changed at 0.5, 1 and 2 s, from a state of motion";
/// Table 7. No jerk is printed: ten times the acceleration is taken.
pub(super) const VELOCITY: [f64; 6] = [6.0, 3.0, 4.0, 5.0, 6.0, 7.0];
pub(super) const ACCELERATION: [f64; 6] = [10.0, 12.0, 14.0, 16.0, 18.0, 20.0];
/// Table 5.
const FROM: [f64; 6] = [0.0, -5.0, 3.0, -2.0, 6.0, 0.0];
const TO: [f64; 6] = [-3.0, 3.0, -5.0, 6.0, 5.0, -6.0];
/// Random starts of the corrected scheme.
const STARTS: usize = 20;

/// Table 7: targets, each from a time on (s).
const TARGETS: [(f64, [f64; 6]); 4] = [
    (0.0, [-3.0, 3.0, -5.0, 6.0, 6.0, -6.0]),
    (0.5, [6.0, 3.0, 2.0, 6.0, -10.0, -6.0]),
    (1.0, [6.0, -5.0, 2.0, 20.0, -10.0, -1.0]),
    (2.0, [5.0, 10.0, -5.0, 3.0, -6.0, 0.0]),
];
/// Table 7: initial velocity and acceleration.
const QD: [f64; 6] = [1.0, 2.0, 0.0, 3.0, -4.0, 0.0];
const QDD: [f64; 6] = [10.0, -15.0, 5.0, 0.0, 1.0, 0.0];

/// The joints of Table 5 or 7, and how long each cycle took to compute.
#[derive(Debug, Clone, PartialEq)]
pub struct JointRun {
    /// The motion.
    pub motion: SampledMotion,
    /// Time of each cycle, s.
    pub cycle_times: Vec<f64>,
}

/// The motions of Table 5.
#[derive(Debug, Clone, PartialEq)]
pub struct Table5Run {
    /// The joints.
    pub joints: JointRun,
    /// Way of the tool along its line (m) and angle about its axis (rad).
    pub tool: SampledMotion,
    /// Tool points of the samples, m.
    pub points: Vec<[f64; 3]>,
    /// Orientations of the samples, x y z w.
    pub orientations: Vec<[f64; 4]>,
    /// The scheme of section 4.2 as corrected, on the joints of Table 5.
    pub corrected: ProjectionOutcome,
    /// The same on random starts.
    pub random: Vec<ProjectionOutcome>,
}

/// The motion of Table 7.
#[derive(Debug, Clone, PartialEq)]
pub struct Table7Run {
    /// The joints.
    pub joints: JointRun,
}

fn limits() -> Limits6 {
    let acceleration = V6::from(ACCELERATION);
    [V6::from(VELOCITY), acceleration, 10.0 * acceleration]
}

/// Bounds of joint `k`; a start beyond an acceleration limit `a0` widens it for as long as the jerk
/// needs.
fn bounds(k: usize, a0: f64) -> Vec<(f64, AxisBounds)> {
    let (a, j) = (ACCELERATION[k], 10.0 * ACCELERATION[k]);
    let kept = AxisBounds::symmetric(VELOCITY[k], a, j);
    let beyond = a0.abs() - a;
    if beyond <= 0.0 {
        return vec![(0.0, kept)];
    }
    let wider = AxisBounds { a: (a0.min(-a), a0.max(a)), ..kept };
    // A cycle that begins before the limit can be kept belongs to the wider bounds.
    vec![(0.0, wider), (beyond / j, kept)]
}

fn project(start: &JointState<6>, targets: &[(f64, [f64; 6])]) -> Result<JointRun, SyncError> {
    let [v, a, j] = limits();
    let mut sync = ProjectionSync::new(start, V6::from(targets[0].1), &symmetric_limits(v, a, j)?)?;
    let (mut t, mut states, mut cycle_times) = (vec![0.0], vec![*start], Vec::new());
    let (mut next, mut arrived) = (1, false);
    for cycle in 0..CYCLES {
        let now = PERIOD * f64::from(cycle);
        let begin = Instant::now();
        if next < targets.len() && now >= targets[next].0 - 0.5 * PERIOD {
            sync.set_target(V6::from(targets[next].1))?;
            next += 1;
        }
        let step = sync.step(PERIOD)?;
        cycle_times.push(begin.elapsed().as_secs_f64());
        let unused = if let ProjectionStatus::Reached { unused } = step.status { Some(unused) } else { None };
        t.push(now + PERIOD - unused.unwrap_or(0.0));
        states.push(step.state);
        arrived = unused.is_some() && next == targets.len();
        if arrived {
            break;
        }
    }
    let target = targets[targets.len() - 1].1;
    let axis = |k: usize| SampledAxis {
        name: format!("joint {}", k + 1),
        p: states.iter().map(|s| s.q[k]).collect(),
        v: states.iter().map(|s| s.qd[k]).collect(),
        a: states.iter().map(|s| s.qdd[k]).collect(),
        start: [start.q[k], start.qd[k], start.qdd[k]],
        end: [target[k], 0.0, 0.0],
        bounds: bounds(k, start.qdd[k]),
    };
    Ok(JointRun {
        motion: SampledMotion { axes: (0..6).map(axis).collect(), t, arrived: Some(arrived), tolerance: 0.0 },
        cycle_times,
    })
}

impl JointRun {
    fn judge(&self, r: &mut Reproduction, place: &str) {
        self.motion.judge(r, place, "joints");
        let mean = self.cycle_times.iter().sum::<f64>() / self.cycle_times.len().max(1) as f64;
        r.information(place, "mean time of one cycle, ms", "under 1", format!("{:.5}", mean * 1e3));
    }

    fn panels(&self) -> Vec<PanelPlot> {
        let end = self.motion.t.last().copied().unwrap_or(0.0);
        let panel = |label: &str, of: fn(&SampledAxis) -> &Vec<f64>, limit: Option<&[f64; 6]>| PanelPlot {
            across: "time t [s]".to_owned(),
            label: label.to_owned(),
            lines: self
                .motion
                .axes
                .iter()
                .map(|axis| {
                    FigureLine::new(&*axis.name, self.motion.t.iter().copied().zip(of(axis).iter().copied()).collect())
                })
                .collect(),
            limits: limit
                .iter()
                .flat_map(|l| {
                    let most = l.iter().copied().fold(0.0, f64::max);
                    [most, -most]
                })
                .map(|x| FigureLine::level((0.0, end), x))
                .collect(),
            marks: Vec::new(),
        };
        vec![
            panel("position [rad]", |a| &a.p, None),
            panel("velocity [rad/s]", |a| &a.v, Some(&VELOCITY)),
            panel("acceleration [rad/s²]", |a| &a.a, Some(&ACCELERATION)),
        ]
    }
}

impl Table5Run {
    /// Runs the joints and the tool of Table 5, and the scheme of the paper.
    ///
    /// # Errors
    /// None with the numbers of the table.
    pub fn measure() -> Result<Self, SyncError> {
        let joints = project(&JointState::rest(V6::from(FROM)), &[(0.0, TO)])?;
        let (tool, points, orientations) = tool_run()?;
        let limits = limits();
        let mut random = Random::new(5);
        let mut state = |share: f64| {
            let mut part = |limit: &V6| V6::from_fn(|k, _| share * limit[k] * random.between(-1.0, 1.0));
            [part(&V6::repeat(6.0 / share)), part(&limits[0]), part(&limits[1])]
        };
        let outcomes = (0..STARTS).map(|_| corrected(&state(0.5), &state(0.5)[0], &limits, PERIOD)).collect();
        let rest = [V6::from(FROM), V6::zeros(), V6::zeros()];
        let corrected = corrected(&rest, &V6::from(TO), &limits, PERIOD);
        Ok(Self { joints, tool, points, orientations, corrected, random: outcomes })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        self.joints.judge(r, PLACE_5);
        let (from, to) = (V6::from(FROM), V6::from(TO));
        let way = (to - from).normalize();
        let axes = &self.joints.motion.axes;
        let off_line = (0..self.joints.motion.t.len()).fold(0.0f64, |worst, i| {
            let moved = V6::from_fn(|k, _| axes[k].p[i]) - from;
            worst.max((moved - way * moved.dot(&way)).norm())
        });
        r.independent(PLACE_5, "joints: off the straight line, rad", "", format!("{off_line:.1e}"), off_line < 1e-9);
        self.tool.judge(r, PLACE_5, "tool, way and angle");
        let (a, b) = (Vector3::from(FROM_POINT), Vector3::from(TO_POINT));
        let off = self.points.iter().map(|p| crate::reproduce::spline::off_segment(&Vector3::from(*p), &a, &b));
        let off = off.fold(0.0f64, f64::max);
        r.independent(PLACE_5, "tool: off the straight line, m", "", format!("{off:.1e}"), off < 1e-12);
        let tilt = self.tilt();
        r.independent(
            PLACE_5,
            "tool: off the plane of its rotation, as quaternions",
            "",
            format!("{tilt:.1e}"),
            tilt < 1e-12,
        );
        self.judge_scheme(r);
    }

    /// Orientations between two on one axis lie in the plane of these two as vectors of four
    /// numbers.
    fn tilt(&self) -> f64 {
        let vector = |q: [f64; 4]| SVector::<f64, 4>::from(q).normalize();
        let first = vector(FROM_QUATERNION);
        let second = vector(TO_QUATERNION);
        let second = (second - first * first.dot(&second)).normalize();
        let off = |q: &[f64; 4]| {
            let q = vector(*q);
            (q - first * first.dot(&q) - second * second.dot(&q)).norm()
        };
        self.orientations.iter().map(off).fold(0.0, f64::max)
    }

    fn judge_scheme(&self, r: &mut Reproduction) {
        let column = frame(&(V6::from(TO) - V6::from(FROM))).column(0).into_owned();
        let (lo, hi) = printed_bounds(&column, &limits()[0]);
        r.information(
            PLACE_5,
            "section 4.2 as printed, velocity along the error, rad/s",
            "",
            format!(
                "{lo:.2} \
         to {hi:.2}"
            ),
        )
        .note(
            "no velocity towards the target is allowed, so nothing moves; the table prints no limits, \
             those of Table 7 are taken",
        );
        let shown = |o: &ProjectionOutcome| o.arrival.map_or("no arrival".to_owned(), |t| format!("{t:.3}"));
        let [v, a, j] = self.corrected.used;
        r.information(PLACE_5, "section 4.2 as corrected, arrival, s", "", shown(&self.corrected))
            .note(format!("uses {v:.3} of the velocity, {a:.3} of the acceleration, {j:.3} of the jerk limits"));
        let beyond = self.random.iter().filter(|o| o.used[1] > 1.0 + 1e-6).count();
        let mut peaks: Vec<f64> = self.random.iter().map(|o| o.used[1]).collect();
        peaks.sort_by(f64::total_cmp);
        let arrived = self.random.iter().filter(|o| o.arrival.is_some()).count();
        r.information(
            PLACE_5,
            "the same, moving random starts that exceed an acceleration limit",
            "",
            format!("{beyond} of {STARTS}"),
        )
        .note(format!(
            "{arrived} arrive within 10 s; largest share: median {:.2}, worst {:.2}",
            peaks[STARTS / 2],
            peaks[STARTS - 1]
        ));
    }

    /// Figure 9.
    pub fn figures(&self) -> Vec<PaperFigure> {
        let joints = &self.joints.motion;
        let end = joints.t.last().copied().unwrap_or(0.0);
        let t = &self.tool.t;
        let line = |name: &str, values: Vec<f64>| FigureLine::new(name, t.iter().copied().zip(values).collect());
        let panel = |label: &str, lines: Vec<FigureLine>| PanelPlot {
            across: "time t [s]".to_owned(),
            label: label.to_owned(),
            lines,
            ..PanelPlot::default()
        };
        let point = |k: usize, name: &str| line(name, self.points.iter().map(|p| p[k]).collect());
        let turn = |k: usize, name: &str| line(name, self.orientations.iter().map(|q| q[k]).collect());
        let axis = |k: usize| &self.tool.axes[k];
        let tool = vec![
            panel("position [m]", vec![point(0, "x"), point(1, "y"), point(2, "z")]),
            panel("quaternion", vec![turn(0, "qx"), turn(1, "qy"), turn(2, "qz"), turn(3, "qw")]),
            panel("speed [m/s], [rad/s]", vec![line("linear", axis(0).v.clone()), line("angular", axis(1).v.clone())]),
            panel("acceleration", vec![line("linear", axis(0).a.clone()), line("angular", axis(1).a.clone())]),
        ];
        let cycles = self.joints.cycle_times.iter().enumerate().map(|(i, t)| (i as f64, t * 1e6)).collect();
        let times = PanelPlot {
            across: "cycle".to_owned(),
            label: "time [µs]".to_owned(),
            lines: vec![FigureLine::new("joints", cycles)],
            ..PanelPlot::default()
        };
        let figure = |file: &str, title: &str, facts: String, caption: &str, panels: Vec<PanelPlot>| PaperFigure {
            file: file.to_owned(),
            title: title.to_owned(),
            facts,
            caption: caption.to_owned(),
            drawing: Drawing::Panels(panels),
        };
        vec![
            figure(
                "hs_figure_09a.svg",
                "Figure 9a: joint space, point to point",
                format!("Table 5, limits of Table 7 (the highest are drawn); {end:.4} s"),
                "The paper shows slight oscillations of its online mode. Ours moves on a straight line and does \
                 not oscillate.",
                self.joints.panels(),
            ),
            figure(
                "hs_figure_09b.svg",
                "Figure 9b: task space, point to point",
                "Table 5; limits 0.5 m/s and 1.5 rad/s, which the paper does not print".to_owned(),
                "The paper shows position and orientation of the tool. Its limits are not printed, so the \
                 duration differs.",
                tool,
            ),
            figure(
                "hs_figure_09c.svg",
                "Figure 9c: computing time of each cycle",
                "this computer; the paper stays under 1 ms".to_owned(),
                "The paper shows less than 1 ms for each cycle in MATLAB. Ours takes microseconds at most.",
                vec![times],
            ),
        ]
    }
}

impl Table7Run {
    /// Runs Table 7.
    ///
    /// # Errors
    /// None with the numbers of the table.
    pub fn measure() -> Result<Self, SyncError> {
        let start = JointState { q: V6::from(FROM), qd: V6::from(QD), qdd: V6::from(QDD), qddd: V6::zeros() };
        Ok(Self { joints: project(&start, &TARGETS)? })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        self.joints.judge(r, PLACE_7);
        let beyond = (QDD[1].abs() - ACCELERATION[1]) / (10.0 * ACCELERATION[1]);
        r.information(PLACE_7, "acceleration limit of joint 2 kept from, s", "", format!("{beyond:.3}")).note(
            "joint 2 starts beyond its limit: no motion keeps it sooner; the jerk is ten times the acceleration \
             (none printed)",
        );
    }

    /// Figure 13.
    pub fn figures(&self) -> Vec<PaperFigure> {
        let mut panels = self.joints.panels();
        for panel in &mut panels {
            panel.marks = TARGETS[1..].iter().map(|(t, _)| (*t, "new target".to_owned())).collect();
        }
        let end = self.joints.motion.t.last().copied().unwrap_or(0.0);
        vec![PaperFigure {
            file: "hs_figure_13.svg".to_owned(),
            title: "Figure 13: targets that change while the joints move".to_owned(),
            facts: format!("Table 7, the highest limits are drawn; {end:.4} s"),
            caption: "The paper shows position, velocity and acceleration, and says that its method cannot bring the \
                      acceleration to zero at the end. Ours ends at rest. Joint 2 starts beyond its acceleration limit."
                .to_owned(),
            drawing: Drawing::Panels(panels),
        }]
    }
}
