//! `cr7 fk`, `ik`, `jacobian` and `torque`: one configuration of an arm.

use crate::Robot;
use arcfeed_kinematics::{AnalyticInverse, Dexterity, Joints};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::cli::Failure;
use crate::cli::output::say;
use crate::cli::robot_args::{RobotArgs, joint_values};

/// Joint angles on the command line.
#[derive(Debug, clap::Args)]
pub struct Angles {
    /// Joint angles in degrees, one for each joint; the zero is the robot's own (the CR7's: upright)
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q",
          required_unless_present = "rad", conflicts_with = "rad")]
    deg: Option<Vec<f64>>,
    /// Joint angles in radians
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q")]
    rad: Option<Vec<f64>>,
}

impl Angles {
    fn of(&self, robot: &Robot) -> Result<Vec<f64>, Failure> {
        match (&self.deg, &self.rad) {
            (Some(deg), _) => Ok(joint_values("--deg", deg, robot)?.iter().map(|d| d.to_radians()).collect()),
            (None, Some(rad)) => joint_values("--rad", rad, robot),
            (None, None) => Err(Failure::BadInput("give the joint angles with --deg or --rad".to_owned())),
        }
    }
}

/// An arm at given joint values.
#[derive(Debug, clap::Args)]
pub struct PoseArgs {
    #[command(flatten)]
    robot: RobotArgs,
    #[command(flatten)]
    angles: Angles,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl PoseArgs {
    /// The robot and its joint values, rad or m.
    fn load(&self) -> Result<(Robot, Vec<f64>), Failure> {
        let robot = self.robot.load()?;
        let q = self.angles.of(&robot)?;
        Ok((robot, q))
    }
}

/// Arguments of `cr7 fk`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 fk --deg 0 -30 90 30 -90 0
  cr7 fk --rad 0 0 1.57 0 -1.57 0 --json
  cr7 fk --robot panda --deg 0 -23 0 -115 0 92 40")]
pub struct ForwardArgs {
    #[command(flatten)]
    pose: PoseArgs,
}

/// Arguments of `cr7 ik`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 ik --xyz-mm 400 0 300 --rpy-deg 180 0 0
  cr7 ik --xyz-mm 400 0 300 --quat-xyzw 1 0 0 0 --near-deg 0 -30 90 30 -90 0
  cr7 ik --robot kr6_r700 --xyz-mm 400 0 300 --rpy-deg 180 0 0")]
pub struct InverseArgs {
    #[command(flatten)]
    robot: RobotArgs,
    /// Position of the flange in the base frame, mm
    #[arg(long, num_args = 3, allow_negative_numbers = true, value_names = ["X", "Y", "Z"])]
    xyz_mm: Vec<f64>,
    /// Orientation by roll, pitch, yaw about the fixed x, y, z axes, degrees
    #[arg(long, num_args = 3, allow_negative_numbers = true, value_names = ["R", "P", "Y"],
          required_unless_present = "quat_xyzw", conflicts_with = "quat_xyzw")]
    rpy_deg: Option<Vec<f64>>,
    /// Orientation by a quaternion x y z w
    #[arg(long, num_args = 4, allow_negative_numbers = true, value_names = ["X", "Y", "Z", "W"])]
    quat_xyzw: Option<Vec<f64>>,
    /// Mark the solution nearest to these joint angles (degrees), full turns included
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "Q")]
    near_deg: Option<Vec<f64>>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Arguments of `cr7 jacobian`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 jacobian --deg 0 -30 90 30 -90 0
  cr7 jacobian --robot arm.urdf --rad 0.1 0.2 0.3 0.4 0.5 0.6 --json")]
pub struct JacobianArgs {
    #[command(flatten)]
    pose: PoseArgs,
}

/// Arguments of `cr7 torque`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 torque --robot ur5e --deg 0 -90 90 -90 -90 0
  cr7 torque --robot panda --deg 0 -23 0 -115 0 92 40 --deg-s 10 10 10 10 10 10 10 --json")]
pub struct TorqueArgs {
    #[command(flatten)]
    pose: PoseArgs,
    /// Joint velocities in degrees per second [default: 0]
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "V")]
    deg_s: Option<Vec<f64>>,
    /// Joint accelerations in degrees per second squared [default: 0]
    #[arg(long, num_args = 1..=10, allow_negative_numbers = true, value_name = "A")]
    deg_s2: Option<Vec<f64>>,
}

fn undoable(error: impl ToString) -> Failure {
    Failure::Undoable(error.to_string())
}

