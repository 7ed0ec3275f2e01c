//! Liu et al. 2024, Table 4 and Figure 7: six joints from state to state, each on its own and
//! together.

use arcfeed_feedrate::{AxisState, MotionLaw, StateToState};
use arcfeed_sync::{MotionOptions, SyncError, Synchronisation, Trajectory, symmetric_limits};

use super::conditions::V6;
use super::printed_cases::{CaseCounts, counts};
use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure};
use crate::reproduce::Reproduction;
use crate::reproduce::checker::{AxisBounds, SampledAxis, SampledMotion};

const PLACE: &str = "Table 4, figure 7: six joints from state to state (rad, s)";
/// Limits of all joints: velocity, acceleration, jerk (rad, s).
const LIMITS: (f64, f64, f64) = (10.0, 100.0, 1000.0);
/// Samples of each motion.
const SAMPLES: u32 = 4000;

/// Start and end (position, velocity, acceleration) of each joint, and the printed duration.
const TABLE_4: [([f64; 3], [f64; 3], &str); 6] = [
    ([0.0, 0.0, 0.0], [4.0, 0.0, 0.0], "0.6000"),
    ([-2.0, -4.0, 1.0], [-6.0, 6.0, 2.0], "0.6519"),
    ([3.0, 3.0, -2.0], [10.0, 7.0, -3.0], "0.7756"),
    ([-4.0, -2.0, 3.0], [2.0, -5.0, -1.0], "0.9145"),
    ([5.0, 0.0, 5.0], [0.0, -6.0, 4.0], "0.6290"),
    ([1.0, 3.0, -2.0], [-5.0, -8.0, 0.0], "0.7559"),
];

/// The motions of Table 4.
#[derive(Debug, Clone, PartialEq)]
pub struct Table4Run {
    /// Each joint on its own.
    pub alone: Vec<SampledMotion>,
    /// All joints in a common time.
    pub together: SampledMotion,
    /// The five cases of section 4.1 on random joints.
    pub cases: CaseCounts,
}

fn axis(joint: usize, states: Vec<[f64; 3]>) -> SampledAxis {
    let (start, end, _) = TABLE_4[joint];
    let of = |k: usize| states.iter().map(|x| x[k]).collect();
    let bounds = vec![(0.0, AxisBounds::symmetric(LIMITS.0, LIMITS.1, LIMITS.2))];
    SampledAxis { name: format!("joint {}", joint + 1), p: of(0), v: of(1), a: of(2), start, end, bounds }
}

fn times(duration: f64) -> Vec<f64> {
    (0..=SAMPLES).map(|i| duration * f64::from(i) / f64::from(SAMPLES)).collect()
}

impl Table4Run {
    /// Plans the motions and samples them.
    ///
    /// # Errors
    /// None with the numbers of the table.
    pub fn measure() -> Result<Self, SyncError> {
        let axes = symmetric_limits(V6::repeat(LIMITS.0), V6::repeat(LIMITS.1), V6::repeat(LIMITS.2))?;
        let state = |s: [f64; 3]| AxisState::new(s[0], s[1], s[2]);
        let (start, end) = (TABLE_4.map(|joint| state(joint.0)), TABLE_4.map(|joint| state(joint.1)));
        let mut alone = Vec::new();
        for k in 0..6 {
            let motion = StateToState::new(&start[k], &end[k], &axes[k])
                .map_err(|source| SyncError::State { axis: k, source })?;
            let t = times(motion.duration());
            let states = t.iter().map(|&t| motion.at(t)).map(|s| [s.p, s.v, s.a]).collect();
            alone.push(SampledMotion { t, axes: vec![axis(k, states)], arrived: None, tolerance: 0.0 });
        }
        let motion = Trajectory::new(&start, &end, &axes, &MotionOptions::new(Synchronisation::Time))?;
        let t = times(motion.duration());
        let at = |k: usize| t.iter().map(|&t| motion.at(t)).map(|s| [s.q[k], s.qd[k], s.qdd[k]]).collect();
        let joints = (0..6).map(|k| axis(k, at(k))).collect();
        let together = SampledMotion { axes: joints, arrived: None, tolerance: 0.0, t };
        Ok(Self { alone, together, cases: counts() })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        let duration = |motion: &SampledMotion| motion.t.last().copied().unwrap_or(f64::NAN);
        for (k, (motion, (_, _, printed))) in self.alone.iter().zip(TABLE_4).enumerate() {
            let name = format!("joint {} alone", k + 1);
            r.print(PLACE, format!("{name}: duration, s"), printed, duration(motion));
            motion.judge(r, PLACE, &name);
        }
        r.print(PLACE, "all joints together: duration, s", "0.9145", duration(&self.together))
            .note("the longest of the six durations, as the paper has it");
        self.together.judge(r, PLACE, "all joints together");
        let CaseCounts { joints, five_cases, one_search } = self.cases;
        let share = |n: usize| format!("{:.1} %", 100.0 * n as f64 / joints.max(1) as f64);
        r.information(PLACE, "section 4.1, random joints solved by its five cases", "", share(five_cases)).note(
            format!(
                "of {joints} joints that our planner solves; a search over all cruise velocities solves {}",
                share(one_search)
            ),
        );
    }

    /// Figures 7a and 7b with position, velocity and acceleration.
    pub fn figures(&self) -> Vec<PaperFigure> {
        let draw = |file: &str, title: &str, caption: &str, pick: &dyn Fn(usize) -> (Vec<f64>, SampledAxis)| {
            let quantity = |label: &str, of: fn(&SampledAxis) -> &Vec<f64>, limit: Option<f64>| {
                let line = |k: usize| {
                    let (t, axis) = pick(k);
                    FigureLine::new(format!("joint {}", k + 1), t.into_iter().zip(of(&axis).iter().copied()).collect())
                };
                let end = (0..6).map(|k| pick(k).0.last().copied().unwrap_or(0.0)).fold(0.0, f64::max);
                PanelPlot {
                    across: "time t [s]".to_owned(),
                    label: label.to_owned(),
                    lines: (0..6).map(line).collect(),
                    limits: limit.iter().flat_map(|&x| [x, -x]).map(|x| FigureLine::level((0.0, end), x)).collect(),
                    marks: Vec::new(),
                }
            };
            PaperFigure {
                file: file.to_owned(),
                title: title.to_owned(),
                facts: "Table 4; limits 10 rad/s, 100 rad/s², 1000 rad/s³".to_owned(),
                caption: caption.to_owned(),
                drawing: Drawing::Panels(vec![
                    quantity("position [rad]", |a| &a.p, None),
                    quantity("velocity [rad/s]", |a| &a.v, Some(LIMITS.0)),
                    quantity("acceleration [rad/s²]", |a| &a.a, Some(LIMITS.1)),
                ]),
            }
        };
        vec![
            draw(
                "hs_figure_07a.svg",
                "Figure 7a: each joint in its shortest time",
                "The paper shows position, velocity and acceleration of six joints with different durations. The \
                 durations are equal in every printed digit.",
                &|k| (self.alone[k].t.clone(), self.alone[k].axes[0].clone()),
            ),
            draw(
                "hs_figure_07b.svg",
                "Figure 7b: all joints arrive together",
                "The paper shows the six joints in the time of joint 4. The paper searches the cruise velocity; ours \
                 solves for it, so the curves between start and end may differ.",
                &|k| (self.together.t.clone(), self.together.axes[k].clone()),
            ),
        ]
    }
}
