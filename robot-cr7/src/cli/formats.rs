//! The kinds of files that `cr7 plan --format` writes.

use crate::cli::Failure;

/// Distance of the compiled motion from the plan where the user gives none, rad.
pub const TOLERANCE: f64 = 1e-6;

/// A kind of file besides the project's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// trajectory_msgs/JointTrajectory as YAML and JSON
    Ros2,
    /// A recording with the trajectory, joint states and frames, for Foxglove and `ros2 bag`; needs the feature `mcap` of this program
    Mcap,
    /// One page for a browser: the arm moving, curves, limits and where they bind; needs the feature `html` of this program
    Html,
    /// The pictures as PNG beside the SVG files, with the fonts of the system; needs the feature `png` of this program
    Png,
}

impl Format {
    /// True for what ROS reads, which is made of the compiled motion.
    pub fn is_of_ros(&self) -> bool {
        matches!(self, Self::Ros2 | Self::Mcap)
    }

    /// Name and feature, where this program was built without it.
    fn missing(self) -> Option<&'static str> {
        match self {
            Self::Mcap if !cfg!(feature = "mcap") => Some("mcap"),
            Self::Html if !cfg!(feature = "html") => Some("html"),
            Self::Png if !cfg!(feature = "png") => Some("png"),
            _ => None,
        }
    }
}

/// Refuses formats that this program was built without.
pub fn check(formats: &[Format]) -> Result<(), Failure> {
    let Some(missing) = formats.iter().find_map(|format| format.missing()) else { return Ok(()) };
    let words = format!("--format {missing}: this program was built without it: build it with `--features {missing}`");
    Err(Failure::BadInput(words))
}
