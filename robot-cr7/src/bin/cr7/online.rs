//! `cr7 online`: targets and limits that change while the arm moves, cycle by cycle.

use std::path::PathBuf;
use std::time::Instant;

use robot_cr7::{
    Cr7, InputError, Job, JointReport, OnlineScenario, Rates, ScenarioError, TrajectoryRow, check_joints,
    write_trajectory,
};

use crate::Failure;
use crate::joint_space::{draw, row};

/// Arguments of `cr7 online`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 online                               the embedded scenario, which shows every key of the format
  cr7 online --print-example > mine.toml   a file to start from
  cr7 online mine.toml --out mine
  cr7 online mine.toml --json | jq .events")]
pub struct Args {
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
        print!("{}", OnlineScenario::EXAMPLE);
        return Ok(());
    }
    let scenario = match &args.scenario {
        Some(file) => OnlineScenario::read(file)?,
        None => OnlineScenario::parse(OnlineScenario::EXAMPLE, "online.toml".as_ref())?,
    };
    let name = args.scenario.as_ref().map_or("online.toml".to_owned(), |file| file.display().to_string());
    let cr7 = Cr7::of(&Job { joints: scenario.joints.clone(), ..Job::default() })?;
    std::fs::create_dir_all(&args.out).map_err(|source| InputError::Write { file: args.out.clone(), source })?;

    let begin = Instant::now();
    let run = scenario.run(cr7.limits()).map_err(|e| match e {
        ScenarioError::Input(e) => Failure::BadInput(e.to_string()),
        other => Failure::Undoable(other.to_string()),
    })?;
    let computing = begin.elapsed();

    let rows: Vec<TrajectoryRow<6>> = run.samples.iter().map(|(t, state, _)| row(cr7.arm(), *t, state)).collect();
    let rates = |i: usize| -> Rates<6> { run.samples[i].2 };
    let (lower, upper) = (*cr7.limits().lower(), *cr7.limits().upper());
    let checks = check_joints(&rows, rates, (&lower.into(), &upper.into()));
    let marks: Vec<f64> = run.events.iter().map(|e| e.t_s).filter(|&t| t > 0.0).collect();
    let duration = rows.last().map_or(0.0, |r| r.t);
    let mut report = JointReport {
        name: format!("online motion of {name}"),
        duration_s: duration,
        samples: rows.len(),
        period_s: scenario.period,
        facts: vec![(
            "computing".to_owned(),
            format!("{:.2} us a cycle", computing.as_secs_f64() * 1e6 / rows.len() as f64),
        )],
        events: run.events.clone(),
        limits: checks,
        files: Vec::new(),
    };
    let trajectory = args.out.join("trajectory.csv");
    write_trajectory(&trajectory, rows.iter().copied())?;
    report.files.push(trajectory);
    report.files.extend(draw(&name, &args.out, &rows, cr7.limits(), rates, &marks)?);
    if args.json {
        println!("{}", report.to_json());
    } else {
        print!("{report}");
    }
    Ok(())
}
