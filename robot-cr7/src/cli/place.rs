//! `cr7 place`: where a workpiece can stand.

use std::path::PathBuf;

use crate::{Cr7Error, PlacementSearch, Placements, ReportHead};

use crate::cli::Failure;
use crate::cli::output::show;
use crate::cli::progress::Progress;
use crate::cli::robot_args::RobotArgs;
use crate::cli::tool_path::{read_job, read_path};

/// Arguments of `cr7 place`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 place part.json                      frames in which the CR7 reaches the whole path, the best first
  cr7 place part.ngc --z-mm 0 --turn       on a table at the height of the base; the part may be turned
  cr7 place --job job.toml --robot ur5e --json | jq '.frames[0]'")]
pub struct Args {
    #[command(flatten)]
    robot: RobotArgs,
    /// Path file, as for `cr7 plan`. Without it: the job's, else an embedded butterfly
    path: Option<PathBuf>,
    /// Job file (TOML): tool, orientation and rotation of the workpiece count. Without it: documented defaults
    #[arg(long)]
    job: Option<PathBuf>,
    /// Unit of a .csv file whose header names none: mm, cm, m or in
    #[arg(long)]
    unit: Option<String>,
    /// Height of the workpiece frame in the base frame, mm [default: free, with the path above the base]
    #[arg(long, value_name = "Z", allow_negative_numbers = true)]
    z_mm: Option<f64>,
    /// The workpiece may be turned about its own z axis
    #[arg(long)]
    turn: bool,
    /// Largest number of frames
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u8).range(1..=50))]
    count: u8,
    /// Print one JSON object on stdout, and nothing else there
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let job = read_job(args.job.as_deref())?;
    if let Some(z) = args.z_mm.filter(|z| z.is_nan() || z.abs() > 1e5) {
        return Err(Failure::BadInput(format!("--z-mm {z}: a height lies within 100 m of the base; check its unit")));
    }
    let path = args.path.as_deref().or(job.path_file.as_deref());
    let file = read_path(path, args.unit.as_deref(), &job)?;
    let robot = args.robot.load()?;
    if robot.joints() != 6 {
        let (name, joints) = (&args.robot.robot, robot.joints());
        return Err(Failure::Undoable(format!("frames are searched for arms of six joints, and {name} has {joints}")));
    }
    let arm = robot.arm::<6>(job.tool).map_err(Cr7Error::from)?;
    let search =
        PlacementSearch { height: args.z_mm.map(|z| z / 1e3), turn: args.turn, count: usize::from(args.count) };
    let progress = Progress::new("looking for frames");
    let tell = |share: f64| progress.step(&format!("looking for frames, {:.0} %", 100.0 * share));
    // The tool adds to the reach of the flange.
    let reach = arm.reach() + job.tool.translation.vector.norm();
    let found = Placements::search(&job, &file, (&arm, reach), arm.range(), &search, tell)?;
    drop(progress);
    if found.frames.is_empty() {
        return Err(Failure::Undoable(format!(
            "{}: in none of {} frames of the workpiece the whole path is in reach: turn the tool ([orientation]), shorten the path, or \
             leave more free (--turn, no --z-mm)",
            file.file.display(),
            found.looked_at
        )));
    }
    show(&found, args.json.then(|| ReportHead::new("place", &robot).json(&found)));
    Ok(())
}
