//! Any robot by name or file: the arms that come with the library, URDF and JSON.

use std::path::Path;

use arcfeed_kinematics::{
    AnyArm, Arm, ArmDescription, ArmDynamics, Inertial, JointLimits, Joints, KinematicsError, models,
};
use nalgebra::{Isometry3, Matrix3};

use super::cr7::{ACCELERATION, JERK, VELOCITY};
use super::error::Cr7Error;
use super::stand_in;
use crate::input::error::read_text;
use crate::input::job::Job;
use crate::input::joint_values::{JointOverrides, JointValues};

const EXPECTED: &str = "a robot as URDF (.urdf) or JSON (.json)";

/// The load of the drives of an arm, and their limits.
#[derive(Debug, Clone, Copy)]
pub struct Drives<const N: usize = 6> {
    /// Links, rotors, friction and payload.
    pub dynamics: ArmDynamics<N>,
    /// Greatest torques, N m.
    pub torque: Joints<N>,
    /// Torques that they give for ever, N m, where these are known.
    pub rated: Option<Joints<N>>,
}

/// An arm that is not known before the program runs, with what its source says and does not say.
///
/// ```
/// use robot_cr7::Robot;
/// let robot = Robot::load("kr6_r700", None, None)?;
/// assert_eq!(robot.joints(), 6);
/// let (limits, assumed) = robot.limits::<6>(&Default::default())?;
/// // The maker gives no jerk.
/// assert!(limits.jerk()[0] > 0.0 && assumed.len() == 1);
/// # Ok::<(), robot_cr7::Cr7Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Robot {
    description: ArmDescription,
    any: AnyArm,
    origin: Origin,
}

/// Where a robot is described.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Origin {
    BuiltIn,
    Urdf,
    Json,
}

impl Robot {
    /// Names of the built-in robots.
    pub const NAMES: [&'static str; 7] = {
        let [a, b, c, d, e, f] = models::NAMES;
        [a, b, c, d, e, f, stand_in::NAME]
    };

    /// A built-in robot by its name, or the robot of a `.urdf` or `.json` file. Of a URDF with several ends, the links
    /// `base` and `tip` say where the arm begins and ends.
    ///
    /// # Errors
    /// [`Cr7Error::NoSuchRobot`], [`Cr7Error::Robot`] naming the file and the joint or link, [`Cr7Error::Input`].
    pub fn load(name: &str, base: Option<&str>, tip: Option<&str>) -> Result<Self, Cr7Error> {
        let wrong = |source| Cr7Error::Robot { file: name.to_owned(), source };
        let file = Path::new(name);
        let extension = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let description = match extension.as_str() {
            "urdf" => ArmDescription::from_urdf(&read_text(file, EXPECTED)?, base, tip).map_err(wrong)?,
            "json" => ArmDescription::from_json(&read_text(file, EXPECTED)?).map_err(wrong)?,
            _ if name == stand_in::NAME => stand_in::description().map_err(wrong)?,
            _ => models::description(name)
                .ok_or_else(|| Cr7Error::NoSuchRobot { name: name.to_owned(), known: &Self::NAMES })?,
        };
        let any = description.build_any().map_err(wrong)?;
        let origin = match extension.as_str() {
            "urdf" => Origin::Urdf,
            "json" => Origin::Json,
            _ => Origin::BuiltIn,
        };
        Ok(Self { description, any, origin })
    }

    /// True for the arm that this crate is named after.
    pub fn is_cr7(&self) -> bool {
        self.origin == Origin::BuiltIn && self.description.name == "cr7"
    }

    /// Notes of its source.
    pub fn description(&self) -> &ArmDescription {
        &self.description
    }

    /// The arm for any number of joints, without a tool.
    pub fn any(&self) -> &AnyArm {
        &self.any
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.any.joints()
    }

    /// The arm with `tool` (tip in the flange frame, m), if it has `N` joints.
    ///
    /// # Errors
    /// [`KinematicsError::JointCount`], or what is wrong with the tool.
    pub fn arm<const N: usize>(&self, tool: Isometry3<f64>) -> Result<Arm<N>, KinematicsError> {
        let count = KinematicsError::JointCount { given: N, expected: self.joints() };
        self.any.get::<N>().ok_or(count)?.with_tool(tool)
    }

