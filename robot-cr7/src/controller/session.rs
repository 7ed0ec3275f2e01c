//! The course of one motion on a controller: look, switch on, lead, arrive, stop. A state machine without a clock.

use arcfeed_kinematics::Joints;

use super::arm_state::{ArmMode, ArmState};
use super::fault::Fault;
use super::guard::Guard;
use super::outcome::Outcome;
use super::recent::Recent;
use super::setpoints::{NextSetpoint, SetpointSource};
use super::settings::SendSettings;
use super::stream::{Event, Order};

/// How long the answer to a question may take, s.
const ANSWER_TIME: f64 = 2.0;
/// How long the drives may take to come on, s.
const ENABLE_TIME: f64 = 10.0;
/// How long the arm may take to its end after the last setpoint and the lag, s.
const ARRIVE_TIME: f64 = 1.0;
/// The time after which a stop is repeated, s.
const STOP_AGAIN: f64 = 0.2;
/// How long the arm has to be seen at rest before no stop is sent any more, s. Setpoints may come after a stop that was sent later, by
/// another connection: for this long they are followed by a stop.
const GUARD_TIME: f64 = 1.0;
/// How long stops are sent, s.
const STOP_TIME: f64 = 4.0;
/// A joint that is slower rests, rad/s.
const REST: f64 = 2e-3;
/// How long all states have to show all joints at rest at the end of the motion, s.
const REST_TIME: f64 = 0.015;

/// Where a session is. Times in s.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// Waits for the first state of the arm.
    Look { since: f64 },
    /// The question about errors is due, then waits for its answer.
    Ask { since: f64, asked: bool },
    /// The order to switch the drives on is due, then waits for it to be carried out.
    SwitchOn { since: f64, ordered: bool },
    /// Setpoint `next` is due at `begin` plus that number of periods.
    Lead { begin: f64, next: usize },
    /// Waits for the arm to be at the end.
    Arrive { since: f64 },
    /// A stop is due at `again`.
    Stop { since: f64, again: f64 },
    /// Nothing is sent any more.
    Over,
}

/// A setpoint that waits for its time.
#[derive(Debug, Clone, Copy)]
struct Ready<const N: usize> {
    setpoint: NextSetpoint<N>,
    /// The time at which the source was asked for it, s.
    asked: f64,
    /// How long the source took at most, s; `None` before the clock was looked at again.
    planning: Option<f64>,
}

/// The course of one motion, whose setpoints `M` gives. It allocates nothing while the arm moves.
#[derive(Debug)]
pub struct Session<M, const N: usize = 6> {
    source: M,
    guard: Guard<N>,
    /// The setpoint that is due next, once it is known and held against the limits.
    ready: Option<Ready<N>>,
    settings: SendSettings,
    phase: Phase,
    /// The last new state, and when it came.
    last: Option<(f64, ArmState<N>)>,
    /// The time since which every state shows all joints at rest, s.
    rests_since: Option<f64>,
    recent: Recent<N>,
    outcome: Outcome,
}

impl<M: SetpointSource<N>, const N: usize> Session<M, N> {
    /// A session that begins at time `now`, s.
    pub fn new(source: M, settings: &SendSettings, now: f64) -> Self {
        let (start, setpoints) = (source.start(), source.count(settings.period));
        Self {
            guard: Guard::new(start, *source.limits(), settings.period),
            source,
            ready: None,
            settings: *settings,
            phase: Phase::Look { since: now },
            last: None,
            rests_since: None,
            recent: Recent::new(start),
            outcome: Outcome { setpoints, ..Outcome::default() },
        }
    }

    /// True once nothing is sent any more.
    pub fn is_over(&self) -> bool {
        self.phase == Phase::Over
    }

    /// What has become of it so far.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// The setpoint that was sent last, rad; the start before the first one.
    pub fn setpoint(&self) -> &Joints<N> {
        self.recent.last()
    }

    /// Where the setpoints came from.
    pub fn source(&self) -> &M {
        &self.source
    }

