//! The report of a run, on one screen and as JSON.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use arcfeed_interp::{Detour, HybridState, PathParameter, Quantity};
use arcfeed_kinematics::Joints;
use serde::Serialize;

use super::limit_table::{ending, limit_table, more};
use crate::input::scenario::{Action, Event, When};
use crate::run::limit_line::{LimitLine, worst};
use crate::run::limit_lines::limit_lines;
use crate::run::measure;
use crate::run::play::{Cycle, Given, Played, StepTimes};
use crate::run::stage::Stage;
use crate::run::trajectory_row::TrajectoryRow;
use crate::text::{WIDTH, clip, number};

/// The result of a run. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunReport {
    /// The scenario file.
    pub name: String,
    /// Name of the path.
    pub path: String,
    /// Length of the path, m.
    pub length_m: f64,
    /// Duration of the motion, s.
    pub duration_s: f64,
    /// Number of samples: the start, and one a control cycle.
    pub samples: usize,
    /// Control period, s.
    pub period_s: f64,
    /// Tangential acceleration that any order may use at any place, m/s^2.
    pub live_acceleration_m_s2: f64,
    /// Tangential jerk that any order may use at any place, m/s^3.
    pub live_jerk_m_s3: f64,
    /// True if the end of the path was reached; false after a stop.
    pub path_finished: bool,
    /// The states one after the other.
    pub states: Vec<StateSpan>,
    /// The events and what the motion said to them.
    pub events: Vec<EventLine>,
    /// The ways off the path and back.
    pub excursions: Vec<ExcursionLine>,
    /// Stretches near singular poses that were gone round.
    pub detours: Vec<DetourLine>,
    /// Accuracy on the path until it was left first, or all the way.
    pub accuracy_before: Option<Accuracy>,
    /// Accuracy on the path after it was resumed.
    pub accuracy_after: Option<Accuracy>,
    /// Every limit with its worst place.
    pub limits: Vec<LimitLine>,
    /// True if no limit was exceeded and the tool was on the path whenever the state says so.
    pub holds: bool,
    /// Time constants of the simulated drives, s.
    pub drive_time_constant_s: [f64; 6],
    /// Largest following error of each joint, rad.
    pub following_error_rad: [f64; 6],
    /// Times of the steps.
    pub step_times: StepTimes,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

/// A stretch of time in one state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateSpan {
    /// The state, in words; on the task path also "holding" and "stepping back".
    pub state: String,
    /// The time at which it begins, s.
    pub from_s: f64,
    /// The time at which it ends, s.
    pub to_s: f64,
}

/// An event that came.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventLine {
    /// The time, s.
    pub t_s: f64,
    /// Arc length there, m.
    pub s_m: f64,
    /// The order.
    pub what: String,
    /// By how much later it came than its own time, s: the events before it had to come first.
    pub late_s: f64,
    /// Why it was not followed, or not to the letter.
    pub refused: Option<String>,
}

/// One way off the path and back.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExcursionLine {
    /// The time of the event, s.
    pub event_s: f64,
    /// From the event until the arm is in joint space, s.
    pub time_to_leave_s: f64,
    /// From the event until it waits at the goal, s.
    pub time_to_goal_s: Option<f64>,
    /// From the order to return until the tool is on the path again, s.
    pub time_to_return_s: Option<f64>,
    /// The time at which it is on the path again, s.
    pub back_s: Option<f64>,
    /// The place where the path was left, m.
    pub left_at_m: f64,
    /// The place where it was resumed, m.
    pub resumed_at_m: Option<f64>,
}

/// A stretch of the path near a singular pose that was gone round.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DetourLine {
    /// The start, m.
    pub from_m: f64,
    /// The end, m.
    pub to_m: f64,
    /// The largest distance of the tool from it, m.
    pub deviation_m: f64,
    /// The duration of the way round, s.
    pub duration_s: f64,
    /// The fault there.
    pub why: String,
}

