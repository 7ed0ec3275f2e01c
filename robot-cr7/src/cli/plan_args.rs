//! The arguments of `cr7 plan`.

use std::path::PathBuf;

use crate::cli::formats::{self, Format};
use crate::cli::robot_args::RobotArgs;

/// Arguments of `cr7 plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 plan                                 the embedded butterfly
  cr7 plan part.json                       a NURBS curve (JSON)
  cr7 plan points.csv --unit mm            a curve fitted to points
  cr7 plan part.ngc --job job.toml         a G-code program; path.blend_mm of the job rounds its corners
  cr7 plan part.dxf --job job.toml         a drawing (DXF, SVG); path.layers of the job names what is followed
  cr7 plan --job robot-cr7/jobs/butterfly.toml --out butterfly
  cr7 plan --robot ur5e                    another robot: a name of `cr7 robots`, a .urdf or a .json file
  cr7 plan --compile-rad 1e-6              the joints as polynomials of the time, too, within 1 urad
  cr7 plan --format ros2                   for ROS 2's joint trajectory controller
  cr7 plan --format html                   a page for a browser on which the arm moves
  cr7 plan --robot arm.urdf --format html --meshes ros/src
                                           with the meshes of the links, package://.. being below ros/src
  cr7 plan --bound                         how much shorter any motion can be, too
  cr7 plan --stream 20                     segments arrive while the motion runs, 20 of them known ahead
  cr7 plan --stream 20 --stream-gap-ms 12  one every 12 ms: the motion waits where they come too late
  cr7 plan --job job.toml --json | jq .duration_s")]
pub struct Args {
    #[command(flatten)]
    pub robot: RobotArgs,
    /// Path file: .json (NURBS curve), .csv (points), .ngc, .nc, .gcode (G-code) or .dxf, .svg (drawings). Without it: the job's, else an embedded butterfly
    pub path: Option<PathBuf>,
    /// Job file (TOML): workpiece, tool, feed, limits, tolerance, period. Without it: documented defaults
    #[arg(long)]
    pub job: Option<PathBuf>,
    /// Folder for the trajectory and the pictures; created when missing
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Unit of a file that names none (.csv, .dxf, .svg, G-code): mm, cm, m or in
    #[arg(long)]
    pub unit: Option<String>,
    /// Also write joint_trajectory.json: polynomials of the time that stay within this tolerance of the planned joints, in rad
    #[arg(long, value_name = "TOLERANCE", conflicts_with = "stream")]
    pub compile_rad: Option<f64>,
    /// Also write the motion for others: `ros2` for trajectory_msgs/JointTrajectory as YAML and JSON, `mcap` for a recording, `html` for a page on which the arm moves, `png` for the pictures as PNG
    #[arg(long, value_enum, value_delimiter = ',', conflicts_with = "stream")]
    pub format: Vec<Format>,
    /// Draw the robot with the meshes that its .urdf file names, which are looked for below this folder alone; needs --format html
    #[arg(long, value_name = "FOLDER", conflicts_with = "stream")]
    pub meshes: Option<PathBuf>,
    /// Also bound the duration of all motions within the limits from below; takes a few to forty times as long as the plan
    #[arg(long, conflicts_with = "stream")]
    pub bound: bool,
    /// Run the motion as a controller does that gets its segments on the way, with N of them known behind the present one
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub stream: Option<u32>,
    /// Time between two segments of the stream, ms; 0: as soon as the controller has a place for one
    #[arg(long, value_name = "MS", default_value_t = 0.0, requires = "stream", value_parser = gap_ms)]
    pub stream_gap_ms: f64,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// A time between segments that a stream can be run with.
fn gap_ms(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(ms) if (0.0..=1e7).contains(&ms) => Ok(ms),
        _ => Err("it has to be a number of milliseconds from 0 to 1e7".to_owned()),
    }
}

impl Args {
    /// The tolerance of the compiled motion, rad, where one is needed.
    pub fn tolerance(&self) -> Option<f64> {
        self.compile_rad.or(self.format.iter().any(Format::is_of_ros).then_some(formats::TOLERANCE))
    }
}