    /// The limits of the joints: those of `job` where it gives them, else the robot's own, else assumed ones, which the second
    /// value names in words, beside what of a URDF is left out.
    ///
    /// # Errors
    /// [`Cr7Error::JointCount`] for a list of another length.
    pub fn limits<const N: usize>(&self, job: &JointOverrides) -> Result<(JointLimits<N>, Vec<String>), Cr7Error> {
        let arm = self.arm::<N>(Isometry3::identity())?;
        let drives = arm.drive_limits();
        // The notes of a URDF say what of the file is left out.
        let mut assumed = if self.origin == Origin::Urdf { self.description.notes.clone() } else { Vec::new() };
        let mut choose = |key, given: &Option<JointValues>, own: Option<Joints<N>>, value: f64| match (given, own) {
            (Some(values), _) => {
                values.of::<N>().map(Joints::from).map_err(|given| Cr7Error::JointCount { key, given, joints: N })
            }
            (None, Some(own)) => Ok(own),
            (None, None) => {
                assumed.push(format!(
                    "{} gives no {key}: {:.0} assumed for all joints; give your own in the job",
                    self.description.name,
                    value.to_degrees()
                ));
                Ok(Joints::repeat(value))
            }
        };
        let velocity = choose("joints.velocity_deg_s", &job.velocity, drives.velocity, VELOCITY)?;
        let acceleration = choose("joints.acceleration_deg_s2", &job.acceleration, drives.acceleration, ACCELERATION)?;
        let jerk = choose("joints.jerk_deg_s3", &job.jerk, drives.jerk, JERK)?;
        Ok((arm.range().with_rates(velocity, acceleration, jerk)?, assumed))
    }

    /// The load and the limits of its drives, payload included; `None` where the job leaves the torque out of account.
    ///
    /// # Errors
    /// [`Cr7Error::NoDynamics`] where the links or the torque limits are not known, [`Cr7Error::JointCount`], or what is wrong with
    /// the payload.
    pub fn drives<const N: usize>(&self, job: &Job) -> Result<Option<Drives<N>>, Cr7Error> {
        let Some(wanted) = &job.torque else { return Ok(None) };
        let arm = self.arm::<N>(Isometry3::identity())?;
        let remedy = "give a robot file that states it, or leave [torque] out of the job";
        let mut dynamics = *arm.dynamics().ok_or_else(|| self.no_dynamics(remedy))?;
        if let Some(payload) = wanted.payload {
            dynamics = dynamics.with_payload(Inertial::new(payload.mass, payload.centre, Matrix3::zeros())?)?;
        }
        let torque = match (&wanted.limit, arm.drive_limits().torque) {
            (Some(values), _) => values.of::<N>().map(Joints::from).map_err(|given| Cr7Error::JointCount {
                key: "torque.limit_nm",
                given,
                joints: N,
            })?,
            (None, Some(own)) => own,
            (None, None) => {
                return Err(Cr7Error::NoDynamics {
                    robot: self.description.name.clone(),
                    missing: "the torque limits are".to_owned(),
                    remedy: "give your own as torque.limit_nm",
                });
            }
        };
        let rated = wanted.rated.as_ref().map(|values| values.of::<N>().map(Joints::from)).transpose();
        let rated = rated.map_err(|given| Cr7Error::JointCount { key: "torque.rated_nm", given, joints: N })?;
        Ok(Some(Drives { dynamics, torque, rated }))
    }

    /// That torques cannot be computed, with the joints behind which the inertia is not known.
    pub(crate) fn no_dynamics(&self, remedy: &'static str) -> Cr7Error {
        let missing = format!("the inertia of the links behind the joints {} is", self.without_inertia());
        Cr7Error::NoDynamics { robot: self.description.name.clone(), missing, remedy }
    }

    /// Names of the joints behind which the inertia is not known.
    pub(crate) fn without_inertia(&self) -> String {
        let unknown = self.description.joints.iter().filter(|joint| joint.inertial.is_none());
        unknown.map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ")
    }
}
