//! `cr7 compare`: every planner on one job.

use std::path::PathBuf;

use crate::plot::compare_picture;
use crate::{OnToolPath, ReportHead, Staging, Task, compare};
use arcfeed_interp::PathArm;

use crate::cli::Failure;
use crate::cli::output::show;
use crate::cli::picture_files::PictureArgs;
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
    #[command(flatten)]
    pictures: PictureArgs,
    /// Print one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

/// The file that is written.
const FILES: [&str; 1] = ["compare.svg"];

pub fn run(args: &Args) -> Result<(), Failure> {
    let painter = args.pictures.painter()?;
    let mut staging = Staging::new(&args.out, &FILES, args.job.as_deref().as_slice())?;
    staging.reads(args.robot.robot.as_ref())?;
    painter.draw(&mut staging);
    let job = read_job(args.job.as_deref())?;
    if let Some(path) = &job.path_file {
        staging.reads(path)?;
    }
    let file = read_path(job.path_file.as_deref(), None, &job)?;
    staging.clear()?;
    let robot = args.robot.load()?;
    robot.on_tool_path(&job, &file, Compare { args, staging, head: ReportHead::new("compare", &robot) })
}

struct Compare<'a> {
    args: &'a Args,
    staging: Staging,
    head: ReportHead,
}

impl OnToolPath for Compare<'_> {
    type Output = ();
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, warnings: Vec<String>) -> Result<(), Failure> {
        let Self { args, mut staging, head } = self;
        let progress = Progress::new("joint path");
        let mut comparison = compare(&task, |planner| progress.step(planner))?;
        progress.step("drawing");
        staging.write_picture(FILES[0], compare_picture(&comparison))?;
        comparison.files = staging.files_with(&[]);
        staging.publish_pictures()?;
        comparison.warnings.extend(warnings);
        drop(progress);
        show(&comparison, args.json.then(|| head.json(&comparison)));
        Ok(())
    }
}
