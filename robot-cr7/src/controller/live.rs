//! A scenario whose setpoints are planned while the arm moves.

use arcfeed_interp::{Command, HybridState};
use arcfeed_kinematics::{JointLimits, Joints};

use super::fault::Fault;
use super::guard::Guard;
use super::live_record::LiveRecord;
use super::setpoints::{NextSetpoint, SetpointSource};
use super::verified_motion::VerifiedMotion;
use crate::run::error::Cr7Error;
use crate::run::live_run::{LiveCycle, LiveRun};
use crate::run::online_events::Happening;
use crate::run::stage::Stage;

/// Largest distance of the period of setpoints from a whole number of cycles, as a part of a cycle.
const WHOLE: f64 = 1e-6;

/// The setpoints of a scenario, which is planned cycle by cycle as they are asked for: events, excursions and the way back are not known
/// before they are due.
pub struct LiveSetpoints<'s> {
    /// The way to the start, and the number of its setpoints.
    way: Option<(&'s VerifiedMotion, usize)>,
    run: LiveRun<'s>,
    record: LiveRecord<'s>,
    limits: JointLimits<6>,
    start: Joints<6>,
    /// The time from one setpoint to the next, s.
    period: f64,
    /// Cycles of the motion from one setpoint to the next.
    cycles: usize,
    /// The setpoints of the scenario without any order.
    rehearsed: Vec<Joints<6>>,
    over: bool,
    /// An order of the operator that came on the way to the start.
    waiting: Option<Command>,
    operator: Box<dyn FnMut(f64) -> Command + 's>,
}

impl<'s> LiveSetpoints<'s> {
    /// A scenario with a setpoint every `period` (s). It is rehearsed first: one that does not come to its end, or has a setpoint that a
    /// session would not send, is not begun.
    ///
    /// # Errors
    /// [`Cr7Error::Input`] naming the line, for an event after the end of the motion, a motion longer than `run.longest_s`, a period
    /// that is not a whole number of cycles, or a setpoint beyond a limit.
    pub fn new(stage: &'s Stage<'s>, period: f64) -> Result<Self, Cr7Error> {
        let cycle = stage.live().period();
        let cycles = (period / cycle).round();
        let wrong = |value: String, rule: &'static str, remedy: &'static str| {
            stage.scenario.check().wrong("sampling.period_ms", value, rule, remedy).into()
        };
        if cycles < 1.0 || (period / cycle - cycles).abs() > WHOLE {
            let value = format!("{} ms, with a setpoint every {} ms", cycle * 1e3, period * 1e3);
            let rule = "setpoints are a whole number of cycles apart";
            return Err(wrong(value, rule, "divide the time between setpoints by a whole number"));
        }
        let cycles = cycles as usize;
        let limits = *stage.live().joints();
        let rehearsed = rehearse(stage, cycles)?;
        if let Some(doubt) = first_doubt(&rehearsed, &limits, period) {
            let rule = "every setpoint is within the limits by the differences of the setpoints";
            return Err(wrong(doubt, rule, "lower the feed, or choose another time between setpoints"));
        }
        let run = LiveRun::new(stage)?;
        Ok(Self {
            way: None,
            start: run.setpoint().q,
            run,
            record: LiveRecord::new(&stage.scenario.events),
            limits,
            period,
            cycles,
            rehearsed,
            over: false,
            waiting: None,
            operator: Box::new(|_| Command::None),
        })
    }

    /// The setpoints of the scenario as it was rehearsed, without any order and without the way to the start, rad.
    pub fn rehearsed(&self) -> &[Joints<6>] {
        &self.rehearsed
    }

    /// The events and orders so far, and which of them were refused. Of a very large number only the first are kept.
    pub fn happenings(&self) -> Vec<Happening> {
        self.record.happenings()
    }

    /// With a way to the start before it, which rests at both ends. An operator who orders a hold or a stop on it ends the session. A way
    /// that ends elsewhere is a step of the setpoints, which the session does not send.
    pub fn with_way(mut self, way: &'s VerifiedMotion) -> Self {
        self.start = way.start();
        self.way = Some((way, way.count(self.period)));
        self
    }

