//! `cr7 move`: from one joint state to another, all joints together, as fast as their limits allow.

use std::path::PathBuf;
use std::time::Instant;

use arcfeed_feedrate::{AxisState, MotionLaw};
use arcfeed_kinematics::JointLimits;
use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};
use robot_cr7::{Cr7Error, InputError, Job, JointReport, Robot, check_joints, write_trajectory};

use crate::Failure;
use crate::joint_space::{axis_limits, draw, for_joints, numbers, rates_of, row};
use crate::output::{say, say_as_is};
use crate::robots::RobotArgs;

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
    /// How the joints belong together: all arrive at once, on a straight line where it can be, on a line or not at all,
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
    let robot = args.robot.load()?;
    for_joints!(robot, run_with(args, &robot))
}

fn run_with<const N: usize>(args: &Args, robot: &Robot) -> Result<(), Failure> {
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
    if args.whole_cycles {
        options = options.with_cycle(job.period).map_err(usage)?;
    }
    let limits = axis_limits(&joint_limits).map_err(|e| Failure::BadInput(e.to_string()))?;
    std::fs::create_dir_all(&args.out).map_err(|source| InputError::Write { file: args.out.clone(), source })?;

    let begin = Instant::now();
    let motion =
        Trajectory::new(&from, &to, &limits, &options).map_err(|e| Failure::Undoable(format!("the move: {e}")))?;
    let computing = begin.elapsed();

    let cycles = (motion.duration() / job.period * (1.0 - 1e-12)).floor() as usize + 1;
    let rows: Vec<_> = (0..=cycles)
        .map(|i| {
            let t = if i == cycles { motion.duration() } else { i as f64 * job.period };
            row(&arm, t, &motion.at(t))
        })
        .collect();
    let rates = rates_of(&joint_limits);
    let (lower, upper) = (*joint_limits.lower(), *joint_limits.upper());
    let checks = check_joints(&rows, |_| rates, (&lower.into(), &upper.into()));
    // The position range is the one thing that the move itself was not planned for.
    if let Some(line) = checks.iter().find(|l| l.name == "joint position" && l.ratio.is_nan() | (l.ratio > 1.0)) {
        return Err(Failure::Undoable(format!(
            "joint {} leaves its range on the way, at t = {:.4} s: move in two steps, or start and end slower",
            line.joint.unwrap_or(0),
            line.at_t_s
        )));
    }
    let slowest = motion.axes().iter().map(MotionLaw::duration).enumerate().fold(
        (0, 0.0),
        |a: (usize, f64), (k, d)| {
            if d > a.1 { (k, d) } else { a }
        },
    );
    let mut facts = vec![
        ("line".to_owned(), if motion.is_straight() { "straight in joint space" } else { "not straight" }.to_owned()),
        ("computing".to_owned(), format!("{:.1} us", computing.as_secs_f64() * 1e6)),
    ];
    facts.extend(assumed.into_iter().map(|text| ("warning".to_owned(), text)));
    if args.mode == Mode::None {
        facts.push(("slowest joint".to_owned(), format!("J{}", slowest.0 + 1)));
    }
    let mut report = JointReport {
        name: "joint move".to_owned(),
        duration_s: motion.duration(),
        samples: rows.len(),
        period_s: job.period,
        facts,
        events: Vec::new(),
        limits: checks,
        files: Vec::new(),
    };
    let trajectory = args.out.join("trajectory.csv");
    write_trajectory(&trajectory, rows.iter().copied())?;
    report.files.push(trajectory);
    report.files.extend(draw("joint move", &args.out, &rows, &joint_limits, |_| rates, &[])?);
    if args.json {
        say!("{}", report.to_json());
    } else {
        say_as_is!("{report}");
    }
    Ok(())
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
