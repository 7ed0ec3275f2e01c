//! The setpoints of a schedule on their way into the trajectory file: checked, written, kept for pictures.

use arcfeed_feedrate::AxisState;
use arcfeed_interp::{PlanError, Schedule, ScheduleLimits, SchedulePath, ScheduleSampler, Setpoint};
use arcfeed_kinematics::{JointRange, Joints};

use crate::cr7::{Cr7Error, trajectory_row};
use crate::error::InputError;
use crate::joint_check::{JointCheck, Rates};
use crate::report::LimitLine;
use crate::schedule_figure::{ShareFigure, SharePanel};
use crate::series::Series;
use crate::trajectory_csv::TrajectoryRow;

/// The setpoints of one schedule.
pub(crate) struct ScheduleRows<'s, 'p, P, const N: usize> {
    schedule: &'s Schedule<'p, P, N>,
    sampler: ScheduleSampler<'s, 'p, P, N>,
    limits: ScheduleLimits<N>,
    samples: usize,
    check: JointCheck<N>,
    /// Quantities that are limited, in units of their limits.
    panels: Vec<(&'static str, Joints<N>)>,
    series: Series,
    ends: [Option<Setpoint<N>>; 2],
}

impl<'s, 'p, P: SchedulePath<N>, const N: usize> ScheduleRows<'s, 'p, P, N> {
    /// Of an arm with joints in `range`, at the control `period` (s), to be held against `limits`.
    pub fn new(
        schedule: &'s Schedule<'p, P, N>,
        limits: &ScheduleLimits<N>,
        range: &JointRange<N>,
        period: f64,
    ) -> Result<Self, PlanError> {
        let sampler = schedule.sampler(period)?;
        let kinds = [
            ("velocity", limits.velocity),
            ("acceleration", limits.acceleration),
            ("torque", limits.torque),
            ("jerk", limits.jerk),
        ];
        let panels: Vec<_> = kinds.into_iter().filter_map(|(label, limits)| Some((label, limits?))).collect();
        Ok(Self {
            schedule,
            limits: *limits,
            samples: sampler.samples(),
            check: JointCheck::new((*range.lower()).into(), (*range.upper()).into()),
            series: Series::new(1 + panels.len() * N, sampler.samples()),
            panels,
            sampler,
            ends: [None, None],
        })
    }

    /// Number of setpoints.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Checks every row and hands it to `write`.
    pub fn write(
        &mut self,
        mut write: impl FnMut(&TrajectoryRow<N>) -> Result<(), InputError>,
        failed: impl Fn(PlanError) -> Cr7Error,
    ) -> Result<(), Cr7Error> {
        let limits = &self.limits;
        let values = |limit: Option<Joints<N>>| limit.map_or([f64::INFINITY; N], Into::into);
        let rates = Rates {
            velocity: values(limits.velocity),
            acceleration: values(limits.acceleration),
            jerk: values(limits.jerk),
        };
        for setpoint in self.sampler.by_ref() {
            let at = setpoint.map_err(&failed)?;
            let row = trajectory_row(&at);
            let dt = self.ends[1].map_or(0.0, |before| at.t - before.t);
            self.check.see(&row, dt, &rates);
            write(&row)?;
            let torque = self.schedule.torque(&at).unwrap_or(Joints::zeros());
            let shares = self.panels.iter().flat_map(|(label, limit)| {
                let value = match *label {
                    "velocity" => &at.qd,
                    "acceleration" => &at.qdd,
                    "torque" => &torque,
                    _ => &at.jerk,
                };
                (0..N).map(move |j| value[j] / limit[j])
            });
            self.series.push(std::iter::once(at.t).chain(shares));
            self.ends = [self.ends[0].or(Some(at)), Some(at)];
        }
        self.series.cut();
        Ok(())
    }

    /// Holds the first and the last row against the joints asked for, at rest where `speeds` are 0.
    pub fn see_ends(&mut self, asked: [Option<Joints<N>>; 2], speeds: [f64; 2]) {
        for (i, end) in ["start", "end"].into_iter().enumerate() {
            let Some(at) = self.ends[i] else { continue };
            let state = |k: usize| AxisState::new(at.q[k], at.qd[k], at.qdd[k]);
            let wanted = |k: usize| {
                // Without a limit on jerk the acceleration steps at the ends.
                let jerk_limited = self.limits.jerk.is_some();
                let (v, a) = match (speeds[i] == 0.0, jerk_limited) {
                    (true, true) => (0.0, 0.0),
                    (true, false) => (0.0, at.qdd[k]),
                    (false, _) => (at.qd[k], at.qdd[k]),
                };
                AxisState::new(asked[i].map_or(at.q[k], |q| q[k]), v, a)
            };
            let (states, wanted) = (std::array::from_fn(state), std::array::from_fn(wanted));
            self.check.see_end(end, at.t, &states, &wanted);
        }
    }

    /// Every limit that was checked, and the joint curves.
    pub fn finish(self, name: &str, facts: &str) -> (Vec<LimitLine>, ShareFigure) {
        let series = &self.series;
        let line =
            |column: usize| series.column(0).iter().copied().zip(series.column(column).iter().copied()).collect();
        let panel = |(i, (label, _)): (usize, &(&str, Joints<N>))| SharePanel {
            label: (*label).to_owned(),
            joints: (0..N).map(|j| line(1 + i * N + j)).collect(),
        };
        let figure = ShareFigure {
            file: "joints.svg".to_owned(),
            title: format!("{name}: joints in units of their limits"),
            facts: facts.to_owned(),
            panels: self.panels.iter().enumerate().map(panel).collect(),
        };
        (self.check.into_lines(), figure)
    }
}