    /// True if a setpoint was planned in the last call of [`Session::next_order`], which took time: ask the clock, and call it again.
    pub fn has_planned(&self) -> bool {
        matches!(self.phase, Phase::Lead { .. }) && self.ready.is_some_and(|ready| ready.planning.is_none())
    }

    /// The time by which [`Session::next_order`] has to be called again, s.
    pub fn due(&self) -> f64 {
        let silence = self.last.map_or(f64::INFINITY, |(at, _)| at + self.settings.feedback_timeout);
        match self.phase {
            Phase::Look { since } => since + ANSWER_TIME,
            Phase::Ask { asked: false, .. } | Phase::SwitchOn { ordered: false, .. } | Phase::Over => f64::NEG_INFINITY,
            Phase::Ask { since, .. } => silence.min(since + ANSWER_TIME),
            Phase::SwitchOn { since, .. } => silence.min(since + ENABLE_TIME),
            Phase::Lead { begin, next } => silence.min(begin + next as f64 * self.settings.period),
            Phase::Arrive { since } => silence.min(since + self.settings.lag + ARRIVE_TIME),
            Phase::Stop { since, again } => again.min(since + STOP_TIME),
        }
    }

    /// The order that is due at time `now` (s), to be sent at once; to be called until there is none, and where [`Session::has_planned`]
    /// with the time of then.
    pub fn next_order(&mut self, now: f64) -> Option<Order<N>> {
        self.check_silence(now);
        match self.phase {
            Phase::Look { since } => self.wait(now, since, ANSWER_TIME, Fault::Silence { silence: now - since }),
            Phase::Ask { since, asked: false } => {
                self.phase = Phase::Ask { since, asked: true };
                return Some(Order::AskErrors);
            }
            Phase::Ask { since, .. } => {
                self.wait(now, since, ANSWER_TIME, Fault::NoAnswer { order: "GetErrorID", waited: now - since });
            }
            Phase::SwitchOn { since, ordered: false } => {
                self.phase = Phase::SwitchOn { since, ordered: true };
                self.outcome.touched = true;
                return Some(Order::Enable);
            }
            Phase::SwitchOn { since, .. } => {
                self.wait(now, since, ENABLE_TIME, Fault::NotEnabled { waited: now - since });
            }
            Phase::Lead { begin, next } => {
                let setpoint = self.setpoint_due(now, begin, next);
                if setpoint.is_some() {
                    return setpoint;
                }
            }
            Phase::Arrive { since } => self.arrive(now, since),
            Phase::Stop { .. } | Phase::Over => {}
        }
        self.stop_due(now)
    }

    /// Takes an event that came at time `now`, s.
    pub fn see(&mut self, now: f64, event: &Event<N>) {
        match event {
            Event::State(state) => self.see_state(now, state),
            Event::Errors { count: 0, .. } => {
                if let (Phase::Ask { .. }, Some((_, state))) = (self.phase, self.last) {
                    self.errors_are_clear(now, &state);
                }
            }
            Event::Errors { count, first } => self.fail(now, Fault::Errors { count: *count, first: *first }),
            Event::Refused { order, code } => self.fail(now, Fault::Refused { order, code: *code }),
        }
    }

    /// Ends it because the operator wants so.
    pub fn interrupt(&mut self, now: f64) {
        self.fail(now, Fault::Interrupted);
    }

    /// Takes it down that a stop left at time `now`, s.
    pub fn stop_is_sent(&mut self, now: f64) {
        self.outcome.stopped_at.get_or_insert(now);
    }

    /// Ends it because the link does not work. A stop is tried again and again all the same.
    pub fn lose(&mut self, now: f64, words: &str) {
        if let Phase::Stop { .. } = self.phase {
            self.outcome.fault.get_or_insert_with(|| Fault::Link(words.to_owned()));
        }
        self.fail(now, Fault::Link(words.to_owned()));
    }

    /// The session has found a doubt. An arm that was touched is stopped.
    fn fail(&mut self, now: f64, fault: Fault) {
        if matches!(self.phase, Phase::Stop { .. } | Phase::Over) {
            return;
        }
        self.outcome.fault = Some(fault);
        self.end(now);
    }

