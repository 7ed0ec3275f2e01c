//! `cr7 schedule`: from pose to pose or through joint way-points, under limits of joints, drives and tool.

use std::path::PathBuf;

use arcfeed_interp::SpeedPlanner;
use clap::ValueEnum;
use robot_cr7::plot::{save_picture, shares_picture, speed_picture};
use robot_cr7::{InputError, Robot, ScheduleFile, run_schedule, trajectory_row, write_trajectory};

use crate::Failure;
use crate::joint_space::for_joints;
use crate::output::{say, say_as_is};
use crate::plan::spinner;
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
            let file = ScheduleFile::read(file)?;
            let robot = args.robot.load()?;
            return for_joints!(robot, run_with(args, &file, &robot));
        }
    }
    Ok(())
}

fn run_with<const N: usize>(args: &Args, file: &ScheduleFile, robot: &Robot) -> Result<(), Failure> {
    // Before the work, not after it.
    std::fs::create_dir_all(&args.out).map_err(|source| InputError::Write { file: args.out.clone(), source })?;
    let bar = spinner("scheduling");
    let run = run_schedule::<N>(file, robot, args.planner.into())?;
    let mut report = run.report;

    let trajectory = args.out.join("trajectory.csv");
    write_trajectory(&trajectory, run.setpoints.iter().map(trajectory_row))?;
    report.files.push(trajectory);
    for (name, svg) in [(&run.speed.file, speed_picture(&run.speed)), (&run.shares.file, shares_picture(&run.shares))] {
        let picture = args.out.join(name);
        let svg = svg.map_err(|source| InputError::Write { file: picture.clone(), source })?;
        save_picture(&picture, &svg)?;
        report.files.push(picture);
    }
    let (json, text) = (args.out.join("report.json"), args.out.join("report.txt"));
    report.files.extend([json.clone(), text.clone()]);
    for (path, content) in [(json, format!("{}\n", report.to_json())), (text, report.to_string())] {
        std::fs::write(&path, content).map_err(|source| InputError::Write { file: path.clone(), source })?;
    }
    bar.finish_and_clear();
    if args.json {
        say!("{}", report.to_json());
    } else {
        say_as_is!("{report}");
    }
    Ok(())
}
