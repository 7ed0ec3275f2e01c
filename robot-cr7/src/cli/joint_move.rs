//! `cr7 move`: from one joint state to another, all joints together, as fast as their limits allow.

use std::path::PathBuf;
use std::time::Instant;

use crate::{Cr7Error, Job, JointReport, ReportHead, Robot, Staging, few_enough, sample_times};
use arcfeed_feedrate::{AxisState, MotionLaw};
use arcfeed_interp::JointRates;
use arcfeed_kinematics::JointLimits;
use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};

use crate::cli::Failure;
use crate::cli::joint_space::{FILES, JointWriter, axes_of, axis_limits, for_joints, numbers, row};
use crate::cli::output::conclude;
use crate::cli::picture_files::PictureArgs;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;

/// Arguments of `cr7 move`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 move --from-deg 0 -30 90 30 -90 0 --to-deg 60 0 60 30 -90 45
  cr7 move --from-deg 0 -30 90 30 -90 0 --to-deg 60 0 60 30 -90 45 --mode line
  cr7 move --from-deg 0 0 0 0 0 0 --from-deg-s 10 0 0 0 0 0 --to-deg 30 0 0 0 0 0 --to-deg-s 5 0 0 0 0 0 --json")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Joint angles at the start, degrees, one for each joint; the zero is the robot's own (the CR7's: upright)
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q", required = true)]
    from_deg: Vec<f64>,
    /// Joint velocities at the start, degrees per second [default: at rest]
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q")]
    from_deg_s: Option<Vec<f64>>,
    /// Joint accelerations at the start, degrees per second squared [default: 0]
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q")]
    from_deg_s2: Option<Vec<f64>>,
    /// Joint angles at the end, degrees
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q", required = true)]
    to_deg: Vec<f64>,
    /// Joint velocities at the end, degrees per second [default: at rest]
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q")]
    to_deg_s: Option<Vec<f64>>,
    /// Joint accelerations at the end, degrees per second squared [default: 0]
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q")]
    to_deg_s2: Option<Vec<f64>>,
    /// Synchronisation of the joints: all arrive at once, on a straight line where it can be, on a line or not at all,
    /// or each on its own
    #[arg(long, value_enum, default_value = "time")]
    mode: Mode,
    /// The move takes at least this long, seconds
    #[arg(long, default_value_t = 0.0)]
    least_s: f64,
    /// Round the duration up to a whole number of control periods
    #[arg(long)]
    whole_cycles: bool,
    /// Job file (TOML): limits of the joints, tool and control period are taken from it
    #[arg(long)]
    job: Option<PathBuf>,
    /// Folder for the trajectory and the pictures; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    pictures: PictureArgs,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, clap::ValueEnum)]
enum Mode {
    /// All joints arrive at the same time
    Time,
    /// On a straight line in joint space wherever both states lie on one
    Line,
    /// On a straight line or not at all
    ForcedLine,
    /// Every joint as fast as it can
    None,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let painter = args.pictures.painter()?;
    let mut staging = Staging::new(&args.out, &FILES, args.job.as_deref().as_slice())?;
    staging.reads(args.robot.robot.as_ref())?;
    painter.draw(&mut staging);
    let robot = args.robot.load()?;
    for_joints!(robot, run_with(args, &robot, staging))
}

