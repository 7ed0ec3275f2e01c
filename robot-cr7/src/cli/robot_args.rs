//! The flags of all commands that choose a robot, and joint values for it.

use crate::Robot;

use crate::cli::Failure;

/// Flags that choose a robot.
#[derive(Debug, clap::Args)]
pub struct RobotArgs {
    /// Robot: a built-in name (`cr7 robots` lists them), or a file .urdf or .json
    #[arg(long, default_value = "cr7")]
    pub robot: String,
    /// Link of a .urdf file where the arm begins [default: its root]
    #[arg(long)]
    pub base_link: Option<String>,
    /// Link of a .urdf file where the arm ends, the flange [default: the hand, tool0 or the only end of its chain]
    #[arg(long)]
    pub tip_link: Option<String>,
}

impl RobotArgs {
    pub fn load(&self) -> Result<Robot, Failure> {
        Ok(Robot::load(&self.robot, self.base_link.as_deref(), self.tip_link.as_deref())?)
    }
}

/// Joint values of a flag, as many as the robot has joints.
pub fn joint_values(flag: &str, values: &[f64], robot: &Robot) -> Result<Vec<f64>, Failure> {
    if let Some(k) = values.iter().position(|v| !v.is_finite()) {
        return Err(Failure::BadInput(format!("{flag}: value {} is {}: give ordinary numbers", k + 1, values[k])));
    }
    // Flags of rates end in a power of the second.
    let turn = if flag.ends_with("deg") { 360.0 } else { std::f64::consts::TAU };
    let angles = flag.ends_with("deg") || flag.ends_with("rad");
    if let Some(k) = values.iter().position(|v| angles && v.abs() > 100.0 * turn) {
        return Err(Failure::BadInput(format!(
            "{flag}: value {} is {}: a joint value lies within a hundred turns; check its unit",
            k + 1,
            values[k]
        )));
    }
    if values.len() != robot.joints() {
        return Err(Failure::BadInput(format!(
            "{flag}: {} values, but {} has {} joints: give one for each",
            values.len(),
            robot.description().name,
            robot.joints()
        )));
    }
    Ok(values.to_vec())
}
