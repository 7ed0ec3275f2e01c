//! The motion that `cr7 send` leads an arm along: read or planned, and certified.

use std::any::Any;
use std::path::Path;

use crate::controller::VerifiedMotion;
use crate::{Cr7Error, OnProgram, OnToolPath, ProgramTask, Robot, Task};
use arcfeed_interp::{JointTrajectory, PathArm};
use arcfeed_kinematics::JointLimits;
use nalgebra::Isometry3;

use crate::cli::Failure;
use crate::cli::send_args::Args;
use crate::cli::tool_path::{read_job, read_path};
use crate::input::error::read_text;

/// Tolerance of planned motions against their plan, rad.
const TOLERANCE: f64 = 1e-6;
/// Share by which a limit of a job may exceed that of the robot, as it is given in degrees.
const ROUNDING: f64 = 1e-9;
/// The key and the value by which a compiled motion is known.
const FORMAT: &str = "joint-trajectory/1";

/// The motion with its name and what was assumed for it.
pub struct SendMotion {
    pub name: String,
    pub motion: VerifiedMotion,
    pub warnings: Vec<String>,
}

/// Reads the motion of a file, or plans the path of a file or a job.
pub fn load(args: &Args, robot: &Robot) -> Result<SendMotion, Failure> {
    let job = read_job(args.job.as_deref())?;
    let (limits, mut warnings) = robot.limits::<6>(&job.joints)?;
    within_its_own(robot, &limits)?;
    let (name, trajectory) = match args.motion.as_deref() {
        Some(file) if is_compiled(file)? => (file.display().to_string(), read(file, robot)?),
        path => {
            let file = read_path(path.or(job.path_file.as_deref()), args.unit.as_deref(), &job)?;
            let compile = Compile { warnings: &mut warnings };
            if ProgramTask::is_needed(&job, &file) {
                robot.on_program(&job, &file, compile)?
            } else {
                robot.on_tool_path(&job, &file, compile)?
            }
        }
    };
    let motion = VerifiedMotion::new(trajectory, &limits).map_err(|e| Failure::Undoable(format!("{name}: {e}")))?;
    Ok(SendMotion { name, motion, warnings })
}

/// Refuses limits beyond those that the description of the robot states: its drives would not follow, or stop the arm.
pub fn within_its_own(robot: &Robot, limits: &JointLimits<6>) -> Result<(), Failure> {
    let arm = robot.arm::<6>(Isometry3::identity()).map_err(Cr7Error::from)?;
    let own = arm.drive_limits();
    let quantities = [
        ("velocity", "deg/s", limits.velocity(), own.velocity),
        ("acceleration", "deg/s^2", limits.acceleration(), own.acceleration),
        ("jerk", "deg/s^3", limits.jerk(), own.jerk),
    ];
    for (quantity, unit, given, own) in quantities {
        let Some(own) = own else { continue };
        if let Some(k) = (0..6).find(|&k| given[k] > own[k] * (1.0 + ROUNDING)) {
            return Err(Failure::BadInput(format!(
                "[joints]: the {quantity} of joint {} may be {:.3} {unit}, and {} of {} has {:.3} {unit}: an arm is led within its own \
                 limits; lower it or leave it out, or give the robot with its true limits by --robot",
                k + 1,
                given[k].to_degrees(),
                robot.any().joint_names()[k],
                robot.description().name,
                own[k].to_degrees()
            )));
        }
    }
    Ok(())
}

fn text(file: &Path) -> Result<String, Failure> {
    let expected = "joint_trajectory.json of `cr7 plan --compile-rad`, a path, or nothing for the path of the job";
    Ok(read_text(file, expected)?)
}

fn is_compiled(file: &Path) -> Result<bool, Failure> {
    if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        return Ok(false);
    }
    let value: Option<serde_json::Value> = serde_json::from_str(&text(file)?).ok();
    Ok(value.and_then(|value| value.get("format")?.as_str().map(|format| format == FORMAT)).unwrap_or(false))
}

/// Reads a compiled motion, whose joints have to be those of the robot.
fn read(file: &Path, robot: &Robot) -> Result<JointTrajectory, Failure> {
    let place = file.display();
    let (trajectory, names) =
        JointTrajectory::from_json(&text(file)?).map_err(|e| Failure::BadInput(format!("{place}: {e}")))?;
    for (k, (name, own)) in names.iter().zip(robot.any().joint_names()).enumerate() {
        if name != own {
            let (joint, robot) = (k + 1, &robot.description().name);
            return Err(Failure::BadInput(format!(
                "{place}: joint {joint} is called {name:?}, and that of {robot} {own:?}: the motion is for another robot; give it by --robot"
            )));
        }
    }
    Ok(trajectory)
}

/// Plans a path as polynomials.
struct Compile<'w> {
    warnings: &'w mut Vec<String>,
}

impl OnToolPath for Compile<'_> {
    type Output = (String, JointTrajectory);
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(
        self,
        task: Task<A, N>,
        _: Vec<String>,
    ) -> Result<(String, JointTrajectory), Failure> {
        let (motion, compiled, _) = task.plan_compiled(TOLERANCE)?;
        self.warnings.extend(motion.warnings().iter().cloned());
        Ok((motion.name().to_owned(), of_six(&compiled)?))
    }
}

impl OnProgram for Compile<'_> {
    type Output = (String, JointTrajectory);
    type Error = Failure;

    fn run<A: PathArm<N> + Clone, const N: usize>(
        self,
        task: ProgramTask<A, N>,
        _: Vec<String>,
    ) -> Result<(String, JointTrajectory), Failure> {
        let (motion, compiled) = task.plan_compiled(TOLERANCE)?;
        self.warnings.extend(motion.warnings().iter().cloned());
        Ok((motion.name().to_owned(), of_six(&compiled.joints)?))
    }
}

/// The motion of an arm of six joints.
fn of_six<const N: usize>(motion: &JointTrajectory<N>) -> Result<JointTrajectory, Failure> {
    let six = (motion as &dyn Any).downcast_ref::<JointTrajectory<6>>().cloned();
    six.ok_or_else(|| Failure::BadInput(format!("the arms of Dobot's CR series have six joints, and this one has {N}")))
}