pub fn forward(args: &ForwardArgs) -> Result<(), Failure> {
    let (robot, q) = args.pose.load()?;
    let pose = robot.any().forward(&q).map_err(undoable)?;
    let at = robot.any().dexterity(&q).map_err(undoable)?;
    let inside = inside(&robot, &q);
    let (p, r) = (pose.translation.vector, pose.rotation);
    let (roll, pitch, yaw) = r.euler_angles();
    let quaternion = r.quaternion();
    let xyzw = [quaternion.i, quaternion.j, quaternion.k, quaternion.w];
    if args.pose.json {
        let object = serde_json::json!({
            "position_m": [p.x, p.y, p.z],
            "quaternion_xyzw": xyzw,
            "inside_limits": inside,
            "configuration": posture(&robot, &q),
            "smallest_singular_value": at.sigma_min,
            "manipulability": at.manipulability,
        });
        say!("{object}");
        return Ok(());
    }
    say!("flange in base");
    say!("  position     {:.4} {:.4} {:.4} mm", p.x * 1e3, p.y * 1e3, p.z * 1e3);
    say!("  rpy          {:.4} {:.4} {:.4} deg", roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees());
    say!("  quaternion   {:.9} {:.9} {:.9} {:.9} (x y z w)", xyzw[0], xyzw[1], xyzw[2], xyzw[3]);
    if let Some(name) = posture(&robot, &q) {
        say!("  configuration {name}");
    }
    print_dexterity(&at);
    if !inside {
        say!("  these joint angles are outside the joint ranges of the arm");
    }
    Ok(())
}

/// The name of the solution that these joint values are, for arms whose solutions have names.
fn posture(robot: &Robot, q: &[f64]) -> Option<String> {
    let arm = robot.any().get::<6>()?;
    arm.posture(&Joints::from_column_slice(q)).map(|posture| posture.to_string())
}

fn inside(robot: &Robot, q: &[f64]) -> bool {
    let (lower, upper) = robot.any().range();
    q.iter().zip(lower.iter().zip(upper)).all(|(q, (low, high))| (low..=high).contains(&q))
}

fn print_dexterity(at: &Dexterity) {
    say!(
        "  singularity  smallest singular value {:.4} (rows in m and rad), condition {:.1}, manipulability {:.5}",
        at.sigma_min,
        at.condition,
        at.manipulability
    );
    if let Some(d) = &at.singularities {
        say!("               nearest kind: {}", d.nearest);
    }
}

pub fn inverse(args: &InverseArgs) -> Result<(), Failure> {
    let robot = args.robot.load()?;
    if args.xyz_mm.len() != 3 {
        return Err(Failure::BadInput("give the position with --xyz-mm X Y Z".to_owned()));
    }
    finite(args.xyz_mm.iter(), "a coordinate of --xyz-mm")?;
    let rotation = match (&args.rpy_deg, &args.quat_xyzw) {
        (_, Some(q)) => {
            finite(q.iter(), "a component of --quat-xyzw")?;
            let quaternion = Quaternion::new(q[3], q[0], q[1], q[2]);
            if quaternion.norm() < 1e-6 {
                return Err(Failure::BadInput(
                    "--quat-xyzw has no direction: give a quaternion of length 1".to_owned(),
                ));
            }
            UnitQuaternion::from_quaternion(quaternion)
        }
        (Some(rpy), None) => {
            finite(rpy.iter(), "an angle of --rpy-deg")?;
            if let Some(v) = rpy.iter().find(|v| v.abs() > 36_000.0) {
                return Err(Failure::BadInput(format!(
                    "an angle of --rpy-deg is {v}: it lies within a hundred turns; give it within +-180 degrees"
                )));
            }
            UnitQuaternion::from_euler_angles(rpy[0].to_radians(), rpy[1].to_radians(), rpy[2].to_radians())
        }
        (None, None) => return Err(Failure::BadInput("give the orientation with --rpy-deg or --quat-xyzw".to_owned())),
    };
    let position = Translation3::new(args.xyz_mm[0] * 1e-3, args.xyz_mm[1] * 1e-3, args.xyz_mm[2] * 1e-3);
    let target = Isometry3::from_parts(position, rotation);
    let (solutions, complete) = robot.any().inverse_all(&target).map_err(undoable)?;
    let nearest = match &args.near_deg {
        Some(near) => {
            let seed: Vec<f64> = joint_values("--near-deg", near, &robot)?.iter().map(|d| d.to_radians()).collect();
            Some(robot.any().inverse(&target, &seed).map_err(undoable)?)
        }
        None => None,
    };
    if args.json {
        let object = serde_json::json!({ "solutions_rad": solutions, "complete": complete, "nearest_rad": nearest });
        say!("{object}");
        return Ok(());
    }
    say!(
        "{} solutions, degrees, modulo 360{}",
        solutions.len(),
        if complete { "" } else { " (found by search: there may be more)" }
    );
    let row = |q: &[f64]| q.iter().map(|a| format!("{:>10.4}", a.to_degrees())).collect::<String>();
    for q in &solutions {
        let name = posture(&robot, q).map(|name| format!("   {name}")).unwrap_or_default();
        let note = if inside(&robot, q) { "" } else { "   outside the joint ranges" };
        say!("{}{name}{note}", row(q));
    }
    if let Some(q) = nearest {
        say!("nearest to --near-deg, full turns included");
        say!("{}", row(&q));
    }
    Ok(())
}

