//! A scenario that runs: its events are given when they are due, one cycle after the other.

use arcfeed_interp::{Command, HybridMotion, HybridState, HybridStep, Setpoint};

use super::error::Cr7Error;
use super::plan_error::live_error;
use super::samples::MOST_CYCLES;
use super::stage::{Order, Stage, What};
use crate::input::scenario::{Action, When};

/// A scenario on its way. Somebody may order more than its events: while that one holds it, its clock stands and no event is given.
pub(crate) struct LiveRun<'s> {
    stage: &'s Stage<'s>,
    motion: HybridMotion<'s>,
    cycles: usize,
    /// Cycles in which nobody held it.
    clock: usize,
    /// Events that were given.
    given: usize,
    /// Cycles for which the arm has stood and waited.
    stood: usize,
    /// The override of the events.
    factor: f64,
    /// True while an event holds the motion.
    is_held: bool,
    operator: Operator,
}

/// What somebody has ordered besides the events.
struct Operator {
    /// True while the motion is held.
    holds: bool,
    /// The override on top of that of the events.
    share: f64,
    /// True once anything was ordered.
    has_ordered: bool,
}

/// One cycle.
pub(crate) struct LiveCycle {
    pub step: HybridStep,
    /// The event that was given in it, followed unless the step says that it was refused.
    pub event: Option<Command>,
}

impl<'s> LiveRun<'s> {
    /// The scenario at its start.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`] for a feed that cannot be.
    pub fn new(stage: &'s Stage<'s>) -> Result<Self, Cr7Error> {
        let motion = HybridMotion::along(&stage.route, stage.scenario.feed);
        let motion = motion.map_err(|e| live_error(&stage.name, e))?;
        let operator = Operator { holds: false, share: 1.0, has_ordered: false };
        Ok(Self { stage, motion, cycles: 0, clock: 0, given: 0, stood: 0, factor: 1.0, is_held: false, operator })
    }

    /// The setpoint of the last cycle; before the first one, the start.
    pub fn setpoint(&self) -> &Setpoint {
        self.motion.setpoint()
    }

    /// The number of cycles so far.
    pub fn cycles(&self) -> usize {
        self.cycles
    }

    /// The next cycle, in which `order` is followed; where it is none, the event that is due.
    pub fn step(&mut self, order: &Command) -> LiveCycle {
        let order = self.ordered(order);
        let event = if order.is_none() && !self.is_paused() { self.event() } else { None };
        let step = self.motion.step(&order.or(event).unwrap_or(Command::None));
        self.cycles += 1;
        self.given += usize::from(event.is_some());
        if let (Some(event), None) = (&event, &step.refused) {
            self.is_held = match event {
                Command::Hold | Command::StepBack(_) => true,
                Command::Resume | Command::Leave(_) | Command::Return => false,
                _ => self.is_held,
            };
        }
        let counts = !self.is_paused();
        self.clock += usize::from(counts);
        self.stood = if counts && stands(&step, self.factor) { self.stood + 1 } else { 0 };
        LiveCycle { step, event }
    }

    /// What an order besides the events means for the motion; it does not end a hold of the events, and overrides go on top of theirs.
    fn ordered(&mut self, order: &Command) -> Option<Command> {
        self.operator.has_ordered |= !matches!(order, Command::None);
        match *order {
            Command::None => None,
            Command::Hold => {
                self.operator.holds = true;
                Some(Command::Hold)
            }
            Command::Resume => {
                let held = std::mem::take(&mut self.operator.holds);
                (held && !self.is_held).then_some(Command::Resume)
            }
            Command::Override(share) => {
                self.operator.share = share;
                Some(Command::Override(self.factor * share))
            }
            other => Some(other),
        }
    }

    /// True while somebody keeps the motion from going on.
    fn is_paused(&self) -> bool {
        self.operator.holds || self.operator.share == 0.0
    }

    /// The event that is due.
    fn event(&mut self) -> Option<Command> {
        let order = self.stage.orders.get(self.given).filter(|order| self.is_due(order))?;
        Some(match &order.what {
            What::Command(command) => match **command {
                Command::Override(factor) => {
                    self.factor = factor;
                    Command::Override(factor * self.operator.share)
                }
                command => command,
            },
            What::StepBackBy(way) => Command::StepBack((self.motion.feed().position() - way).max(0.0)),
        })
    }

    /// True at the end of the motion.
    ///
    /// # Errors
    /// [`Cr7Error::Input`] naming the line for an event after the end, or a motion longer than `run.longest_s`.
    pub fn is_over(&self) -> Result<bool, Cr7Error> {
        if matches!(self.motion.state(), HybridState::Done | HybridState::Stopped) {
            // Orders change when the motion is where.
            return if self.operator.has_ordered { Ok(true) } else { self.all_given().map(|()| true) };
        }
        if self.clock >= self.stage.most_cycles() { Err(self.too_long()) } else { Ok(false) }
    }

    fn is_due(&self, order: &Order) -> bool {
        let period = self.stage.live().period();
        let now = self.clock as f64 * period;
        match order.when {
            When::Time(t) => t <= now + 1e-9 * period,
            When::Cycle(at) => at <= self.clock as u64,
            When::Length(s) => self.motion.state() == HybridState::TaskPath && self.motion.feed().position() >= s,
            When::Stood(t) => self.stood > 0 && t <= self.stood as f64 * period + 1e-9 * period,
        }
    }

    /// Nothing is ordered after the end.
    fn all_given(&self) -> Result<(), Cr7Error> {
        let Some(event) = self.stage.scenario.events.get(self.given) else { return Ok(()) };
        let (name, value) = match event.when {
            When::Time(t) => ("at_s", t.to_string()),
            When::Cycle(cycle) => ("at_cycle", cycle.to_string()),
            When::Length(s) => ("at_mm", (s * 1e3).to_string()),
            When::Stood(t) => ("wait_s", t.to_string()),
        };
        let value = format!("{value}, but the motion ended at {:.3} s", self.setpoint().t);
        let rule = "nothing can be ordered after the end";
        let remedy = match event.action {
            Action::Leave(..) => "let it come earlier: an event has to find the arm on its path",
            _ => "let it come earlier, or remove it",
        };
        Err(self.stage.scenario.check().wrong(&format!("event[{}].{name}", self.given), value, rule, remedy).into())
    }

    fn too_long(&self) -> Cr7Error {
        let (scenario, period, state) = (self.stage.scenario, self.stage.live().period(), self.motion.state().name());
        if scenario.longest > MOST_CYCLES as f64 * period {
            let value = format!("{} ms, and after {MOST_CYCLES} cycles the state is \"{state}\"", period * 1e3);
            let rule = "a scenario has no more cycles than that";
            let remedy = "raise it, or the feeds, or let the scenario end earlier";
            return scenario.check().wrong("sampling.period_ms", value, rule, remedy).into();
        }
        let value = format!("{} s, and the motion is still in the state \"{state}\"", scenario.longest);
        let rule = "a scenario ends within it";
        let remedy = "raise it, or look in the events for what keeps the arm from the end of its path";
        scenario.check().wrong("run.longest_s", value, rule, remedy).into()
    }
}

/// True if the arm stands and waits for an order.
fn stands(step: &HybridStep, factor: f64) -> bool {
    let waits = step.holding || step.state == HybridState::Waiting || factor == 0.0 && step.on_path;
    waits && step.setpoint.qd.amax() == 0.0 && step.setpoint.qdd.amax() == 0.0
}
