//! `cr7 online`: targets and limits that change while the arm moves, cycle by cycle.

use std::path::PathBuf;
use std::time::Instant;

use nalgebra::Isometry3;
use robot_cr7::{
    Cr7Error, InputError, JointReport, OnlineScenario, Rates, Robot, ScenarioError, TrajectoryRow, check_joints,
    write_trajectory,
};

use crate::Failure;
use crate::joint_space::{draw, for_joints, row};
use crate::output::{say, say_as_is};
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
    let robot = args.robot.load()?;
    for_joints!(robot, run_with(args, &robot))
}

fn run_with<const N: usize>(args: &Args, robot: &Robot) -> Result<(), Failure> {
    let scenario = match &args.scenario {
        Some(file) => OnlineScenario::read(file)?,
        None => OnlineScenario::parse(OnlineScenario::EXAMPLE, "online.toml".as_ref())?,
    };
    let name = args.scenario.as_ref().map_or("online.toml".to_owned(), |file| file.display().to_string());
    let (limits, assumed) = robot.limits::<N>(&scenario.joints)?;
    let arm = robot.arm::<N>(Isometry3::identity()).map_err(Cr7Error::from)?;
    std::fs::create_dir_all(&args.out).map_err(|source| InputError::Write { file: args.out.clone(), source })?;

    let begin = Instant::now();
    let run = scenario.run(&limits).map_err(|e| match e {
        ScenarioError::Input(e) => Failure::BadInput(e.to_string()),
        other => Failure::Undoable(other.to_string()),
    })?;
    let computing = begin.elapsed();

    let rows: Vec<TrajectoryRow<N>> = run.samples.iter().map(|(t, state, _)| row(&arm, *t, state)).collect();
    let rates = |i: usize| -> Rates<N> { run.samples[i].2 };
    let (lower, upper) = (*limits.lower(), *limits.upper());
    let checks = check_joints(&rows, rates, (&lower.into(), &upper.into()));
    let marks: Vec<f64> = run.events.iter().map(|e| e.t_s).filter(|&t| t > 0.0).collect();
    let duration = rows.last().map_or(0.0, |r| r.t);
    let per_cycle = format!("{:.2} us a cycle", computing.as_secs_f64() * 1e6 / rows.len() as f64);
    let mut facts = vec![("computing".to_owned(), per_cycle)];
    facts.extend(assumed.into_iter().map(|text| ("warning".to_owned(), text)));
    let mut report = JointReport {
        name: format!("online motion of {name}"),
        duration_s: duration,
        samples: rows.len(),
        period_s: scenario.period,
        facts,
        events: run.events.clone(),
        limits: checks,
        files: Vec::new(),
    };
    let trajectory = args.out.join("trajectory.csv");
    write_trajectory(&trajectory, rows.iter().copied())?;
    report.files.push(trajectory);
    report.files.extend(draw(&name, &args.out, &rows, &limits, rates, &marks)?);
    if args.json {
        say!("{}", report.to_json());
    } else {
        say_as_is!("{report}");
    }
    Ok(())
}
