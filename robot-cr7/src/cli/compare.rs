//! `cr7 compare`: every planner on one job.

use std::path::PathBuf;

use crate::plot::{compare_picture, save_picture};
use crate::{InputError, OnToolPath, ReportHead, Task, compare};
use arcfeed_interp::PathArm;

use crate::cli::Failure;
use crate::cli::output::show;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;
use crate::cli::tool_path::{read_job, read_path};

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
    let job = read_job(args.job.as_deref())?;
    let file = read_path(job.path_file.as_deref(), None, &job)?;
    std::fs::create_dir_all(&args.out).map_err(|source| InputError::Write { file: args.out.clone(), source })?;
    let robot = args.robot.load()?;
    robot.on_tool_path(&job, &file, Compare { args, head: ReportHead::new("compare", &robot) })
}

struct Compare<'a> {
    args: &'a Args,
    head: ReportHead,
}

impl OnToolPath for Compare<'_> {
    type Output = ();
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, warnings: Vec<String>) -> Result<(), Failure> {
        let args = self.args;
        let progress = Progress::new("joint path");
        let mut comparison = compare(&task, |planner| progress.step(planner))?;
        progress.step("drawing");
        let picture = args.out.join("compare.svg");
        let svg = compare_picture(&comparison).map_err(|source| InputError::Write { file: picture.clone(), source })?;
        save_picture(&picture, &svg)?;
        comparison.files.push(picture);
        comparison.warnings.extend(warnings);
        drop(progress);
        show(&comparison, args.json.then(|| self.head.json(&comparison)));
        Ok(())
    }
}
