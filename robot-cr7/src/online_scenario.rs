//! Scenarios of targets and limits that change while the arm moves, as TOML, and their simulation cycle by cycle.

use std::path::{Path, PathBuf};

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_kinematics::JointLimits;
use arcfeed_sync::{JointState, OnlineGenerator, SyncError, Synchronisation};
use serde::Deserialize;
use thiserror::Error;

use crate::error::{InputError, read_text};
use crate::job_file::{PerJoint, RawJoints, RawSampling};
use crate::joint_check::Rates;
use crate::joint_run::Happening;
use crate::joint_values::{JointOverrides, JointValues};
use crate::online_events::{Teller, in_degrees};
use crate::samples::MOST_CYCLES;
use crate::toml_check::{Check, read_toml};

const EXPECTED: &str = "a TOML scenario such as scenarios/online.toml";
/// Radians per degree.
const DEGREE: f64 = std::f64::consts::PI / 180.0;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScenario {
    #[serde(default)]
    sampling: RawSampling,
    #[serde(default)]
    run: RawRun,
    #[serde(default)]
    joints: RawJoints,
    start: RawState,
    target: RawState,
    #[serde(default)]
    change: Vec<RawChange>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawRun {
    mode: RawMode,
    longest_s: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawMode {
    #[default]
    Time,
    Line,
    None,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawState {
    q_deg: PerJoint,
    qd_deg_s: Option<PerJoint>,
    qdd_deg_s2: Option<PerJoint>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChange {
    at_s: f64,
    joint: Option<i64>,
    q_deg: Option<PerJoint>,
    qd_deg_s: Option<PerJoint>,
    qdd_deg_s2: Option<PerJoint>,
    velocity_deg_s: Option<PerJoint>,
    acceleration_deg_s2: Option<PerJoint>,
    jerk_deg_s3: Option<PerJoint>,
}

/// A checked scenario, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct OnlineScenario {
    file: PathBuf,
    text: String,
    /// Control period, s.
    pub period: f64,
    /// How the joints belong together.
    pub synchronisation: Synchronisation,
    /// Longest motion that is simulated, s.
    pub longest: f64,
    /// Limits that replace those of the arm's model.
    pub joints: JointOverrides,
    start: [JointValues; 3],
    target: [JointValues; 3],
    changes: Vec<Change>,
}

/// What changes at one time. The values are those of position, velocity, acceleration of the target, then of the limits
/// of velocity, acceleration and jerk.
#[derive(Debug, Clone, PartialEq)]
struct Change {
    at: f64,
    joint: Option<usize>,
    values: [Option<JointValues>; 6],
}

/// Keys of a change, in the order of `Change::values`.
const KEYS: [&str; 6] = ["q_deg", "qd_deg_s", "qdd_deg_s2", "velocity_deg_s", "acceleration_deg_s2", "jerk_deg_s3"];

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
        /// What the generator says.
        source: SyncError,
    },
    /// The motion is still under way at the end of what is simulated.
    #[error("{}: after run.longest_s = {longest} s the target is not reached, {left:.3} s are missing: raise run.longest_s", file.display())]
    TooLong {
        /// The file.
        file: PathBuf,
        /// Longest motion, s.
        longest: f64,
        /// What is missing, s.
        left: f64,
    },
    /// The motion has more control cycles than are simulated.
    #[error("{}: after {MOST_CYCLES} cycles of sampling.period_ms = {period_ms} the target is not reached, {left:.3} s are missing: raise sampling.period_ms, or the limits of the joints", file.display())]
    TooManyCycles {
        /// The file.
        file: PathBuf,
        /// Control period, ms.
        period_ms: f64,
        /// What is missing, s.
        left: f64,
    },
}

impl OnlineScenario {
    /// A scenario with every key and what it means.
    pub const EXAMPLE: &'static str = include_str!("../scenarios/online.toml");

    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// When the file cannot be read, is not TOML, has an unknown key, or a value breaks its rule.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        Self::parse(&read_text(file, EXPECTED)?, file)
    }

    /// Like [`OnlineScenario::read`], from text; `file` is the name used in messages.
    ///
    /// # Errors
    /// As [`OnlineScenario::read`].
    pub fn parse(text: &str, file: &Path) -> Result<Self, InputError> {
        let raw: RawScenario = read_toml(text, file, "scenarios/online.toml")?;
        let check = Check::new(text, file);
        let state = |section: &str, raw: &RawState| -> Result<[JointValues; 3], InputError> {
            let or_zero = |key, value: &Option<PerJoint>| {
                Ok(match value {
                    None => JointValues::All(0.0),
                    Some(value) => check.values(&format!("{section}.{key}"), value, DEGREE)?,
                })
            };
            Ok([
                check.places(&format!("{section}.q_deg"), &raw.q_deg, DEGREE)?,
                or_zero("qd_deg_s", &raw.qd_deg_s)?,
                or_zero("qdd_deg_s2", &raw.qdd_deg_s2)?,
            ])
        };
        let mut changes: Vec<Change> = Vec::with_capacity(raw.change.len());
        for (i, raw) in raw.change.iter().enumerate() {
            let change = Self::change(&check, i, raw)?;
            if let Some(before) = changes.last().filter(|before| before.at > change.at) {
                let value = format!("{} after {}", change.at, before.at);
                let rule = "changes stand in the order of their times";
                return Err(check.wrong(&format!("change[{i}].at_s"), value, rule, "sort them"));
            }
            changes.push(change);
        }
        Ok(Self {
            file: file.to_owned(),
            text: text.to_owned(),
            period: check.period(raw.sampling.period_ms)?.unwrap_or(1e-3),
            synchronisation: match raw.run.mode {
                RawMode::Time => Synchronisation::Time,
                RawMode::Line => Synchronisation::StraightLine,
                RawMode::None => Synchronisation::None,
            },
            longest: check.limit("run.longest_s", raw.run.longest_s, 1.0)?.unwrap_or(60.0),
            joints: JointOverrides {
                velocity: check.joints("joints.velocity_deg_s", raw.joints.velocity_deg_s.as_ref())?,
                acceleration: check.joints("joints.acceleration_deg_s2", raw.joints.acceleration_deg_s2.as_ref())?,
                jerk: check.joints("joints.jerk_deg_s3", raw.joints.jerk_deg_s3.as_ref())?,
            },
            start: state("start", &raw.start)?,
            target: state("target", &raw.target)?,
            changes,
        })
    }

    fn change(check: &Check<'_>, i: usize, raw: &RawChange) -> Result<Change, InputError> {
        let key = |name: &str| format!("change[{i}].{name}");
        if !(raw.at_s.is_finite() && raw.at_s >= 0.0) {
            let rule = "a change happens at a time from 0 s on";
            return Err(check.wrong(&key("at_s"), raw.at_s, rule, "count the time from the start of the motion"));
        }
        let joint = match raw.joint {
            None => None,
            Some(joint) => Some(usize::try_from(joint).ok().and_then(|j| j.checked_sub(1)).ok_or_else(|| {
                check.wrong(&key("joint"), joint, "joints count from 1", "remove the key to change all joints")
            })?),
        };
        let given = [
            &raw.q_deg,
            &raw.qd_deg_s,
            &raw.qdd_deg_s2,
            &raw.velocity_deg_s,
            &raw.acceleration_deg_s2,
            &raw.jerk_deg_s3,
        ];
        let mut values: [Option<JointValues>; 6] = Default::default();
        for (k, (slot, given)) in values.iter_mut().zip(given).enumerate() {
            let Some(given) = given else { continue };
            if let (Some(_), PerJoint::Each(list)) = (joint, given) {
                let rule = "with `joint` it is about that one";
                let value = format!("a list of {}", list.len());
                return Err(check.wrong(&key(KEYS[k]), value, rule, "write one number"));
            }
            *slot = match k {
                0 => Some(check.places(&key(KEYS[k]), given, DEGREE)?),
                1..=2 => Some(check.values(&key(KEYS[k]), given, DEGREE)?),
                _ => check.joints(&key(KEYS[k]), Some(given))?,
            };
        }
        if values.iter().all(Option::is_none) {
            let rule = "a change has to change something";
            return Err(check.wrong(
                &format!("change[{i}]"),
                "empty",
                rule,
                "add q_deg, velocity_deg_s or another key",
            ));
        }
        Ok(Change { at: raw.at_s, joint, values })
    }

    fn of<const N: usize>(&self, key: &str, values: &JointValues) -> Result<[f64; N], InputError> {
        values.of::<N>().map_err(|given| {
            let rule = "a list has one number for each joint of the arm";
            let value = format!("a list of {given} for {N} joints");
            Check::new(&self.text, &self.file).wrong(key, value, rule, "write one number for all, or one for each")
        })
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
            let line = Check::new(&self.text, &self.file).line_of(key);
            ScenarioError::Refused { file: self.file.clone(), line, place: format!("{place}{unit}"), source }
        };
        let mut rates = Rates::from(limits);
        let mut target = self.states::<N>("target", &self.target)?;
        let start = self.states::<N>("start", &self.start)?;
        let axes = axis_limits(&rates).map_err(|e| refused("joints", "joints", e))?;
        let ranges = std::array::from_fn(|k| (limits.lower()[k], limits.upper()[k]));
        let mut generator = OnlineGenerator::new(start, axes, self.period, self.synchronisation)
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
        let longest = (self.longest / self.period).ceil();
        let most = longest.min(MOST_CYCLES as f64) as usize;
        for cycle in 0.. {
            let now = cycle as f64 * self.period;
            // A change takes effect with the first cycle that begins at its time or later.
            while let Some((i, change)) = changes.next_if(|(_, c)| c.at <= now + 1e-9 * self.period) {
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
                let left = generator.time_left();
                if longest > MOST_CYCLES as f64 {
                    let (file, period_ms) = (self.file.clone(), self.period * 1e3);
                    return Err(ScenarioError::TooManyCycles { file, period_ms, left });
                }
                return Err(ScenarioError::TooLong { file: self.file.clone(), longest: self.longest, left });
            }
            let step = generator.step();
            let t = (cycle + 1) as f64 * self.period;
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
        rates: &mut Rates<N>,
    ) -> Result<(), InputError> {
        let joints = match change.joint {
            None => 0..N,
            Some(joint) if joint < N => joint..joint + 1,
            Some(joint) => {
                let rule = "the arm has no such joint";
                let check = Check::new(&self.text, &self.file);
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

impl Change {
    fn words(&self) -> String {
        let given: Vec<&str> =
            KEYS.into_iter().zip(&self.values).filter_map(|(key, value)| value.is_some().then_some(key)).collect();
        let whose = self.joint.map_or("all joints".to_owned(), |j| format!("joint {}", j + 1));
        format!("new {} of {whose}", given.join(", "))
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
    pub samples: Vec<(f64, JointState<N>, Rates<N>)>,
    /// What happened.
    pub events: Vec<Happening>,
}

fn axis_limits<const N: usize>(rates: &Rates<N>) -> Result<[AxisLimits; N], SyncError> {
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
