//! A scenario whose setpoints are planned while the arm moves.

use arcfeed_interp::{Command, HybridState};
use arcfeed_kinematics::{JointLimits, Joints};

use super::fault::Fault;
use super::setpoints::{NextSetpoint, SetpointSource};
use super::verified_motion::VerifiedMotion;
use crate::run::error::Cr7Error;
use crate::run::live_run::LiveRun;
use crate::run::stage::Stage;

/// Largest distance of the period of setpoints from a whole number of cycles, as a part of a cycle.
const WHOLE: f64 = 1e-6;

/// The setpoints of a scenario, which is planned cycle by cycle as they are asked for: events, excursions and the way back are not known
/// before they are due.
pub struct LiveSetpoints<'s> {
    /// The way to the start, and the number of its setpoints.
    way: Option<(&'s VerifiedMotion, usize)>,
    run: LiveRun<'s>,
    limits: JointLimits<6>,
    start: Joints<6>,
    /// Cycles of the motion from one setpoint to the next.
    cycles: usize,
    count: usize,
    over: bool,
    /// An order of the operator that came on the way to the start.
    waiting: Option<Command>,
    operator: Box<dyn FnMut(f64) -> Command + 's>,
}

impl<'s> LiveSetpoints<'s> {
    /// A scenario with a setpoint every `period` (s). It is played once in simulated time first: one that does not come to its end is not
    /// begun.
    ///
    /// # Errors
    /// [`Cr7Error::Input`] naming the line, for an event after the end of the motion, a motion longer than `run.longest_s`, or a period
    /// that is not a whole number of cycles.
    pub fn new(stage: &'s Stage<'s>, period: f64) -> Result<Self, Cr7Error> {
        let cycle = stage.live().period();
        let cycles = (period / cycle).round();
        if cycles < 1.0 || (period / cycle - cycles).abs() > WHOLE {
            let value = format!("{} ms, with a setpoint every {} ms", cycle * 1e3, period * 1e3);
            let rule = "setpoints are a whole number of cycles apart";
            let remedy = "divide the time between setpoints by a whole number";
            return Err(stage.scenario.check().wrong("sampling.period_ms", value, rule, remedy).into());
        }
        let mut rehearsal = LiveRun::new(stage)?;
        while !rehearsal.is_over()? {
            rehearsal.step(&Command::None);
        }
        let (cycles, run) = (cycles as usize, LiveRun::new(stage)?);
        Ok(Self {
            way: None,
            start: run.setpoint().q,
            run,
            limits: *stage.live().joints(),
            cycles,
            count: rehearsal.cycles().div_ceil(cycles) + 1,
            over: false,
            waiting: None,
            operator: Box::new(|_| Command::None),
        })
    }

    /// With a way to the start before it, which rests at both ends. An operator who orders a hold or a stop on it ends the session. A way
    /// that ends elsewhere is a step of the setpoints, which the session does not send.
    pub fn with_way(mut self, way: &'s VerifiedMotion, period: f64) -> Self {
        let count = way.count(period);
        (self.start, self.count) = (way.start(), self.count + count);
        self.way = Some((way, count));
        self
    }

    /// With somebody who is asked in every cycle what to do, with the time of the motion (s); [`Command::None`] is nothing. While that one
    /// holds the motion the scenario waits, with its clock and its events. A resume ends no hold of the scenario, and an override multiplies
    /// that of the scenario.
    pub fn with_operator(mut self, operator: impl FnMut(f64) -> Command + 's) -> Self {
        self.operator = Box::new(operator);
        self
    }

    /// What the operator orders on the way to the start: an override waits for the scenario.
    fn order_on_the_way(&mut self) -> Result<(), Fault> {
        match (self.operator)(0.0) {
            Command::Hold | Command::Stop => return Err(Fault::Interrupted),
            order @ Command::Override(_) => self.waiting = Some(order),
            _ => {}
        }
        Ok(())
    }

    /// The next cycle of the scenario.
    fn cycle(&mut self) -> Result<(), Fault> {
        let order = self.waiting.take().unwrap_or_else(|| (self.operator)(self.run.setpoint().t));
        let step = self.run.step(&order).step;
        // One who wants the arm to stand still is not disregarded.
        let halts = matches!(order, Command::Hold | Command::Stop);
        let is_ending = matches!(step.state, HybridState::Stopping | HybridState::Stopped | HybridState::Done);
        if let (true, false, Some(refused)) = (halts, is_ending, step.refused) {
            return Err(Fault::Scenario(refused.to_string()));
        }
        self.over = self.run.is_over().map_err(|error| Fault::Scenario(error.to_string()))?;
        Ok(())
    }
}

impl SetpointSource for LiveSetpoints<'_> {
    fn start(&self) -> Joints<6> {
        self.start
    }

    fn limits(&self) -> &JointLimits<6> {
        &self.limits
    }

    fn count(&self, _: f64) -> usize {
        self.count
    }

    fn setpoint(&mut self, index: usize, period: f64) -> Result<NextSetpoint<6>, Fault> {
        let mut index = index;
        if let Some((mut way, count)) = self.way {
            if index < count {
                self.order_on_the_way()?;
                let next = SetpointSource::setpoint(&mut way, index, period)?;
                return Ok(NextSetpoint { is_last: false, ..next });
            }
            index -= count;
        }
        let cycles = if index == 0 { 0 } else { self.cycles };
        for _ in 0..cycles {
            // At its end the motion rests.
            if self.over {
                break;
            }
            self.cycle()?;
        }
        Ok(NextSetpoint { q: self.run.setpoint().q, is_last: self.over })
    }
}
