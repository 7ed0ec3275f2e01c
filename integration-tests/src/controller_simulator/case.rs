//! A session against the simulated controller in fast time, and a judge of what became of it.

use arcfeed_interp::JointTrajectory;
use arcfeed_kinematics::{JointLimits, Joints};
use arcfeed_testing::Random;
use robot_cr7::Robot;
use robot_cr7::controller::{
    Dialect, DobotLink, JointStream, Outcome, SendLog, SendSettings, Session, VerifiedMotion, Wire, drive, lead_in,
};

use super::arm::{ArmLimits, SimulatedArm};
use super::controller::{SimulatedController, Version};
use super::disturbance::Disturbance;
use super::in_process::InProcess;

/// The time from a fault to rest that is stated, ms. A delay of the link comes on top.
pub const STATED: u64 = 700;
/// The time from a stop to rest, ms.
const BRAKING: u64 = 600;
/// The time that a session is watched after its end, ms.
const AFTERWARDS: u64 = 3000;
/// The lag of the drives, s.
const DRIVE_LAG: f64 = 0.02;
/// Digits of a setpoint, degrees.
const DIGITS: f64 = 1e-6;
/// The period of the setpoints, s.
const PERIOD: f64 = 0.03;

/// The limits of the CR7 that the project assumes.
///
/// # Panics
/// Never: the robot is built in.
pub fn cr7_limits() -> JointLimits<6> {
    let robot = Robot::load("cr7", None, None).expect("a built-in robot");
    robot.limits::<6>(&Default::default()).expect("six joints").0
}

/// The same as the simulated arm has them.
fn arm_limits(limits: &JointLimits<6>) -> ArmLimits {
    let degrees = |q: &Joints<6>| std::array::from_fn(|k| q[k].to_degrees());
    ArmLimits {
        lower: degrees(limits.lower()),
        upper: degrees(limits.upper()),
        velocity: degrees(limits.velocity()),
        acceleration: degrees(limits.acceleration()),
    }
}

/// A motion of `moves` random joint moves that uses nearly all of the limits.
///
/// # Panics
/// Where a move is not certified, which it has to be.
pub fn random_motion(seed: u64, moves: usize) -> VerifiedMotion {
    let mut random = Random::new(seed);
    let limits = cr7_limits();
    let mut place = || Joints::<6>::from(std::array::from_fn(|_| random.between(-1.2, 1.2)));
    // A way to the start uses a fifth of the limits: of 4.9 times these nearly all.
    let range = limits.range();
    let wide = range.with_rates(limits.velocity() * 4.9, limits.acceleration() * 4.9, limits.jerk() * 4.9);
    let rest = JointTrajectory::resting(&place(), 0.2).expect("rest");
    let mut motion = VerifiedMotion::new(rest, &wide.expect("limits")).expect("rest keeps limits");
    for _ in 0..moves {
        motion = lead_in(&motion, &place()).expect("a way");
    }
    VerifiedMotion::new(motion.trajectory().clone(), &limits).expect("it keeps the limits")
}

/// A motion of at least `seconds`.
///
/// # Panics
/// Where it is not certified, which it has to be.
pub fn long_motion(seed: u64, seconds: f64) -> VerifiedMotion {
    let there = random_motion(seed, 12);
    let mut motion = there.trajectory().clone().then(&there.trajectory().reversed()).expect("there and back");
    while motion.duration() < seconds {
        motion = motion.clone().then(&motion).expect("again");
    }
    VerifiedMotion::new(motion, there.limits()).expect("it keeps the limits")
}

/// One session.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Version of the protocol.
    pub version: Version,
    /// What goes wrong.
    pub fault: Disturbance,
    /// When, ms.
    pub fault_at: u64,
    /// Jitter of the link in each direction, ms.
    pub jitter: usize,
    /// True if the drives are off at the start, and may be switched on.
    pub off: bool,
    /// Seed of the jitter.
    pub seed: u64,
}

/// What became of a session.
#[derive(Debug, Clone)]
pub struct Judged {
    /// As the session sees it.
    pub outcome: Outcome,
    /// From the fault to rest of the simulated arm, ms.
    pub fault_to_rest: u64,
    /// From the first stop that arrived to rest, ms.
    pub stop_to_rest: u64,
}

