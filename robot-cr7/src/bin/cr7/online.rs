//! `cr7 online`: targets and limits that change while the arm moves, cycle by cycle.

use std::path::PathBuf;
use std::time::Instant;

use arcfeed_feedrate::AxisState;
use arcfeed_sync::Synchronisation;
use nalgebra::Isometry3;
use robot_cr7::{Cr7Error, JointReport, OnlineScenario, Robot, ScenarioError, Staging};

use crate::Failure;
use crate::joint_space::{FILES, JointWriter, axes_of, for_joints, row};
use crate::output::{conclude, say_as_is};
use crate::progress::Progress;
use crate::robots::RobotArgs;

/// Arguments of `cr7 online`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 online                               the embedded scenario, which shows every key of the format
  cr7 online --print-example > mine.toml   a file to start from
  cr7 online mine.toml --out mine
  cr7 online mine.toml --json | jq .events")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Scenario file (TOML): start, target, limits and timed changes. Without it: an embedded one
    scenario: Option<PathBuf>,
    /// Print the embedded scenario, with every key explained, and stop
    #[arg(long)]
    print_example: bool,
    /// Folder for the trajectory and the pictures; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    if args.print_example {
        say_as_is!("{}", OnlineScenario::EXAMPLE);
        return Ok(());
    }
    let staging = Staging::new(&args.out, &FILES, args.scenario.as_deref().as_slice())?;
    let robot = args.robot.load()?;
    for_joints!(robot, run_with(args, &robot, staging))
}

fn run_with<const N: usize>(args: &Args, robot: &Robot, mut staging: Staging) -> Result<(), Failure> {
    let scenario = match &args.scenario {
        Some(file) => OnlineScenario::read(file)?,
        None => OnlineScenario::parse(OnlineScenario::EXAMPLE, "online.toml".as_ref())?,
    };
    let name = args.scenario.as_ref().map_or("online.toml".to_owned(), |file| file.display().to_string());
    let (limits, assumed) = robot.limits::<N>(&scenario.joints)?;
    let arm = robot.arm::<N>(Isometry3::identity()).map_err(Cr7Error::from)?;
    staging.clear()?;

    let progress = Progress::new("simulating");
    let begin = Instant::now();
    let run = scenario.run(&limits).map_err(|e| match e {
        ScenarioError::Input(e) => Failure::BadInput(e.to_string()),
        other => Failure::Undoable(other.to_string()),
    })?;
    let computing = begin.elapsed();

    progress.step("checking and writing");
    let mut writer = JointWriter::new(&mut staging, &limits, run.samples.len())?;
    for (t, state, rates) in &run.samples {
        writer.write(&row(&arm, *t, state), scenario.period, rates)?;
    }
    if let (Some((_, first, _)), Some((t, last, _))) = (run.samples.first(), run.samples.last()) {
        writer.see_end(0.0, &axes_of(first), &run.start);
        let wanted = passed(&run.target, &axes_of(last), scenario.synchronisation);
        writer.see_end(*t, &axes_of(last), &wanted);
    }
    let duration = writer.last().map_or(0.0, |r| r.t);
    let samples = writer.rows();
    let marks: Vec<f64> = run.events.iter().map(|e| e.t_s).filter(|&t| t > 0.0).collect();
    let limits = writer.finish(&name, &marks)?;
    let per_cycle = format!("{:.2} us a cycle", computing.as_secs_f64() * 1e6 / samples as f64);
    let facts = vec![("computing".to_owned(), per_cycle)];
    let report = JointReport {
        name: format!("online motion of {name}"),
        duration_s: duration,
        samples,
        period_s: scenario.period,
        facts,
        events: run.events,
        limits,
        warnings: assumed,
        files: Vec::new(),
    };
    drop(progress);
    conclude(report, staging, args.json, "change the target, the limits or the mode")
}

/// The states of the joints at the end, when they are at `last`.
///
/// Joints that arrive one by one go on with the velocity of their target until the last one arrives.
fn passed<const N: usize>(
    target: &[AxisState; N],
    last: &[AxisState; N],
    synchronisation: Synchronisation,
) -> [AxisState; N] {
    std::array::from_fn(|k| {
        let (target, last) = (target[k], last[k]);
        let ahead = (last.p - target.p) * target.v > 0.0;
        match synchronisation {
            Synchronisation::None if ahead => AxisState::new(last.p, target.v, 0.0),
            _ => target,
        }
    })
}