pub fn jacobian(args: &JacobianArgs) -> Result<(), Failure> {
    let (robot, q) = args.pose.load()?;
    let at = robot.any().dexterity(&q).map_err(undoable)?;
    let near = robot.any().nearest_singular_pose(&q).map_err(undoable)?;
    if args.pose.json {
        let object = serde_json::json!({
            "columns": at.jacobian, "smallest_singular_value": at.sigma_min, "condition": at.condition,
            "manipulability": at.manipulability, "nearest_singularity": at.singularities.map(|d| d.nearest.to_string()),
            "nearest_singular_pose": near.as_ref().map(|pose| serde_json::json!({
                "joints_rad": pose.q, "distance_rad": pose.distance, "kind": pose.kind.map(|kind| kind.to_string()),
                "lost_direction": pose.lost,
            })),
        });
        say!("{object}");
        return Ok(());
    }
    say!("Jacobian at the flange, base axes; rows m/s and rad/s, a column for 1 rad/s (m/s) of each joint");
    for (row, name) in ["x", "y", "z", "wx", "wy", "wz"].iter().enumerate() {
        let cells: String = at.jacobian.iter().map(|column| format!("{:>11.6}", column[row])).collect();
        say!("  {name:<3}{cells}");
    }
    print_dexterity(&at);
    if let Some(pose) = near {
        let joints: String = pose.q.iter().map(|q| format!(" {:.3}", q.to_degrees())).collect();
        let kind = pose.kind.map_or("of no named kind".to_owned(), |kind| kind.to_string());
        say!("               singular pose {:.3} deg away ({kind}):{joints} deg", pose.distance.to_degrees());
    }
    Ok(())
}

pub fn torque(args: &TorqueArgs) -> Result<(), Failure> {
    let (robot, q) = args.pose.load()?;
    let rates = |flag: &str, given: &Option<Vec<f64>>| -> Result<Vec<f64>, Failure> {
        match given {
            Some(given) => Ok(joint_values(flag, given, &robot)?.iter().map(|d| d.to_radians()).collect()),
            None => Ok(vec![0.0; robot.joints()]),
        }
    };
    let (qd, qdd) = (rates("--deg-s", &args.deg_s)?, rates("--deg-s2", &args.deg_s2)?);
    let joints = &robot.description().joints;
    if joints.iter().any(|joint| joint.inertial.is_none()) {
        return Err(undoable(robot.no_dynamics("give a robot file that states it")));
    }
    let torque = robot.any().torque(&q, &qd, &qdd).map_err(undoable)?;
    if args.pose.json {
        let limits: Vec<_> = joints.iter().map(|j| j.torque).collect();
        say!("{}", serde_json::json!({ "torque": torque, "limit": limits }));
        return Ok(());
    }
    say!("torque of the drives, friction included");
    for (joint, torque) in joints.iter().zip(&torque) {
        let limit = joint.torque.map(|l| format!("  {:>6.1} % of {l} N m", 100.0 * torque.abs() / l));
        say!("  {:<16}{torque:>12.4} N m{}", joint.name, limit.unwrap_or_default());
    }
    for note in &robot.description().notes {
        say!("  note: {note}");
    }
    Ok(())
}

fn finite<'a>(values: impl IntoIterator<Item = &'a f64>, what: &str) -> Result<(), Failure> {
    match values.into_iter().find(|v| !v.is_finite()) {
        Some(v) => Err(Failure::BadInput(format!("{what} is {v}: give ordinary numbers"))),
        None => Ok(()),
    }
}
