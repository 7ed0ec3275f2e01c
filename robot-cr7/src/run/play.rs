//! A scenario cycle by cycle, in simulated or in real time.

use std::time::{Duration, Instant};

use arcfeed_feedrate::LiveSection;
use arcfeed_interp::{Command, DriveLag, HybridState, LimitError, Setpoint};
use arcfeed_kinematics::Joints;
use serde::Serialize;

use super::error::Cr7Error;
use super::live_run::{LiveCycle, LiveRun};
use super::plan_error::plan_error;
use super::stage::Stage;

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
        let period = self.live().period();
        let mut run = LiveRun::new(self)?;
        let start = *run.setpoint();
        let mut drive =
            DriveLag::new(start.q, self.drive, period).map_err(|e: LimitError| plan_error(&self.name, e.into()))?;
        let mut asked = Asked { feed: self.scenario.feed, factor: 1.0, sections: Vec::new() };
        let foreseen = ((1.5 * self.live().curve().duration() / period) as usize + 10_000).min(self.most_cycles());
        let mut cycles: Vec<Cycle> = Vec::with_capacity(foreseen);
        let mut times: Vec<f64> = Vec::with_capacity(foreseen);
        let mut given: Vec<Given> = Vec::with_capacity(self.orders.len());
        let (mut late, mut latest) = (0, 0.0f64);
        let begin = Instant::now();
        while !run.is_over()? {
            let cycle = run.cycles();
            if clock == Clock::RealTime {
                let behind = wait_until(begin + Duration::from_secs_f64(cycle as f64 * period));
                late += usize::from(behind > period);
                latest = latest.max(behind);
            }
            let before = Instant::now();
            let LiveCycle { step, event } = run.step(&Command::None);
            times.push(before.elapsed().as_secs_f64());
            if let Some(command) = event {
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
        }
        Ok(Played { start, cycles, given, times: statistics(times, late, latest) })
    }
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
