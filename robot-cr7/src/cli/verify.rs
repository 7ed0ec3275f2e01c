//! `cr7 verify`: a joint trajectory of any source against the limits of an arm and a job.

use std::path::PathBuf;

use crate::{
    Cr7Error, InputError, Job, JointReport, LimitsHold, NamedColumn, RapidKind, RecordedCheck, RecordedLimits,
    RecordedRows, ReportHead, Robot,
};

use crate::cli::Failure;
use crate::cli::joint_space::for_joints;
use crate::cli::output::show;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;

/// What rounding feigns is told from this part of a limit on.
const BLURRED: f64 = 0.1;
/// What can be blurred.
const BLURRED_NAMES: [&str; 4] = ["joint velocity", "joint acceleration", "joint jerk", "tool speed"];

/// Arguments of `cr7 verify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 verify out/trajectory.csv
  cr7 verify recorded.csv --robot ur5e --job job.toml
  cr7 verify recorded.csv --json | jq '.limits[] | select(.ratio > 1)'

Columns are known by their names, in any order: t_s or t_ms; q1_rad or q1_deg and so on; where there are any, qd1_rad_s or
qd1_deg_s and qdd1_rad_s2 or qdd1_deg_s2. What the digits of the file cannot tell is taken off and told.
Exit code 0: every limit holds. 1: one does not.")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Trajectory (CSV)
    trajectory: PathBuf,
    /// Job file (TOML): limits of the joints, the tool and its highest feed, torque. Without it: the robot's own, of the joints alone
    #[arg(long)]
    job: Option<PathBuf>,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let robot = args.robot.load()?;
    for_joints!(robot, run_with(args, &robot))
}

fn run_with<const N: usize>(args: &Args, robot: &Robot) -> Result<(), Failure> {
    let job = args.job.as_deref().map_or_else(|| Ok(Job::default()), Job::read)?;
    let (joints, mut warnings) = robot.limits::<N>(&job.joints)?;
    let arm = robot.arm::<N>(job.tool).map_err(Cr7Error::from)?;
    let feed = tool_speed(args, &job, &mut warnings);
    let drives = robot.drives::<N>(&job)?;
    let limited = drives.is_some();

    let file = std::fs::File::open(&args.trajectory).map_err(|source| InputError::Read {
        file: args.trajectory.clone(),
        source,
        remedy: "give a trajectory as CSV",
    })?;
    let progress = Progress::new("checking");
    let mut rows = RecordedRows::<_, N>::new(file, &args.trajectory)?;
    same_joints(args, robot, rows.named_columns())?;
    let mut check = RecordedCheck::new(RecordedLimits { arm, joints, drives, feed }, rows.rounding());
    let mut stated = [true; 2];
    for row in rows.by_ref() {
        let row = row?;
        stated = [row.qd.is_some(), row.qdd.is_some()];
        check.see(&row);
    }
    drop(progress);
    let (samples, duration_s) = (check.rows(), check.duration());
    if samples < 2 {
        let words = format!("{}: a trajectory has two rows or more; this one has {samples}", args.trajectory.display());
        return Err(Failure::BadInput(words));
    }
    for (what, stated) in ["velocities", "accelerations"].into_iter().zip(stated) {
        if !stated {
            warnings.push(format!("the file has no {what}: differences of the positions are checked"));
        }
    }
    if limited && stated != [true; 2] {
        warnings.push("torque is not checked: it needs velocities and accelerations".to_owned());
    }
    for (name, blur) in BLURRED_NAMES.into_iter().zip(check.blur()) {
        if blur > BLURRED {
            let percent = 100.0 * blur;
            warnings.push(format!(
                "{name}: {percent:.0} % of the limit can be rounding of the file, which is taken off: write more digits"
            ));
        }
    }
    let ignored: Vec<&str> = rows.ignored().iter().map(String::as_str).filter(|name| !is_own(name)).collect();
    if !ignored.is_empty() {
        warnings.push(format!("columns that are passed over: {}", ignored.join(", ")));
    }
    let (period_s, limits) = (check.period(), check.finish());
    let held = LimitsHold::of(&limits);
    let report = JointReport {
        name: args.trajectory.display().to_string(),
        duration_s,
        samples,
        period_s,
        facts: Vec::new(),
        events: Vec::new(),
        limits,
        warnings,
        files: Vec::new(),
    };
    show(&report, args.json.then(|| ReportHead::new("verify", robot).json(&report)));
    held.map(drop).map_err(|error| Failure::Undoable(error.to_string()))
}

/// Refuses the motion of a robot whose joints have other names.
fn same_joints(args: &Args, robot: &Robot, columns: &[NamedColumn]) -> Result<(), Failure> {
    let own = robot.any().joint_names();
    let Some(wrong) = columns.iter().find(|column| own.get(column.joint) != Some(&column.name)) else { return Ok(()) };
    Err(Failure::BadInput(format!(
        "{}: joint {} is called {:?} in column {}, and that of {} {:?}: the motion is of another robot; give it by --robot",
        args.trajectory.display(),
        wrong.joint + 1,
        wrong.name,
        wrong.column,
        robot.description().name,
        own.get(wrong.joint).map_or("", String::as_str)
    )))
}

/// True for columns of the project's own trajectories that follow from the others.
fn is_own(name: &str) -> bool {
    name.starts_with("jerk") || ["x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"].contains(&name)
}

/// The highest speed of the tool that the job states, m/s, where it holds for the whole motion.
fn tool_speed(args: &Args, job: &Job, warnings: &mut Vec<String>) -> Option<f64> {
    let programs = ["ngc", "nc", "gcode", "cnc", "tap"];
    let extension = job.path_file.as_ref().and_then(|file| file.extension()).map(|e| e.to_ascii_lowercase());
    let is_program = extension.and_then(|e| e.to_str().map(|e| programs.contains(&e))).unwrap_or(false);
    let why = match (args.job.is_some(), is_program, job.rapid.kind) {
        (false, ..) => "without --job the tool is not checked",
        (_, true, _) => "the speed of the tool is not checked: the path of the job is a program with feeds of its own",
        (_, _, RapidKind::Joints) => "the speed of the tool is not checked: rapid moves are motions of the joints",
        _ => return Some(job.rapid.speed.map_or(job.feed.feed, |rapid| rapid.max(job.feed.feed))),
    };
    warnings.push(why.to_owned());
    None
}
