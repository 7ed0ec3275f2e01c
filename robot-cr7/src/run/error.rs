//! Why a command did not give a motion.

use std::path::PathBuf;

use arcfeed_geometry::GeometryError;
use arcfeed_interp::{CompileError, LiveError, PlanError};
use arcfeed_kinematics::KinematicsError;
use thiserror::Error;

use super::samples::TooManySamples;
use crate::input::error::InputError;

/// Why a job did not become a motion.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Cr7Error {
    /// Something is wrong with an input file: exit code 2 of the command.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The curve of a path file cannot be used: exit code 2.
    #[error("{file}: {source}")]
    Curve {
        /// The file, or the name of an embedded path.
        file: String,
        /// The fault of the curve.
        source: GeometryError,
    },
    /// A tool frame or a joint limit is unusable: exit code 2.
    #[error("the arm of the job: {0}")]
    Arm(#[from] KinematicsError),
    /// A list of joint limits in the job has another length than the arm has joints: exit code 2.
    #[error("{key} of the job lists {given} numbers, but the arm has {joints} joints: give one number, or {joints}")]
    JointCount {
        /// Key of the job.
        key: &'static str,
        /// The number of values that it lists.
        given: usize,
        /// The number of joints.
        joints: usize,
    },
    /// There is no robot of this name: exit code 2.
    #[error("no robot is called \"{name}\": the built-in ones are {}; a file ends in .urdf or .json", known.join(", "))]
    NoSuchRobot {
        /// The name given.
        name: String,
        /// The names there are.
        known: &'static [&'static str],
    },
    /// The file of a robot cannot be used: exit code 2.
    #[error("{file}: {source}")]
    Robot {
        /// The file, or the name of a built-in robot.
        file: String,
        /// The fault.
        source: KinematicsError,
    },
    /// The job has a key of the start that is for arms of six joints, and the arm has seven: exit code 2.
    #[error("{key} is for arms of six joints, and {robot} has seven: remove the key")]
    SixJointsOnly {
        /// Key of the job.
        key: &'static str,
        /// Name of the robot.
        robot: String,
    },
    /// The arm cannot follow a path of the tool: exit code 1.
    #[error("{robot} has {joints} joints: a tool path with its orientation needs six, or seven of which one is held")]
    Unsuited {
        /// Name of the robot.
        robot: String,
        /// The number of its joints.
        joints: usize,
    },
    /// Torques are asked for, but what they take is not known of the robot: exit code 2.
    #[error("torques are asked for, but of {robot} {missing} not known: {remedy}")]
    NoDynamics {
        /// Name of the robot.
        robot: String,
        /// The missing part, with its verb.
        missing: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// A motion between poses does not start or end in the joints asked for: exit code 1.
    #[error("{}{}: {key}: {problem}", file.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    Configuration {
        /// The file.
        file: PathBuf,
        /// Line of the key, if it is known.
        line: Option<usize>,
        /// The key, such as `goal.q_deg`.
        key: &'static str,
        /// The place where the motion leads instead, the reason and the remedy.
        problem: String,
    },
    /// The motion has more samples than are written: exit code 1.
    #[error("{file}: {source}")]
    TooManySamples {
        /// The file.
        file: String,
        /// Their number, and the remedy.
        source: TooManySamples,
    },
    /// The path cannot be planned: exit code 1.
    #[error("{file}: {source}{hint}")]
    Plan {
        /// The file, or the name of an embedded path.
        file: String,
        /// Why, and where on the path.
        source: Box<PlanError>,
        /// A likely cause, starting with a separator; empty when there is none to name.
        hint: String,
    },
    /// A structure shakes more than the job allows, however low the jerk: exit code 1.
    #[error(
        "{file}: vibration of {what}, with {factor} of the joints' jerk still: raise vibration.{key}, or lower feed and accelerations"
    )]
    Shaking {
        /// The file, or the name of an embedded path.
        file: String,
        /// Which structure, its deflection and its limit.
        what: String,
        /// The lowest part of the jerk that was tried.
        factor: String,
        /// The key of the limit.
        key: &'static str,
    },
    /// A limit on residual vibration where none can be kept: exit code 2.
    #[error("{file}: the job limits a residual vibration (residual_limit_mm, residual_limit_deg), and {why}")]
    Residual {
        /// The file, or the name of an embedded path.
        file: String,
        /// Why not, and the way out.
        why: &'static str,
    },
    /// The motion cannot be made of polynomials that keep the limits: exit code 1.
    #[error("{file}, compiled: {source}")]
    Compile {
        /// The file, or the name of an embedded path.
        file: String,
        /// Why.
        source: Box<CompileError>,
    },
    /// The part of a scenario in joint space cannot be set up: exit code 1.
    #[error("{file}: {source}")]
    Live {
        /// The file.
        file: String,
        /// Why.
        source: Box<LiveError>,
    },
}
