//! An online scenario, simulated cycle by cycle.

use std::path::PathBuf;

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_interp::{JointRates, ToolTargetError};
use arcfeed_kinematics::JointLimits;
use arcfeed_sync::{JointState, OnlineGenerator, SyncError, Synchronisation};
use thiserror::Error;

use super::online_events::{Happening, Teller, in_degrees};
use super::samples::MOST_CYCLES;
use crate::input::error::InputError;
use crate::input::joint_values::JointValues;
use crate::input::online_scenario::{Change, KEYS, OnlineScenario};
use crate::input::online_settings::OnlineSettings;

/// Why a scenario did not run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// Something is wrong with the file.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A start, target or limit that cannot be followed.
    #[error("{}{}: {place}: {source}", file.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    Refused {
        /// The file.
        file: PathBuf,
        /// Line of the key, if it is known.
        line: Option<usize>,
        /// Which part of the scenario.
        place: String,
        /// The error of the generator.
        source: Box<SyncError>,
    },
    /// A start, target or limit of the tool that cannot be followed.
    #[error("{}{}: {place}: {source}", file.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    RefusedTool {
        /// The file.
        file: PathBuf,
        /// Line of the key, if it is known.
        line: Option<usize>,
        /// Which part of the scenario.
        place: String,
        /// The reason.
        source: Box<ToolTargetError>,
    },
    /// The motion is still under way at the end of what is simulated.
    #[error("{}: after run.longest_s = {longest} s the target is not reached, {left:.3} s are missing: raise run.longest_s", file.display())]
    TooLong {
        /// The file.
        file: PathBuf,
        /// Longest motion, s.
        longest: f64,
        /// The time that is missing, s.
        left: f64,
    },
    /// The motion has more control cycles than are simulated.
    #[error("{}: after {MOST_CYCLES} cycles of sampling.period_ms = {period_ms} the target is not reached, {left:.3} s are missing: raise sampling.period_ms, or the limits of the joints", file.display())]
    TooManyCycles {
        /// The file.
        file: PathBuf,
        /// Control period, ms.
        period_ms: f64,
        /// The time that is missing, s.
        left: f64,
    },
}

impl OnlineSettings {
    /// Number of control cycles that are simulated.
    pub(super) fn most_cycles(&self) -> usize {
        (self.longest / self.period).ceil().min(MOST_CYCLES as f64) as usize
    }

    /// The error of a motion that misses its target by the time `left`, s.
    pub(super) fn overdue(&self, left: f64) -> ScenarioError {
        let file = self.file.clone();
        if self.longest > MOST_CYCLES as f64 * self.period {
            ScenarioError::TooManyCycles { file, period_ms: self.period * 1e3, left }
        } else {
            ScenarioError::TooLong { file, longest: self.longest, left }
        }
    }
}

impl OnlineScenario {
    fn of<const N: usize>(&self, key: &str, values: &JointValues) -> Result<[f64; N], InputError> {
        self.settings.check().of(key, values)
    }

    fn states<const N: usize>(&self, section: &str, v: &[JointValues; 3]) -> Result<[AxisState; N], InputError> {
        let [q, qd, qdd] = [(0, "q_deg"), (1, "qd_deg_s"), (2, "qdd_deg_s2")]
            .map(|(i, key)| self.of::<N>(&format!("{section}.{key}"), &v[i]));
        let (q, qd, qdd) = (q?, qd?, qdd?);
        Ok(std::array::from_fn(|k| AxisState::new(q[k], qd[k], qdd[k])))
    }

