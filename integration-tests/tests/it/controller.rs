//! `cr7 send` against a simulated controller: an arm is led or stopped, whatever goes wrong.

use arcfeed_kinematics::Joints;
use arcfeed_testing::allocations_in;
use integration_tests::controller_simulator::{
    ArmLimits, Case, Disturbance, InProcess, SimulatedArm, SimulatedController, Version, cr7_limits, long_motion,
    random_motion,
};
use robot_cr7::controller::{
    Channel, Dialect, DobotLink, FEEDBACK_BYTES, JointStream, LinkError, SendLog, SendSettings, Session, Wire, drive,
};

/// Random faults; the example `soak_controller` runs any number of them.
#[test]
fn random_faults_end_in_a_stop_within_the_stated_time_and_within_the_limits() {
    let mut stopped = 0;
    for seed in 1..=300 {
        let motion = random_motion(seed, 4);
        let case = Case::random(seed, motion.trajectory().duration());
        let judged = case.run(&motion).unwrap_or_else(|words| panic!("{words}: {case:?}"));
        stopped += usize::from(judged.outcome.fault.is_some());
    }
    assert!(stopped > 150, "{stopped}");
}

#[test]
fn minutes_of_motion_are_led_without_a_false_alarm() {
    let motion = long_motion(7, 300.0);
    for (version, jitter) in [(Version::Three, 8), (Version::Four, 0)] {
        let case = Case { version, fault: Disturbance::None, fault_at: 0, jitter, off: true, seed: 7 };
        let judged = case.run(&motion).unwrap_or_else(|words| panic!("{words}: {case:?}"));
        assert_eq!(judged.outcome.sent, judged.outcome.setpoints);
    }
}

/// The judge is not blind: setpoints that no limit allows make the simulated arm brake and alarm.
#[test]
fn a_step_of_the_setpoints_is_an_alarm_of_the_simulator() {
    let limits = cr7_limits();
    let all = |q: &Joints<6>| std::array::from_fn(|k| q[k].to_degrees());
    let limits = ArmLimits {
        lower: all(limits.lower()),
        upper: all(limits.upper()),
        velocity: all(limits.velocity()),
        acceleration: all(limits.acceleration()),
    };
    let arm = SimulatedArm::new([0.0; 6], limits, 0.02);
    let controller = SimulatedController::new(Version::Four, arm, true, (Disturbance::None, 0));
    let mut wire = InProcess::new(controller, 0, (Disturbance::None, 0), 1);
    for q in [0.0, 0.0, 5.0, 10.0] {
        let command = format!("ServoJ({q},0,0,0,0,0,t=0.030)");
        wire.send(Channel::Dashboard, command.as_bytes()).expect("a link");
        wire.pass(30);
    }
    wire.pass(500);
    wire.send(Channel::Dashboard, b"RobotMode()").expect("a link");
    let (mut bytes, mut text) = ([0; FEEDBACK_BYTES], String::new());
    while let Ok(Some((channel, count))) = wire.receive(wire.now() + 0.01, &mut bytes) {
        if channel == Channel::Dashboard {
            text.push_str(&String::from_utf8_lossy(&bytes[..count]));
            if text.contains("RobotMode") {
                break;
            }
        }
    }
    assert!(text.ends_with("0,{9},RobotMode();"), "{text}");
    assert_eq!(wire.controller().arm().excess(), None);
}

/// An arm that is at once where it is asked to be, without an allocation.
struct Echo {
    milliseconds: u64,
    asked: bool,
    packet: [u8; FEEDBACK_BYTES],
}

impl Echo {
    fn put(&mut self, at: usize, value: &[u8]) {
        self.packet[at..at + value.len()].copy_from_slice(value);
    }

    fn be_at(&mut self, joint: usize, degrees: f64) {
        self.put(192 + 8 * joint, &degrees.to_le_bytes());
        self.put(432 + 8 * joint, &degrees.to_le_bytes());
    }
}

impl Wire for Echo {
    fn now(&self) -> f64 {
        self.milliseconds as f64 * 1e-3
    }

    fn send(&mut self, _: Channel, bytes: &[u8]) -> Result<(), LinkError> {
        let text = std::str::from_utf8(bytes).expect("text");
        self.asked |= text.starts_with("GetErrorID");
        if let Some(numbers) = text.strip_prefix("ServoJ(") {
            for (joint, number) in numbers.split(',').take(6).enumerate() {
                self.be_at(joint, number.parse().expect("a number"));
            }
        }
        Ok(())
    }

    fn receive(&mut self, until: f64, bytes: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError> {
        if std::mem::take(&mut self.asked) {
            let reply = b"0,{[[],[],[],[],[],[],[]]},GetErrorID();";
            bytes[..reply.len()].copy_from_slice(reply);
            return Ok(Some((Channel::Dashboard, reply.len())));
        }
        while self.now() < until {
            self.milliseconds += 1;
            if self.milliseconds.is_multiple_of(8) {
                self.put(32, &self.milliseconds.to_le_bytes());
                *bytes = self.packet;
                return Ok(Some((Channel::Feedback, FEEDBACK_BYTES)));
            }
        }
        Ok(None)
    }
}

#[test]
fn a_session_allocates_nothing_while_it_leads_an_arm() {
    let motion = random_motion(3, 4);
    let mut echo = Echo { milliseconds: 0, asked: false, packet: [0; FEEDBACK_BYTES] };
    let values: [(usize, &[u8]); 4] = [
        (0, &1440u16.to_le_bytes()),
        (24, &5u64.to_le_bytes()),
        (48, &0x0123_4567_89AB_CDEFu64.to_le_bytes()),
        (1026, &[1]),
    ];
    values.into_iter().for_each(|(at, value)| echo.put(at, value));
    (0..6).for_each(|k| echo.be_at(k, motion.start()[k].to_degrees()));
    let mut link = DobotLink::new(echo, Dialect::V4);
    let mut log = SendLog::new(motion.trajectory().duration());
    let mut session = Session::new(&motion, &SendSettings::new(0.03).expect("a period"), link.now());
    let count = allocations_in(|| drive(&mut session, &mut link, &mut log, || false));
    assert_eq!((session.outcome().fault.as_ref(), count), (None, 0));
    assert!(log.rows().len() > 300 && log.missed() == 0);
}
