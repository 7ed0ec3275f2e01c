//! A tool path on any robot: the arm that the flags name, held where it has a joint too many.

use std::path::Path;

use arcfeed_geometry::PosePath;
use arcfeed_interp::{LockedArm, MotionPath, PathArm, ToolPath};
use arcfeed_kinematics::Joints;
use robot_cr7::{Cr7Error, Job, LengthUnit, PathFile, ProgramTask, Task, butterfly};

use crate::Failure;
use crate::robots::RobotArgs;

/// A command on a tool path.
pub trait OnToolPath {
    /// `warnings` tell what was assumed of the arm.
    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, warnings: Vec<String>) -> Result<(), Failure>;
}

/// Makes the path ready for the robot and hands it on.
pub fn on_tool_path(args: &RobotArgs, job: &Job, file: &PathFile, command: impl OnToolPath) -> Result<(), Failure> {
    if args.is_default() {
        return command.run(Task::of_cr7(job, file)?, Vec::new());
    }
    let robot = args.load()?;
    match robot.joints() {
        6 => {
            let (limits, assumed) = robot.limits::<6>(&job.joints)?;
            let arm = robot.arm::<6>(job.tool).map_err(Cr7Error::from)?;
            command.run(Task::of_six_joints(job, file, arm, &limits, robot.drives::<6>(job)?)?, assumed)
        }
        7 if job.start_near.is_none() && job.start_posture.is_none() => {
            let (limits, assumed) = robot.limits::<7>(&job.joints)?;
            let arm = robot.arm::<7>(job.tool).map_err(Cr7Error::from)?;
            let drives = robot.drives::<7>(job)?;
            let task = Task::new(job, file, &limits, drives, |path| LockedArm::for_path(&arm, path))?;
            let held = held_words(task.arm());
            command.run(task, std::iter::once(held).chain(assumed).collect())
        }
        joints => Err(unsuited(args, joints, job)),
    }
}

/// A command on a program in parts.
pub trait OnProgram {
    /// `warnings` tell what was assumed of the arm.
    fn run<A: PathArm<N> + Clone, const N: usize>(
        self,
        task: ProgramTask<A, N>,
        warnings: Vec<String>,
    ) -> Result<(), Failure>;
}

/// Makes the parts of a program ready for the robot and hands them on.
pub fn on_program(args: &RobotArgs, job: &Job, file: &PathFile, command: impl OnProgram) -> Result<(), Failure> {
    if args.is_default() {
        return command.run(ProgramTask::of_cr7(job, file)?, Vec::new());
    }
    let robot = args.load()?;
    match robot.joints() {
        6 => {
            let (limits, assumed) = robot.limits::<6>(&job.joints)?;
            let arm = robot.arm::<6>(job.tool).map_err(Cr7Error::from)?;
            command.run(ProgramTask::of_six_joints(job, file, arm, &limits, robot.drives::<6>(job)?)?, assumed)
        }
        7 if job.start_near.is_none() && job.start_posture.is_none() => {
            let (limits, assumed) = robot.limits::<7>(&job.joints)?;
            let arm = robot.arm::<7>(job.tool).map_err(Cr7Error::from)?;
            let under = (&limits, robot.drives::<7>(job)?);
            // The joint that is held for the first path is held for all.
            let first = |path: &PosePath| LockedArm::for_path(&arm, path);
            let near = |arm: &LockedArm, path: &PosePath, near: &Joints<7>| {
                Ok(ToolPath::starting_near(arm, path.clone(), near)?.start())
            };
            let task = ProgramTask::new(job, file, under, first, near)?;
            let held = task.arm().map(held_words);
            command.run(task, held.into_iter().chain(assumed).collect())
        }
        joints => Err(unsuited(args, joints, job)),
    }
}

fn held_words(arm: &LockedArm) -> String {
    let (joint, value) = arm.held();
    format!("joint {} is held at {:.3} deg all the way", joint + 1, value.to_degrees())
}

/// The arm cannot follow a path of the tool.
fn unsuited(args: &RobotArgs, joints: usize, job: &Job) -> Failure {
    match joints {
        7 if job.start_near.is_some() || job.start_posture.is_some() => Failure::BadInput(format!(
            "{} is for arms of six joints, and {} has seven: remove the key",
            if job.start_near.is_some() { "start.near_deg" } else { "start.configuration" },
            args.robot
        )),
        n => Failure::Undoable(format!(
            "{} has {n} joints: a tool path with its orientation needs six, or seven of which one is held",
            args.robot
        )),
    }
}

/// The job of a file, or the documented defaults.
pub fn read_job(file: Option<&Path>) -> Result<Job, Failure> {
    file.map_or_else(|| Ok(Job::default()), |file| Ok(Job::read(file)?))
}

/// The path file named, or the embedded butterfly.
pub fn read_path(file: Option<&Path>, unit: Option<&str>, job: &Job) -> Result<PathFile, Failure> {
    let unit = match unit {
        None => None,
        Some(symbol) => Some(LengthUnit::from_symbol(symbol).ok_or_else(|| {
            Failure::BadInput(format!("--unit {symbol}: not a known unit of length: use mm, cm, m or in"))
        })?),
    };
    Ok(match file {
        Some(file) => PathFile::read_for_job(file, unit, job)?,
        None => butterfly()?,
    })
}