impl Case {
    /// The case of a seed, for a motion of `duration` seconds.
    pub fn random(seed: u64, duration: f64) -> Self {
        let mut random = Random::new(seed);
        let joint = random.below(6);
        let off = random.between(1.0, 40.0) * if random.below(2) == 0 { 1.0 } else { -1.0 };
        let mode = [1, 2, 3, 6, 8, 10, 11, 12][random.below(8)];
        let time = random.log(5.0, 800.0) as u64;
        let kinds = [
            Disturbance::None,
            Disturbance::WrongStart(joint, off),
            Disturbance::AlarmAtStart,
            Disturbance::OffAtStart,
            Disturbance::OtherModel,
            Disturbance::ModeAtStart(mode),
            Disturbance::Alarm,
            Disturbance::Off,
            Disturbance::Mode(mode),
            Disturbance::Stuck(joint),
            Disturbance::Refused,
            Disturbance::Forgotten(1 + random.below(30)),
            Disturbance::Silent,
            Disturbance::Frozen,
            Disturbance::Garbage,
            Disturbance::NotANumber,
            Disturbance::Lost,
            Disturbance::Deaf,
            Disturbance::Delayed(time),
            Disturbance::Stalled(time),
            Disturbance::Interrupted,
        ];
        let fault = kinds[random.below(kinds.len())];
        Self {
            version: if random.below(2) == 0 { Version::Three } else { Version::Four },
            fault,
            fault_at: random.below((1e3 * duration) as usize + 1500) as u64,
            jitter: random.below(9),
            off: fault == Disturbance::OffAtStart || random.below(4) == 0,
            seed,
        }
    }

    /// Runs the session and judges it.
    ///
    /// # Errors
    /// The promise that is broken, in words.
    pub fn run(&self, motion: &VerifiedMotion) -> Result<Judged, String> {
        let mut start: [f64; 6] = std::array::from_fn(|k| motion.start()[k].to_degrees());
        if let Disturbance::WrongStart(joint, off) = self.fault {
            start[joint] += off;
        }
        let fault = (self.fault, self.fault_at);
        let arm = SimulatedArm::new(start, arm_limits(motion.limits()), DRIVE_LAG);
        let controller = SimulatedController::new(self.version, arm, !self.off, fault);
        let wire = InProcess::new(controller, self.jitter, fault, self.seed);
        let clock = wire.clock();
        let dialect = if self.version == Version::Three { Dialect::V3 } else { Dialect::V4 };
        let mut link = DobotLink::new(Shared(std::rc::Rc::new(std::cell::RefCell::new(wire))), dialect);
        let shared = link.wire().0.clone();

        let settings = SendSettings::new(PERIOD).map_err(|e| e.to_string())?;
        let enable = self.fault != Disturbance::OffAtStart;
        let settings = SendSettings { enable, models: &[7, 117, 207], ..settings };
        let mut session = Session::new(motion, &settings, link.now());
        let mut log = SendLog::new(60.0);
        let asked = || self.fault == Disturbance::Interrupted && clock.get() >= self.fault_at;
        drive(&mut session, &mut link, &mut log, asked);
        let outcome = session.outcome().clone();
        let ended_at = clock.get();
        drop(link);
        let judge = Judge { case: self, motion, outcome, ended_at };
        let mut wire = shared.borrow_mut();
        judge.judge(&mut wire)
    }
}

/// A link that is looked at from outside, too.
struct Shared(std::rc::Rc<std::cell::RefCell<InProcess>>);

impl Wire for Shared {
    fn now(&self) -> f64 {
        self.0.borrow().now()
    }

    fn send(
        &mut self,
        channel: robot_cr7::controller::Channel,
        bytes: &[u8],
    ) -> Result<(), robot_cr7::controller::LinkError> {
        self.0.borrow_mut().send(channel, bytes)
    }

    fn receive(
        &mut self,
        until: f64,
        bytes: &mut [u8; robot_cr7::controller::FEEDBACK_BYTES],
    ) -> Result<Option<(robot_cr7::controller::Channel, usize)>, robot_cr7::controller::LinkError> {
        self.0.borrow_mut().receive(until, bytes)
    }
}

struct Judge<'c> {
    case: &'c Case,
    motion: &'c VerifiedMotion,
    outcome: Outcome,
    ended_at: u64,
}

