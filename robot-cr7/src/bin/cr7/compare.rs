//! `cr7 compare`: every planner on one job.

use std::path::PathBuf;

use arcfeed_interp::{LockedArm, MotionPath, PathArm, ToolPath};
use robot_cr7::plot::{compare_picture, save_picture};
use robot_cr7::{Cr7Error, InputError, Job, Task, compare};

use crate::Failure;
use crate::output::{say, say_as_is};
use crate::plan::read_path;
use crate::progress::Progress;
use crate::robots::RobotArgs;

/// Arguments of `cr7 compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 compare                              the embedded butterfly
  cr7 compare robot-cr7/jobs/butterfly.toml --out butterfly
  cr7 compare job.toml --robot ur5e --json | jq '.entries[] | {planner, duration_s}'")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Job file (TOML). Without it: documented defaults and the embedded butterfly
    job: Option<PathBuf>,
    /// Folder for the picture; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// Print one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let job = match &args.job {
        Some(file) => Job::read(file)?,
        None => Job::default(),
    };
    let file = read_path(job.path_file.as_deref(), None, job.csv_unit)?;
    std::fs::create_dir_all(&args.out).map_err(|source| InputError::Write { file: args.out.clone(), source })?;
    if args.robot.is_default() {
        return finish(args, &Task::of_cr7(&job, &file)?);
    }
    let robot = args.robot.load()?;
    match robot.joints() {
        6 => {
            let (limits, _) = robot.limits::<6>(&job.joints)?;
            let arm = robot.arm::<6>(job.tool).map_err(Cr7Error::from)?;
            let task = Task::new(&job, &file, &limits, robot.drives::<6>(&job)?, |path| {
                let start = ToolPath::new(&arm, path.clone(), limits.range())?.start();
                Ok((arm, start))
            })?;
            finish(args, &task)
        }
        7 => {
            let (limits, _) = robot.limits::<7>(&job.joints)?;
            let arm = robot.arm::<7>(job.tool).map_err(Cr7Error::from)?;
            let drives = robot.drives::<7>(&job)?;
            finish(args, &Task::new(&job, &file, &limits, drives, |path| LockedArm::for_path(&arm, path))?)
        }
        n => Err(Failure::Undoable(format!(
            "{} has {n} joints: a tool path with its orientation needs six, or seven of which one is held",
            args.robot.robot
        ))),
    }
}

fn finish<A: PathArm<N>, const N: usize>(args: &Args, task: &Task<A, N>) -> Result<(), Failure> {
    let progress = Progress::new("joint path");
    let mut comparison = compare(task, |planner| progress.step(planner))?;
    progress.step("drawing");
    let picture = args.out.join("compare.svg");
    let svg = compare_picture(&comparison).map_err(|source| InputError::Write { file: picture.clone(), source })?;
    save_picture(&picture, &svg)?;
    comparison.files.push(picture);
    drop(progress);
    if args.json {
        say!("{}", comparison.to_json());
    } else {
        say_as_is!("{comparison}");
    }
    Ok(())
}
