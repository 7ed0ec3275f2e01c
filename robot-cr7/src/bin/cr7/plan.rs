//! `cr7 plan`: from a path file to trajectory, pictures and report.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use arcfeed_interp::{LockedArm, PathArm, Setpoint, best_start};
use indicatif::{ProgressBar, ProgressStyle};
use robot_cr7::plot::{Along, Bound, JointQuantity, feed_picture, joint_picture, path_picture, save_picture};
use robot_cr7::{
    Cr7Error, InputError, Job, LengthUnit, Motion, PathFile, Task, butterfly, drawn_segments, trajectory_row,
    write_trajectory,
};

use crate::Failure;
use crate::output::{say, say_as_is};
use crate::robots::RobotArgs;

/// Arguments of `cr7 plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 plan                                 the embedded butterfly
  cr7 plan part.json                       a NURBS curve (JSON)
  cr7 plan points.csv --unit mm            a curve fitted to points
  cr7 plan --job robot-cr7/jobs/butterfly.toml --out butterfly
  cr7 plan --robot ur5e                    another robot: a name of `cr7 robots`, a .urdf or a .json file
  cr7 plan --job job.toml --json | jq .duration_s")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Path file: .json (NURBS curve) or .csv (points). Without it: the job's, else an embedded butterfly
    path: Option<PathBuf>,
    /// Job file (TOML): workpiece, tool, feed, limits, tolerance, period. Without it: documented defaults
    #[arg(long)]
    job: Option<PathBuf>,
    /// Folder for the trajectory and the pictures; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// Unit of a .csv file whose header names none: mm, cm, m or in
    #[arg(long)]
    unit: Option<String>,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let job = match &args.job {
        Some(file) => Job::read(file)?,
        None => Job::default(),
    };
    let file = read_path(args.path.as_deref().or(job.path_file.as_deref()), args.unit.as_deref(), job.csv_unit)?;

    // Before the work, not after it.
    std::fs::create_dir_all(&args.out).map_err(|source| InputError::Write { file: args.out.clone(), source })?;

    let bar = spinner("planning");
    if args.robot.is_default() {
        return finish(args, &job, &robot_cr7::plan(&job, &file)?, &bar);
    }
    let robot = args.robot.load()?;
    match robot.joints() {
        6 => {
            let (limits, assumed) = robot.limits::<6>(&job.joints)?;
            let arm = robot.arm::<6>(job.tool).map_err(Cr7Error::from)?;
            let mut motion = Task::new(&job, &file, &limits, robot.drives::<6>(&job)?, |path| {
                let start = best_start(&arm, path, limits.lower(), limits.upper())?;
                Ok((arm, start))
            })?
            .plan()?;
            motion.warn(assumed);
            finish(args, &job, &motion, &bar)
        }
        7 => {
            let (limits, assumed) = robot.limits::<7>(&job.joints)?;
            let arm = robot.arm::<7>(job.tool).map_err(Cr7Error::from)?;
            let drives = robot.drives::<7>(&job)?;
            let mut motion = Task::new(&job, &file, &limits, drives, |path| LockedArm::for_path(&arm, path))?.plan()?;
            let (joint, value) = motion.arm().held();
            motion.warn([format!("joint {} is held at {:.3} deg all the way", joint + 1, value.to_degrees())]);
            motion.warn(assumed);
            finish(args, &job, &motion, &bar)
        }
        n => Err(Failure::Undoable(format!(
            "{} has {n} joints: a tool path with its orientation needs six, or seven of which one is held",
            args.robot.robot
        ))),
    }
}