/// The distances of the tool from the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Accuracy {
    /// Largest distance of the setpoints from their place on the path, by forward kinematics, m.
    pub setpoints_m: f64,
    /// Largest distance of the simulated arm from the nearest point of the path, m.
    pub simulated_arm_m: f64,
}

impl RunReport {
    /// Measures a run.
    pub fn new(stage: &Stage<'_>, played: &Played) -> Self {
        let scenario = stage.scenario;
        let cycles = &played.cycles;
        let limits = limit_lines(&stage.verify(played), PathParameter::ArcLength);
        let excursions = excursions(stage, played);
        let holds = limits.iter().all(LimitLine::holds);
        let left = cycles.iter().position(|c| !c.on_path).unwrap_or(cycles.len());
        let back = cycles[left..].iter().position(|c| c.on_path).map_or(cycles.len(), |n| left + n);
        let accuracy = |cycles: &[Cycle]| {
            measure::accuracy(stage, cycles.iter())
                .map(|(setpoints_m, simulated_arm_m)| Accuracy { setpoints_m, simulated_arm_m })
        };
        let last = &cycles[cycles.len() - 1];
        let mut warnings = stage.warnings.clone();
        let events = events(stage, played);
        let refused = events.iter().filter(|e| e.refused.is_some()).count();
        if refused > 0 {
            warnings.push(format!("{refused} of {} events were not followed, or not to the letter", events.len()));
        }
        let following = |k: usize| cycles.iter().fold(0.0f64, |a, c| a.max(c.following_error[k].abs()));
        Self {
            name: scenario.file.display().to_string(),
            path: stage.name.clone(),
            length_m: stage.live().path().pose_path().length(),
            duration_s: last.setpoint.t,
            samples: cycles.len() + 1,
            period_s: stage.live().period(),
            live_acceleration_m_s2: stage.live().curve().acceleration(),
            live_jerk_m_s3: stage.live().curve().jerk(),
            path_finished: last.state == HybridState::Done,
            states: spans(played),
            events,
            excursions,
            detours: detours(stage),
            accuracy_before: accuracy(&cycles[..left]),
            accuracy_after: accuracy(&cycles[back..]),
            limits,
            holds,
            drive_time_constant_s: stage.drive.into(),
            following_error_rad: std::array::from_fn(following),
            step_times: played.times,
            warnings,
            files: Vec::new(),
        }
    }

    /// Largest part of a limit that is used; the distance from the path, which is rounding, is left out.
    pub fn worst_ratio(&self) -> f64 {
        worst(self.limits.iter().filter(|line| line.name != Quantity::PathDeviation.name()))
            .map_or(0.0, |line| line.ratio)
    }
}

impl Played {
    /// Rows of the trajectory file: the setpoints, the start included.
    pub fn rows(&self) -> impl Iterator<Item = TrajectoryRow> + '_ {
        std::iter::once(&self.start).chain(self.cycles.iter().map(|c| &c.setpoint)).map(TrajectoryRow::from)
    }
}

impl Stage<'_> {
    /// Rows of the simulated arm, behind its setpoints: positions and velocities of its joints, the pose of its tool; accelerations and
    /// jerks are left at 0.
    pub fn simulated_rows<'p>(&'p self, played: &'p Played) -> impl Iterator<Item = TrajectoryRow> + 'p {
        let none = Joints::zeros();
        let row = move |c: &Cycle| {
            TrajectoryRow::new(c.setpoint.t, [&c.joints, &c.velocity, &none, &none], &self.arm.forward(&c.joints))
        };
        played.cycles.iter().map(row)
    }
}

fn label(cycle: &Cycle) -> String {
    match cycle.state {
        HybridState::JointMove(point) => format!("joint move {}", point + 1),
        HybridState::TaskPath if cycle.holding => "holding".to_owned(),
        HybridState::TaskPath if cycle.setpoint.feed < 0.0 => "stepping back".to_owned(),
        other => other.name().to_owned(),
    }
}

