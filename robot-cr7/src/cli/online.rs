//! `cr7 online`: targets and limits that change while the arm moves, cycle by cycle.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::{
    Cr7Error, JointReport, LimitLine, OnlineFile, OnlineRun, OnlineScenario, ReportHead, Robot, ScenarioError, Staging,
    ToolScenario, tool_lines,
};
use arcfeed_feedrate::AxisState;
use arcfeed_kinematics::{ForwardKinematics, JointLimits};
use arcfeed_sync::Synchronisation;
use nalgebra::Isometry3;

use crate::cli::Failure;
use crate::cli::joint_space::{FILES, JointWriter, axes_of, for_joints, row};
use crate::cli::output::{conclude, say_as_is};
use crate::cli::picture_files::PictureArgs;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;

/// Arguments of `cr7 online`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 online                               the embedded scenario, which shows every key of the format
  cr7 online --print-example > mine.toml   a file to start from
  cr7 online --print-tool-example > tool.toml   one with poses of the tool as targets
  cr7 online mine.toml --out mine
  cr7 online mine.toml --json | jq .events")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Scenario file (TOML): start, target, limits and timed changes, for joints or for the tool. Without it: an embedded one
    scenario: Option<PathBuf>,
    /// Print the embedded scenario, with every key explained, and stop
    #[arg(long)]
    print_example: bool,
    /// Print a scenario with poses of the tool as targets, with every key explained, and stop
    #[arg(long, conflicts_with = "print_example")]
    print_tool_example: bool,
    /// Folder for the trajectory and the pictures; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    pictures: PictureArgs,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    if args.print_example {
        say_as_is!("{}", OnlineScenario::EXAMPLE);
        return Ok(());
    }
    if args.print_tool_example {
        say_as_is!("{}", ToolScenario::EXAMPLE);
        return Ok(());
    }
    let painter = args.pictures.painter()?;
    let mut staging = Staging::new(&args.out, &FILES, args.scenario.as_deref().as_slice())?;
    staging.reads(args.robot.robot.as_ref())?;
    painter.draw(&mut staging);
    let robot = args.robot.load()?;
    let file = match &args.scenario {
        Some(file) => OnlineFile::read(file)?,
        None => OnlineFile::Joints(OnlineScenario::parse(OnlineScenario::EXAMPLE, "online.toml".as_ref())?),
    };
    match (file, robot.joints()) {
        (OnlineFile::Joints(scenario), _) => for_joints!(robot, joint_targets(args, &robot, &scenario, staging)),
        (OnlineFile::Tool(scenario), 6) => tool_targets(args, &robot, &scenario, staging),
        (OnlineFile::Tool(_), n) => Err(Failure::Undoable(format!(
            "{} has {n} joints: targets of the tool need an arm of six joints: take another --robot, or give targets of \
             the joints",
            args.robot.robot
        ))),
    }
}

fn joint_targets<const N: usize>(
    args: &Args,
    robot: &Robot,
    scenario: &OnlineScenario,
    mut staging: Staging,
) -> Result<(), Failure> {
    let (limits, warnings) = robot.limits::<N>(&scenario.settings.joints)?;
    let arm = robot.arm::<N>(Isometry3::identity()).map_err(Cr7Error::from)?;
    staging.clear()?;
    let progress = Progress::new("simulating");
    let begin = Instant::now();
    let run = scenario.run(&limits).map_err(failed)?;
    let simulated = Simulated {
        robot,
        wanted: passed(&run.target, &last(&run), scenario.synchronisation),
        run: &run,
        computing: begin.elapsed(),
        facts: Vec::new(),
        tool: Vec::new(),
        warnings,
        remedy: "change the target, the limits or the mode",
    };
    simulated.write(args, &arm, &limits, scenario.settings.period, staging, progress)
}

fn tool_targets(args: &Args, robot: &Robot, scenario: &ToolScenario, mut staging: Staging) -> Result<(), Failure> {
    let (limits, mut warnings) = robot.limits::<6>(&scenario.settings.joints)?;
    warnings.extend(scenario.warnings.iter().cloned());
    let arm = robot.arm::<6>(scenario.tool).map_err(Cr7Error::from)?;
    staging.clear()?;
    let progress = Progress::new("simulating");
    let begin = Instant::now();
    let run = scenario.run(&arm, &limits).map_err(failed)?;
    let share =
        format!("{:.1} % of the tool's speed at least, so that the joints keep their limits", 100.0 * run.least_share);
    let simulated = Simulated {
        robot,
        // The check of the tool judges where that is.
        wanted: last(&run.joints).map(|axis| AxisState::rest(axis.p)),
        run: &run.joints,
        computing: begin.elapsed(),
        facts: vec![("tool".to_owned(), share)],
        tool: tool_lines(&arm, &run),
        warnings,
        remedy: "change the target, or the limits of the tool",
    };
    simulated.write(args, &arm, &limits, scenario.settings.period, staging, progress)
}

/// The states of the joints at the end.
fn last<const N: usize>(run: &OnlineRun<N>) -> [AxisState; N] {
    run.samples.last().map_or(run.start, |(_, state, _)| axes_of(state))
}

fn failed(error: ScenarioError) -> Failure {
    match error {
        ScenarioError::Input(e) => Failure::BadInput(e.to_string()),
        other => Failure::Undoable(other.to_string()),
    }
}

/// A motion on its way to files and a report.
struct Simulated<'a, const N: usize> {
    robot: &'a Robot,
    run: &'a OnlineRun<N>,
    computing: Duration,
    facts: Vec<(String, String)>,
    /// What the check of the tool found.
    tool: Vec<LimitLine>,
    warnings: Vec<String>,
    /// The states in which the joints have to end.
    wanted: [AxisState; N],
    remedy: &'static str,
}

impl<const N: usize> Simulated<'_, N> {
    fn write<A: ForwardKinematics<N>>(
        self,
        args: &Args,
        arm: &A,
        limits: &JointLimits<N>,
        period: f64,
        mut staging: Staging,
        progress: Progress,
    ) -> Result<(), Failure> {
        let run = self.run;
        let name = args.scenario.as_ref().map_or("online.toml".to_owned(), |file| file.display().to_string());
        progress.step("checking and writing");
        let mut writer = JointWriter::new(&mut staging, self.robot, limits, run.samples.len())?;
        for (t, state, rates) in &run.samples {
            writer.write(&row(arm, *t, state), period, rates)?;
        }
        if let (Some((_, first, _)), Some((t, last, _))) = (run.samples.first(), run.samples.last()) {
            writer.see_end(0.0, &axes_of(first), &run.start);
            writer.see_end(*t, &axes_of(last), &self.wanted);
        }
        let duration = writer.last().map_or(0.0, |r| r.t);
        let samples = writer.rows();
        let marks: Vec<f64> = run.events.iter().map(|e| e.t_s).filter(|&t| t > 0.0).collect();
        let mut limits = writer.finish(&name, &marks)?;
        limits.extend(self.tool);
        let per_cycle = format!("{:.2} us a cycle", self.computing.as_secs_f64() * 1e6 / samples as f64);
        let mut facts = self.facts;
        facts.push(("computing".to_owned(), per_cycle));
        let report = JointReport {
            name: format!("online motion of {name}"),
            duration_s: duration,
            samples,
            period_s: period,
            facts,
            events: run.events.clone(),
            limits,
            warnings: self.warnings,
            files: Vec::new(),
        };
        drop(progress);
        conclude(&ReportHead::new("online", self.robot), report, staging, args.json, self.remedy)
    }
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
