//! A scenario cycle by cycle, in simulated or in real time.

use std::time::{Duration, Instant};

use arcfeed_feedrate::LiveSection;
use arcfeed_interp::{Command, DriveLag, HybridMotion, HybridState, HybridStep, LimitError, Setpoint};
use arcfeed_kinematics::Joints;
use serde::Serialize;

use super::error::Cr7Error;
use super::plan_error::{live_error, plan_error};
use super::samples::MOST_CYCLES;
use super::stage::{Order, Stage, What};
use crate::input::scenario::{Action, When};

/// The passing of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// As fast as the computer is.
    Simulated,
    /// Each cycle begins at its time.
    RealTime,
}

/// The result of one cycle.
#[derive(Debug, Clone, Copy)]
pub struct Cycle {
    /// The setpoint at its end.
    pub setpoint: Setpoint,
    /// The state of the motion.
    pub state: HybridState,
    /// True while the tool is on the path.
    pub on_path: bool,
    /// True while it was told to hold, and stands.
    pub holding: bool,
    /// The joints of the simulated arm at its end, rad.
    pub joints: Joints<6>,
    /// Their velocities, rad/s; 0 for a drive without lag.
    pub velocity: Joints<6>,
    /// By how much they are behind their setpoints, rad.
    pub following_error: Joints<6>,
    /// Feed asked for here, sections and override included, m/s.
    pub asked: f64,
    /// Programmed feed, m/s.
    pub programmed: f64,
    /// Override.
    pub factor: f64,
}

/// An event that was given to the motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Given {
    /// Number of the cycle that took it.
    pub cycle: usize,
    pub refused: Option<String>,
}

/// Times of the cycles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepTimes {
    /// Median time of one step of the motion, s.
    pub median_s: f64,
    /// 99 of 100 steps are done within it, s.
    pub p99_s: f64,
    /// The longest, s.
    pub worst_s: f64,
    /// Cycles that began more than a period late, in real time.
    pub late: usize,
    /// Most that a cycle began late, s; 0 in simulated time.
    pub latest_s: f64,
}

/// A scenario that was played to its end.
#[derive(Debug, Clone)]
pub struct Played {
    pub(crate) start: Setpoint,
    pub(crate) cycles: Vec<Cycle>,
    pub(crate) given: Vec<Given>,
    pub(crate) times: StepTimes,
}

impl Played {
    /// Setpoint before the first cycle.
    pub fn start(&self) -> &Setpoint {
        &self.start
    }

    /// Every cycle.
    pub fn cycles(&self) -> &[Cycle] {
        &self.cycles
    }

    /// Times of the cycles.
    pub fn times(&self) -> &StepTimes {
        &self.times
    }
}

/// Programmed feed, override and sections, to be shown beside what came of them.
struct Asked {
    feed: f64,
    factor: f64,
    sections: Vec<LiveSection>,
}

impl Asked {
    fn take(&mut self, command: &Command) {
        match *command {
            Command::Feed(feed) => self.feed = feed,
            Command::Override(factor) => self.factor = factor,
            Command::Section(section) => self.sections.push(section),
            Command::ClearSections => self.sections.clear(),
            _ => {}
        }
    }

    fn programmed(&self, s: f64) -> f64 {
        let here = self.sections.iter().filter(|section| (section.from..section.to).contains(&s));
        here.map(|section| section.feed).reduce(f64::min).unwrap_or(self.feed)
    }
}

