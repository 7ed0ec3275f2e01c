//! `cr7 send` against a simulated controller: an arm is led or stopped, whatever goes wrong.

use arcfeed_interp::{Command, JointTrajectory};
use arcfeed_kinematics::Joints;
use arcfeed_testing::allocations_in;
use integration_tests::controller_simulator::{
    ArmLimits, Case, Disturbance, InProcess, Operator, SCENARIOS, SimulatedArm, SimulatedController, Version,
    cr7_limits, long_motion, on_stage, random_motion,
};
use robot_cr7::controller::{
    Channel, Dialect, DobotLink, FEEDBACK_BYTES, Fault, JointStream, LinkError, LiveSetpoints, NextSetpoint, SendLog,
    SendSettings, Session, SetpointSource, VerifiedMotion, Wire, drive, lead_in,
};
use robot_cr7::{Clock, Stage};

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

/// Scenarios that are planned while the arm moves: without a fault they are those that `cr7 run` plays.
#[test]
fn live_scenarios_are_led_to_their_end() {
    for index in 0..SCENARIOS {
        on_stage(index, |stage| {
            let played = stage.play(Clock::Simulated).expect("it ends");
            let cycles = played.cycles();
            let every = (0.03 / stage.live().period()).round() as usize;
            let place =
                |i: usize| if i == 0 { played.start().q } else { cycles[(i * every).min(cycles.len()) - 1].setpoint.q };
            let expected: Vec<_> = (0..=cycles.len().div_ceil(every)).map(place).collect();
            for (version, jitter) in [(Version::Three, 8), (Version::Four, 0)] {
                let case = Case { version, fault: Disturbance::None, fault_at: 0, jitter, off: true, seed: 7 };
                let source = LiveSetpoints::new(stage, 0.03).expect("a period of whole cycles");
                let judged = case.run_source(source, &expected).unwrap_or_else(|words| panic!("{index}: {words}"));
                assert_eq!((judged.outcome.sent, judged.outcome.setpoints), (expected.len(), expected.len()));
                assert!(judged.outcome.off.1 > 1e-3, "it moved");
            }
        });
    }
}

/// While an operator holds the arm it stands, whatever events are due, and the scenario goes on afterwards as if nothing had been.
#[test]
fn a_hold_of_the_operator_outlasts_the_events() {
    for index in 0..SCENARIOS {
        on_stage(index, |stage| {
            let seconds = stage.play(Clock::Simulated).expect("it ends").cycles().last().expect("cycles").setpoint.t;
            let alone = Operator::default().setpoints(stage).expect("it ends");
            for part in 1..16 {
                let at = seconds * f64::from(part) / 16.0;
                let held = Operator::new(vec![(at, Command::Hold), (at + 4.0, Command::Resume)]);
                let setpoints = held.setpoints(stage).expect("it ends");
                // It takes up to a second to stand.
                let [from, to] = [at + 1.0, at + 4.0].map(|t| (t / 0.03) as usize + 1);
                let stands =
                    setpoints[from..to.min(setpoints.len())].iter().all(|q| (q - setpoints[from]).amax() < 1e-9);
                assert!(stands, "{index}: held at {at} s, and it moves");
                assert!((setpoints[setpoints.len() - 1] - alone[alone.len() - 1]).amax() < 1e-9, "{index}: {at}");
                assert!(setpoints.len() > alone.len() + 90, "{index}: {at}");
            }
        });
    }
}

/// As for certified motions, while an operator overrides and holds; the example `soak_controller` runs any number of them.
#[test]
fn random_faults_in_live_scenarios_end_in_a_stop() {
    let (mut stopped, mut arrived) = (0, 0);
    for index in 0..SCENARIOS {
        on_stage(index, |stage| {
            let seconds = 1.2 * stage.live().curve().duration();
            for seed in 1..=(300.0 / seconds) as u64 {
                let operator = Operator::random(seed, seconds);
                let case = Case::random(1000 * index as u64 + seed, seconds);
                let judged = case.run_live(stage, &operator);
                let judged = judged.unwrap_or_else(|words| panic!("{index}: {words}: {case:?}, {operator:?}"));
                let ended = judged.outcome.fault.is_some();
                (stopped, arrived) = (stopped + usize::from(ended), arrived + usize::from(!ended));
            }
        });
    }
    assert!(stopped > 40 && arrived > 5, "{stopped} {arrived}");
}