fn spans(played: &Played) -> Vec<StateSpan> {
    let mut spans: Vec<StateSpan> = Vec::new();
    let mut before = 0.0;
    for cycle in &played.cycles {
        // The last cycle of a state brings the next one.
        let (state, t) = (label(cycle), cycle.setpoint.t);
        match spans.last_mut() {
            Some(span) if span.state == state => span.to_s = t,
            _ => spans.push(StateSpan { state, from_s: before, to_s: t }),
        }
        before = t;
    }
    spans
}

fn events(stage: &Stage<'_>, played: &Played) -> Vec<EventLine> {
    let period = stage.live().period();
    let line = |(event, given): (&Event, &Given)| {
        let t_s = given.cycle as f64 * period;
        let own = match event.when {
            When::Time(t) => t,
            When::Cycle(cycle) => cycle as f64 * period,
            When::Length(_) | When::Stood(_) => t_s,
        };
        let late = t_s - own;
        EventLine {
            t_s,
            s_m: played.cycles[given.cycle].setpoint.s,
            what: event.action.words(),
            late_s: if late > 1.001 * period { late } else { 0.0 },
            refused: given.refused.clone(),
        }
    };
    stage.scenario.events.iter().zip(&played.given).map(line).collect()
}

fn detours(stage: &Stage<'_>) -> Vec<DetourLine> {
    let line = |detour: &Detour| DetourLine {
        from_m: detour.interval.from,
        to_m: detour.interval.to,
        deviation_m: detour.deviation,
        duration_s: detour.duration,
        why: detour.interval.kind.to_string(),
    };
    stage.route.detours().iter().map(line).collect()
}

fn excursions(stage: &Stage<'_>, played: &Played) -> Vec<ExcursionLine> {
    let period = stage.live().period();
    let cycles = &played.cycles;
    // Cycle of the last event of a kind at or before another.
    let ordered = |upto: usize, wanted: fn(&Action) -> bool| {
        let events = stage.scenario.events.iter().zip(&played.given);
        events.filter(|(e, g)| g.cycle <= upto && wanted(&e.action)).map(|(_, g)| g.cycle).next_back()
    };
    let mut lines = Vec::new();
    let mut i = 0;
    while let Some(left) = cycles[i..].iter().position(|c| !c.on_path).map(|n| i + n) {
        let back = cycles[left..].iter().position(|c| c.on_path).map(|n| left + n);
        let end = back.unwrap_or(cycles.len());
        // Ways round have lines of their own.
        if cycles[left].state == HybridState::GoingRound {
            i = end;
            continue;
        }
        let event = ordered(left, |a| matches!(a, Action::Leave(..))).unwrap_or(left);
        let goal = cycles[left..end].iter().position(|c| c.state == HybridState::Waiting).map(|n| left + n);
        let order = ordered(end, |a| matches!(a, Action::Return)).filter(|&r| r >= left);
        let since = |a: usize, b: usize| (b + 1 - a) as f64 * period;
        lines.push(ExcursionLine {
            event_s: event as f64 * period,
            // The first cycle off the path begins in joint space.
            time_to_leave_s: (left - event) as f64 * period,
            time_to_goal_s: goal.map(|g| since(event, g)),
            time_to_return_s: order.zip(back).map(|(order, back)| (back - order) as f64 * period),
            back_s: back.map(|b| b as f64 * period),
            left_at_m: cycles[left].setpoint.s,
            resumed_at_m: back.map(|b| cycles[b - 1].setpoint.s),
        });
        i = end;
    }
    lines
}

const MOST_LINES: usize = 16;

