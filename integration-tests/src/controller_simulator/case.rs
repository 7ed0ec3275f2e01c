//! Motions, and what goes wrong on the way.

use arcfeed_interp::JointTrajectory;
use arcfeed_kinematics::{JointLimits, Joints};
use arcfeed_testing::Random;
use robot_cr7::Robot;
use robot_cr7::controller::{VerifiedMotion, lead_in};

use super::controller::Version;
use super::disturbance::Disturbance;

/// The period of the setpoints, s.
pub(super) const PERIOD: f64 = 0.03;

/// The limits of the CR7 that the project assumes.
///
/// # Panics
/// Never: the robot is built in.
pub fn cr7_limits() -> JointLimits<6> {
    let robot = Robot::load("cr7", None, None).expect("a built-in robot");
    robot.limits::<6>(&Default::default()).expect("six joints").0
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
            Disturbance::Overtaken(time),
            Disturbance::ForeignReply,
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

    /// False where a fault is noticed once the motion shows it, or once the stop is answered.
    pub fn shows_at_once(&self) -> bool {
        match self.fault {
            Disturbance::Stuck(_) | Disturbance::Forgotten(_) | Disturbance::Deaf => false,
            // Setpoints are not answered there.
            Disturbance::ForeignReply => self.version == Version::Four,
            _ => true,
        }
    }
}
