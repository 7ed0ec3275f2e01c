//! `cr7 advise`: what each limit costs.

use std::path::PathBuf;

use crate::{Advice, OnToolPath, ReportHead, Task};
use arcfeed_interp::PathArm;

use crate::cli::Failure;
use crate::cli::output::show;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;
use crate::cli::tool_path::{read_job, read_path};

/// Arguments of `cr7 advise`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 advise                               the embedded butterfly
  cr7 advise job.toml --robot ur5e
  cr7 advise job.toml --json | jq '.costs[0]'")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Job file (TOML). Without it: documented defaults and the embedded butterfly
    job: Option<PathBuf>,
    /// Print one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let job = read_job(args.job.as_deref())?;
    let file = read_path(job.path_file.as_deref(), None, &job)?;
    let robot = args.robot.load()?;
    robot.on_tool_path(&job, &file, Advise { json: args.json, head: ReportHead::new("advise", &robot) })
}

struct Advise {
    json: bool,
    head: ReportHead,
}

impl OnToolPath for Advise {
    type Output = ();
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, assumed: Vec<String>) -> Result<(), Failure> {
        let progress = Progress::new("planning");
        let mut advice = Advice::new(&task, |limit| progress.step(limit))?;
        advice.warnings.extend(assumed);
        drop(progress);
        show(&advice, self.json.then(|| self.head.json(&advice)));
        Ok(())
    }
}
