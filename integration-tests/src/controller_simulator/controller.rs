//! The controller: modes, commands, replies, feedback.

use super::arm::SimulatedArm;
use super::command::{Command, Commands};
use super::disturbance::Disturbance;
use super::packet::{Said, packet};

/// Milliseconds between two packets.
const FEEDBACK: u64 = 8;
/// Milliseconds that the drives take to come on.
const ENABLING: u64 = 400;
/// The time between two setpoints of a move of its own, s.
const MOVE_PERIOD: f64 = 0.008;
/// The model number of the CR7.
const CR7: u8 = 7;

/// The version of the protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// Setpoints come on the motion port and are not answered.
    Three,
    /// All commands come on the dashboard port.
    Four,
}

/// What came.
#[derive(Debug, Clone, Default)]
pub struct Record {
    /// All setpoints, degrees.
    pub setpoints: Vec<[f64; 6]>,
    /// Time of the first one, ms.
    pub first_setpoint: Option<u64>,
    /// Number of stops.
    pub stops: usize,
    /// Time of the first one, ms.
    pub first_stop: Option<u64>,
    /// Motion commands after a stop. Connections keep no order between each other: in version 3 only those after the last stop count.
    pub motions_after_stop: usize,
    /// The last time at which the arm moved, ms.
    pub moved: u64,
    /// Orders to switch the drives on.
    pub enables: usize,
    /// Commands that are not known or come on the wrong port.
    pub foreign: Vec<String>,
}

/// A controller with its arm. Time passes by [`SimulatedController::step`].
#[derive(Debug, Clone)]
pub struct SimulatedController {
    version: Version,
    arm: SimulatedArm,
    time: u64,
    enabled: bool,
    enabling: Option<u64>,
    alarms: Vec<i64>,
    other_mode: Option<u64>,
    commands: [Commands; 2],
    replies: Vec<u8>,
    feedback: Vec<u8>,
    fault: Disturbance,
    fault_at: u64,
    last_packet: Option<[u8; 1440]>,
    record: Record,
}

impl SimulatedController {
    /// A controller with its drives on or off. `fault` begins `fault_at` milliseconds after now.
    pub fn new(version: Version, arm: SimulatedArm, enabled: bool, (fault, fault_at): (Disturbance, u64)) -> Self {
        let other_mode = if let Disturbance::ModeAtStart(mode) = fault { Some(mode) } else { None };
        Self {
            version,
            arm,
            time: 0,
            enabled,
            enabling: None,
            alarms: if fault == Disturbance::AlarmAtStart { vec![17] } else { Vec::new() },
            other_mode,
            commands: Default::default(),
            replies: Vec::new(),
            feedback: Vec::new(),
            fault,
            fault_at,
            last_packet: None,
            record: Record::default(),
        }
    }

    /// Time since the start, ms.
    pub fn time(&self) -> u64 {
        self.time
    }

    /// The arm.
    pub fn arm(&self) -> &SimulatedArm {
        &self.arm
    }

    /// What came so far.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// The version of the protocol.
    pub fn version(&self) -> Version {
        self.version
    }

    /// True from the time of the fault on.
    fn faulty(&self) -> bool {
        self.time >= self.fault_at
    }

    /// Text that comes on the dashboard port, or on the motion port of version 3.
    pub fn hear(&mut self, on_motion_port: bool, bytes: &[u8]) {
        for command in self.commands[usize::from(on_motion_port)].push(bytes) {
            self.obey(on_motion_port, &command);
        }
    }

