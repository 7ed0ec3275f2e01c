//! `cr7 send` against the simulated controller: random faults in fast time, a long motion in fast time, a motion in real time.
//!
//! ```sh
//! cargo run --release -p integration-tests --features controller --example soak_controller -- 1000 1 3600 60
//! ```
//!
//! Arguments: number of faults, first seed, seconds of motion in fast time, seconds in real time over TCP.

use std::collections::BTreeMap;
use std::time::Instant;

use integration_tests::controller_simulator::{
    ArmLimits, Case, Disturbance, Judged, Operator, SCENARIOS, SimulatedArm, SimulatedController, Version, long_motion,
    on_stage, random_motion, serve,
};
use robot_cr7::controller::{Dialect, DobotLink, JointStream, Ports, SendLog, SendSettings, Session, TcpWire, drive};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<f64> = std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    let number = |i: usize, default: f64| arguments.get(i).copied().unwrap_or(default);
    let (count, seed) = (number(0, 40.0) as u64, number(1, 1.0) as u64);
    let mut tally = Tally::default();
    for seed in seed..seed + count {
        let motion = random_motion(seed, 4);
        let case = Case::random(seed, motion.trajectory().duration());
        tally.see(&case, case.run(&motion));
    }
    println!("certified motions: {tally}");
    let mut live = Tally::default();
    for index in 0..SCENARIOS {
        on_stage(index, |stage| {
            let seconds = 1.2 * stage.live().curve().duration();
            for seed in (seed..seed + count).filter(|seed| *seed as usize % SCENARIOS == index) {
                let case = Case::random(seed, seconds);
                live.see(&case, case.run_live(stage, &Operator::random(seed, seconds)));
            }
        });
    }
    println!("live scenarios: {live}");
    let broken = tally.broken + live.broken;
    for version in [Version::Three, Version::Four] {
        long(version, number(2, 20.0))?;
    }
    for version in [Version::Three, Version::Four] {
        if number(3, 0.0) > 0.0 {
            real(version, number(3, 0.0))?;
        }
    }
    if broken > 0 { Err(format!("{broken} promises broken").into()) } else { Ok(()) }
}

/// What became of random faults.
#[derive(Default)]
struct Tally {
    count: usize,
    /// Promises that are broken.
    broken: usize,
    kinds: BTreeMap<String, usize>,
    /// From the fault to rest at most, and in which case; ms.
    worst: (u64, String),
    /// From the stop to rest at most, ms.
    braking: u64,
}

impl Tally {
    fn see(&mut self, case: &Case, result: Result<Judged, String>) {
        self.count += 1;
        let judged = match result {
            Ok(judged) => judged,
            Err(words) => {
                self.broken += 1;
                println!("{words}: {case:?}");
                return;
            }
        };
        let kind = judged.outcome.fault.as_ref().map_or("arrived".to_owned(), |fault| {
            let name = format!("{fault:?}");
            name.split([' ', '(']).next().unwrap_or_default().to_owned()
        });
        *self.kinds.entry(kind).or_default() += 1;
        self.braking = self.braking.max(judged.stop_to_rest);
        if judged.outcome.fault.is_some() && case.shows_at_once() && judged.fault_to_rest > self.worst.0 {
            self.worst = (judged.fault_to_rest, format!("{case:?}"));
        }
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} faults, {} promises broken; {:?}", self.count, self.broken, self.kinds)?;
        let (worst, case) = &self.worst;
        write!(f, "from the fault to rest {worst} ms at most: {case}; from the stop to rest {} ms", self.braking)
    }
}

/// A long motion in fast time.
fn long(version: Version, seconds: f64) -> Result<(), Box<dyn std::error::Error>> {
    let motion = long_motion(7, seconds);
    let case = Case { version, fault: Disturbance::None, fault_at: 0, jitter: 8, off: false, seed: 7 };
    let begin = Instant::now();
    let judged = case.run(&motion)?;
    println!(
        "{version:?}: {:.0} s of motion, {} setpoints in {:.1} s; {:.3} deg behind at most",
        motion.trajectory().duration(),
        judged.outcome.sent,
        begin.elapsed().as_secs_f64(),
        judged.outcome.off.1.to_degrees()
    );
    Ok(())
}

/// A motion in real time over TCP.
fn real(version: Version, seconds: f64) -> Result<(), Box<dyn std::error::Error>> {
    let motion = long_motion(9, seconds);
    let start = std::array::from_fn(|k| motion.start()[k].to_degrees());
    let limits = motion.limits();
    let degrees = |k: usize, q: &arcfeed_kinematics::Joints<6>| q[k].to_degrees();
    let limits = ArmLimits {
        lower: std::array::from_fn(|k| degrees(k, limits.lower())),
        upper: std::array::from_fn(|k| degrees(k, limits.upper())),
        velocity: std::array::from_fn(|k| degrees(k, limits.velocity())),
        acceleration: std::array::from_fn(|k| degrees(k, limits.acceleration())),
    };
    let arm = SimulatedArm::new(start, limits, 0.02);
    let served = serve(SimulatedController::new(version, arm, true, (Disturbance::None, 0)), [0; 3])?;
    let dialect = if version == Version::Three { Dialect::V3 } else { Dialect::V4 };
    let [dashboard, motion_port, feedback] = served.ports;
    let ports = Ports { dashboard, motion: motion_port, feedback };
    let mut link = DobotLink::new(TcpWire::connect([127, 0, 0, 1].into(), ports, dialect)?, dialect);
    let mut log = SendLog::new(motion.trajectory().duration());
    let mut session = Session::new(&motion, &SendSettings::new(0.03)?, link.now());
    drive(&mut session, &mut link, &mut log, || false);
    let (outcome, controller) = (session.outcome(), served.controller());
    println!(
        "{version:?} in real time: {:.1} s, {} of {} setpoints, {}; end: {}; excess {:?}, {} motions after a stop, {} states",
        motion.trajectory().duration(),
        outcome.sent,
        outcome.setpoints,
        outcome.deadlines,
        outcome.fault.as_ref().map_or("arrived".to_owned(), ToString::to_string),
        controller.arm().excess(),
        controller.record().motions_after_stop,
        log.rows().len()
    );
    Ok(())
}