    fn end(&mut self, now: f64) {
        self.rests_since = None;
        self.phase = if self.outcome.touched { Phase::Stop { since: now, again: now } } else { Phase::Over };
    }

    fn wait(&mut self, now: f64, since: f64, longest: f64, fault: Fault) {
        if now >= since + longest {
            self.fail(now, fault);
        }
    }

    fn check_silence(&mut self, now: f64) {
        let Some((at, _)) = self.last else { return };
        if now >= at + self.settings.feedback_timeout {
            self.fail(now, Fault::Silence { silence: now - at });
        }
    }

    /// The setpoint that is due. It is made ready a period before, so that what it takes to plan it does not make it late.
    fn setpoint_due(&mut self, now: f64, begin: f64, next: usize) -> Option<Order<N>> {
        let is_new = self.ready.is_none();
        let mut ready = match self.ready.take().map_or_else(|| self.prepare(now, next), Ok) {
            Ok(ready) => ready,
            Err(fault) => {
                self.fail(now, fault);
                return None;
            }
        };
        if is_new {
            // The clock has to be looked at anew: it went on while the setpoint was planned.
            self.ready = Some(ready);
            return None;
        }
        let planning = *ready.planning.get_or_insert(now - ready.asked);
        self.ready = Some(ready);
        // The first setpoint sets the time of all others.
        let begin = if next == 0 { now } else { begin };
        let late = now - (begin + next as f64 * self.settings.period);
        if late < 0.0 {
            return None;
        }
        if late > self.settings.lateness {
            self.fail(now, Fault::Late { index: next, late, planning });
            return None;
        }
        self.ready = None;
        let NextSetpoint { q, is_last } = ready.setpoint;
        self.outcome.stopped_by_order = is_last && self.source.is_stopped_by_order();
        self.recent.push(now, q);
        self.outcome.touched = true;
        self.outcome.sent = next + 1;
        self.outcome.deadlines.see(late);
        self.phase = if is_last { Phase::Arrive { since: now } } else { Phase::Lead { begin, next: next + 1 } };
        Some(Order::Setpoint { q, period: self.settings.period })
    }

    /// Setpoint `next`, held against the limits.
    fn prepare(&mut self, now: f64, next: usize) -> Result<Ready<N>, Fault> {
        let setpoint = self.source.setpoint(next, self.settings.period)?;
        self.guard.check(&setpoint)?;
        Ok(Ready { setpoint, asked: now, planning: None })
    }

    /// The stop that is due. It is repeated until the arm has been at rest for some time.
    fn stop_due(&mut self, now: f64) -> Option<Order<N>> {
        let Phase::Stop { since, again } = self.phase else { return None };
        if now >= since + STOP_TIME {
            self.outcome.fault.get_or_insert(Fault::NotResting { waited: now - since });
            self.phase = Phase::Over;
            return None;
        }
        if now < again {
            return None;
        }
        self.phase = Phase::Stop { since, again: now + STOP_AGAIN };
        Some(Order::Stop)
    }

    fn see_state(&mut self, now: f64, state: &ArmState<N>) {
        if let Some((_, last)) = self.last {
            if state.clock_ms < last.clock_ms {
                return self.fail(now, Fault::Clock { back_ms: last.clock_ms - state.clock_ms });
            }
            // The same clock again: the controller repeats itself.
            if state.clock_ms == last.clock_ms {
                return;
            }
        }
        let gap = self.last.is_some_and(|(at, _)| now > at + self.settings.feedback_timeout);
        self.last = Some((now, *state));
        let since = if gap { None } else { self.rests_since };
        self.rests_since = (state.qd.amax() <= REST).then(|| since.unwrap_or(now));
        match self.phase {
            Phase::Look { .. } => self.phase = Phase::Ask { since: now, asked: false },
            Phase::SwitchOn { .. } if state.alarm || state.mode == ArmMode::Alarm => {
                self.fail(now, Fault::Mode { mode: ArmMode::Alarm });
            }
            Phase::SwitchOn { .. } if state.enabled && state.mode == ArmMode::Idle => self.begin(now, state),
            Phase::Lead { .. } | Phase::Arrive { .. } => {
                if let Some(fault) = wrong_mode(state).or_else(|| self.not_following(now, state)) {
                    self.fail(now, fault);
                }
            }
            Phase::Stop { .. } if self.outcome.stopped_at.is_some() && self.rested(now) >= GUARD_TIME => {
                self.outcome.rests_at = self.rests_since;
                self.phase = Phase::Over;
            }
            _ => {}
        }
    }

