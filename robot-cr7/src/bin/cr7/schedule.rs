//! `cr7 schedule`: from pose to pose or through joint way-points, under limits of joints, drives and tool.

use std::path::PathBuf;

use arcfeed_interp::SpeedPlanner;
use clap::ValueEnum;
use robot_cr7::plot::{shares_picture, speed_picture};
use robot_cr7::{LimitsHold, Robot, ScheduleFile, Staging, TrajectoryWriter, run_schedule};

use crate::Failure;
use crate::joint_space::for_joints;
use crate::output::{say, say_as_is};
use crate::progress::Progress;
use crate::robots::RobotArgs;

/// Arguments of `cr7 schedule`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 schedule --print-example > pick.toml     a motion between poses, with every key explained
  cr7 schedule pick.toml --robot kr6_r700 --out pick
  cr7 schedule --print-example=waypoints > way.toml
  cr7 schedule way.toml --planner jerk-limited
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
    #[arg(long, value_enum, default_value = "certified")]
    planner: Planner,
    /// Folder for trajectory, report and pictures; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
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
    /// Every limit at the grid points, fastest to compute
    BothEnds,
    /// The scan of Electronics 2025, 14, 3869, for comparison: it breaks the limits
    Published,
    /// The optimum of the limits at the grid points
    Reachability,
    /// The limits between the grid points too
    Certified,
    /// Those and jerk
    JerkLimited,
}

impl From<Planner> for SpeedPlanner {
    fn from(planner: Planner) -> Self {
        match planner {
            Planner::BothEnds => Self::BothEnds,
            Planner::Published => Self::Published,
            Planner::Reachability => Self::Reachability,
            Planner::Certified => Self::Certified,
            Planner::JerkLimited => Self::JerkLimited,
        }
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    match (args.print_example, &args.file) {
        (Some(Example::Waypoints), _) => say_as_is!("{}", ScheduleFile::WAYPOINTS),
        (Some(Example::Poses), _) | (None, None) => say_as_is!("{}", ScheduleFile::EXAMPLE),
        (None, Some(file)) => {
            let staging = Staging::new(&args.out, &FILES, &[file])?;
            let file = ScheduleFile::read(file)?;
            let robot = args.robot.load()?;
            return for_joints!(robot, run_with(args, &file, &robot, staging));
        }
    }
    Ok(())
}

/// What the command writes.
const FILES: [&str; 5] = ["trajectory.csv", "speed.svg", "joints.svg", "report.json", "report.txt"];

fn run_with<const N: usize>(
    args: &Args,
    file: &ScheduleFile,
    robot: &Robot,
    mut staging: Staging,
) -> Result<(), Failure> {
    staging.clear()?;
    let progress = Progress::new("scheduling");
    let name = FILES[0];
    let mut trajectory = TrajectoryWriter::new(staging.create(name)?).map_err(|e| staging.failed(name, e))?;
    let run = run_schedule::<N>(file, robot, args.planner.into(), |row| {
        trajectory.write(row).map_err(|e| staging.failed(name, e))
    })?;
    trajectory.finish().map_err(|e| staging.failed(name, e))?;
    let mut report = run.report;
    let held = LimitsHold::of(&report.limits);
    if let Ok(hold) = &held {
        for (name, svg) in [(FILES[1], speed_picture(&run.speed)), (FILES[2], shares_picture(&run.shares))] {
            staging.write(name, &svg.map_err(|source| staging.failed(name, source))?)?;
        }
        report.files = FILES.iter().map(|name| args.out.join(name)).collect();
        staging.write("report.json", &(report.to_json() + "\n"))?;
        staging.write("report.txt", &report.to_string())?;
        staging.publish(hold)?;
    }
    drop(progress);
    if args.json {
        say!("{}", report.to_json());
    } else {
        say_as_is!("{report}");
    }
    let remedy = "take --planner certified or jerk-limited, more intervals, or lower start_speed and end_speed";
    held.map(drop).map_err(|error| Failure::exceeded(&error, remedy))
}
