//! `cr7 verify`: a joint trajectory of any source against the limits of an arm and a job.

use std::path::PathBuf;

use robot_cr7::{
    Cr7Error, InputError, Job, JointReport, LimitsHold, RecordedCheck, RecordedLimits, RecordedRows, Robot,
};

use crate::Failure;
use crate::joint_space::for_joints;
use crate::output::show;
use crate::progress::Progress;
use crate::robots::RobotArgs;

/// Jerk that rounding feigns is told from this part of its limit on.
const BLURRED: f64 = 0.1;

/// Arguments of `cr7 verify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 verify out/trajectory.csv
  cr7 verify recorded.csv --robot ur5e --job job.toml
  cr7 verify recorded.csv --json | jq '.limits[] | select(.ratio > 1)'

Columns are known by their names, in any order: t_s or t_ms; q1_rad or q1_deg and so on; where there are any, qd1_rad_s or
qd1_deg_s and qdd1_rad_s2 or qdd1_deg_s2. Without velocities and accelerations the differences of the positions are checked.
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
    let feed = args.job.is_some().then_some(job.feed.feed);
    let drives = robot.drives::<N>(&job)?;
    let limited = drives.is_some();
    let mut check = RecordedCheck::new(RecordedLimits { arm, joints, drives, feed });

    let file = std::fs::File::open(&args.trajectory).map_err(|source| InputError::Read {
        file: args.trajectory.clone(),
        source,
        remedy: "give a trajectory as CSV",
    })?;
    let progress = Progress::new("checking");
    let mut rows = RecordedRows::<_, N>::new(file, &args.trajectory)?;
    let mut with_rates = true;
    for row in rows.by_ref() {
        let row = row?;
        with_rates = row.qd.is_some() && row.qdd.is_some();
        check.see(&row);
    }
    drop(progress);
    if check.rows() < 2 {
        let words =
            format!("{}: a trajectory has two rows or more; this one has {}", args.trajectory.display(), check.rows());
        return Err(Failure::BadInput(words));
    }
    let (duration_s, samples, blur) = (check.end(), check.rows(), check.blur());
    if !with_rates {
        warnings
            .push("the file has no velocities and accelerations: differences of the positions are checked".to_owned());
        if limited {
            warnings.push("torque is not checked: it needs velocities and accelerations".to_owned());
        }
    }
    if blur > BLURRED {
        warnings.push(format!(
            "positions are rounded so coarsely that {:.0} % of the jerk limit can be rounding, which is taken off: write more digits",
            100.0 * blur
        ));
    }
    if args.job.is_none() {
        warnings.push("without --job the tool is not checked".to_owned());
    }
    let limits = check.finish();
    let held = LimitsHold::of(&limits);
    let report = JointReport {
        name: args.trajectory.display().to_string(),
        duration_s,
        samples,
        period_s: duration_s / (samples - 1) as f64,
        facts: Vec::new(),
        events: Vec::new(),
        limits,
        warnings,
        files: Vec::new(),
    };
    show(&report, args.json.then(|| report.to_json()));
    held.map(drop).map_err(|error| Failure::Undoable(error.to_string()))
}