    /// With somebody who is asked in every cycle what to do, with the time of the motion (s); [`Command::None`] is nothing. While that one
    /// holds the motion the scenario waits, with its clock and its events. A resume ends no hold of the scenario, and an override
    /// multiplies that of the scenario, up to the highest feed of its job. An order that comes every cycle keeps no event from coming.
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
        let LiveCycle { step, event } = self.run.step(&order);
        let refused = step.refused.as_ref();
        let t = step.setpoint.t;
        self.record.order(t, &order, refused.filter(|_| event.is_none()));
        if event.is_some() {
            self.record.event(t, refused);
        }
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
        self.rehearsed.len() + self.way.map_or(0, |(_, count)| count)
    }

    fn is_stopped_by_order(&self) -> bool {
        self.run.is_stopped_by_order()
    }

    fn setpoint(&mut self, index: usize, period: f64) -> Result<NextSetpoint<6>, Fault> {
        // The scenario would run at another speed.
        if period != self.period {
            let (asked, made) = (1e3 * period, 1e3 * self.period);
            let words = format!(
                "the session asks for a setpoint every {asked} ms, and the scenario has one every {made} ms: give both the same period"
            );
            return Err(Fault::Scenario(words));
        }
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

/// The setpoints of a scenario that is played in simulated time, one after so many cycles.
fn rehearse(stage: &Stage<'_>, cycles: usize) -> Result<Vec<Joints<6>>, Cr7Error> {
    let mut run = LiveRun::new(stage)?;
    let mut places = vec![run.setpoint().q];
    while !run.is_over()? {
        run.step(&Command::None);
        if run.cycles().is_multiple_of(cycles) {
            places.push(run.setpoint().q);
        }
    }
    // At its end the motion rests.
    if !run.cycles().is_multiple_of(cycles) {
        places.push(run.setpoint().q);
    }
    Ok(places)
}

/// What the guard of a session would say of the first setpoint that it does not let pass.
fn first_doubt(places: &[Joints<6>], limits: &JointLimits<6>, period: f64) -> Option<String> {
    let mut guard = Guard::new(*places.first()?, *limits, period);
    places.iter().enumerate().find_map(|(i, q)| {
        let next = NextSetpoint { q: *q, is_last: i + 1 == places.len() };
        let fault = guard.check(&next).err()?;
        Some(format!("a setpoint every {} ms, and at {:.3} s {fault}", period * 1e3, i as f64 * period))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cr7, Scenario};

    #[test]
    fn a_setpoint_that_a_session_would_not_send_is_found_before() {
        let scenario = Scenario::parse(Scenario::EXAMPLE, "event.toml".as_ref()).expect("a scenario");
        let cr7 = Cr7::of(scenario.job()).expect("an arm");
        let stage = scenario.stage(cr7.arm(), cr7.limits()).expect("in reach");
        let live = LiveSetpoints::new(&stage, 0.03).expect("it keeps the limits");
        let mut places = live.rehearsed().to_vec();
        assert_eq!(first_doubt(&places, cr7.limits(), 0.03), None);
        places[40][2] += 0.1;
        let doubt = first_doubt(&places, cr7.limits(), 0.03).expect("a jump");
        assert!(doubt.contains("at 1.200 s setpoint 40") && doubt.contains("joint 3"), "{doubt}");
        // The end counts: the arm has to rest there.
        let doubt = first_doubt(&live.rehearsed()[..60], cr7.limits(), 0.03).expect("it moves at its end");
        assert!(doubt.contains("setpoint 59"), "{doubt}");
    }

    #[test]
    fn a_session_with_another_period_gets_no_setpoint() {
        let scenario = Scenario::parse(Scenario::EXAMPLE, "event.toml".as_ref()).expect("a scenario");
        let cr7 = Cr7::of(scenario.job()).expect("an arm");
        let stage = scenario.stage(cr7.arm(), cr7.limits()).expect("in reach");
        let mut live = LiveSetpoints::new(&stage, 0.03).expect("it keeps the limits");
        assert!(live.setpoint(0, 0.03).is_ok());
        let fault = live.setpoint(1, 0.02).expect_err("another period");
        assert!(fault.to_string().contains("every 20 ms") && fault.to_string().contains("every 30 ms"), "{fault}");
    }
}