    /// How long the arm has been seen at rest, s.
    fn rested(&self, now: f64) -> f64 {
        self.rests_since.map_or(0.0, |since| now - since)
    }

    fn errors_are_clear(&mut self, now: f64, state: &ArmState<N>) {
        let models = self.settings.models;
        if !models.is_empty() && !models.contains(&state.model) {
            return self.fail(now, Fault::Model { found: state.model, expected: models });
        }
        match state.mode {
            ArmMode::Idle if state.enabled && !state.alarm => self.begin(now, state),
            ArmMode::Disabled if self.settings.enable && !state.alarm => {
                self.phase = Phase::SwitchOn { since: now, ordered: false };
            }
            ArmMode::Disabled => self.fail(now, Fault::Disabled),
            mode => self.fail(now, Fault::Mode { mode: if state.alarm { ArmMode::Alarm } else { mode } }),
        }
    }

    /// Begins to lead the arm if it rests at the start.
    fn begin(&mut self, now: f64, state: &ArmState<N>) {
        let start = self.source.start();
        for joint in 0..N {
            let (actual, velocity) = (state.q[joint], state.qd[joint]);
            // Not `>`: a NaN has to show.
            let there = (actual - start[joint]).abs() <= self.settings.start_tolerance;
            if !there {
                return self.fail(now, Fault::Elsewhere { joint, actual, start: start[joint] });
            }
            let rests = velocity.abs() <= REST;
            if !rests {
                return self.fail(now, Fault::Moving { joint, velocity });
            }
        }
        self.phase = Phase::Lead { begin: now, next: 0 };
    }

    /// Looks whether each joint is where it was asked to be at some time within the lag.
    fn not_following(&mut self, now: f64, state: &ArmState<N>) -> Option<Fault> {
        let (least, most) = self.recent.range(now - self.settings.lag);
        for joint in 0..N {
            let off = (least[joint] - state.q[joint]).max(state.q[joint] - most[joint]);
            let error = (state.q[joint] - self.setpoint()[joint]).abs();
            if error > self.outcome.off.1 {
                self.outcome.off = (joint, error);
            }
            let follows = off <= self.settings.following_tolerance;
            if !follows {
                return Some(Fault::Following { joint, off });
            }
        }
        None
    }

    /// Ends it once the arm rests at the end of the motion.
    fn arrive(&mut self, now: f64, since: f64) {
        let Some((_, state)) = self.last else { return };
        let distance = (state.q - self.setpoint()).abs();
        let joint = distance.imax();
        let there = distance[joint] <= self.settings.start_tolerance && self.rested(now) >= REST_TIME;
        let waited = now - since;
        if there && waited >= self.settings.period {
            self.end(now);
        } else if now >= since + self.settings.lag + ARRIVE_TIME {
            self.fail(now, Fault::NotArrived { joint, off: distance[joint], waited });
        }
    }
}

/// The doubt in what the arm does while it is led.
fn wrong_mode<const N: usize>(state: &ArmState<N>) -> Option<Fault> {
    match state.mode {
        _ if state.alarm => Some(Fault::Mode { mode: ArmMode::Alarm }),
        ArmMode::Disabled => Some(Fault::Disabled),
        ArmMode::Idle | ArmMode::Running => (!state.enabled).then_some(Fault::Disabled),
        mode => Some(Fault::Mode { mode }),
    }
}
