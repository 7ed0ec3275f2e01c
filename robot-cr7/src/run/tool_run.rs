//! A scenario of tool targets, simulated cycle by cycle.

use arcfeed_feedrate::AxisState;
use arcfeed_interp::{JointRates, LiveTool, PathArm, ToolTargetError};
use arcfeed_kinematics::{JointLimits, Joints};
use arcfeed_sync::{PoseLimits, ProjectionStatus, SyncError};
use nalgebra::Isometry3;

use super::online_events::Happening;
use super::online_run::{OnlineRun, ScenarioError};
use crate::input::tool_scenario::ToolScenario;

/// A simulated scenario of tool targets.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolRun<const N: usize> {
    /// The motion of the joints, under limits that do not change.
    pub joints: OnlineRun<N>,
    /// The limits of the tool, in the order of [`ToolScenario::limits`], each from its time (s) on.
    pub limits: Vec<(f64, [f64; 6])>,
    /// The target that is set in the end, tool in base.
    pub target: Isometry3<f64>,
    /// The least share of the limits of the tool that a target was given, so that the joints keep theirs.
    pub least_share: f64,
}

impl ToolScenario {
    /// Runs the scenario for an arm with the tool of the file and `limits` of its joints, one step a control period.
    ///
    /// # Errors
    /// [`ScenarioError`], naming the line where there is one.
    pub fn run<A: PathArm<N>, const N: usize>(
        &self,
        arm: &A,
        limits: &JointLimits<N>,
    ) -> Result<ToolRun<N>, ScenarioError> {
        let start = Joints::from(self.settings.check().of::<N>("start.q_deg", &self.start)?);
        let begin = Place::new("start", "start.q_deg");
        let tool = tool_limits(&self.limits).map_err(|e| self.refused(&begin, e.into()))?;
        let motion =
            LiveTool::new(arm, &start, limits, &tool, self.settings.period).map_err(|e| self.refused(&begin, e))?;
        let rates = JointRates::from(limits);
        let axes = std::array::from_fn(|k| AxisState::rest(start[k]));
        let samples = vec![(0.0, motion.joints(), rates)];
        let joints = OnlineRun { start: axes, target: axes, samples, events: Vec::new() };
        let target = self.target.after(motion.target());
        let run = ToolRun { joints, limits: vec![(0.0, self.limits)], target, least_share: 1.0 };
        Simulation { scenario: self, motion, rates, limits: self.limits, underway: true, run }.run()
    }

    fn refused(&self, place: &Place, source: ToolTargetError) -> ScenarioError {
        let line = self.settings.check().line_of(&place.key);
        ScenarioError::RefusedTool {
            file: self.settings.file.clone(),
            line,
            place: place.what.clone(),
            source: Box::new(source),
        }
    }
}

struct Simulation<'s, 'a, A, const N: usize> {
    scenario: &'s ToolScenario,
    motion: LiveTool<'a, A, N>,
    rates: JointRates<N>,
    /// Limits of the tool in force.
    limits: [f64; 6],
    underway: bool,
    run: ToolRun<N>,
}

impl<A: PathArm<N>, const N: usize> Simulation<'_, '_, A, N> {
    /// Sets a target and limits of the tool at `now` (s).
    fn set(
        &mut self,
        now: f64,
        words: &str,
        place: &Place,
        target: Isometry3<f64>,
        limits: [f64; 6],
    ) -> Result<(), ScenarioError> {
        tool_limits(&limits)
            .map_err(ToolTargetError::from)
            .and_then(|of_tool| self.motion.set(&target, &of_tool))
            .map_err(|e| self.scenario.refused(place, e))?;
        let share = self.motion.share();
        let slower = if share < 1.0 {
            format!(" at {:.1} % of the tool's speed, for the joints", 100.0 * share)
        } else {
            String::new()
        };
        let left = self.motion.time_left().map(|left| format!(", {left:.4} s to go")).unwrap_or_default();
        self.tell(now, format!("{words}{slower}{left}"));
        if limits != self.limits {
            self.run.limits.push((now, limits));
        }
        self.run.least_share = self.run.least_share.min(share);
        (self.run.target, self.limits, self.underway) = (target, limits, true);
        Ok(())
    }

    fn tell(&mut self, t_s: f64, what: String) {
        self.run.joints.events.push(Happening { t_s, what });
    }

    fn run(mut self) -> Result<ToolRun<N>, ScenarioError> {
        let scenario = self.scenario;
        let first = Place::new("target", "target");
        self.set(0.0, "off to the target", &first, self.run.target, self.limits)?;
        let mut changes = scenario.changes.iter().enumerate().peekable();
        for cycle in 0..=scenario.settings.most_cycles() {
            let now = cycle as f64 * scenario.settings.period;
            // A change takes effect with the first cycle that begins at its time or later.
            while let Some((i, change)) = changes.next_if(|(_, c)| c.at <= now + 1e-9 * scenario.settings.period) {
                let place = Place::new(format!("change at {} s", change.at), format!("change[{i}].at_s"));
                let limits = std::array::from_fn(|k| change.limits[k].unwrap_or(self.limits[k]));
                let target = change.pose.after(&self.run.target);
                self.set(now, &change.words(), &place, target, limits)?;
            }
            let step = self.motion.step().map_err(|e| scenario.refused(&first, e))?;
            let t = (cycle + 1) as f64 * scenario.settings.period;
            self.run.joints.samples.push((t, step.joints, self.rates));
            if let ProjectionStatus::Reached { .. } = step.status {
                if std::mem::replace(&mut self.underway, false) {
                    self.tell(t, "target reached".to_owned());
                }
                if changes.peek().is_none() {
                    return Ok(self.run);
                }
            }
        }
        Err(scenario.settings.overdue(self.motion.time_left().unwrap_or_default()))
    }
}

/// Which part of a scenario, in words and as its key.
struct Place {
    what: String,
    key: String,
}

impl Place {
    fn new(what: impl Into<String>, key: impl Into<String>) -> Self {
        Self { what: what.into(), key: key.into() }
    }
}

fn tool_limits(limits: &[f64; 6]) -> Result<PoseLimits, SyncError> {
    let [v, a, j, angular_v, angular_a, angular_j] = *limits;
    PoseLimits::new([v, a, j], [angular_v, angular_a, angular_j])
}
