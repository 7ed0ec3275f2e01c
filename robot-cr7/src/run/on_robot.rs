//! A path on a robot that is known only when the program runs.

use arcfeed_geometry::PosePath;
use arcfeed_interp::{LockedArm, MotionPath, PathArm, ToolPath};
use arcfeed_kinematics::Joints;

use super::error::Cr7Error;
use super::program_task::ProgramTask;
use super::robot::Robot;
use super::task::Task;
use crate::input::job::Job;
use crate::input::path_file::PathFile;

/// What is done with a tool path, whatever the arm.
pub trait OnToolPath {
    /// The result.
    type Output;
    /// The error.
    type Error: From<Cr7Error>;

    /// Does it. `warnings` tell what was assumed of the arm.
    ///
    /// # Errors
    /// Its own.
    fn run<A: PathArm<N>, const N: usize>(
        self,
        task: Task<A, N>,
        warnings: Vec<String>,
    ) -> Result<Self::Output, Self::Error>;
}

/// What is done with a program in parts, whatever the arm.
pub trait OnProgram {
    /// The result.
    type Output;
    /// The error.
    type Error: From<Cr7Error>;

    /// Does it. `warnings` tell what was assumed of the arm.
    ///
    /// # Errors
    /// Its own.
    fn run<A: PathArm<N> + Clone, const N: usize>(
        self,
        task: ProgramTask<A, N>,
        warnings: Vec<String>,
    ) -> Result<Self::Output, Self::Error>;
}

impl Robot {
    /// Makes the path ready for this robot and hands it on. Of seven joints one is held all the way.
    ///
    /// # Errors
    /// [`Cr7Error`] of [`Task::new`]; [`Cr7Error::Unsuited`] and [`Cr7Error::SixJointsOnly`] by the number of joints; those of `work`.
    pub fn on_tool_path<W: OnToolPath>(&self, job: &Job, file: &PathFile, work: W) -> Result<W::Output, W::Error> {
        if self.is_cr7() {
            return work.run(Task::of_cr7(job, file)?, Vec::new());
        }
        match self.joints() {
            6 => {
                let (limits, assumed) = self.limits::<6>(&job.joints)?;
                let arm = self.arm::<6>(job.tool).map_err(Cr7Error::from)?;
                work.run(Task::of_six_joints(job, file, arm, &limits, self.drives::<6>(job)?)?, assumed)
            }
            7 => {
                self.refuse_start(job)?;
                let (limits, assumed) = self.limits::<7>(&job.joints)?;
                let arm = self.arm::<7>(job.tool).map_err(Cr7Error::from)?;
                let drives = self.drives::<7>(job)?;
                let task = Task::new(job, file, &limits, drives, |path| LockedArm::for_path(&arm, path))?;
                let held = held_words(task.arm());
                work.run(task, std::iter::once(held).chain(assumed).collect())
            }
            _ => Err(self.unsuited().into()),
        }
    }

    /// Makes the parts of a program ready for this robot and hands them on.
    ///
    /// # Errors
    /// As [`Robot::on_tool_path`], of [`ProgramTask::new`].
    pub fn on_program<W: OnProgram>(&self, job: &Job, file: &PathFile, work: W) -> Result<W::Output, W::Error> {
        if self.is_cr7() {
            return work.run(ProgramTask::of_cr7(job, file)?, Vec::new());
        }
        match self.joints() {
            6 => {
                let (limits, assumed) = self.limits::<6>(&job.joints)?;
                let arm = self.arm::<6>(job.tool).map_err(Cr7Error::from)?;
                work.run(ProgramTask::of_six_joints(job, file, arm, &limits, self.drives::<6>(job)?)?, assumed)
            }
            7 => {
                self.refuse_start(job)?;
                let (limits, assumed) = self.limits::<7>(&job.joints)?;
                let arm = self.arm::<7>(job.tool).map_err(Cr7Error::from)?;
                let under = (&limits, self.drives::<7>(job)?);
                // The joint that is held for the first path is held for all.
                let first = |path: &PosePath| LockedArm::for_path(&arm, path);
                let near = |arm: &LockedArm, path: &PosePath, near: &Joints<7>| {
                    Ok(ToolPath::starting_near(arm, path.clone(), near)?.start())
                };
                let task = ProgramTask::new(job, file, under, first, near)?;
                let held = task.arm().map(held_words);
                work.run(task, held.into_iter().chain(assumed).collect())
            }
            _ => Err(self.unsuited().into()),
        }
    }

    /// Refuses the keys of the start that are for arms of six joints.
    fn refuse_start(&self, job: &Job) -> Result<(), Cr7Error> {
        let key = match (&job.start_near, job.start_posture) {
            (Some(_), _) => "start.near_deg",
            (None, Some(_)) => "start.configuration",
            (None, None) => return Ok(()),
        };
        Err(Cr7Error::SixJointsOnly { key, robot: self.description().name.clone() })
    }

    /// The arm cannot follow a path of the tool.
    fn unsuited(&self) -> Cr7Error {
        Cr7Error::Unsuited { robot: self.description().name.clone(), joints: self.joints() }
    }
}

fn held_words(arm: &LockedArm) -> String {
    let (joint, value) = arm.held();
    format!("joint {} is held at {:.3} deg all the way", joint + 1, value.to_degrees())
}
