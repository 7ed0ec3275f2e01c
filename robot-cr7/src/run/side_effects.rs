//! What a motion does besides moving: it shakes structures and heats drives.

use arcfeed_interp::{LimitError, PlanError, Trajectory};
use arcfeed_kinematics::Joints;
use serde::Serialize;

use crate::input::job::VibrationJob;
use crate::text::number;

/// The vibration of a structure that a motion excites.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VibrationLine {
    /// The joint that carries it, from 1; none for the tool.
    pub joint: Option<usize>,
    /// Its natural frequency in Hz.
    pub frequency_hz: f64,
    /// Its damping, as a part of the critical one.
    pub damping: f64,
    /// Largest deflection during the motion, in rad, or in m for the tool.
    pub deflection: f64,
    /// Largest deflection after its end.
    pub residual: f64,
    /// The limit on that, where the job gives one.
    pub residual_limit: Option<f64>,
}

impl VibrationLine {
    /// The vibration of each structure.
    pub(crate) fn all<const N: usize>(
        vibrations: &[VibrationJob],
        trajectory: &Trajectory<'_, N>,
    ) -> Result<Vec<Self>, PlanError> {
        let one = |job: &VibrationJob| {
            let vibration = match job.joint {
                Some(joint) => trajectory.joint_vibration(joint, &job.oscillator),
                None => trajectory.tool_vibration(&job.oscillator),
            }?;
            Ok(Self {
                joint: job.joint.map(|joint| joint + 1),
                frequency_hz: job.oscillator.frequency(),
                damping: job.oscillator.damping(),
                deflection: vibration.deflection,
                residual: vibration.residual,
                residual_limit: job.limit,
            })
        };
        vibrations.iter().map(one).collect()
    }

    /// The largest deflections of each structure over motions one after the other, each from a structure at rest.
    pub(crate) fn most_of<'l>(motions: impl Iterator<Item = &'l [Self]>) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for lines in motions {
            if all.is_empty() {
                all = lines.to_vec();
            }
            for (most, line) in all.iter_mut().zip(lines) {
                most.deflection = most.deflection.max(line.deflection);
                most.residual = most.residual.max(line.residual);
            }
        }
        all
    }

    /// The residual in units of its limit; 0 without one.
    pub(crate) fn used(&self) -> f64 {
        self.residual_limit.map_or(0.0, |limit| self.residual / limit)
    }

    /// True if the residual is within its limit.
    pub fn holds(&self) -> bool {
        self.used() <= 1.0
    }

    /// Where it is, and the frequency.
    pub(crate) fn place(&self) -> String {
        let place = self.joint.map_or("tool".to_owned(), |joint| format!("J{joint}"));
        format!("{place} at {} Hz", number(self.frequency_hz))
    }

    /// A deflection with its unit for people.
    pub(crate) fn shown(&self, deflection: f64) -> String {
        match self.joint {
            Some(_) => format!("{} deg", number(deflection.to_degrees())),
            None => format!("{} mm", number(deflection * 1e3)),
        }
    }

    fn words(&self) -> String {
        let limit = self.residual_limit.map(|limit| format!(" (limit {})", self.shown(limit))).unwrap_or_default();
        let (deflection, residual) = (self.shown(self.deflection), self.shown(self.residual));
        format!("{}: {deflection} on the way, {residual} after the end{limit}", self.place())
    }
}

/// The line of a report on vibrations, and whether all limits hold.
pub(crate) fn vibration_words(lines: &[VibrationLine]) -> Option<(bool, String)> {
    let worst = lines.iter().max_by(|a, b| a.used().total_cmp(&b.used()))?;
    let more = if lines.len() > 1 { format!("; {} more in the JSON report", lines.len() - 1) } else { String::new() };
    Some((worst.holds(), worst.words() + &more))
}

/// The thermal load of one drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThermalLine {
    /// The joint, from 1.
    pub joint: usize,
    /// Root mean square of the torque over the motion, in N m.
    pub rms_torque_nm: f64,
    /// The torque that the drive gives for ever, in N m, where it is known.
    pub rated_nm: Option<f64>,
    /// The part of it that is used.
    pub used: Option<f64>,
}

impl ThermalLine {
    /// The load of each drive; none where no torque is limited.
    pub(crate) fn all<const N: usize>(
        rated: Option<&Joints<N>>,
        trajectory: &Trajectory<'_, N>,
    ) -> Result<Vec<Self>, PlanError> {
        let Some(rms) = trajectory.rms_torque()? else { return Ok(Vec::new()) };
        let one = |joint: usize| {
            let rated = rated.map(|rated| rated[joint]);
            let used = rated.map(|rated| rms[joint] / rated);
            Self { joint: joint + 1, rms_torque_nm: rms[joint], rated_nm: rated, used }
        };
        Ok((0..N).map(one).collect())
    }

    fn words(&self) -> String {
        match self.used {
            Some(used) => format!("J{} {:.1} %", self.joint, 100.0 * used),
            None => format!("J{} {}", self.joint, number(self.rms_torque_nm)),
        }
    }
}

/// The line of a report on the thermal load, and whether it is below what is rated.
pub(crate) fn thermal_words(lines: &[ThermalLine]) -> Option<(bool, String)> {
    let unit = if lines.first()?.used.is_some() { "of rated" } else { "N m" };
    let holds = lines.iter().all(|line| line.used.is_none_or(|used| used <= 1.0));
    let each: Vec<String> = lines.iter().map(ThermalLine::words).collect();
    Some((holds, format!("{} {unit}", each.join(", "))))
}

/// Checks that the arm has the joints of the vibrations.
pub(crate) fn check_joints<const N: usize>(vibrations: &[VibrationJob]) -> Result<(), LimitError> {
    match vibrations.iter().filter_map(|vibration| vibration.joint).find(|joint| *joint >= N) {
        Some(joint) => Err(LimitError::NoSuchJoint { what: "a vibration", joint, joints: N }),
        None => Ok(()),
    }
}

/// What is said of jerk that was lowered for the sake of vibration.
pub(crate) fn calm_words(jerk: f64) -> Option<String> {
    (jerk < 1.0).then(|| format!("the jerk of the joints is {jerk:.3} of its limit, to keep the limits on vibration"))
}
