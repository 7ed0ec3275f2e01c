//! The files of `cr7 plan --format` for ROS 2.

#[cfg(feature = "mcap")]
use std::fs::File;

#[cfg(feature = "mcap")]
use crate::{Cr7Error, RosRecording};
use crate::{Job, RosTrajectory, Staging, TrajectoryRow};
use arcfeed_interp::JointTrajectory;
use arcfeed_kinematics::JointLimits;

use crate::cli::Failure;
use crate::cli::formats::Format;
use crate::cli::plan_args::Args;

/// The files of the command.
pub const FILES: [&str; 3] = ["ros2_trajectory.yaml", "ros2_trajectory.json", "motion.mcap"];

/// The files while they are written.
pub struct RosFiles<const N: usize> {
    #[cfg(feature = "mcap")]
    recording: Option<RosRecording<File, N>>,
}

impl<const N: usize> RosFiles<N> {
    /// Writes the trajectory and begins the recording, as far as these are asked for.
    pub fn new(
        args: &Args,
        job: &Job,
        staging: &mut Staging,
        pieces: Option<&JointTrajectory<N>>,
        limits: &JointLimits<N>,
    ) -> Result<Self, Failure> {
        let none = Self {
            #[cfg(feature = "mcap")]
            recording: None,
        };
        let (Some(pieces), true) = (pieces, args.format.iter().any(Format::is_of_ros)) else { return Ok(none) };
        let robot = args.robot.load()?;
        let message = RosTrajectory::new(pieces, robot.any().joint_names(), limits)
            .map_err(|error| Failure::Undoable(format!("--format: {error}")))?;
        if args.format.contains(&Format::Ros2) {
            staging.write(FILES[0], &message.to_yaml())?;
            staging.write(FILES[1], &(message.to_json() + "\n"))?;
        }
        #[cfg(feature = "mcap")]
        if args.format.contains(&Format::Mcap) {
            let file = staging.create(FILES[2])?;
            let arm = robot.arm::<N>(job.tool).map_err(Cr7Error::from)?;
            let recording = RosRecording::new(file, &message, &robot, arm.chain());
            return Ok(Self { recording: Some(recording.map_err(|source| staging.failed(FILES[2], source))?) });
        }
        #[cfg(not(feature = "mcap"))]
        let _ = job;
        Ok(none)
    }

    /// Adds a sample to the recording.
    pub fn write(&mut self, row: &TrajectoryRow<N>, staging: &Staging) -> Result<(), Failure> {
        #[cfg(feature = "mcap")]
        if let Some(recording) = &mut self.recording {
            recording.write(row).map_err(|source| staging.failed(FILES[2], source))?;
        }
        #[cfg(not(feature = "mcap"))]
        let _ = (row, staging);
        Ok(())
    }

    /// Ends the recording.
    pub fn finish(self, staging: &Staging) -> Result<(), Failure> {
        #[cfg(feature = "mcap")]
        if let Some(recording) = self.recording {
            recording.finish().map_err(|source| staging.failed(FILES[2], source))?;
        }
        #[cfg(not(feature = "mcap"))]
        let _ = staging;
        Ok(())
    }
}