impl Display for RunReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} of {} mm", clip(&self.name, 60), clip(&self.path, 20), number(self.length_m * 1e3))?;
        let end = if self.path_finished { "end of the path" } else { "stopped" };
        let (duration, period) = (number(self.duration_s), number(self.period_s * 1e3));
        writeln!(f, "  {:<16}{duration} s, {} cycles of {period} ms; {end}", "motion", self.samples - 1)?;
        let live = [self.live_acceleration_m_s2, self.live_jerk_m_s3].map(|v| number((v * 1e4).round() / 10.0));
        let [acceleration, jerk] = live;
        writeln!(
            f,
            "  {:<16}{acceleration} mm/s^2 and {jerk} mm/s^3 along the path: more would leave less speed in bends",
            "live bounds"
        )?;
        let times = &self.step_times;
        let us = |s: f64| number((s * 1e7).round() / 10.0);
        let (median, p99, worst) = (us(times.median_s), us(times.p99_s), us(times.worst_s));
        write!(f, "  {:<16}median {median} us, 99 % within {p99} us, worst {worst} us", "step")?;
        if times.latest_s > 0.0 {
            write!(f, "; {} cycles late, at most {} us", times.late, us(times.latest_s))?;
        }
        writeln!(f)?;
        let tau = self.drive_time_constant_s.iter().fold(0.0f64, |a, &b| a.max(b));
        let most = self.following_error_rad.iter().fold(0.0f64, |a, &b| a.max(b)).to_degrees();
        writeln!(f, "  {:<16}lag {} ms, following error at most {} deg", "drives", number(tau * 1e3), number(most))?;

        writeln!(f, "\n  {:>10}  {:>10}  {:<22}", "from [s]", "to [s]", "state")?;
        for span in self.states.iter().take(MOST_LINES) {
            writeln!(f, "  {:>10.4}  {:>10.4}  {}", span.from_s, span.to_s, span.state)?;
        }
        more(f, self.states.len(), MOST_LINES, "states")?;
        if !self.events.is_empty() {
            writeln!(f, "\n  {:>10}  {:>10}  {:<22}", "at [s]", "s [mm]", "event")?;
        }
        for event in self.events.iter().take(MOST_LINES) {
            let mut what = event.what.clone();
            if event.late_s > 0.0 {
                what += &format!(" ({} s late)", number(event.late_s));
            }
            if let Some(reason) = &event.refused {
                what += &format!(": {reason}");
            }
            writeln!(f, "  {:>10.4}  {:>10.3}  {}", event.t_s, event.s_m * 1e3, clip(&what, WIDTH - 26))?;
        }
        more(f, self.events.len(), MOST_LINES, "events")?;
        for way in &self.excursions {
            let seconds = |t: Option<f64>| t.map_or("never".to_owned(), |t| format!("{t:.4} s"));
            writeln!(
                f,
                "\n  left the path at {:.4} mm; {:.4} s to leave, {} to the goal, {} to return{}",
                way.left_at_m * 1e3,
                way.time_to_leave_s,
                seconds(way.time_to_goal_s),
                seconds(way.time_to_return_s),
                way.resumed_at_m.map(|s| format!("; resumed at {:.4} mm", s * 1e3)).unwrap_or_default()
            )?;
        }
        for way in &self.detours {
            let (from, to) = (number(way.from_m * 1e3), number(way.to_m * 1e3));
            let (off, time) = (number(way.deviation_m * 1e3), number(way.duration_s));
            writeln!(f, "\n  went round {from} to {to} mm, {off} mm off the path at most, in {time} s: {}", way.why)?;
        }
        writeln!(f, "\n  {:<24}{:>20}{:>20}", "distance from the path", "setpoints [mm]", "simulated arm [mm]")?;
        let first = if self.excursions.is_empty() { "all the way" } else { "before leaving it" };
        for (name, accuracy) in [(first, self.accuracy_before), ("after resuming it", self.accuracy_after)] {
            if let Some(a) = accuracy {
                writeln!(f, "  {name:<24}{:>20.2e}{:>20.5}", a.setpoints_m * 1e3, a.simulated_arm_m * 1e3)?;
            }
        }
        limit_table(f, &self.limits)?;
        ending(f, &self.warnings, &self.files, [usize::MAX; 2])
    }
}
