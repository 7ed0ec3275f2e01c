//! A session against the simulated controller in fast time.

use std::cell::RefCell;
use std::rc::Rc;

use arcfeed_kinematics::{JointLimits, Joints};
use robot_cr7::controller::{
    Channel, Dialect, DobotLink, FEEDBACK_BYTES, JointStream, LinkError, SendLog, SendSettings, Session,
    SetpointSource, VerifiedMotion, Wire, drive,
};

use super::arm::{ArmLimits, SimulatedArm};
use super::case::{Case, PERIOD};
use super::controller::{SimulatedController, Version};
use super::disturbance::Disturbance;
use super::in_process::InProcess;
use super::judge::{Judge, Judged};

/// The time that a session is watched after its end, ms.
const AFTERWARDS: u64 = 3000;
/// The lag of the drives, s.
const DRIVE_LAG: f64 = 0.02;

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

impl Case {
    /// Runs a session that leads the simulated arm along a motion, and judges it.
    ///
    /// # Errors
    /// The promise that is broken, in words.
    pub fn run(&self, motion: &VerifiedMotion) -> Result<Judged, String> {
        let count = motion.count(PERIOD);
        let setpoints: Vec<_> = (0..count).map(|i| motion.trajectory().at(i as f64 * PERIOD).q).collect();
        self.run_source(motion, &setpoints)
    }

    /// The same with setpoints of any source, which are `expected`, rad.
    ///
    /// # Errors
    /// The promise that is broken, in words.
    pub fn run_source<M: SetpointSource>(&self, source: M, expected: &[Joints<6>]) -> Result<Judged, String> {
        let mut start: [f64; 6] = std::array::from_fn(|k| source.start()[k].to_degrees());
        if let Disturbance::WrongStart(joint, off) = self.fault {
            start[joint] += off;
        }
        let fault = (self.fault, self.fault_at);
        let arm = SimulatedArm::new(start, arm_limits(source.limits()), DRIVE_LAG);
        let controller = SimulatedController::new(self.version, arm, !self.off, fault);
        let wire = InProcess::new(controller, self.jitter, fault, self.seed);
        let clock = wire.clock();
        let dialect = if self.version == Version::Three { Dialect::V3 } else { Dialect::V4 };
        let mut link = DobotLink::new(Shared(Rc::new(RefCell::new(wire))), dialect);
        let shared = link.wire().0.clone();

        let settings = SendSettings::new(PERIOD).map_err(|e| e.to_string())?;
        let enable = self.fault != Disturbance::OffAtStart;
        let settings = SendSettings { enable, models: &[7, 117, 207], ..settings };
        let mut session = Session::new(source, &settings, link.now());
        let mut log = SendLog::new(60.0);
        let interrupts = matches!(self.fault, Disturbance::Interrupted | Disturbance::Overtaken(_));
        let asked = || interrupts && clock.get() >= self.fault_at;
        drive(&mut session, &mut link, &mut log, asked);
        let outcome = session.outcome().clone();
        drop(link);
        let mut wire = shared.borrow_mut();
        wire.pass(AFTERWARDS);
        Judge { case: self, expected, outcome }.judge(&wire)
    }
}

/// A link that is looked at from outside, too.
struct Shared(Rc<RefCell<InProcess>>);

impl Wire for Shared {
    fn now(&self) -> f64 {
        self.0.borrow().now()
    }

    fn send(&mut self, channel: Channel, bytes: &[u8]) -> Result<(), LinkError> {
        self.0.borrow_mut().send(channel, bytes)
    }

    fn receive(&mut self, until: f64, bytes: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError> {
        self.0.borrow_mut().receive(until, bytes)
    }
}