/// One session leads the arm to the start and along the scenario; a stop on the way there ends it.
#[test]
fn the_way_to_a_scenario_is_led_in_its_session() {
    on_stage(0, |stage| {
        let live = || LiveSetpoints::new(stage, 0.03).expect("a period of whole cycles");
        let start = live().start();
        let rest = JointTrajectory::resting(&start, 0.1).expect("a rest");
        let rest = VerifiedMotion::new(rest, stage.live().joints()).expect("within the range");
        let way = lead_in(&rest, &(start + Joints::repeat(0.05))).expect("a way");
        let mut expected: Vec<_> = (0..(&way).count(0.03)).map(|i| way.trajectory().at(i as f64 * 0.03).q).collect();
        let on_the_way = expected.len();
        expected.extend(Operator::default().setpoints(stage).expect("it ends"));
        let case =
            Case { version: Version::Four, fault: Disturbance::None, fault_at: 0, jitter: 0, off: false, seed: 1 };
        let judged = case.run_source(live().with_way(&way), &expected).expect("it arrives");
        assert_eq!((judged.outcome.sent, judged.outcome.setpoints), (expected.len(), expected.len()));

        for order in [Command::Stop, Command::Hold] {
            let mut asked = 0;
            let source = live().with_way(&way).with_operator(|_| {
                asked += 1;
                if asked == on_the_way / 2 { order } else { Command::None }
            });
            let words = case.run_source(source, &expected).expect_err("it is stopped");
            assert!(words.contains("for another reason: Interrupted"), "{words}");
            assert_eq!(asked, on_the_way / 2, "nobody is asked after that");
        }
    });
}

#[test]
fn a_period_of_setpoints_is_a_whole_number_of_cycles() {
    on_stage(0, |stage| {
        let error = LiveSetpoints::new(stage, 1.5 * stage.live().period()).err().expect("no whole number");
        assert!(error.to_string().contains("sampling.period_ms"), "{error}");
    });
}

/// A source whose setpoint 100 is wrong by some degrees in one joint.
struct Wrong<'m> {
    right: &'m VerifiedMotion,
    off: f64,
}

impl SetpointSource for Wrong<'_> {
    fn start(&self) -> Joints<6> {
        self.right.start()
    }

    fn limits(&self) -> &arcfeed_kinematics::JointLimits<6> {
        self.right.limits()
    }

    fn count(&self, period: f64) -> usize {
        self.right.count(period)
    }

    fn setpoint(&mut self, index: usize, period: f64) -> Result<NextSetpoint<6>, Fault> {
        let mut next = self.right.setpoint(index, period)?;
        if index == 100 {
            next.q[3] += self.off;
        }
        Ok(next)
    }
}

#[test]
fn a_setpoint_beyond_a_limit_is_not_sent_and_ends_in_a_stop() {
    let motion = random_motion(3, 4);
    let expected: Vec<_> = (0..100).map(|i| motion.trajectory().at(f64::from(i) * 0.03).q).collect();
    for off in [0.02, -0.5, f64::NAN] {
        let case =
            Case { version: Version::Four, fault: Disturbance::None, fault_at: 0, jitter: 0, off: false, seed: 1 };
        // The judge knows no reason for it, and looks at the rest first.
        let words = case.run_source(Wrong { right: &motion, off }, &expected).expect_err("it is stopped");
        assert!(words.contains("for another reason: Unsafe { index: 100,"), "{off}: {words}");
    }
}

#[test]
fn a_live_scenario_allocates_nothing_while_it_leads_an_arm() {
    fn led(stage: &Stage<'_>) {
        let source = LiveSetpoints::new(stage, 0.03).expect("a period of whole cycles");
        let mut link = DobotLink::new(Echo::at(&source.start()), Dialect::V4);
        let mut log = SendLog::new(60.0);
        let mut session = Session::new(source, &SendSettings::new(0.03).expect("a period"), link.now());
        let count = allocations_in(|| drive(&mut session, &mut link, &mut log, || false));
        assert_eq!((session.outcome().fault.as_ref(), count), (None, 0));
        assert!(session.outcome().sent > 100 && log.missed() == 0);
    }
    on_stage(0, led);
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
    /// At rest and ready at `q`, rad.
    fn at(q: &Joints<6>) -> Self {
        let mut echo = Self { milliseconds: 0, asked: false, packet: [0; FEEDBACK_BYTES] };
        let values: [(usize, &[u8]); 4] = [
            (0, &1440u16.to_le_bytes()),
            (24, &5u64.to_le_bytes()),
            (48, &0x0123_4567_89AB_CDEFu64.to_le_bytes()),
            (1026, &[1]),
        ];
        values.into_iter().for_each(|(at, value)| echo.put(at, value));
        (0..6).for_each(|k| echo.be_at(k, q[k].to_degrees()));
        echo
    }

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
    let mut link = DobotLink::new(Echo::at(&motion.start()), Dialect::V4);
    let mut log = SendLog::new(motion.trajectory().duration());
    let mut session = Session::new(&motion, &SendSettings::new(0.03).expect("a period"), link.now());
    let count = allocations_in(|| drive(&mut session, &mut link, &mut log, || false));
    assert_eq!((session.outcome().fault.as_ref(), count), (None, 0));
    assert!(log.rows().len() > 300 && log.missed() == 0);
}
