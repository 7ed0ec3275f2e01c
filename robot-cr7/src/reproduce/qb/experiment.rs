//! Huang et al. 2025, Figures 12 to 14, as a simulated experiment: drives with lag, encoders and
//! torque sensors with noise.

use arcfeed_interp::{DriveLag, LimitError};
use arcfeed_kinematics::{Arm, Dynamics, Joints};

use crate::reproduce::{Random, Reproduction};

const PLACE: &str = "Section 5.3, figures 12 to 14: simulated experiment (drives with lag, sensors with noise)";
/// Lag of the drives, s; deviation of the encoders, rad, and of the torque, N m.
const LAG: f64 = 8e-3;
const ENCODER: f64 = 2e-7;
const SENSOR: f64 = 0.1;

/// What the sensors of the simulated arm show.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Time between samples, s.
    pub period: f64,
    /// Velocities by differences of the encoders.
    pub velocity: Vec<Joints<6>>,
    /// Accelerations by second differences.
    pub acceleration: Vec<Joints<6>>,
    /// Torques.
    pub torque: Vec<Joints<6>>,
    /// Limits of the same.
    pub limits: [Joints<6>; 3],
}

impl Experiment {
    /// Runs the setpoints `q` on the drive model; the noise is seeded.
    ///
    /// # Errors
    /// [`LimitError`] for a period that is not above 0.
    pub fn run(arm: &Arm<6>, q: &[Joints<6>], period: f64, limits: [Joints<6>; 3]) -> Result<Self, LimitError> {
        let mut random = Random::new(14);
        let mut drive = DriveLag::<6>::new(q[0], Joints::repeat(LAG), period)?;
        let (mut read, mut true_q) = (Vec::new(), Vec::new());
        for setpoint in q {
            let at = drive.step(setpoint);
            true_q.push(at);
            read.push(at + Joints::from_fn(|_, _| ENCODER * random.normal()));
        }
        let velocity: Vec<Joints<6>> = read.windows(2).map(|w| (w[1] - w[0]) / period).collect();
        let acceleration: Vec<Joints<6>> =
            read.windows(3).map(|w| (w[2] - w[1] * 2.0 + w[0]) / (period * period)).collect();
        let mut torque = Vec::new();
        if let Some(dynamics) = arm.dynamics() {
            for (i, w) in true_q.windows(3).enumerate() {
                let qdd = (w[2] - w[1] * 2.0 + w[0]) / (period * period);
                // Friction follows the motion that the encoders show: a joint that stands trembles.
                let clean = dynamics.torque(&w[1], &velocity[i], &qdd);
                torque.push(clean + Joints::from_fn(|_, _| SENSOR * random.normal()));
            }
        }
        Ok(Self { period, velocity, acceleration, torque, limits })
    }

    /// Adds the rows. Nothing here counts: it is a model, not the paper's arm.
    pub fn judge(&self, r: &mut Reproduction) {
        let share = |all: &[Joints<6>], limit: &Joints<6>| {
            all.iter().map(|x| x.component_div(limit).amax()).fold(0.0, f64::max)
        };
        let rows = [
            ("velocity", share(&self.velocity, &self.limits[0])),
            ("acceleration", share(&self.acceleration, &self.limits[1])),
            ("torque", share(&self.torque, &self.limits[2])),
        ];
        for (what, share) in rows {
            r.information(
                PLACE,
                format!("largest measured {what}, share of its limit"),
                "below 1",
                format!("{share:.3}"),
            );
        }
        let fourth = || self.torque.iter().map(|t| t[3]);
        let (lo, hi) = (fourth().fold(f64::INFINITY, f64::min), fourth().fold(f64::NEG_INFINITY, f64::max));
        r.information(PLACE, "torque of joint 4, which stands, N m", "-6.81 and 6.30", format!("{lo:.2} and {hi:.2}"))
            .fitted()
            .note("the Coulomb friction of the stand-in is 6 N m; its sign follows the noise of the encoder");
    }
}
