//! The judge of a session: what the simulated controller and its arm saw, against what is promised.

use arcfeed_kinematics::Joints;
use robot_cr7::controller::{Fault, Outcome};

use super::case::{Case, PERIOD};
use super::controller::{Record, Version};
use super::disturbance::Disturbance;
use super::in_process::InProcess;

/// The time from a fault to rest that is stated, ms. A delay of the link comes on top.
const STATED: u64 = 700;
/// The time from a stop to rest, ms.
const BRAKING: u64 = 600;
/// Digits of a setpoint, degrees.
const DIGITS: f64 = 1e-6;
/// A stop is repeated that often where nothing is heard of the arm.
const REPEATED: usize = 10;

/// What became of a session.
#[derive(Debug, Clone)]
pub struct Judged {
    /// As the session sees it.
    pub outcome: Outcome,
    /// From the fault to rest of the simulated arm, a delay of the link not counted, ms.
    pub fault_to_rest: u64,
    /// From the first stop that arrived to rest, a delay of the link not counted, ms.
    pub stop_to_rest: u64,
}

/// One session and what became of it.
pub(super) struct Judge<'c> {
    pub case: &'c Case,
    /// The setpoints, rad.
    pub expected: &'c [Joints<6>],
    pub outcome: Outcome,
}

impl Judge<'_> {
    /// Looks at the controller some seconds after the end of the session.
    pub fn judge(self, wire: &InProcess) -> Result<Judged, String> {
        let (controller, record) = (wire.controller(), wire.controller().record());
        if let Some(excess) = controller.arm().excess() {
            return Err(format!("the arm exceeds a limit: {excess:?}"));
        }
        if record.motions_after_stop > 0 {
            return Err(format!("{} motions after a stop", record.motions_after_stop));
        }
        if let Some(foreign) = record.foreign.first() {
            return Err(format!("a command that the controller does not know: {foreign}"));
        }
        if record.moved + 100 >= controller.time() {
            return Err("the arm moves long after the end".to_owned());
        }
        self.setpoints(&record.setpoints)?;
        let delay = match self.case.fault {
            Disturbance::Delayed(time) => time,
            // What comes late is played, and stopped by the next stop.
            Disturbance::Overtaken(time) => time + 200,
            _ => 0,
        };
        let stop_to_rest = record.first_stop.map_or(0, |stop| record.moved.saturating_sub(stop + delay));
        if stop_to_rest > BRAKING {
            return Err(format!("{stop_to_rest} ms from the stop to rest"));
        }
        let fault_to_rest = record.moved.saturating_sub(self.case.fault_at + delay);
        match (&self.outcome.fault, self.must_fail(record.first_setpoint)) {
            (None, false) => self.arrived(wire)?,
            (None, true) => return Err("the fault is not noticed".to_owned()),
            (Some(fault), _) if !self.explains(fault) => return Err(format!("a fault for another reason: {fault:?}")),
            (Some(_), _) => self.stopped(record, fault_to_rest)?,
        }
        Ok(Judged { outcome: self.outcome, fault_to_rest, stop_to_rest })
    }

    /// Every setpoint is one of those that are expected, in order.
    fn setpoints(&self, setpoints: &[[f64; 6]]) -> Result<(), String> {
        for (i, setpoint) in setpoints.iter().enumerate() {
            let q = self.expected.get(i).ok_or_else(|| format!("setpoint {i} of {}", self.expected.len()))?;
            if let Some(k) = (0..6).find(|&k| (setpoint[k] - q[k].to_degrees()).abs() > DIGITS) {
                return Err(format!("setpoint {i}: joint {} is {} deg, not {}", k + 1, setpoint[k], q[k].to_degrees()));
            }
        }
        Ok(())
    }

    fn arrived(&self, wire: &InProcess) -> Result<(), String> {
        let (record, q) = (wire.controller().record(), wire.controller().arm().q());
        let end = self.expected.last().ok_or("nothing to be sent")?;
        let off = (0..6).map(|k| (q[k] - end[k].to_degrees()).abs()).fold(0.0, f64::max);
        // A link that is deaf towards the end loses setpoints of rest and the stop, and the arm rests already.
        let told = record.stops > 0 && record.setpoints.len() == self.expected.len();
        if off > 0.06 || !(told || self.case.fault == Disturbance::Deaf) {
            return Err(format!(
                "not arrived: {off} deg, {} setpoints, {} stops",
                record.setpoints.len(),
                record.stops
            ));
        }
        Ok(())
    }

    /// True if the disturbance of the case explains a fault of this kind.
    fn explains(&self, fault: &Fault) -> bool {
        let name = format!("{fault:?}");
        let name = name.split([' ', '(']).next().unwrap_or_default();
        self.kinds().contains(&name)
    }

    /// The kinds of fault that the disturbance may show as.
    fn kinds(&self) -> &'static [&'static str] {
        match self.case.fault {
            Disturbance::None => &[],
            Disturbance::WrongStart(..) => &["Elsewhere"],
            Disturbance::AlarmAtStart => &["Errors"],
            Disturbance::OffAtStart => &["Disabled"],
            Disturbance::OtherModel => &["Model"],
            Disturbance::ModeAtStart(_) => &["Mode"],
            Disturbance::Alarm => &["Mode", "Refused", "Errors"],
            Disturbance::Off => &["Disabled", "Refused"],
            Disturbance::Mode(_) => &["Mode", "Refused", "NotEnabled"],
            Disturbance::Stuck(_) => &["Following", "NotArrived"],
            // An arm that gets no setpoint brakes and alarms.
            Disturbance::Refused | Disturbance::Forgotten(_) => &["Refused", "Following", "Mode"],
            Disturbance::Deaf => &["Following", "Mode", "NoAnswer", "NotEnabled"],
            Disturbance::Silent | Disturbance::Frozen | Disturbance::Garbage => &["Silence", "NotResting"],
            Disturbance::NotANumber | Disturbance::ForeignReply | Disturbance::Lost => &["Link"],
            Disturbance::Delayed(_) => &["Silence", "Mode", "Refused"],
            // States that came meanwhile are older than the lag.
            Disturbance::Stalled(_) => &["Late", "Silence", "Following"],
            Disturbance::Interrupted => &["Interrupted"],
            Disturbance::Overtaken(_) => &["Interrupted", "Mode"],
        }
    }

    /// The arm is stopped in time, and told so if it can be; an arm that may not be led gets no setpoint.
    fn stopped(&self, record: &Record, fault_to_rest: u64) -> Result<(), String> {
        let fault = self.case.fault;
        // Where the arm stands is looked at with the drives on.
        let touched = record.enables > 0 && !matches!(fault, Disturbance::WrongStart(..));
        if self.at_start() && (touched || !record.setpoints.is_empty()) {
            return Err("the arm is touched in spite of a fault at the start".to_owned());
        }
        let reachable = !matches!(fault, Disturbance::Lost | Disturbance::Deaf);
        if reachable && !record.setpoints.is_empty() && record.stops == 0 {
            return Err("no stop was sent".to_owned());
        }
        // Nothing is heard of the arm any more: the stop is not given up.
        let unheard = matches!(fault, Disturbance::NotANumber | Disturbance::Silent | Disturbance::Garbage);
        if unheard && !record.setpoints.is_empty() && record.stops < REPEATED {
            return Err(format!("only {} stops", record.stops));
        }
        if fault == Disturbance::ForeignReply && !record.setpoints.is_empty() && record.stops < 4 {
            return Err(format!("only {} stops", record.stops));
        }
        if self.case.shows_at_once() && fault_to_rest > STATED {
            return Err(format!("{fault_to_rest} ms from the fault to rest"));
        }
        Ok(())
    }

    /// True for a fault at the start.
    fn at_start(&self) -> bool {
        matches!(
            self.case.fault,
            Disturbance::WrongStart(..)
                | Disturbance::AlarmAtStart
                | Disturbance::OffAtStart
                | Disturbance::OtherModel
                | Disturbance::ModeAtStart(_)
        )
    }

    /// True for faults that a session has to notice. The first setpoint came at `first`, ms.
    fn must_fail(&self, first: Option<u64>) -> bool {
        // Well before the last setpoint.
        let duration = (1e3 * PERIOD * (self.expected.len() as f64 - 2.0)).max(0.0) as u64;
        let fault_at = self.case.fault_at;
        let during = first.is_some_and(|first| first < fault_at && fault_at + 300 < first + duration);
        match self.case.fault {
            Disturbance::None | Disturbance::Forgotten(_) => false,
            Disturbance::Stuck(joint) => during && self.moves_on(joint),
            Disturbance::Delayed(time) => during && time > 150,
            Disturbance::Stalled(time) => during && time > 60,
            Disturbance::Refused | Disturbance::ForeignReply if self.case.version == Version::Three => false,
            _ => during || self.at_start(),
        }
    }

    /// True if the motion takes a joint well away from where it stands when it gets stuck.
    fn moves_on(&self, joint: usize) -> bool {
        // The motion began at most a second and a bit after the start.
        let at = self.case.fault_at as f64 * 1e-3;
        let later = self.expected.iter().enumerate().filter(|(i, _)| PERIOD * *i as f64 > at);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for place in later.map(|(_, q)| q[joint].to_degrees()) {
            (least, most) = (least.min(place), most.max(place));
        }
        most - least > 6.0
    }
}