/// Samples the motion and writes all there is to write.
fn finish<A: PathArm<N>, const N: usize>(
    args: &Args,
    job: &Job,
    motion: &Motion<A, N>,
    bar: &ProgressBar,
) -> Result<(), Failure> {
    bar.set_message("sampling");
    let begin = Instant::now();
    let mut setpoints = Vec::new();
    for setpoint in motion.sampler().map_err(|e| Failure::Undoable(e.to_string()))? {
        setpoints.push(setpoint.map_err(|e| Failure::Undoable(e.to_string()))?);
    }
    let sampling = begin.elapsed();

    bar.set_message("writing");
    let mut report = motion.report(setpoints.len(), sampling);
    let trajectory = args.out.join("trajectory.csv");
    write_trajectory(&trajectory, setpoints.iter().map(trajectory_row))?;
    report.files.push(trajectory);
    for (name, svg) in pictures(motion, job, &setpoints) {
        let svg = svg.map_err(|source| InputError::Write { file: args.out.join(name), source })?;
        let picture = args.out.join(name);
        save_picture(&picture, &svg)?;
        report.files.push(picture);
    }
    bar.finish_and_clear();
    if args.json {
        say!("{}", report.to_json());
    } else {
        say_as_is!("{report}");
    }
    Ok(())
}

/// The path file named, or the embedded butterfly.
pub fn read_path(file: Option<&Path>, unit: Option<&str>, job_unit: Option<LengthUnit>) -> Result<PathFile, Failure> {
    let unit = match unit {
        None => job_unit,
        Some(symbol) => Some(LengthUnit::from_symbol(symbol).ok_or_else(|| {
            Failure::BadInput(format!("--unit {symbol}: not a known unit of length: use mm, cm, m or in"))
        })?),
    };
    Ok(match file {
        Some(file) => PathFile::read(file, unit)?,
        None => butterfly()?,
    })
}

/// A spinner on stderr when that is a terminal; nothing otherwise.
pub fn spinner(message: &'static str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_message(message);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

type Picture = (&'static str, Result<String, std::io::Error>);

fn pictures<A: PathArm<N>, const N: usize>(
    motion: &Motion<A, N>,
    job: &Job,
    setpoints: &[Setpoint<N>],
) -> Vec<Picture> {
    let plan = motion.plan();
    let name = motion.name();
    let segments = drawn_segments(plan, &job.workpiece);
    let by_length: Vec<_> = setpoints.iter().map(|p| (p.s, p.feed)).collect();
    let by_time: Vec<_> = setpoints.iter().map(|p| (p.t, p.feed)).collect();
    // The limit curve is constant on every interval: a step at each grid point.
    let mut limit: Vec<(f64, f64)> = Vec::new();
    for (s, v) in plan.limit_curve() {
        if let Some(&(_, before)) = limit.last() {
            limit.push((s, before));
        }
        limit.push((s, v));
    }
    let limit_by_time: Vec<_> =
        setpoints.iter().map(|p| (p.t, limit[limit.partition_point(|l| l.0 <= p.s).saturating_sub(1)].1)).collect();
    let t: Vec<f64> = setpoints.iter().map(|p| p.t).collect();
    let joints = motion.joint_limits();
    let picture = |quantity, of: fn(&Setpoint<N>) -> [f64; N], limits: [f64; N]| {
        let columns: [Vec<f64>; N] = std::array::from_fn(|k| setpoints.iter().map(|p| of(p)[k]).collect());
        let values: [&[f64]; N] = std::array::from_fn(|k| columns[k].as_slice());
        joint_picture(name, quantity, &t, &values, &limits.map(Bound::Constant), &[])
    };
    vec![
        ("path.svg", path_picture(name, &segments, plan.segmentation().deviations(), plan.chord_tolerance())),
        ("feed.svg", feed_picture(name, Along::Length, &by_length, &limit)),
        ("feed_time.svg", feed_picture(name, Along::Time, &by_time, &limit_by_time)),
        ("joint_velocity.svg", picture(JointQuantity::Velocity, |p| p.qd.into(), (*joints.velocity()).into())),
        (
            "joint_acceleration.svg",
            picture(JointQuantity::Acceleration, |p| p.qdd.into(), (*joints.acceleration()).into()),
        ),
        ("joint_jerk.svg", picture(JointQuantity::Jerk, |p| p.jerk.into(), (*joints.jerk()).into())),
    ]
}
