//! `cr7 robots`: the robots that come with the program, and what is known of one.

use crate::{Cr7Error, Robot};
use nalgebra::Isometry3;

use crate::cli::Failure;
use crate::cli::joint_space::for_joints;
use crate::cli::output::{say, say_as_is};

/// Arguments of `cr7 robots`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 robots
  cr7 robots --json
  cr7 robots --urdf panda > panda.urdf     a built-in robot as a URDF file")]
pub struct Args {
    /// Print one JSON object
    #[arg(long, conflicts_with = "urdf")]
    json: bool,
    /// Print this robot as URDF
    #[arg(long, value_name = "NAME")]
    urdf: Option<String>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(name) = &args.urdf {
        say_as_is!("{}", Robot::load(name, None, None)?.description().to_urdf());
        return Ok(());
    }
    let robots: Vec<Robot> =
        Robot::NAMES.iter().map(|name| Robot::load(name, None, None)).collect::<Result<_, Cr7Error>>()?;
    if args.json {
        let list: Vec<_> = robots
            .iter()
            .map(|r| {
                let d = r.description();
                serde_json::json!({
                    "name": d.name, "joints": r.joints(), "inverse": r.any().method().to_string(),
                    "source": d.source, "licence": d.licence, "missing": d.missing(), "notes": d.notes,
                })
            })
            .collect();
        say!("{}", serde_json::json!({ "robots": list }));
        return Ok(());
    }
    for robot in &robots {
        let d = robot.description();
        say!("{:<10} {} joints, {} inverse", d.name, robot.joints(), robot.any().method());
        say!("           {} ({})", d.source, d.licence);
    }
    say!("\nA file does as well: --robot arm.urdf, --robot arm.json; cr7 inspect --robot NAME tells more.");
    Ok(())
}

/// Prints the facts of a robot: inverse, reach, joints with their limits, Denavit-Hartenberg table where there is one.
pub fn inspect(robot: &Robot) -> Result<(), Failure> {
    for_joints!(robot, inspect_with(robot))
}

fn inspect_with<const N: usize>(robot: &Robot) -> Result<(), Failure> {
    let arm = robot.arm::<N>(Isometry3::identity()).map_err(Cr7Error::from)?;
    let d = robot.description();
    say!("{}", d.name);
    say!(
        "  source       {}{}",
        d.source,
        if d.licence.is_empty() { String::new() } else { format!(" ({})", d.licence) }
    );
    say!("  inverse      {}", arm.method());
    for reason in arm.closed_form_refusals().iter().flatten() {
        say!("               no closed form: {reason}");
    }
    say!("  reach        {:.1} mm at most from the first joint", arm.reach() * 1e3);
    say!("  dynamics     {}", if arm.dynamics().is_some() { "links known" } else { "unknown" });
    say!("\n  joint                     range [deg]   speed [deg/s]  accel. [deg/s2]  jerk [deg/s3]  torque [N m]");
    for joint in &d.joints {
        let range = joint
            .range
            .map_or("unknown".to_owned(), |[a, b]| format!("{:.1} .. {:.1}", a.to_degrees(), b.to_degrees()));
        let degrees = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{:.1}", v.to_degrees()));
        let torque = joint.torque.map_or("-".to_owned(), |v| format!("{v:.1}"));
        say!(
            "  {:<18}{range:>19}{:>16}{:>17}{:>15}{torque:>14}",
            joint.name,
            degrees(joint.velocity),
            degrees(joint.acceleration),
            degrees(joint.jerk)
        );
    }
    match arm.chain().to_dh() {
        Ok(table) => {
            say!("\n  Denavit-Hartenberg (standard)  a [mm]  alpha [deg]      d [mm]  theta at zero [deg]");
            for (row, joint) in table.rows.iter().zip(&d.joints) {
                say!(
                    "  {:<22}{:>15.3}{:>13.3}{:>12.3}{:>21.3}",
                    joint.name,
                    row.a * 1e3,
                    row.alpha.to_degrees(),
                    row.d * 1e3,
                    row.theta.to_degrees()
                );
            }
        }
        Err(reason) => say!("\n  no Denavit-Hartenberg table: {reason}"),
    }
    for missing in d.missing() {
        say!("  not known: {missing}");
    }
    for note in &d.notes {
        say!("  note: {note}");
    }
    Ok(())
}
