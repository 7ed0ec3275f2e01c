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
    /// The place that the events have told the tool to step back to, m.
    back: Option<f64>,
    operator: Operator,
}

/// What somebody has ordered besides the events.
struct Operator {
    /// A hold that has not ended.
    hold: Option<Hold>,
    /// The override on top of that of the events.
    share: f64,
    /// An override that is not in force yet.
    wanted: Option<f64>,
    /// True once anything was ordered.
    has_ordered: bool,
    /// True once a stop was ordered and followed.
    has_stopped: bool,
}

/// A hold of the operator.
#[derive(Clone, Copy)]
struct Hold {
    /// True if the events held the motion before: they alone end that.
    over_events: bool,
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
        let operator = Operator { hold: None, share: 1.0, wanted: None, has_ordered: false, has_stopped: false };
        Ok(Self { stage, motion, cycles: 0, clock: 0, given: 0, stood: 0, factor: 1.0, back: None, operator })
    }

    /// The setpoint of the last cycle; before the first one, the start.
    pub fn setpoint(&self) -> &Setpoint {
        self.motion.setpoint()
    }

    /// The number of cycles so far.
    pub fn cycles(&self) -> usize {
        self.cycles
    }

    /// True once the motion was stopped by an order besides the events.
    #[cfg(feature = "controller")]
    pub fn is_stopped_by_order(&self) -> bool {
        self.operator.has_stopped
    }

    /// The next cycle, in which `order` is followed. An override gives way to an event that is due in the same cycle, and comes after it;
    /// any other order is followed first.
    pub fn step(&mut self, order: &Command) -> LiveCycle {
        let ordered = self.ordered(order);
        let event = if ordered.is_none() && !self.is_paused() { self.event() } else { None };
        let wanted = if ordered.is_none() && event.is_none() { self.operator.wanted.take() } else { None };
        let factor = if let Some(Command::Override(factor)) = event { factor } else { self.factor };
        let share = wanted.unwrap_or(self.operator.share);
        let command = match (event, wanted) {
            (Some(Command::Override(_)), _) | (None, Some(_)) => Command::Override(factor * share),
            (event, _) => ordered.or(event).unwrap_or(Command::None),
        };
        let before = self.motion.is_held();
        let step = self.motion.step(&command);
        self.cycles += 1;
        self.given += usize::from(event.is_some());
        // What was refused changes nothing, here neither.
        if step.refused.is_none() {
            match command {
                Command::Override(_) => (self.factor, self.operator.share) = (factor, share),
                _ if ordered.is_some() => self.followed(order, before),
                _ => self.back = back_after(&command, self.back),
            }
        }
        let counts = !self.is_paused();
        self.clock += usize::from(counts);
        if counts {
            self.stood = if stands(&step, self.factor) { self.stood + 1 } else { 0 };
        }
        LiveCycle { step, event }
    }

    /// What an order besides the events, other than an override, means for the motion. It does not end a hold of the events.
    fn ordered(&mut self, order: &Command) -> Option<Command> {
        self.operator.has_ordered |= !matches!(order, Command::None);
        match *order {
            Command::None => None,
            Command::Override(share) => {
                self.operator.wanted = Some(share);
                None
            }
            Command::Resume => match (self.operator.hold?.over_events, self.back) {
                (false, _) => Some(Command::Resume),
                // The hold took the way back from it.
                (true, Some(place)) if place < self.motion.feed().position() => Some(Command::StepBack(place)),
                (true, _) => {
                    self.operator.hold = None;
                    None
                }
            },
            other => Some(other),
        }
    }

    /// An order besides the events was followed; the motion was held `before` or not.
    fn followed(&mut self, order: &Command, before: bool) {
        match order {
            Command::Hold => {
                self.operator.hold.get_or_insert(Hold { over_events: before });
            }
            Command::Resume => self.operator.hold = None,
            other => {
                self.operator.has_stopped |= matches!(other, Command::Stop);
                self.back = back_after(other, self.back);
            }
        }
    }

    /// True while somebody keeps the motion from going on.
    fn is_paused(&self) -> bool {
        self.operator.hold.is_some() || self.operator.share == 0.0
    }

    /// The event that is due.
    fn event(&self) -> Option<Command> {
        let order = self.stage.orders.get(self.given).filter(|order| self.is_due(order))?;
        Some(match &order.what {
            What::Command(command) => **command,
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

/// The place to step back to after a command was followed.
fn back_after(command: &Command, back: Option<f64>) -> Option<f64> {
    match command {
        Command::StepBack(place) => Some(*place),
        Command::Hold | Command::Resume | Command::Leave(_) | Command::Return | Command::Stop => None,
        _ => back,
    }
}

/// True if the arm stands and waits for an order.
fn stands(step: &HybridStep, factor: f64) -> bool {
    let waits = step.holding || step.state == HybridState::Waiting || factor == 0.0 && step.on_path;
    waits && step.setpoint.qd.amax() == 0.0 && step.setpoint.qdd.amax() == 0.0
}