    /// Takes what the dashboard port has to say.
    pub fn take_replies(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.replies)
    }

    /// Takes what the feedback port has to say.
    pub fn take_feedback(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.feedback)
    }

    /// The next millisecond.
    pub fn step(&mut self) {
        self.time += 1;
        if self.enabling.is_some_and(|at| self.time >= at) {
            (self.enabling, self.enabled) = (None, true);
        }
        if self.time == self.fault_at {
            self.begin_fault();
        }
        self.arm.step();
        if self.arm.take_starved() {
            self.alarms.push(30);
        }
        if !self.arm.rests() {
            self.record.moved = self.time;
        }
        if self.time.is_multiple_of(FEEDBACK) {
            self.speak();
        }
    }

    fn begin_fault(&mut self) {
        match self.fault {
            Disturbance::Alarm => self.alarms.push(24),
            Disturbance::Off => self.enabled = false,
            Disturbance::Mode(mode) => self.other_mode = Some(mode),
            Disturbance::Stuck(joint) => return self.arm.block(joint),
            _ => return,
        }
        self.arm.stop();
    }

    fn mode(&self) -> u64 {
        match self.other_mode {
            _ if !self.alarms.is_empty() => 9,
            Some(mode) => mode,
            None if !self.enabled => 4,
            None if self.arm.is_led() => 7,
            None => 5,
        }
    }

    fn speak(&mut self) {
        let (q_target, qd_target) = self.arm.reference();
        let said = Said {
            mode: self.mode(),
            time_ms: self.time,
            enabled: self.enabled,
            alarm: !self.alarms.is_empty(),
            running: self.arm.is_led(),
            robot_type: if self.fault == Disturbance::OtherModel { 10 } else { CR7 },
            q_target: *q_target,
            qd_target: *qd_target,
            q_actual: *self.arm.q(),
            qd_actual: *self.arm.velocity(),
        };
        let mut bytes = packet(&said);
        match self.fault {
            Disturbance::Silent if self.faulty() => return,
            Disturbance::Frozen if self.faulty() => bytes = self.last_packet.unwrap_or(bytes),
            Disturbance::Garbage if self.faulty() => bytes.iter_mut().for_each(|b| *b = b.wrapping_mul(31) ^ 0x5A),
            Disturbance::NotANumber if self.faulty() => bytes[440..448].copy_from_slice(&f64::NAN.to_le_bytes()),
            _ => {}
        }
        self.last_packet = Some(bytes);
        self.feedback.extend(bytes);
    }

    fn obey(&mut self, on_motion_port: bool, command: &Command) {
        let three = self.version == Version::Three;
        let is_motion = ["servoj", "movj", "jointmovj"].contains(&command.name.as_str());
        if is_motion && self.record.stops > 0 {
            self.record.motions_after_stop += 1;
        }
        if is_motion != on_motion_port && three {
            self.record.foreign.push(command.text.clone());
            return;
        }
        let (code, values) = match command.name.as_str() {
            "servoj" => (self.servo(command), String::new()),
            "movj" | "jointmovj" => (self.move_joints(command), String::new()),
            "stop" if !three => (self.stop(), String::new()),
            "resetrobot" if three => (self.stop(), String::new()),
            "enablerobot" => (self.enable(), String::new()),
            "disablerobot" => {
                self.enabled = false;
                self.arm.stop();
                (0, String::new())
            }
            "clearerror" => {
                self.alarms.clear();
                (0, String::new())
            }
            "requestcontrol" if !three => (0, String::new()),
            "robotmode" => (0, self.mode().to_string()),
            "getangle" => (0, self.arm.q().map(|q| format!("{q:.6}")).join(",")),
            "geterrorid" => (0, self.errors()),
            _ => {
                self.record.foreign.push(command.text.clone());
                (-10000, String::new())
            }
        };
        // Version 3 does not answer setpoints.
        if three && command.name == "servoj" {
            return;
        }
        if self.fault == Disturbance::ForeignReply && self.faulty() {
            self.replies.extend(b"Control Mode Is Not Tcp");
        } else {
            self.replies.extend(format!("{code},{{{values}}},{};", command.text).bytes());
        }
    }

    /// The alarms of controller and drives; version 4 puts brackets around all of them.
    fn errors(&self) -> String {
        let alarms = self.alarms.iter().map(i64::to_string).collect::<Vec<_>>().join(",");
        let lists = format!("[{alarms}],[],[],[],[],[],[]");
        if self.version == Version::Four { format!("[{lists}]") } else { lists }
    }

    fn stop(&mut self) -> i32 {
        self.record.stops += 1;
        self.record.first_stop.get_or_insert(self.time);
        if self.version == Version::Three {
            self.record.motions_after_stop = 0;
        }
        self.arm.stop();
        0
    }

    fn enable(&mut self) -> i32 {
        self.record.enables += 1;
        if !self.alarms.is_empty() {
            return -2;
        }
        self.enabling = Some(self.time + ENABLING);
        0
    }

    /// What forbids a motion now.
    fn forbidden(&self) -> Option<i32> {
        if !self.alarms.is_empty() {
            return Some(-2);
        }
        (!self.enabled || self.other_mode.is_some()).then_some(-1)
    }

    fn servo(&mut self, command: &Command) -> i32 {
        let numbers = command.numbers();
        let Some(q) = numbers.first_chunk::<6>() else { return -20000 };
        let period = numbers.get(6).copied().unwrap_or(0.1);
        let least = if self.version == Version::Three { 0.02 } else { 0.004 };
        if !(least..=3600.0).contains(&period) {
            return -60001;
        }
        self.record.setpoints.push(*q);
        self.record.first_setpoint.get_or_insert(self.time);
        if let Some(code) = self.forbidden() {
            return code;
        }
        match &mut self.fault {
            Disturbance::Refused if self.time >= self.fault_at => return -1,
            Disturbance::Forgotten(left) if self.time >= self.fault_at && *left > 0 => *left -= 1,
            _ => self.arm.follow(*q, period),
        }
        0
    }

    /// A joint move of its own: a quintic from where it is, at about a quarter of the limits.
    fn move_joints(&mut self, command: &Command) -> i32 {
        let numbers = command.numbers();
        let Some(&to) = numbers.first_chunk::<6>() else { return -20000 };
        if let Some(code) = self.forbidden() {
            return code;
        }
        let from = *self.arm.q();
        let longest = (0..6).map(|k| (to[k] - from[k]).abs()).fold(0.0, f64::max);
        let duration = (longest / 30.0).max(0.5);
        let count = (duration / MOVE_PERIOD).ceil() as usize;
        for i in 0..=count {
            let x = i as f64 / count as f64;
            let part = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
            self.arm.follow(std::array::from_fn(|k| from[k] + (to[k] - from[k]) * part), MOVE_PERIOD);
        }
        0
    }
}