impl Stage<'_> {
    /// Plays the scenario to its end.
    ///
    /// # Errors
    /// [`Cr7Error::Input`] naming the line for an event after the end of the motion, or a motion longer than `run.longest_s`.
    pub fn play(&self, clock: Clock) -> Result<Played, Cr7Error> {
        let (scenario, period) = (self.scenario, self.live().period());
        let mut motion = HybridMotion::along(&self.route, scenario.feed).map_err(|e| live_error(&self.name, e))?;
        let start = *motion.setpoint();
        let mut drive =
            DriveLag::new(start.q, self.drive, period).map_err(|e: LimitError| plan_error(&self.name, e.into()))?;
        let mut asked = Asked { feed: scenario.feed, factor: 1.0, sections: Vec::new() };
        let longest = (scenario.longest / period).ceil();
        let most = longest.min(MOST_CYCLES as f64) as usize;
        let foreseen = ((1.5 * self.live().curve().duration() / period) as usize + 10_000).min(most);
        let mut cycles: Vec<Cycle> = Vec::with_capacity(foreseen);
        let mut times: Vec<f64> = Vec::with_capacity(foreseen);
        let mut given: Vec<Given> = Vec::with_capacity(self.orders.len());
        let (mut late, mut latest, mut stood) = (0, 0.0f64, 0usize);
        let begin = Instant::now();
        for cycle in 0..most {
            if clock == Clock::RealTime {
                let behind = wait_until(begin + Duration::from_secs_f64(cycle as f64 * period));
                late += usize::from(behind > period);
                latest = latest.max(behind);
            }
            let due = self.orders.get(given.len()).filter(|order| self.is_due(order, cycle, &motion, stood));
            let command = due.map_or(Command::None, |order| match &order.what {
                What::Command(command) => **command,
                What::StepBackBy(way) => Command::StepBack((motion.feed().position() - way).max(0.0)),
            });
            let before = Instant::now();
            let step = motion.step(&command);
            times.push(before.elapsed().as_secs_f64());
            if due.is_some() {
                let refused = step.refused.map(|e| e.to_string());
                if refused.is_none() {
                    asked.take(&command);
                }
                given.push(Given { cycle, refused });
            }
            let joints = drive.step(&step.setpoint.q);
            let programmed = asked.programmed(step.setpoint.s);
            cycles.push(Cycle {
                setpoint: step.setpoint,
                state: step.state,
                on_path: step.on_path,
                holding: step.holding,
                joints,
                velocity: drive.velocity(),
                following_error: drive.following_error(),
                asked: programmed * asked.factor,
                programmed,
                factor: asked.factor,
            });
            stood = if stands(&step, asked.factor) { stood + 1 } else { 0 };
            if matches!(step.state, HybridState::Done | HybridState::Stopped) {
                self.all_given(given.len(), step.setpoint.t)?;
                let times = statistics(times, late, latest);
                return Ok(Played { start, cycles, given, times });
            }
        }
        let state = motion.state().name();
        if longest > MOST_CYCLES as f64 {
            let value = format!("{} ms, and after {MOST_CYCLES} cycles the state is \"{state}\"", period * 1e3);
            let rule = "a scenario has no more cycles than that";
            let remedy = "raise it, or the feeds, or let the scenario end earlier";
            return Err(scenario.check().wrong("sampling.period_ms", value, rule, remedy).into());
        }
        let value = format!("{} s, and the motion is still in the state \"{state}\"", scenario.longest);
        let rule = "a scenario ends within it";
        let remedy = "raise it, or look in the events for what keeps the arm from the end of its path";
        Err(scenario.check().wrong("run.longest_s", value, rule, remedy).into())
    }

    fn is_due(&self, order: &Order, cycle: usize, motion: &HybridMotion<'_>, stood: usize) -> bool {
        let period = self.live().period();
        let now = cycle as f64 * period;
        match order.when {
            When::Time(t) => t <= now + 1e-9 * period,
            When::Cycle(at) => at <= cycle as u64,
            When::Length(s) => motion.state() == HybridState::TaskPath && motion.feed().position() >= s,
            When::Stood(t) => stood > 0 && t <= stood as f64 * period + 1e-9 * period,
        }
    }

    /// Nothing is ordered after the end.
    fn all_given(&self, given: usize, end: f64) -> Result<(), Cr7Error> {
        let Some(event) = self.scenario.events.get(given) else { return Ok(()) };
        let (name, value) = match event.when {
            When::Time(t) => ("at_s", t.to_string()),
            When::Cycle(cycle) => ("at_cycle", cycle.to_string()),
            When::Length(s) => ("at_mm", (s * 1e3).to_string()),
            When::Stood(t) => ("wait_s", t.to_string()),
        };
        let value = format!("{value}, but the motion ended at {end:.3} s");
        let rule = "nothing can be ordered after the end";
        let remedy = match event.action {
            Action::Leave(..) => "let it come earlier: an event has to find the arm on its path",
            _ => "let it come earlier, or remove it",
        };
        Err(self.scenario.check().wrong(&format!("event[{given}].{name}"), value, rule, remedy).into())
    }
}

/// True if the arm stands and waits for an order.
fn stands(step: &HybridStep, factor: f64) -> bool {
    let waits = step.holding || step.state == HybridState::Waiting || factor == 0.0 && step.on_path;
    waits && step.setpoint.qd.amax() == 0.0 && step.setpoint.qdd.amax() == 0.0
}

/// Sleeps until `time`; by how much it is past (s).
fn wait_until(time: Instant) -> f64 {
    // The last part without sleep: timers of the operating system are coarse.
    const AWAKE: Duration = Duration::from_micros(200);
    loop {
        let left = time.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Instant::now().saturating_duration_since(time).as_secs_f64();
        }
        if left > AWAKE {
            std::thread::sleep(left - AWAKE);
        } else {
            std::hint::spin_loop();
        }
    }
}

fn statistics(mut times: Vec<f64>, late: usize, latest_s: f64) -> StepTimes {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    StepTimes { median_s: at(0.5), p99_s: at(0.99), worst_s: at(1.0), late, latest_s }
}