    /// Runs the scenario for an arm with `limits`, one step of the generator a control period.
    ///
    /// # Errors
    /// [`ScenarioError`], naming the line where there is one.
    pub fn run<const N: usize>(&self, limits: &JointLimits<N>) -> Result<OnlineRun<N>, ScenarioError> {
        let refused = |place: &str, key: &str, source| {
            let (source, unit) = in_degrees(source);
            let line = self.settings.check().line_of(key);
            ScenarioError::Refused {
                file: self.settings.file.clone(),
                line,
                place: format!("{place}{unit}"),
                source: Box::new(source),
            }
        };
        let mut rates = JointRates::from(limits);
        let mut target = self.states::<N>("target", &self.target)?;
        let start = self.states::<N>("start", &self.start)?;
        let axes = axis_limits(&rates).map_err(|e| refused("joints", "joints", e))?;
        let ranges = std::array::from_fn(|k| (limits.lower()[k], limits.upper()[k]));
        let mut generator = OnlineGenerator::new(start, axes, self.settings.period, self.synchronisation)
            .and_then(|generator| generator.with_ranges(ranges))
            .map_err(|e| refused("start", "start", e))?;
        generator.set_target(target).map_err(|e| refused("target", "target", e))?;
        let mut run = OnlineRun {
            start,
            target,
            samples: vec![(0.0, state_of(generator.state()), rates)],
            events: vec![Happening { t_s: 0.0, what: format!("off to the target, {:.4} s", generator.time_left()) }],
        };
        let mut changes = self.changes.iter().enumerate().peekable();
        let mut teller = Teller::new(self.synchronisation == Synchronisation::None);
        let most = self.settings.most_cycles();
        for cycle in 0.. {
            let now = cycle as f64 * self.settings.period;
            // A change takes effect with the first cycle that begins at its time or later.
            while let Some((i, change)) = changes.next_if(|(_, c)| c.at <= now + 1e-9 * self.settings.period) {
                self.apply(i, change, &mut target, &mut rates)?;
                let axes = axis_limits(&rates).map_err(|e| refused("limits", &format!("change[{i}]"), e))?;
                generator
                    .set(target, axes)
                    .map_err(|e| refused(&format!("change at {} s", change.at), &format!("change[{i}].at_s"), e))?;
                run.events.push(Happening {
                    t_s: now,
                    what: format!("{}; {:.4} s to go", change.words(), generator.time_left()),
                });
                // From here on these limits are in force.
                if let Some(last) = run.samples.last_mut() {
                    last.2 = rates;
                }
            }
            if cycle >= most {
                return Err(self.settings.overdue(generator.time_left()));
            }
            let step = generator.step();
            let t = (cycle + 1) as f64 * self.settings.period;
            run.samples.push((t, step.state, rates));
            teller.tell(&step.events, (now, t), &mut run.events);
            if !generator.is_underway() && changes.peek().is_none() {
                run.target = target;
                return Ok(run);
            }
        }
        Ok(run)
    }

    fn apply<const N: usize>(
        &self,
        i: usize,
        change: &Change,
        target: &mut [AxisState; N],
        rates: &mut JointRates<N>,
    ) -> Result<(), InputError> {
        let joints = match change.joint {
            None => 0..N,
            Some(joint) if joint < N => joint..joint + 1,
            Some(joint) => {
                let rule = "the arm has no such joint";
                let check = self.settings.check();
                return Err(check.wrong(&format!("change[{i}].joint"), joint + 1, rule, "joints count from 1"));
            }
        };
        for (k, values) in change.values.iter().enumerate() {
            let Some(values) = values else { continue };
            let values = self.of::<N>(&format!("change[{i}].{}", KEYS[k]), values)?;
            for j in joints.clone() {
                let slot = match k {
                    0 => &mut target[j].p,
                    1 => &mut target[j].v,
                    2 => &mut target[j].a,
                    3 => &mut rates.velocity[j],
                    4 => &mut rates.acceleration[j],
                    _ => &mut rates.jerk[j],
                };
                *slot = values[j];
            }
        }
        Ok(())
    }
}

/// A simulated scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct OnlineRun<const N: usize> {
    /// The state it starts in.
    pub start: [AxisState; N],
    /// The target that is set in the end.
    pub target: [AxisState; N],
    /// Time, state, and the limits in force from this sample to the next.
    pub samples: Vec<(f64, JointState<N>, JointRates<N>)>,
    /// The events.
    pub events: Vec<Happening>,
}

fn axis_limits<const N: usize>(rates: &JointRates<N>) -> Result<[AxisLimits; N], SyncError> {
    let mut axes = [None; N];
    for (axis, slot) in axes.iter_mut().enumerate() {
        let limits = AxisLimits::symmetric(rates.velocity[axis], rates.acceleration[axis], rates.jerk[axis]);
        *slot = Some(limits.map_err(|source| SyncError::State { axis, source })?);
    }
    // Every slot is filled by now.
    axes.into_iter().flatten().collect::<Vec<_>>().try_into().map_err(|_| SyncError::NoSuchAxis { axis: 0, count: N })
}

fn state_of<const N: usize>(state: &[AxisState; N]) -> JointState<N> {
    let column = |of: fn(&AxisState) -> f64| arcfeed_sync::nalgebra::SVector::from_fn(|k, _| of(&state[k]));
    JointState { q: column(|s| s.p), qd: column(|s| s.v), qdd: column(|s| s.a), qddd: column(|_| 0.0) }
}