fn run_with<const N: usize>(args: &Args, robot: &Robot, mut staging: Staging) -> Result<(), Failure> {
    let job = args.job.as_deref().map_or_else(|| Ok(Job::default()), Job::read)?;
    let (joint_limits, assumed) = robot.limits::<N>(&job.joints)?;
    let arm = robot.arm::<N>(job.tool).map_err(Cr7Error::from)?;
    let state =
        |flag: &str, q: &[f64], v: &Option<Vec<f64>>, a: &Option<Vec<f64>>| -> Result<[AxisState; N], Failure> {
            let q = numbers::<N>(&format!("{flag}-deg"), q, robot)?;
            let v = numbers::<N>(&format!("{flag}-deg-s"), v.as_deref().unwrap_or(&[0.0; N]), robot)?;
            let a = numbers::<N>(&format!("{flag}-deg-s2"), a.as_deref().unwrap_or(&[0.0; N]), robot)?;
            Ok(std::array::from_fn(|k| AxisState::new(q[k].to_radians(), v[k].to_radians(), a[k].to_radians())))
        };
    let from = state("--from", &args.from_deg, &args.from_deg_s, &args.from_deg_s2)?;
    let to = state("--to", &args.to_deg, &args.to_deg_s, &args.to_deg_s2)?;
    for (flag, state) in [("--from-deg", &from), ("--to-deg", &to)] {
        inside_range(&joint_limits, flag, state)?;
    }
    let options = MotionOptions::new(match args.mode {
        Mode::Time => Synchronisation::Time,
        Mode::Line => Synchronisation::StraightLine,
        Mode::ForcedLine => Synchronisation::ForcedStraight,
        Mode::None => Synchronisation::None,
    });
    let usage = |e: arcfeed_sync::SyncError| Failure::BadInput(e.to_string());
    let mut options = options.with_least_duration(args.least_s).map_err(usage)?;
    if args.whole_cycles || job.whole_cycles {
        options = options.with_cycle(job.period).map_err(usage)?;
    }
    let limits = axis_limits(&joint_limits).map_err(|e| Failure::BadInput(e.to_string()))?;
    staging.clear()?;

    let begin = Instant::now();
    let motion =
        Trajectory::new(&from, &to, &limits, &options).map_err(|e| Failure::Undoable(format!("the move: {e}")))?;
    let computing = begin.elapsed();
    few_enough(motion.duration(), job.period, "the limits in [joints] of the job, or lower --least-s")?;

    let progress = Progress::new("checking and writing");
    let rates = JointRates::from(&joint_limits);
    let times = sample_times(motion.duration(), job.period);
    let mut writer = JointWriter::new(&mut staging, robot, &joint_limits, times.len())?;
    for t in times {
        let before = writer.last().map_or(t, |row| row.t);
        writer.write(&row(&arm, t, &motion.at(t)), t - before, &rates)?;
    }
    writer.see_end(0.0, &axes_of(&motion.at(0.0)), &from);
    let arrivals: [f64; N] = std::array::from_fn(|k| motion.axes()[k].duration());
    let arrived = std::array::from_fn(|k| axes_of(&motion.at(arrivals[k]))[k]);
    writer.see_end(motion.duration(), &arrived, &to);
    let samples = writer.rows();
    let checks = writer.finish("joint move", &[])?;
    let slowest =
        arrivals.iter().enumerate().fold((0, 0.0), |a: (usize, f64), (k, &d)| if d > a.1 { (k, d) } else { a });
    let mut facts = vec![
        ("line".to_owned(), if motion.is_straight() { "straight in joint space" } else { "not straight" }.to_owned()),
        ("computing".to_owned(), format!("{:.1} us", computing.as_secs_f64() * 1e6)),
    ];
    if args.mode == Mode::None {
        facts.push(("slowest joint".to_owned(), format!("J{}", slowest.0 + 1)));
    }
    let report = JointReport {
        name: "joint move".to_owned(),
        duration_s: motion.duration(),
        samples,
        period_s: job.period,
        facts,
        events: Vec::new(),
        limits: checks,
        warnings: assumed,
        files: Vec::new(),
    };
    drop(progress);
    // The position range is the one thing that the move itself is not planned for.
    conclude(&ReportHead::new("move", robot), report, staging, args.json, "move in two steps, or start and end slower")
}

fn inside_range<const N: usize>(limits: &JointLimits<N>, flag: &str, state: &[AxisState; N]) -> Result<(), Failure> {
    let (lower, upper) = (limits.lower(), limits.upper());
    match (0..N).find(|&k| !(lower[k]..=upper[k]).contains(&state[k].p)) {
        None => Ok(()),
        Some(k) => Err(Failure::BadInput(format!(
            "{flag}: joint {} is {:.3} deg, outside its range [{:.3}, {:.3}] deg",
            k + 1,
            state[k].p.to_degrees(),
            lower[k].to_degrees(),
            upper[k].to_degrees()
        ))),
    }
}
