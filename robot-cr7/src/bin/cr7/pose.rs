//! `cr7 fk` and `cr7 ik`: from joint angles to the tool and back.

use arcfeed_kinematics::{
    AnalyticInverse, ForwardKinematics, InverseKinematics, Joints, manipulability, smallest_singular_value,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use robot_cr7::{Cr7, Cr7Error};

use crate::Failure;

/// Arguments of `cr7 fk`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 fk --deg 0 -30 90 30 -90 0
  cr7 fk --rad 0 0 1.57 0 -1.57 0 --json")]
pub struct ForwardArgs {
    /// Joint angles in degrees, six of them; 0 is the maker's zero, the arm upright
    #[arg(long, num_args = 6, allow_negative_numbers = true, value_names = ["Q1", "Q2", "Q3", "Q4", "Q5", "Q6"],
          required_unless_present = "rad", conflicts_with = "rad")]
    deg: Option<Vec<f64>>,
    /// Joint angles in radians
    #[arg(long, num_args = 6, allow_negative_numbers = true, value_names = ["Q1", "Q2", "Q3", "Q4", "Q5", "Q6"])]
    rad: Option<Vec<f64>>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Arguments of `cr7 ik`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 ik --xyz-mm 400 0 300 --rpy-deg 180 0 0
  cr7 ik --xyz-mm 400 0 300 --quat-xyzw 1 0 0 0 --near-deg 0 -30 90 30 -90 0")]
pub struct InverseArgs {
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
    #[arg(long, num_args = 6, allow_negative_numbers = true, value_names = ["Q1", "Q2", "Q3", "Q4", "Q5", "Q6"])]
    near_deg: Option<Vec<f64>>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn forward(args: &ForwardArgs) -> Result<(), Failure> {
    let q = match (&args.deg, &args.rad) {
        (Some(deg), _) => Joints::<6>::from_iterator(deg.iter().map(|d| d.to_radians())),
        (None, Some(rad)) => Joints::<6>::from_iterator(rad.iter().copied()),
        (None, None) => return Err(Failure::BadInput("give the joint angles with --deg or --rad".to_owned())),
    };
    finite(q.iter(), "a joint angle")?;
    let cr7 = Cr7::new(Isometry3::identity()).map_err(Cr7Error::from)?;
    let (pose, jacobian) = cr7.arm().forward_jacobian(&q);
    let (p, r) = (pose.translation.vector, pose.rotation);
    let (roll, pitch, yaw) = r.euler_angles();
    let quaternion = r.quaternion();
    let xyzw = [quaternion.i, quaternion.j, quaternion.k, quaternion.w];
    let sigma = smallest_singular_value(&jacobian);
    if args.json {
        let object = serde_json::json!({
            "position_m": [p.x, p.y, p.z],
            "quaternion_xyzw": xyzw,
            "inside_limits": cr7.arm().range().contains(&q),
            "smallest_singular_value": sigma,
            "manipulability": manipulability(&jacobian),
        });
        println!("{object}");
        return Ok(());
    }
    println!("flange in base");
    println!("  position     {:.4} {:.4} {:.4} mm", p.x * 1e3, p.y * 1e3, p.z * 1e3);
    println!("  rpy          {:.4} {:.4} {:.4} deg", roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees());
    println!("  quaternion   {:.9} {:.9} {:.9} {:.9} (x y z w)", xyzw[0], xyzw[1], xyzw[2], xyzw[3]);
    println!(
        "  singularity  smallest singular value {sigma:.4} (rows in m and rad), manipulability {:.5}",
        manipulability(&jacobian)
    );
    if !cr7.arm().range().contains(&q) {
        println!("  these joint angles are outside the joint ranges of the arm");
    }
    Ok(())
}

pub fn inverse(args: &InverseArgs) -> Result<(), Failure> {
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
            UnitQuaternion::from_euler_angles(rpy[0].to_radians(), rpy[1].to_radians(), rpy[2].to_radians())
        }
        (None, None) => return Err(Failure::BadInput("give the orientation with --rpy-deg or --quat-xyzw".to_owned())),
    };
    let position = Translation3::new(args.xyz_mm[0] * 1e-3, args.xyz_mm[1] * 1e-3, args.xyz_mm[2] * 1e-3);
    let target = Isometry3::from_parts(position, rotation);
    let cr7 = Cr7::new(Isometry3::identity()).map_err(Cr7Error::from)?;
    let solutions = cr7.arm().inverse_all(&target).map_err(|e| Failure::Undoable(e.to_string()))?;
    let nearest = match &args.near_deg {
        Some(near) => {
            finite(near.iter(), "an angle of --near-deg")?;
            let seed = Joints::<6>::from_iterator(near.iter().map(|d| d.to_radians()));
            Some(cr7.arm().inverse(&target, &seed).map_err(|e| Failure::Undoable(e.to_string()))?)
        }
        None => None,
    };
    if args.json {
        let list: Vec<[f64; 6]> = solutions.iter().map(|q| (*q).into()).collect();
        let near: Option<[f64; 6]> = nearest.map(Into::into);
        println!("{}", serde_json::json!({ "solutions_rad": list, "nearest_rad": near }));
        return Ok(());
    }
    println!("{} solutions, degrees, modulo 360", solutions.len());
    let row = |q: &Joints<6>| q.iter().map(|a| format!("{:>10.4}", a.to_degrees())).collect::<String>();
    for q in solutions.iter() {
        let note = if cr7.arm().range().contains(q) { "" } else { "   outside the joint ranges" };
        println!("{}{note}", row(q));
    }
    if let Some(q) = nearest {
        println!("nearest to --near-deg, full turns included");
        println!("{}", row(&q));
    }
    Ok(())
}

fn finite<'a>(values: impl IntoIterator<Item = &'a f64>, what: &str) -> Result<(), Failure> {
    match values.into_iter().find(|v| !v.is_finite()) {
        Some(v) => Err(Failure::BadInput(format!("{what} is {v}: give ordinary numbers"))),
        None => Ok(()),
    }
}
