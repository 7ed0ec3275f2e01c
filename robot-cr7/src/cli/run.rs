//! `cr7 run`: a scenario on a tool path, cycle by cycle.

use std::path::PathBuf;

use crate::plot::run_pictures;
use crate::{Clock, Cr7, Cr7Error, LimitsHold, ReportHead, Robot, RunReport, Scenario, Staging};
use arcfeed_interp::PathArm;
use arcfeed_kinematics::{AnalyticInverse, JointLimits};

use crate::cli::Failure;
use crate::cli::output::{REPORTS, conclude, say_as_is};
use crate::cli::picture_files::PictureArgs;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;

/// Arguments of `cr7 run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 run                                  the embedded scenario: an event, a joint move, the way back
  cr7 run --print-example > mine.toml      a file to start from, with every key explained
  cr7 run --print-example butterfly_live   another embedded one: event, event_middle, butterfly_live
  cr7 run mine.toml --out mine
  cr7 run mine.toml --real-time            every cycle at its time, as a controller would call it
  cr7 run mine.toml --json | jq .excursions")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Scenario file (TOML): path, limits, and what is ordered when. Without it: an embedded one
    scenario: Option<PathBuf>,
    /// Print an embedded scenario and stop
    #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "event")]
    print_example: Option<String>,
    /// Folder for trajectory, pictures and reports; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// Begin every cycle at its time, in place of as soon as possible
    #[arg(long)]
    real_time: bool,
    #[command(flatten)]
    pictures: PictureArgs,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(name) = &args.print_example {
        let text =
            Scenario::ALL.into_iter().find(|(file, _)| *file == name || file.strip_suffix(".toml") == Some(name));
        let names = Scenario::ALL.map(|(file, _)| file).join(", ");
        let (_, text) =
            text.ok_or_else(|| Failure::BadInput(format!("--print-example {name}: the embedded ones are {names}")))?;
        say_as_is!("{text}");
        return Ok(());
    }
    let painter = args.pictures.painter()?;
    let mut staging = Staging::new(&args.out, &FILES, args.scenario.as_deref().as_slice())?;
    staging.reads(args.robot.robot.as_ref())?;
    painter.draw(&mut staging);
    let scenario = match &args.scenario {
        Some(file) => Scenario::read(file)?,
        None => Scenario::parse(Scenario::EXAMPLE, "event.toml".as_ref())?,
    };
    if let Some(path) = scenario.path_file() {
        staging.reads(path)?;
    }
    staging.clear()?;
    let robot = args.robot.load()?;
    if robot.is_cr7() {
        let cr7 = Cr7::of(scenario.job())?;
        return play(args, &robot, staging, &scenario, (cr7.arm(), cr7.limits()), Vec::new());
    }
    if robot.joints() != 6 {
        return Err(Failure::Undoable(format!(
            "{} has {} joints: a scenario on a tool path needs six",
            args.robot.robot,
            robot.joints()
        )));
    }
    let (limits, assumed) = robot.limits::<6>(&scenario.job().joints)?;
    let arm = robot.arm::<6>(scenario.job().tool).map_err(Cr7Error::from)?;
    play(args, &robot, staging, &scenario, (&arm, &limits), assumed)
}

/// The files of the command.
const FILES: [&str; 8] = [
    "trajectory.csv",
    "simulated.csv",
    "tool_path.svg",
    "joints.svg",
    "timeline.svg",
    "feed.svg",
    REPORTS[0],
    REPORTS[1],
];

fn play<A>(
    args: &Args,
    robot: &Robot,
    mut staging: Staging,
    scenario: &Scenario,
    (arm, limits): (&A, &JointLimits<6>),
    assumed: Vec<String>,
) -> Result<(), Failure>
where
    A: PathArm<6> + AnalyticInverse<6>,
{
    let progress = Progress::new("making the path ready");
    let mut stage = scenario.stage(arm, limits)?;
    stage.warn(assumed);
    progress.step("playing");
    let played = stage.play(if args.real_time { Clock::RealTime } else { Clock::Simulated })?;
    progress.step("measuring");
    let report = RunReport::new(&stage, &played);
    if LimitsHold::of(&report.limits).is_ok() {
        progress.step("writing");
        let names = robot.any().joint_names();
        staging.write_trajectory("trajectory.csv", names, played.rows())?;
        staging.write_trajectory("simulated.csv", names, stage.simulated_rows(&played))?;
        for (name, svg) in run_pictures(&stage, &played, &report) {
            staging.write_picture(name, svg)?;
        }
    }
    drop(progress);
    conclude(
        &ReportHead::new("run", robot),
        report,
        staging,
        args.json,
        "lower the feed, or take another path or start",
    )
}