impl Judge<'_> {
    fn judge(self, wire: &mut InProcess) -> Result<Judged, String> {
        // The last time at which the arm moved.
        let mut moved = if wire.controller().arm().rests() { 0 } else { self.ended_at };
        for _ in 0..AFTERWARDS {
            wire.pass(1);
            if !wire.controller().arm().rests() {
                moved = wire.controller().time();
            }
        }
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
        if moved + 100 >= controller.time() {
            return Err("the arm moves long after the end".to_owned());
        }
        self.setpoints(&record.setpoints)?;
        let stop_to_rest = record.first_stop.map_or(0, |stop| self.rest(moved).saturating_sub(stop));
        if stop_to_rest > BRAKING {
            return Err(format!("{stop_to_rest} ms from the stop to rest"));
        }
        let fault_to_rest = self.rest(moved).saturating_sub(self.case.fault_at);
        match (&self.outcome.fault, self.must_fail(record.first_setpoint)) {
            (None, false) => self.arrived(wire)?,
            (None, true) => return Err("the fault is not noticed".to_owned()),
            (Some(fault), _) if self.case.fault == Disturbance::None => return Err(format!("a false alarm: {fault}")),
            (Some(_), _) => self.stopped(wire, fault_to_rest)?,
        }
        Ok(Judged { outcome: self.outcome, fault_to_rest, stop_to_rest })
    }

    /// When the arm came to rest, ms: at the end of the session or later.
    fn rest(&self, moved: u64) -> u64 {
        if moved == 0 { self.ended_at.min(self.case.fault_at) } else { moved }
    }

    /// Every setpoint is one of the verified motion, in order.
    fn setpoints(&self, setpoints: &[[f64; 6]]) -> Result<(), String> {
        for (i, setpoint) in setpoints.iter().enumerate() {
            let q = self.motion.trajectory().at(i as f64 * PERIOD).q;
            if let Some(k) = (0..6).find(|&k| (setpoint[k] - q[k].to_degrees()).abs() > DIGITS) {
                return Err(format!("setpoint {i}: joint {} is {} deg, not {}", k + 1, setpoint[k], q[k].to_degrees()));
            }
        }
        Ok(())
    }

    fn arrived(&self, wire: &InProcess) -> Result<(), String> {
        let (record, q) = (wire.controller().record(), wire.controller().arm().q());
        let end = self.motion.trajectory().at(self.motion.trajectory().duration()).q;
        let off = (0..6).map(|k| (q[k] - end[k].to_degrees()).abs()).fold(0.0, f64::max);
        // A link that is deaf towards the end loses setpoints of rest and the stop, and the arm rests already.
        let told = record.stops > 0 && record.setpoints.len() == self.outcome.setpoints;
        if off > 0.06 || !(told || self.case.fault == Disturbance::Deaf) {
            return Err(format!(
                "not arrived: {off} deg, {} setpoints, {} stops",
                record.setpoints.len(),
                record.stops
            ));
        }
        Ok(())
    }

    /// The arm is stopped in time, and told so if it can be.
    fn stopped(&self, wire: &InProcess, fault_to_rest: u64) -> Result<(), String> {
        let record = wire.controller().record();
        let reachable = !matches!(self.case.fault, Disturbance::Lost | Disturbance::Deaf);
        if reachable && !record.setpoints.is_empty() && record.stops == 0 {
            return Err("no stop was sent".to_owned());
        }
        let delay = if let Disturbance::Delayed(time) = self.case.fault { time } else { 0 };
        // These are noticed once the motion shows them.
        let shows = matches!(self.case.fault, Disturbance::Stuck(_) | Disturbance::Forgotten(_) | Disturbance::Deaf);
        if !shows && fault_to_rest > STATED + delay {
            return Err(format!("{fault_to_rest} ms from the fault to rest"));
        }
        Ok(())
    }

    /// True for faults that a session has to notice. The first setpoint came at `first`, ms.
    fn must_fail(&self, first: Option<u64>) -> bool {
        // Well before the last setpoint.
        let during = first.is_some_and(|first| first < self.case.fault_at)
            && self.case.fault_at + 100 < self.ended_at.saturating_sub(600);
        match self.case.fault {
            Disturbance::None | Disturbance::Forgotten(_) => false,
            Disturbance::WrongStart(..)
            | Disturbance::AlarmAtStart
            | Disturbance::OffAtStart
            | Disturbance::OtherModel
            | Disturbance::ModeAtStart(_) => true,
            Disturbance::Stuck(joint) => during && self.moves_on(joint),
            Disturbance::Delayed(time) => during && time > 150,
            Disturbance::Stalled(time) => during && time > 60,
            Disturbance::Refused if self.case.version == Version::Three => false,
            _ => during,
        }
    }

    /// True if the motion takes a joint well away from where it stands when it gets stuck.
    fn moves_on(&self, joint: usize) -> bool {
        let trajectory = self.motion.trajectory();
        // The motion began at most a second and a bit after the start.
        let place = |t: f64| trajectory.at(t).q[joint].to_degrees();
        let at = self.case.fault_at as f64 * 1e-3;
        let steps = (trajectory.duration() / 0.01) as usize;
        let later = (0..steps).map(|i| 0.01 * i as f64).filter(|t| *t > at);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for t in later {
            (least, most) = (least.min(place(t)), most.max(place(t)));
        }
        most - least > 6.0
    }
}
