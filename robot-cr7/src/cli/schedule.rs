//! `cr7 schedule`: from pose to pose or through joint way-points, under limits of joints, drives and tool.

use std::path::PathBuf;

use crate::plot::{shares_picture, speed_picture};
use crate::{
    Cr7Error, LimitsHold, ReportHead, Robot, ScheduleFile, ScheduleRun, ScheduleWay, SpeedTask, Staging,
    TrajectoryWriter,
};
use arcfeed_interp::Method;
use clap::ValueEnum;

use crate::cli::Failure;
use crate::cli::joint_space::for_joints;
use crate::cli::output::{REPORTS, conclude, say_as_is};
use crate::cli::picture_files::PictureArgs;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;

/// Arguments of `cr7 schedule`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 schedule --print-example > pick.toml     a motion between poses, with every key explained
  cr7 schedule pick.toml --robot kr6_r700 --out pick
  cr7 schedule --print-example=waypoints > way.toml
  cr7 schedule way.toml --planner reachability
  cr7 schedule pick.toml --robot kr6_r700 --json | jq .binding

The same rotation at both ends makes a pure translation, the same position a pure orientation.")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Schedule file (TOML): start and goal, or way-points; tool, payload, limits
    #[arg(required_unless_present = "print_example")]
    file: Option<PathBuf>,
    /// Print a file to start from, and stop
    #[arg(long, value_enum, num_args = 0..=1, require_equals = true, default_missing_value = "poses")]
    print_example: Option<Example>,
    /// Which planner finds the speed
    #[arg(long, value_enum, default_value = "jerk-limited")]
    planner: Planner,
    /// Folder for trajectory, report and pictures; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    pictures: PictureArgs,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Example {
    /// From pose to pose
    Poses,
    /// Through joint way-points
    Waypoints,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Planner {
    /// The least time under all limits, jerk included
    JerkLimited,
    /// Profiles with continuous acceleration, the limits shared out by fixed parts
    ContinuousAcceleration,
    /// Every limit but those on jerk, forward and backward: fastest to compute
    ForwardBackward,
    /// The optimum of every limit but those on jerk
    Reachability,
    /// The same, kept between the grid points by interpolation
    InterpolatedReachability,
}

impl From<Planner> for Method {
    fn from(planner: Planner) -> Self {
        match planner {
            Planner::JerkLimited => Self::JerkLimited,
            Planner::ContinuousAcceleration => Self::ContinuousAcceleration,
            Planner::ForwardBackward => Self::ForwardBackward,
            Planner::Reachability => Self::Reachability,
            Planner::InterpolatedReachability => Self::InterpolatedReachability,
        }
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    match (args.print_example, &args.file) {
        (Some(Example::Waypoints), _) => say_as_is!("{}", ScheduleFile::WAYPOINTS),
        (Some(Example::Poses), _) | (None, None) => say_as_is!("{}", ScheduleFile::EXAMPLE),
        (None, Some(file)) => {
            let painter = args.pictures.painter()?;
            let mut staging = Staging::new(&args.out, &FILES, &[file])?;
            staging.reads(args.robot.robot.as_ref())?;
            painter.draw(&mut staging);
            let file = ScheduleFile::read(file)?;
            let robot = args.robot.load()?;
            return match (&file.way, robot.joints()) {
                (ScheduleWay::Waypoints(_), _) => for_joints!(robot, way_points(args, &file, &robot, staging)),
                (ScheduleWay::Poses { .. }, 6) => {
                    let arm = robot.arm::<6>(file.tool).map_err(Cr7Error::from)?;
                    finish(args, staging, &robot, &SpeedTask::pose_move(&file, &robot, &arm, args.planner.into())?)
                }
                (ScheduleWay::Poses { .. }, n) => Err(Failure::Undoable(format!(
                    "{} has {n} joints: a motion between poses needs an arm of six joints: take another --robot, or \
                     give joint way-points",
                    args.robot.robot
                ))),
            };
        }
    }
    Ok(())
}

fn way_points<const N: usize>(
    args: &Args,
    file: &ScheduleFile,
    robot: &Robot,
    staging: Staging,
) -> Result<(), Failure> {
    let arm = robot.arm::<N>(file.tool).map_err(Cr7Error::from)?;
    finish(args, staging, robot, &SpeedTask::way_points(file, robot, &arm, args.planner.into())?)
}

/// The files of the command.
const FILES: [&str; 5] = ["trajectory.csv", "speed.svg", "joints.svg", REPORTS[0], REPORTS[1]];

/// Plans the motion and writes all there is to write.
fn finish<const N: usize>(
    args: &Args,
    mut staging: Staging,
    robot: &Robot,
    task: &SpeedTask<'_, N>,
) -> Result<(), Failure> {
    staging.clear()?;
    let progress = Progress::new("scheduling");
    let name = FILES[0];
    let (file, names) = (staging.create(name)?, robot.any().joint_names());
    let mut trajectory = TrajectoryWriter::new(file, names).map_err(|e| staging.failed(name, e))?;
    let run = ScheduleRun::of(task, |row| trajectory.write(row).map_err(|e| staging.failed(name, e)))?;
    trajectory.finish().map_err(|e| staging.failed(name, e))?;
    if LimitsHold::of(&run.report.limits).is_ok() {
        for (name, svg) in [(FILES[1], speed_picture(&run.speed)), (FILES[2], shares_picture(&run.shares))] {
            staging.write_picture(name, svg)?;
        }
    }
    drop(progress);
    let remedy = "take --planner jerk-limited, more intervals, or lower start_speed and end_speed";
    conclude(&ReportHead::new("schedule", robot), run.report, staging, args.json, remedy)
}
